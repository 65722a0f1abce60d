"""Robots that see only what is ahead of them (model.md 6.22)."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError, Swarm, simulate
from feasibee.strategies import STRATEGIES

BLIND_RADIO = {"radio.range": 1e-3, "decision.strategy": "census"}


def in_world(changes):
    base = {"arena.side": 8.0, "run.steps": 30, "sensing.view": 100.0}
    return Scenario().replace({**base, **changes})


@pytest.mark.parametrize("robots", [20, 140])
@pytest.mark.parametrize("view", [359.0, 250.0, 180.0, 90.0, 15.0])
def test_robots_see_the_tasks_whose_direction_is_near_their_heading_and_no_others(view, robots):
    world = in_world({**BLIND_RADIO, "robots.count": robots, "tasks.count": 50, "sensing.view": view})
    swarm = Swarm(world, seed=3)
    before = swarm.positions
    swarm.advance()
    seen = names(swarm, robots, 50)
    way, heading = (
        np.mod(each + 4, 8) - 4
        for each in (swarm.tasks[None] - swarm.positions[:, None], swarm.positions - before)
    )
    angle = np.arctan2(way[..., 1], way[..., 0]) - np.arctan2(heading[:, 1], heading[:, 0])[:, None]
    off = np.abs(np.mod(np.degrees(angle) + 180, 360) - 180)
    expected = (np.hypot(way[..., 0], way[..., 1]) <= 2) & (off <= view / 2)
    assert 0 < expected.sum() < expected.size
    np.testing.assert_array_equal(seen, expected)


def names(swarm, robots, tasks):
    """Return which tasks each robot knows by name, after the words of the robots' names."""
    words = swarm.knowledge[:, (robots + 31) // 32 :].astype(np.uint32)
    return (words[:, np.arange(tasks) >> 5] >> np.arange(tasks, dtype=np.uint32) % 32 & 1).astype(bool)


def test_a_robot_whose_step_is_no_unit_long_sees_all_round():
    world = in_world({**BLIND_RADIO, "robots.speed": 1e-12, "tasks.count": 50, "sensing.view": 1e-9})
    swarm = Swarm(world, seed=3)
    swarm.advance()
    way = np.mod(swarm.tasks[None] - swarm.positions[:, None] + 4, 8) - 4
    np.testing.assert_array_equal(names(swarm, 20, 50), np.hypot(way[..., 0], way[..., 1]) <= 2)


def test_robots_hear_all_round():
    narrow, wide = (
        Swarm(in_world({"sensing.view": view, "decision.strategy": "voter"}), seed=4) for view in (1.0, 359.9)
    )
    heard = 0
    for _ in range(20):
        narrow.advance()
        wide.advance()
        for i in range(20):
            senders = [[each[0] for each in swarm.robot(i).heard] for swarm in (narrow, wide)]
            assert senders[0] == senders[1]
            heard += len(senders[0])
    assert heard > 100


@pytest.mark.parametrize("name", [name for name, each in STRATEGIES.items() if each.all_round])
def test_strategies_that_conclude_from_what_they_do_not_see_need_an_all_round_view(name):
    changes = {"decision.strategy": name, "robots.know_count": True, "sensing.view": 359.0}
    with pytest.raises(ScenarioError, match="concludes from what it doesn't see in range") as caught:
        Scenario().replace(changes)
    (problem,) = caught.value.problems
    assert (problem.path, problem.value) == ("sensing.view", 359.0)


def test_strategies_that_take_what_they_do_not_see_for_absent_are_those_that_read_the_range_of_sight():
    assert {name for name, each in STRATEGIES.items() if each.all_round} == {"map", "roster"}


def test_strategies_are_told_half_the_width_of_the_strip_that_a_robot_sees():
    sights = [in_world({"sensing.view": view}).setting.sight for view in (360.0, 180.0, 60.0)]
    assert sights == [2.0, 2.0, 1.0]


@pytest.mark.quick(4)
def test_a_quiet_time_is_long_enough_for_a_narrow_view():
    changes = {"decision.strategy": "quiet-census", "robots.know_count": True, "tasks.count": 21}
    ends = {"run.steps": 1500, "run.stop_at_declarations": True}
    scenario = Scenario().replace({**changes, **ends, "sensing.view": 60.0})
    assert (simulate(scenario, runs=400, seed=5).declared_feasible.values > 0).sum() <= 4
