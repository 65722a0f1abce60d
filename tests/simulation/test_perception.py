"""Wrong names, noisy positions, a narrow view and late messages (model.md 6.3, 6.21 to 6.24)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario, Swarm, reference, simulate
from feasibee.simulation.lowering import lower
from feasibee.strategies import STRATEGIES
from feasibee.studies.needs import noisy_names_in_words
from tests.equal import assert_equal
from tests.shares import assert_share

CENSUS = {"decision.strategy": "census"}
STANDING = {
    **CENSUS,
    **{"robots.count": 1, "robots.speed": 0.0, "robots.placement": "points", "robots.points": [[5.0, 5.0]]},
    **{"tasks.placement": "points", "decision.exploration": 1e6},
}
"""A robot that explores for ever where it stands."""


def seen_in(steps, tasks, **sensing):
    """Return what a standing robot sees of tasks on its height, in each step, and its swarm."""
    changes = {f"sensing.{name}": value for name, value in sensing.items()}
    scenario = Scenario().replace({**STANDING, "tasks.points": [[x, 5.0] for x in tasks], **changes})
    swarm, seen = reference.Swarm(scenario, 3, 0), []
    for _ in range(steps):
        swarm.step()
        seen.append([thing for thing, _ in swarm.sightings(swarm.robots[0])])
    return seen, swarm


# --- Wrong names ---

TEN = [5.0 + 0.1 * k for k in range(10)]


def test_each_task_has_one_wrong_name_with_a_position_and_a_hash_of_its_own():
    (right,), wrong = seen_in(1, TEN)[0], seen_in(30, TEN, misname=1.0)[0]
    assert [each.id for each in wrong[0]] == [10 + each.id for each in right]
    assert [each.x for each in wrong[0]] == [each.x + 10.0 for each in right]
    assert {each.hash for each in wrong[0]}.isdisjoint(each.hash for each in right)
    assert all(each == wrong[0] for each in wrong)


def test_wrong_names_come_at_their_rate_anew_in_each_step():
    names = [each.id for step in seen_in(400, TEN, misname=0.2)[0] for each in step]
    assert set(names) == set(range(20))
    assert_share(np.array(names) >= 10, 0.2)


def test_with_wrong_names_a_quiet_census_declares_infeasible_what_is_feasible():
    small = {"robots.count": 10, "tasks.count": 10, "arena.side": 10.0, "run.steps": 200}
    scenario = Scenario().replace({**small, "decision.strategy": "quiet-census", "robots.know_count": True})
    found = [assert_equal(scenario.replace({"sensing.misname": rate}), 7, 2) for rate in (0.0, 0.01)]
    assert [each.declared_infeasible.max() > 0 for each in found] == [False, True]


# --- Noisy positions ---


@pytest.mark.parametrize(
    ("error", "gate", "names"),
    [
        (0.046, None, [0, 1, 0, 0, 0]),  # 8 - 3.75 deviations are 0.1955; the whole chain is longer
        (0.04, 0.3, [0, 1, 2, 3, 4]),
        (0.1, 0.9, [0, 0, 0, 0, 0]),
        (0.1, 0.2, [0, 1, 2, 3, 4]),
    ],
)
def test_tasks_in_a_chain_of_short_gaps_have_the_name_of_the_lowest(error, gate, names):
    places = [4.62, 5.7, 5.0, 4.81, 5.19]
    (seen,), swarm = seen_in(1, places, position_error=error, gate=gate)
    assert [each.id % 5 for each in seen] == names
    for each, name in zip(seen, names, strict=True):
        own = name, swarm.names.task(name, 0, 0.0, 0.0).hash, places[name]
        assert each.id >= 5 or (each.id, each.hash, round(each.x, 6)) == own


def test_on_a_torus_a_chain_may_cross_the_edge_and_the_engine_finds_it_among_many():
    random = np.random.default_rng(5)
    spots = [[0.05, 3.0], [19.95, 3.0], [3.0, 0.02], [3.0, 19.9], *random.uniform(0, 20, (296, 2)).tolist()]
    points = {"tasks.placement": "points", "tasks.points": spots, "sensing.position_error": 0.06}
    scenario = Scenario().replace({**CENSUS, **points})
    names = Swarm(scenario, 1)._state.array("names", len(spots)).tolist()
    assert names == [*reference.Swarm(scenario, 1, 0)._called.values()]
    assert (names[1], names[3]) == (0, 2)
    assert 100 < len(set(names)) < 298


def test_looks_beyond_the_gate_give_wrong_names_in_addition_to_misname():
    alone = Scenario().replace({**CENSUS, "sensing.position_error": 0.1, "sensing.gate": 0.3})
    both = alone.replace({"sensing.misname": 0.2}).sensing.wrong
    assert both == pytest.approx(1 - 0.8 * (1 - math.exp(-(3**2) / 4)), rel=1e-8)
    assert lower(alone, 1).params.sensing.misname == pytest.approx(2**32 * math.exp(-9 / 4), rel=1e-8)
    assert alone.setting.task_ids == 40


@pytest.mark.quick(3)
def test_a_census_holds_merged_tasks_for_one_and_so_too_many_for_feasible():
    world = Scenario().replace({**CENSUS, "tasks.count": 21, "run.steps": 600})
    noisy = (world.replace({"sensing.position_error": error}) for error in (0.0, 0.2))
    shares = [(simulate(each, 60, 1).feasible_at_end.values > 10).mean() for each in noisy]
    assert shares[0] < 0.05
    assert shares[1] > 0.5


@pytest.mark.parametrize(
    ("error", "gate", "strategy", "lines"),
    [
        (0.05, None, "census", ["0.067 pairs of tasks on average are at most 0.212 units apart"]),
        (0.05, 0.3, "census", ["One look in 8,103"]),
        (0.01, None, "census", []),
        (0.0, 0.3, "census", []),
        (0.2, None, "tally", []),
    ],
)
def test_an_assessment_warns_of_names_that_are_merged_or_wrong(error, gate, strategy, lines):
    sensing = {"sensing.position_error": error, "sensing.gate": gate}
    found = noisy_names_in_words(Scenario().replace({"decision.strategy": strategy, **sensing}))
    assert [line in each for line, each in zip(lines, found, strict=True)] == [True] * len(lines)


# --- A narrow view ---

CLOSE = {"arena.side": 8.0, "run.steps": 40}
BLIND_RADIO = {**CLOSE, **CENSUS, "radio.range": 1e-3, "tasks.count": 50}


@pytest.mark.parametrize("robots", [20, 140])
@pytest.mark.parametrize(("view", "speed"), [*((v, 1.0) for v in (359.0, 250.0, 90.0, 15.0)), (1e-9, 1e-12)])
def test_robots_see_the_tasks_whose_direction_is_near_their_heading_and_no_others(view, speed, robots):
    """One whose step is no unit long sees all round."""
    world = Scenario().replace({**BLIND_RADIO, "robots.count": robots, "robots.speed": speed})
    swarm = Swarm(world.replace({"sensing.view": view}), seed=3)
    before = swarm.positions
    swarm.advance()
    words = swarm.knowledge[:, (robots + 31) // 32 :].astype(np.uint32)  # after those of the robots' names
    seen = (words[:, np.arange(50) >> 5] >> np.arange(50, dtype=np.uint32) % 32 & 1).astype(bool)
    way, heading = (
        np.mod(each + 4, 8) - 4
        for each in (swarm.tasks[None] - swarm.positions[:, None], swarm.positions - before)
    )
    angle = np.arctan2(way[..., 1], way[..., 0]) - np.arctan2(heading[:, 1], heading[:, 0])[:, None]
    off = np.abs(np.mod(np.degrees(angle) + 180, 360) - 180)
    expected = (np.hypot(way[..., 0], way[..., 1]) <= 2) & ((off <= view / 2) | (speed < 1))
    assert 0 < expected.sum() < expected.size
    np.testing.assert_array_equal(seen, expected)


def test_robots_hear_all_round():
    changes = {**CLOSE, "decision.strategy": "voter"}
    narrow, wide = (Swarm(Scenario().replace({**changes, "sensing.view": v}), seed=4) for v in (1.0, 359.9))
    heard = 0
    for _ in range(20):
        narrow.advance()
        wide.advance()
        for i in range(20):
            senders = [[each[0] for each in swarm.robot(i).heard] for swarm in (narrow, wide)]
            assert senders[0] == senders[1]
            heard += len(senders[0])
    assert heard > 100


def test_strategies_know_how_far_they_see():
    """Those that take what they don't see for absent need an all-round view; others half a strip's width."""
    assert {name for name, each in STRATEGIES.items() if each.all_round} == {"map", "roster"}
    sights = [Scenario().replace({"sensing.view": v}).setting.sight for v in (360.0, 180.0, 60.0)]
    assert sights == [2.0, 2.0, 1.0]


# --- Late messages ---


@pytest.mark.parametrize("robots", [20, 140])
def test_robots_hear_what_others_would_have_said_some_steps_before(robots):
    """All hear all; so an inbox has the latest message of each sender up to so many steps before."""
    changes = {**CLOSE, "arena.boundary": "walls", "radio.range": 20.0, "robots.count": robots}
    world = Scenario().replace({**changes, "radio.delay": (delay := 4)})
    swarm, said, inboxes, changed = Swarm(world, seed=3), [], [{} for _ in range(robots)], 0
    for step in range(40 if robots == 20 else 15):
        robots_before = [swarm.robot(i) for i in range(robots)]
        said.append({i: each.broadcasts for i, each in enumerate(robots_before) if each.broadcasts >= 0})
        swarm.advance()
        arriving = said[step - delay] if step >= delay else {}
        changed += arriving != said[step]
        for i, before in enumerate(robots_before):
            others = {sender: opinion for sender, opinion in arriving.items() if sender != i}
            ends = before.phase_left == 1 and before.flags >> 2 & 1
            inboxes[i] = {} if ends else inboxes[i] | others
            assert {sender: opinion for sender, opinion, _ in swarm.robot(i).heard} == inboxes[i], (step, i)
    assert changed > 8


@pytest.mark.parametrize("strategy", ["voter", "census"])
def test_bits_count_when_they_are_broadcast(strategy):
    """Phases of these strategies don't depend on messages; what isn't heard changes none, either."""
    world = Scenario().replace({**CLOSE, "decision.strategy": strategy, "radio.range": 1e-3})
    early, delayed = (Swarm(world.replace({"radio.delay": delay}), seed=5) for delay in (0, 7))
    early.advance(23)
    delayed.advance(30)
    assert delayed.bits_sent == early.bits_sent > 0


def test_ages_are_those_at_arrival():
    """Else robots make each other's news of a task that vanished younger, and never forget it."""
    changes = {"decision.strategy": "roster", "robots.know_count": True, "decision.parameters.looks": 1e6}
    world = {"tasks.count": 25, "events": [{"step": 100, "tasks": -10}], "run.steps": 450, "radio.delay": 20}
    found = simulate(Scenario().replace({**changes, **world}), runs=20, seed=5)
    assert (found.feasible_at_end.values > 18).sum() >= 19
