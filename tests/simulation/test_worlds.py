"""Beyond the paper (model.md 6): cases by hand and laws; statistical ones at alpha of 1e-7 (Z = 5.3) or less.

The reference's robots are looked into; the engine equals the reference bit for bit (test_conformance).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario, Swarm, reference
from feasibee.robot.controller import Message
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from tests.equal import assert_equal
from tests.shares import Z, assert_share

SMALL = {"arena.side": 8.0, "robots.count": 16, "tasks.count": 12}


def scenario_of(changes):
    return Scenario().replace({**SMALL, **changes})


def minds_after(changes, steps, seed=1):
    """Return the swarm of the reference after some steps of an exploration that doesn't end."""
    swarm = reference.Swarm(scenario_of({"decision.exploration": 1e6, **changes}), seed, 0)
    for _ in range(steps):
        swarm.step()
    return swarm


def robots_seen(swarm):
    return np.array([sum(robot.mind.robots_seen) for robot in swarm.robots])


def tasks_seen(swarm):
    return np.array([sum(robot.mind.tasks_seen) for robot in swarm.robots])


def same_record(a, b, runs=20, seed=3):
    first, second = (simulate_record(each, Runs(runs, seed), curves=True) for each in (a, b))
    for name in ("decision", "decision_step", "feasible_count"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)


# --- The defaults are still the paper's ---


@pytest.mark.parametrize(
    "changes",
    [
        {"robots.diameter": 3.0},  # without collisions or walls, a disc is a point
        {"robots.spread": 9.0, "robots.clusters": 7, "tasks.spread": 9.0},
        {"faults.stop_step": 50, "faults.byzantine_says": "random"},
        {"faults.stopped": 0.02},  # 0.4 of a robot
        {"arena.side": [20.0, 20.0]},
    ],
)
def test_what_is_not_in_use_changes_nothing(changes):
    """Catches a field that acts without the one that it belongs to, or a slow path unlike the fast."""
    same_record(Scenario(), Scenario().replace(changes))


# --- Walls (6.1) ---


@pytest.mark.parametrize("diameter", [0.5, 2.0])
@pytest.mark.parametrize("count", [16, 40])
def test_robots_stay_off_the_walls_by_their_radius_and_reach_them(diameter, count):
    """Catches a margin left out, a whole diameter, and a wall that only some sides have."""
    changes = {"arena.boundary": "walls", "arena.side": [8.0, 5.0], "robots.count": count}
    swarm = Swarm(scenario_of({**changes, "robots.diameter": diameter, "robots.speed": 0.2}), seed=1)
    low, high = swarm.positions.min(axis=0), swarm.positions.max(axis=0)
    for _ in range(500):
        swarm.advance()
        low = np.minimum(low, swarm.positions.min(axis=0))
        high = np.maximum(high, swarm.positions.max(axis=0))
    assert (low >= diameter / 2).all()
    assert (high <= np.array([8.0, 5.0]) - diameter / 2 + 1e-8).all()
    np.testing.assert_allclose(low, diameter / 2, atol=0.1)
    np.testing.assert_allclose(high, np.array([8.0, 5.0]) - diameter / 2, atol=0.1)


@pytest.mark.quick(2)
@pytest.mark.parametrize("tasks", [4, 40])
@pytest.mark.parametrize("side", [8.0, [8.0, 5.0], [5.0, 8.0]])
def test_tasks_on_the_far_walls_are_tasks(tasks, side):
    """A task may be at the very edge, x = side: catches a cell beyond the last, which a crash would tell."""
    wide, high = side if isinstance(side, list) else (side, side)
    points = [[wide, high], [wide, 0.0], [0.0, high], [wide / 2, high]] * (tasks // 4)
    spots = {"tasks.count": tasks, "tasks.placement": "points", "tasks.points": points}
    assert_equal(
        scenario_of({"arena.boundary": "walls", "arena.side": side, "run.steps": 100, **spots}), 1, 3
    )


# --- Faults (6.6) ---


@pytest.mark.parametrize("count", [16, 40])
def test_stopped_robots_stand_still_and_dont_count_from_their_step_on(count):
    """Catches a step too early or late, a share rounded otherwise, and a decision taken over all."""
    faults = {"faults.stopped": 0.25, "faults.stop_step": 5, "robots.count": count}
    swarm = Swarm(scenario_of(faults), seed=2)
    for step in range(1, 12):
        before = swarm.positions
        swarm.advance()
        still = (swarm.positions == before).all(axis=1)
        assert still.sum() == (count // 4 if step >= 5 else 0)
        if step >= 5:
            np.testing.assert_array_equal(swarm.counted, ~still)
        else:
            assert swarm.counted.all()
        assert swarm.feasible_count == swarm.opinions[swarm.counted].sum()


def test_stopped_robots_fall_silent_and_deaf_but_are_seen():
    """Catches messages of the stopped, and robots that vanish when they stop."""
    close = {"arena.side": 4.0, "robots.speed": 0.0, "sensing.range": 2.0, "tasks.count": 0}
    stopped = minds_after({**close, "faults.stopped": 0.5}, 4)
    working = stopped.counted
    assert len(working) == 8
    free = minds_after(close, 4)
    seen, expected = robots_seen(stopped), robots_seen(free)
    for robot in stopped.robots:
        assert seen[robot.number] == (expected[robot.number] if robot in working else 0)


def test_a_single_honest_robot_decides_alone_among_liars():
    """The decision is taken over honest robots: catches liars that count."""
    record = simulate_record(scenario_of({"faults.byzantine": {"count": 15}}), Runs(50, 1))
    assert (record.decision_step == 0).all()


@pytest.mark.quick(4)
@pytest.mark.parametrize("count", [16, 40])
@pytest.mark.parametrize("says", ["opposite", "feasible", "infeasible", "random"])
def test_what_liars_say(says, count):
    """What is heard decides: a crowd of liars brings the few honest ones to what it says."""
    lies = {"faults.byzantine": 0.75, "faults.byzantine_says": says, "tasks.count": 0}
    scenario = scenario_of({**lies, "arena.side": 4.0, "robots.count": count, "run.steps": 300})
    swarm, told = reference.Swarm(scenario, 3, 0), []
    for _ in range(40):
        swarm.step()
        liars = set(swarm.robots) - set(swarm.counted)
        assert len(liars) == 3 * count // 4
        for robot in swarm.robots:
            message, held = robot.says(swarm.time + 1), robot.mind.opinion
            assert (message is None) == (not robot.mind.disseminating)
            if message is not None and robot in liars:
                told.append((message.opinion, held))
            elif message is not None:
                assert message == Message(held)
    said, held = np.transpose(told)
    if says == "random":
        assert_share(said, 0.5)
        return
    assert (said == {"opposite": 1 - held, "feasible": 1, "infeasible": 0}[says]).all()
    if says != "opposite":
        record = simulate_record(scenario, Runs(200, 1))
        later = record.decision[record.decision_step > 0]  # a few honest ones may agree at the start
        assert (later == (says == "feasible")).mean() > 0.95


@pytest.mark.parametrize(
    "changes",
    [
        {"faults.stopped": 15 / 16},  # the last one hears nothing
        {"faults.stubborn": {"count": 16}},
        {"radio.loss": 1.0},
        {"radio.loss": 1.0, "robots.count": 40},
    ],
)
def test_nobody_changes_who_is_stubborn_or_hears_nothing(changes):
    """Catches the stubborn that follow, messages of the stopped, and a loss below which some slip through."""
    scenario = scenario_of({**changes, "arena.side": 4.0, "run.steps": 300})
    curve = simulate_record(scenario, Runs(20, 1), curves=True).feasible_count
    assert (curve == curve[:, :1]).all()
    assert set(curve[:, 0]) >= ({0, 1} if "faults.stopped" in changes else set())


def test_robots_that_are_not_stubborn_change():
    """The others do change, and all are honest."""
    swarm = Swarm(scenario_of({"faults.stubborn": 0.5, "arena.side": 4.0}), seed=1)
    held = [swarm.opinions]
    for _ in range(300):
        swarm.advance()
        held.append(swarm.opinions)
    assert 0 < np.ptp(held, axis=0).sum() <= 8
    assert swarm.counted.all()


def test_faults_are_drawn_per_run():
    """Catches the same robots in every run: each is stopped in a quarter of 400 runs."""
    scenario = scenario_of({"faults.stopped": 0.25})
    stopped = sum(~Swarm(scenario, seed=1, run=run).counted for run in range(400))
    assert stopped.sum() == 400 * 4
    assert (np.abs(stopped - 100) < Z * math.sqrt(400 * 0.25 * 0.75)).all()


# --- Radio and sensor (6.3, 6.5) ---


def all_heard(steps, **changes):
    """Return the minds of robots in one place, after so many steps."""
    place = {"robots.speed": 0.0, "robots.placement": "points", "robots.points": [[1.0, 1.0]] * 16}
    swarm = reference.Swarm(scenario_of({"tasks.count": 0, "decision.gain": 1e6, **place, **changes}), 1, 0)
    for _ in range(steps):
        swarm.step()
    return [robot.mind for robot in swarm.robots]


def test_messages_are_lost_at_their_rate_for_each_receiver():
    """Catches 0.35 lost for 0.3, and a message lost for all at once."""
    heard = [
        sum(len(mind._messages) for mind in all_heard(60, **{"decision.inbox": "every-message", **loss}))
        for loss in ({"radio.loss": 0.0}, {"radio.loss": 0.3})
    ]
    assert_share(np.arange(heard[0]) < heard[1], 0.7)
    talking = {"decision.exploration": 0.1, "sensing.miss": 1.0, "radio.loss": 0.3}
    minds = all_heard(2, **talking)  # now all have told all others once
    reached = [sum(sender in mind._latest for mind in minds) for sender in range(16)]
    assert sum(0 < number < 15 for number in reached) > 8


def test_what_is_always_missed_is_never_counted():
    """Catches a miss that spares robots or tasks; a robot doesn't miss itself."""
    swarm = minds_after({"sensing.miss": 1.0, "arena.side": 4.0}, 10)
    assert robots_seen(swarm).sum() == tasks_seen(swarm).sum() == 0
    itself = minds_after({"sensing.miss": 1.0, "arena.side": 4.0, "sensing.count_self": True}, 10)
    assert (robots_seen(itself) == 10).all()


def test_things_are_missed_at_their_rate():
    """Catches 0.3 for 0.25, and the same things missed in every step."""
    swarm, whole = (minds_after({"sensing.miss": miss, "arena.side": 4.0}, 40) for miss in (0.25, 0.0))
    for seen in (robots_seen, tasks_seen):
        total = seen(whole).sum()
        assert abs(seen(swarm).sum() - 0.75 * total) < Z * math.sqrt(0.25 * 0.75 * total)


@pytest.mark.parametrize("mean", [0.2, pytest.param(40.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("field", "seen"), [("sensing.false_robots", robots_seen), ("sensing.false_tasks", tasks_seen)]
)
def test_false_sightings_are_poisson(field, seen, mean):
    """Catches a mean off by a tenth and a variance that isn't the mean, and robots taken for tasks."""
    alone = {"robots.count": 1, "tasks.count": 0, field: mean, "decision.exploration": 1e6}
    swarm, counts, steps = reference.Swarm(scenario_of(alone), 1, 0), [], 4000 if mean < 1 else 1000
    for _ in range(steps):
        swarm.step()
        counts.append(seen(swarm)[0])
    numbers = np.diff(counts, prepend=0)
    assert abs(numbers.mean() - mean) < Z * math.sqrt(mean / steps)
    spread = math.sqrt((mean + 2 * mean**2) / steps)  # of the variance of a Poisson number
    assert abs(numbers.var() - mean) < Z * spread
    assert (robots_seen(swarm) + tasks_seen(swarm) == counts[-1]).all()


def test_a_thing_counts_once_an_exploration():
    """Catches a thing counted twice, forgotten never or too early, and robots confused with tasks."""
    crowded = {"arena.side": 4.0, "sensing.observation": "unique"}
    long = minds_after(crowded, 200)
    assert (robots_seen(long) == 15).all()  # each other one
    assert (tasks_seen(long) == 12).all()
    assert (robots_seen(minds_after({**crowded, "sensing.count_self": True}, 20)) <= 16).all()
    for observation, times in (("unique", 1), ("repeated", 9)):
        standing = {"arena.side": 4.0, "robots.speed": 0.0, "sensing.observation": observation}
        once, often = (minds_after(standing, steps) for steps in (1, 9))
        for seen in (robots_seen, tasks_seen):
            np.testing.assert_array_equal(seen(often), times * seen(once))
    swarm = reference.Swarm(scenario_of(crowded), 1, 0)
    seen = []
    for _ in range(200):
        swarm.step()
        seen.append(robots_seen(swarm) + tasks_seen(swarm))
    anew = np.diff(seen, axis=0, prepend=0)
    assert (
        np.where(anew >= 0, anew, seen).sum(axis=0) > 15 + 12
    ).all()  # later explorations count them again
    assert np.max(seen) <= 15 + 12


# --- Placement (6.4) ---


def starts(changes, what="positions", runs=300):
    return np.concatenate(
        [getattr(Swarm(scenario_of(changes), seed=1, run=run), what) for run in range(runs)]
    )


@pytest.mark.parametrize("what", ["robots", "tasks"])
def test_points_are_where_they_were_given(what):
    """Catches x and y swapped, and one list used for the other."""
    points = np.random.default_rng(1).uniform(1, 7, (16, 2))
    scenario = scenario_of(
        {f"{what}.placement": "points", f"{what}.points": points.tolist(), f"{what}.count": 16}
    )
    swarm = Swarm(scenario, seed=3)
    np.testing.assert_allclose(swarm.positions if what == "robots" else swarm.tasks, points, atol=1e-8)


@pytest.mark.quick(1)
@pytest.mark.parametrize(("what", "attribute"), [("robots", "positions"), ("tasks", "tasks")])
def test_clusters_are_normal_about_uniform_centres(what, attribute):
    """One cluster: catches a spread off by 5 %, centres not uniform, and one centre for all runs."""
    changes = {f"{what}.placement": "clusters", f"{what}.spread": 0.3, f"{what}.clusters": 1}
    places = starts(changes, attribute).reshape(300, -1, 2)
    off = (places - places[:, :1] + 4) % 8 - 4
    variance = off.var(axis=1, ddof=1).mean()
    freedoms = 300 * 2 * (places.shape[1] - 1)
    assert abs(variance / 0.09 - 1) < Z * math.sqrt(2 / freedoms)
    turned = np.exp(2j * math.pi * places[:, 0] / 8).mean(axis=0)
    assert (np.abs(turned) < math.sqrt(-math.log(1e-7) / 300)).all()


def test_there_are_as_many_clusters_as_asked_for():
    """Catches a cluster never chosen, and one for each robot."""
    changes = {"robots.placement": "clusters", "robots.spread": 1e-6, "robots.clusters": 3}
    numbers = [
        len(np.unique(np.round(Swarm(scenario_of(changes), seed=1, run=run).positions, 3), axis=0))
        for run in range(50)
    ]
    assert max(numbers) == 3
    assert np.mean(numbers) > 2.9


@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_a_large_spread_is_the_references(boundary):
    """Catches an overflow of the engine's whole numbers; a larger one is refused."""
    changes = {"tasks.placement": "clusters", "tasks.spread": 8.0, "arena.boundary": boundary}
    engine, plain = (kind(scenario_of(changes), 1, 0) for kind in (Swarm, reference.Swarm))
    places = np.array(list(plain.tasks.values())) * float(plain.world.unit)
    np.testing.assert_array_equal(engine.tasks, places)


# --- Mixed robots and teams (6.7) ---


@pytest.mark.parametrize(("robots", "extra"), [(20, {}), (40, {}), (20, {"sensing.observation": "unique"})])
@pytest.mark.parametrize(("skills", "able"), [(["any"], 7), (["lift", "scan"], 0)])
def test_classes_of_which_all_can_do_all_change_nothing(robots, extra, skills, able):
    """The least Hall ratio is then the paper's equation: catches any other weight, set of skills or mean."""
    plain = Scenario().replace({"robots.count": robots, "tasks.count": 10, **extra})
    teams = [
        {"name": f"r{k}", "count": count, "skills": skills} for k, count in enumerate((robots - able, able))
    ]
    sites = [{"name": f"t{k}", "count": 10 // len(skills), "needs": {s: 1}} for k, s in enumerate(skills)]
    same_record(plain, Scenario(robots={"classes": teams}, tasks={"classes": sites}).replace(extra))


def test_a_task_that_needs_several_is_as_many_tasks_in_one_place():
    """Catches needs that aren't counted: {lift: 3} once is {lift: 1} three times at the same point."""
    points = np.random.default_rng(1).uniform(0, 20, (5, 2)).tolist()
    able = {"classes": [{"name": "a", "count": 20, "skills": ["lift"]}]}
    given = {"placement": "points"}
    three = {"classes": [{"name": "t", "count": 5, "needs": {"lift": 3}}], "points": points, **given}
    single = {"classes": [{"name": "t", "count": 15, "needs": {"lift": 1}}], "points": 3 * points, **given}
    same_record(Scenario(robots=able, tasks=three), Scenario(robots=able, tasks=single))


def test_a_skill_that_nobody_has_makes_robots_sure_of_infeasible():
    """The scarcest set of skills decides, however many robots there are: catches a mean in its place."""
    scenario = Scenario(
        robots={"classes": [{"name": "a", "count": 20, "skills": ["lift"]}]},
        tasks={"classes": [{"name": "t", "count": 20, "needs": {"scan": 1}}]},
    )
    record = simulate_record(scenario, Runs(400, 1))
    assert (record.decision == 0).mean() > 0.85  # half of the runs, if all robots were set against all tasks
