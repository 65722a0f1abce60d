"""Opinions that follow from knowledge in every step: a user's file in both implementations."""

from __future__ import annotations

import numpy as np
import pytest
from own_files import FADING, assert_same, controller, played, replaced

from feasibee import Scenario, reference
from feasibee.strategies.contract import Thing

SMALL = {"arena.side": 8.0, "run.steps": 60, "robots.know_count": True, "decision.gain": 5.0}
WORLDS = {
    "paper": {},
    "crowd, walls and bodies": {
        "robots.count": 300,
        "tasks.count": 150,
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
        "arena.side": 30.0,
        "run.steps": 25,
    },
    "faults": {
        "faults.stopped": 0.2,
        "faults.stop_step": 25,
        "faults.stubborn": 0.2,
        "faults.byzantine": 0.2,
        "decision.declare": {"quorum": 0.7, "rounds": 2, "heard": 2},
    },
}


def scenario_of(path, **changes):
    return Scenario().replace({**SMALL, "decision.strategy": str(path), **changes})


@pytest.mark.quick(1)
@pytest.mark.parametrize("world", WORLDS)
def test_judging_is_equal_in_engine_and_reference(write, world):
    record = assert_same(*2 * [scenario_of(write(FADING), **WORLDS[world])])
    changes = np.diff(record.feasible_count, axis=1) != 0
    assert changes.mean() > 0.2  # else opinions would follow at ends of phases only


def test_a_robot_holds_what_it_judged_and_at_minus_1_its_own_opinion(write):
    """Robot i judges -1 up to step i, then 0 and 1 by turns; `decide` keeps that."""
    own = "-1 if me.step < me.id else (me.step + me.id) % 2"
    faded = "    for k in range(len(known)):\n        known[k] = max(known[k] - 1, 0)\n    if"
    path = write(replaced(FADING, faded, f"    if me.step >= 0:\n        return {own}\n    if"))
    first = [robot.mind.opinion for robot in reference.Swarm(scenario_of(path), 3, 0).robots]
    for step, swarm in enumerate(played(scenario_of(path))):
        for number, robot in enumerate(swarm.robots):
            wanted = first[number] if step < number else (step + number) % 2
            assert robot.mind.opinion == wanted
    assert_same(*2 * [scenario_of(path)])


def test_a_stubborn_robot_is_asked_but_keeps_its_opinion(write):
    path = write(FADING)
    (*_, last) = swarms = list(played(scenario_of(path, **{"faults.stubborn": 0.99, "tasks.count": 2})))
    assert len({swarm.feasible_count for swarm in swarms}) == 1
    assert 0 < last.feasible_count < 20
    assert all(max(robot.mind.knowledge.words) < 9 for robot in last.robots)  # each was counted down


# --- On a robot ---


def test_a_controller_follows_what_it_knows(write):
    robot = controller(write(FADING), 3.0)
    robot.recognise([Thing(False, 4 + k, 0, 1, 1.0, 1.5) for k in range(3)])
    assert robot.knowledge.counted() == ([5], [4])  # three tasks in sight, and the one known at the start
    robot.end_step()
    assert (robot.opinion, robot.declared) == (0, -1)
    robot.end_step()
    robot.end_step()
    assert (robot.opinion, robot.knowledge.counted()) == (1, ([5], [0]))
