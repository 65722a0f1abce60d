"""The theory against stored runs of the engine, against exact statements, and at the edge of its reach."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError, simulate
from feasibee.theory.chain import chain_of
from feasibee.theory.classes import CLASS
from feasibee.theory.geometry import Space, ending, sightings
from feasibee.theory.predict import compare, even_tasks, predict
from feasibee.theory.quality import GRID, durations
from feasibee.theory.reach import TIME_ERROR, time_error
from feasibee.theory.rule import swarm_of
from feasibee.theory.saddle import manifold, tipping

ENGINE = json.loads(Path(__file__).with_name("engine.json").read_text("utf-8"))
SPACE = Space((20.0, 20.0), 1.0, ending(10.0))


def paper(tasks, **decision):
    return Scenario(tasks={"count": tasks}, decision=decision)


@pytest.mark.quick(6)
@pytest.mark.parametrize("tasks", ENGINE["tasks"])
def test_the_papers_ratios_are_predicted(tasks):
    engine, found = ENGINE["tasks"][tasks], predict(paper(int(tasks)))
    assert found.feasible == pytest.approx(engine["feasible"] / ENGINE["runs"], abs=0.021)
    assert found.steps["median"] == pytest.approx(engine["median_step"], rel=0.035)


@pytest.mark.parametrize(
    ("tasks", "engine"), [(10, 0.989), (16, 0.865), (18, 0.755), (20, 0.586), (25, 0.232)]
)
def test_robots_that_see_others_hear_them(tasks, engine):
    """Without it, dmvd is 0.15 off. The engine's shares are those of 4,000 runs with seed 9."""
    assert predict(paper(tasks, strategy="dmvd")).feasible == pytest.approx(engine, abs=0.03)


@pytest.mark.parametrize(
    ("faults", "tasks", "feasible", "infeasible", "error"),
    [
        ({"stubborn": {"count": 1}}, 10, 0.752, 0.248, 0.045),
        ({"stubborn": {"count": 2}}, 10, 0.614, 0.231, 0.045),
        ({"stubborn": {"count": 3}}, 40, 0.178, 0.470, 0.045),
        ({"byzantine": {"count": 3}}, 10, 0.723, 0.276, 0.045),
        ({"byzantine": {"count": 2}, "byzantine_says": "random"}, 16, 0.588, 0.412, 0.045),
        ({"byzantine": {"count": 2}, "byzantine_says": "infeasible"}, 10, 0.499, 0.501, 0.07),
        ({"byzantine": {"count": 2}, "byzantine_says": "feasible"}, 10, 0.917, 0.083, 0.07),
    ],
)
def test_faulty_robots_are_predicted(faults, tasks, feasible, infeasible, error):
    """The engine's shares are those of 1,000 runs; half of the error is left for their noise."""
    found = predict(Scenario(tasks={"count": tasks}, faults=faults))
    assert found.error == error
    assert (found.feasible, found.infeasible) == pytest.approx((feasible, infeasible), abs=0.03)


def test_two_stubborn_robots_prevent_the_other_decision():
    scenario = Scenario(tasks={"count": 10}, faults={"stubborn": {"count": 2}})
    both = [swarm_of(scenario, feasible_ones=held) for held in (0, 2)]
    feasible, infeasible = chain_of(both[0], (19, 17))[0].over_time(2_000)[-1]
    assert feasible == 0
    assert infeasible > 0.4
    feasible, infeasible = chain_of(both[1], (17, 19))[0].over_time(2_000)[-1]
    assert infeasible == 0
    assert feasible > 0.9


def test_what_explorers_heard_leaves_the_durations_as_likely():
    swarm = swarm_of(paper(20))
    sends = swarm._sends(np.full((1, 2), 1.0))[0]
    assert sends.sum(1) == pytest.approx(np.ones_like(sends[:, 0]))
    long = sends[:, -1, 0]  # by votes; feasible then infeasible
    assert long[0, 3] > 3 * long[1, 3]
    assert long[0, 0] < long[1, 0]
    votes = np.arange(sends.shape[-1])
    law = 0.5 ** (votes + 1)
    law[-1] *= 2
    assert sends[:, :, 0] @ law == pytest.approx(swarm.weights, abs=0.01)


@pytest.mark.parametrize(
    ("tasks", "engine", "error"), [(10, 0.9765, 0.01), (16, 0.7448, 0.015), (25, 0.1995, 0.07)]
)
def test_first_sight_is_predicted(tasks, engine, error):
    """The engine's shares are those of 4,000 runs with seed 77."""
    found = predict(paper(tasks, start="first-sight"))
    assert found.feasible == pytest.approx(engine, abs=error)
    assert found.error == 0.06


def test_first_sight_without_the_own_vote_is_less_exact():
    """The engine's share is that of 2,000 runs with seed 77."""
    found = predict(paper(16, start="first-sight", own_vote=False, exploration=28.0, gain=40.0))
    assert found.feasible == pytest.approx(0.785, abs=0.08)
    assert found.error == 0.08


def test_the_mean_number_of_sightings_is_exact():
    for length, law in zip((5, 20), sightings(SPACE, 2.0, 2, (5, 20)), strict=True):
        assert law.sum() == pytest.approx(1)
        assert law @ np.arange(length + 1) == pytest.approx(length * np.pi * 4 / 400)
        assert law.min() >= 0


def test_robots_come_into_range_as_often_as_in_a_walk():
    random = np.random.default_rng(3)
    place, size = 20 * random.random((2, 40_000)), 20.0
    headings, near, came = 2 * np.pi * random.random((2, 40_000)), None, []
    for _ in range(40):
        turns = random.random(headings.shape) < SPACE.turning
        headings[turns] = 2 * np.pi * random.random(turns.sum())
        place += [np.diff(np.cos(headings), axis=0)[0], np.diff(np.sin(headings), axis=0)[0]]
        place -= size * np.round(place / size)
        before, near = near, np.hypot(*place) <= 2
        came += [] if before is None else [np.mean(near & ~before)]
    assert np.mean(came) == pytest.approx(SPACE.coming(2.0), rel=0.02)


def test_durations_keep_mean_and_variance():
    chances = np.random.default_rng(1).random(GRID + 1)
    chances /= chances.sum()
    steps = 1 + 20 * np.linspace(0, 1, GRID + 1) ** 2
    ends, weights = durations(chances, steps)
    for power in (1, 2, 5):
        assert weights @ (1 / ends) ** power == pytest.approx(chances @ steps**power)
    single = np.zeros(GRID + 1)
    single[GRID // 2] = 1
    ends, weights = durations(single, steps)
    assert weights @ (1 / ends) == pytest.approx(6)


def test_without_quality_both_decisions_are_equally_likely():
    majority, voter = predict(paper(5, strategy="majority")), predict(paper(40, strategy="voter"))
    assert majority.feasible == pytest.approx(majority.infeasible)
    assert voter.feasible == pytest.approx(voter.infeasible)
    assert majority.tipping.point == pytest.approx(0.5)
    assert voter.tipping is None
    assert "do not tip" in voter.warnings[-1]


def test_the_formula_is_close_to_the_chain():
    for tasks in (5, 10, 40):
        found = predict(paper(tasks))
        assert found.tipping.share(20) == pytest.approx(found.feasible, abs=0.01)


def test_the_value_grows_with_any_deviation():
    swarm = swarm_of(paper(10))
    tips = tipping(swarm)
    shares = np.linspace(0.3, 0.7, 41)
    drift = manifold(swarm, shares).drift
    at = np.flatnonzero((drift[:-1] <= 0) & (drift[1:] > 0))[0]
    root = shares[at] - drift[at] * (shares[at + 1] - shares[at]) / (drift[at + 1] - drift[at])
    along = manifold(swarm, np.array([root]))
    change = np.random.default_rng(2).random(along.states.shape)
    change -= along.states * change.sum() / along.states.sum()  # as many robots as before

    def after(state):
        return swarm.forward(state, swarm.hearing(swarm.counts(state)))

    grown = (after(along.states + 1e-3 * change) - after(along.states - 1e-3 * change)) / 2e-3
    expected = tips.growth * (along.value * change).sum(CLASS)
    assert (along.value * grown).sum(CLASS) == pytest.approx(expected, rel=5e-4)


def test_the_mean_steps_of_a_round_are_those_of_all_its_steps():
    swarm = swarm_of(paper(10))
    hearing = swarm.hearing(swarm.counts(swarm.start())[None])
    start = np.random.default_rng(1).random((1, *swarm.start().shape))
    goes_on = np.array([[1 - swarm.explored, *(1 - ends)] for ends in swarm.ends])
    steps = hearing.steps_until(start, goes_on)
    stays = goes_on[..., None, None] * steps
    assert steps == pytest.approx(hearing.after(start + stays))


def test_steps_in_time_lead_to_the_exact_shares_of_the_chain():
    chain, _ = chain_of(swarm_of(paper(10)), (19, 19))
    among, exits = chain.moves()
    shares = chain.start @ np.linalg.solve(np.diag(chain.up + chain.down) - among, exits) + chain.decided
    by_step = chain.over_time(3_000)
    assert shares.sum() == pytest.approx(1)
    assert by_step[-1] == pytest.approx(shares, abs=1e-9)
    assert (np.diff(by_step, axis=0) >= 0).all()


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"decision.strategy": "census"}, "decision.strategy"),
        ({"decision.inbox": "every-message"}, "decision.inbox"),
        ({"decision.listen": {"last": 3}}, "decision.listen"),
        ({"decision.dissemination_floor": 2}, "decision.dissemination_floor"),
        ({"decision.exploration": 5.0}, "decision.exploration"),
        ({"decision.gain": 0.5}, "decision.gain"),
        ({"robots.count": 9}, "robots.count"),
        ({"robots.speed": 0.1}, "robots.speed"),
        ({"arena.boundary": "walls"}, "arena.boundary"),
        ({"sensing.range": 0.5}, "radio.range"),
        ({"faults.byzantine": 0.2}, "faults.byzantine"),
        ({"faults.stubborn": {"count": 4}, "robots.count": 25}, "faults.stubborn"),
        ({"faults.byzantine": 0.1, "faults.byzantine_says": "colluding"}, "faults.byzantine_says"),
        ({"faults.byzantine": 0.1, "decision.strategy": "voter"}, "decision.strategy"),
        ({"faults.stopped": 0.1}, "faults.stopped"),
        ({"events": [{"step": 5, "tasks": 1}]}, "events"),
    ],
)
def test_a_scenario_beyond_reach_is_refused_by_its_field(changes, path):
    with pytest.raises(ScenarioError) as caught:
        predict(Scenario().replace(changes))
    assert path in [problem.path for problem in caught.value.problems]
    assert all(problem.rule and problem.remedy for problem in caught.value.problems)


CROWDED = {
    "arena.side": 11.73,
    "robots.speed": 1.09,
    "sensing.range": 2.75,
    "walk.mean_run": 22.8,
    "decision.exploration": 20.1,
    "decision.gain": 11.4,
    "decision.start": "first-sight",
}


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({**CROWDED, "robots.count": 11, "tasks.count": 6}, "decision.start"),
        ({**CROWDED, "robots.count": 11, "tasks.count": 7}, "decision.start"),
        ({**CROWDED, "robots.count": 22, "tasks.count": 12, "arena.side": 16.59}, "decision.start"),
        (
            {
                "robots.count": 10,
                "tasks.count": 30,
                "decision.strategy": "dmvd",
                "decision.start": "first-sight",
            },
            "decision.start",
        ),
        ({"arena.side": [100.0, 4.1], "tasks.count": 13}, "arena.side"),
        ({"walk.mean_run": 1.0}, "walk.mean_run"),
    ],
)
def test_what_the_theory_would_miss_is_refused_and_the_remedy_works(changes, path):
    """Its shares were up to 0.24 off there, or half of the swarms decided up to a half later."""
    scenario = Scenario().replace(changes)
    with pytest.raises(ScenarioError) as caught:
        predict(scenario)
    (problem,) = caught.value.problems
    assert problem.path == path
    value = problem.remedy.removeprefix("use ").removeprefix("a square of ").split()[0].strip(',"')
    predict(scenario.replace({path: value if path == "decision.start" else float(value)}))


@pytest.mark.parametrize(("reach", "near"), [(1.0, 1.1), (5.0, 4.7)])
def test_the_remedy_for_too_few_or_too_many_heard_is_the_nearest_range(reach, near):
    with pytest.raises(ScenarioError, match=f"try {near},"):
        predict(Scenario(radio={"range": reach}))


def test_first_sight_is_refused_where_it_moves_the_tipping_point():
    near = Scenario().replace({**CROWDED, "robots.count": 11, "tasks.count": 7})
    with pytest.raises(ScenarioError, match=r"tipping point moves by 0\.15"):
        predict(near)


def test_the_error_of_the_median_step_is_stated_where_it_is_larger():
    """The engine's median of dmvd is that of 1,000 runs with seed 1; predicted is later by 19 % at most."""
    assert time_error(Scenario()) == TIME_ERROR
    found = predict(paper(16, strategy="dmvd"))
    assert "of the median step up to 20%" in found.warnings[0]
    assert time_error(found.scenario) == 0.2
    steps = np.full(1_000, round(found.steps["median"] * 0.83))
    decision = np.repeat([1, 0], [round(1_000 * found.feasible), 1_000 - round(1_000 * found.feasible)])
    assert compare(found, SimpleNamespace(decision=decision, decision_step=steps)).agree


def test_warnings_name_what_was_measured():
    (warning,) = predict(Scenario(robots={"count": 60}, arena={"side": 34.6})).warnings
    assert "robots.count = 60: above 40 robots" in warning
    assert predict(paper(20, strategy="cross-inhibition")).error > predict(paper(20)).error
    for change in ({"radio.loss": 0.1}, {"sensing.miss": 0.1}, {"radio.range": 2.5}):
        unreliable = predict(Scenario().replace(change))
        assert (unreliable.error, unreliable.warnings) == (0.045, ())
    near = predict(
        Scenario().replace({"robots.speed": 0.5, "decision.exploration": 8.0, "decision.gain": 30.0})
    )
    assert [each.split(" = ")[0] for each in near.warnings] == [
        "decision.gain",
        "robots.speed",
        "decision.exploration",
    ]
    assert near.error == 0.05
    assert predict(Scenario(arena={"side": [40.0, 10.0]})).warnings == ()  # the longest one in reach
    slow = predict(Scenario(run={"steps": 100}))
    assert any("slowly" in each for each in slow.warnings)
    assert slow.undecided > 0.5
    assert slow.steps["median"] is None


def by_step(changes, seed):
    """Return a prediction, and by step the error of its mean and the share of runs within its band."""
    scenario = Scenario().replace({**changes, "run.steps": 400, "run.stop_at_decision": False})
    found = predict(scenario)
    mean, low, high = found.opinions.T
    engine = simulate(scenario, 2000, seed, curves=True).feasible_count.values / scenario.robots.count
    return found, mean - engine.mean(0), ((low <= engine) & (engine <= high)).mean(0)


@pytest.mark.parametrize(
    ("changes", "seed"),
    [
        ({"tasks.count": 7}, 1001),
        ({"tasks.count": 25}, 1004),
        ({"tasks.count": 16, "decision.strategy": "k-unanimity"}, 1013),
        ({"tasks.count": 16, "decision.start": "first-sight"}, 1022),
    ],
)
def test_the_share_for_feasible_is_predicted_at_every_step(changes, seed):
    """These four are among the 31 of 36 for which it holds: see the slow test below."""
    found, errors, within = by_step(changes, seed)
    assert np.abs(errors).max() <= found.error
    assert within[[20, 60, 150]].min() >= 0.88
    assert 0.1 < found.opinions[20, 1] < found.opinions[20, 2] < 0.95


def fresh_scenarios():
    """Return scenarios that nobody had looked at when the rule was fixed: name, changes."""
    cases = [("paper", {"tasks.count": tasks}) for tasks in (3, 7, 12, 16, 25, 60)]
    for name in ("cross-inhibition", "dmvd", "k-unanimity", "majority", "voter"):
        cases += [(name, {"decision.strategy": name, "tasks.count": tasks}) for tasks in (7, 16, 30)]
    cases += [("sight", {"decision.start": "first-sight", "tasks.count": tasks}) for tasks in (7, 16, 30)]
    random = np.random.default_rng(20261127)
    for _ in range(12):
        robots = int(random.integers(10, 41))
        changes = {
            "robots.count": robots,
            "tasks.count": int(random.integers(robots // 3, 3 * robots)),
            "arena.side": float(round(20 * (robots / 20) ** 0.5, 1)),
            "decision.exploration": float(round(random.uniform(8, 25), 1)),
            "decision.gain": float(round(random.uniform(6, 25), 1)),
        }
        cases.append(("random", changes))
    return cases


@pytest.mark.slow
def test_how_far_opinions_by_step_are_predicted():
    """By the rule that was fixed before, means hold in 32 of 36 scenarios, and bands in 31.

    The rule: at each step, the error is at most the tested error of a share of decisions; and at steps 20, 60
    and 150, the band has at least 88 % of the runs. The bounds below were set after these runs.
    """
    means = bands = 0
    for k, (name, changes) in enumerate(fresh_scenarios()):
        found, errors, within = by_step(changes, 1000 + k)
        largest = np.abs(errors).max()
        assert largest <= (0.09 if name == "cross-inhibition" else 0.056), changes
        means += largest <= found.error
        bands += within[[20, 60, 150]].min() >= 0.88
    assert means >= 32
    assert bands >= 31


def test_the_number_of_tasks_at_which_swarms_are_even():
    tasks = even_tasks(Scenario())
    before, after = (predict(paper(each)) for each in (tasks, tasks + 1))
    assert before.feasible > before.infeasible
    assert after.feasible < after.infeasible
    assert even_tasks(paper(5, strategy="majority")) is None


def test_the_test_of_agreement():
    found = predict(paper(10))
    right = round(1_000 * found.feasible)
    decision = np.repeat([1, 0], [right, 1_000 - right])
    steps = np.full(1_000, found.steps["median"])

    def agree(decision=decision, steps=steps):
        both = compare(found, SimpleNamespace(decision=decision, decision_step=steps))
        return both.shares_agree, both.times_agree

    assert agree() == (True, True)
    assert agree(decision=np.roll(decision, 1)[::-1] * 0 + 1) == (False, True)
    assert agree(steps=steps * 2) == (True, False)
    assert agree(steps=steps // 2) == (True, False)
