"""The live arena of robots that act: frames, and what is said of a robot."""

from __future__ import annotations

import re

import numpy as np
import pytest
from playing import swarm_at
from serving import decode

from feasibee import Scenario, Swarm
from feasibee.live.messages import NO_TASK, encode_frame
from feasibee.live.reasons import reasons_of
from feasibee.simulation.snapshot import FLAGS

SCENARIO = Scenario(acting={"start": 30}, robots={"know_count": True}, run={"steps": 200})
CHANGING = SCENARIO.replace({"events": [{"step": 35, "tasks": -9}, {"step": 40, "robots": -4, "tasks": 6}]})

WORKING = SCENARIO.replace({"tasks.work": 10})


def said(swarm, robot):
    return dict(reasons_of(swarm, robot))["Acts"]


@pytest.mark.parametrize("scenario", [SCENARIO, CHANGING, SCENARIO.replace({"acting.hold": "tag"}), WORKING])
def test_a_frame_has_the_task_of_each_robot_and_what_is_taken(scenario):
    """Aims and tasks are told by place: those of a world that changes have other numbers."""
    swarm, met = Swarm(scenario, 3), set()
    for step in (0, 10, 31, 33, 36, 45, 90):
        swarm.advance(step - swarm.step)
        frame, numbers = decode(encode_frame(swarm, 0, 0)), swarm.task_numbers
        stands = (frame["flags"] >> FLAGS.index("standing") & 1).astype(bool)
        np.testing.assert_array_equal(stands, swarm.standing)
        for robot, aim in enumerate(frame["aims"].tolist()):
            task = -1 if aim == NO_TASK else numbers[aim]
            held = np.flatnonzero(swarm.holders == robot).tolist() if stands[robot] else []
            target = swarm.targets[robot]
            assert [task] == (held or [target if target in numbers else -1])
            met.add((task >= 0, bool(stands[robot])))
        looks = {-2: 2, -1: 0}
        assert frame["taken"].tolist() == [looks.get(each, 1) for each in swarm.holders[numbers].tolist()]
        assert (frame["standing"], frame["allTakenStep"]) == (swarm.standing.sum(), swarm.all_taken_step)
    assert met == {(False, False), (True, False), (True, True)}
    assert "aims" not in decode(encode_frame(Swarm(), 0, 0))


def test_a_robot_says_which_task_it_goes_to_and_why():
    swarm, met = swarm_at(30, SCENARIO, 3), set()
    while swarm.step < 60:
        swarm.advance()
        for robot in range(20):
            words, target = said(swarm, robot), swarm.targets[robot]
            known = swarm.news[robot][swarm.news[robot] >= 0]
            assert words.endswith(f"; knows {known.size} tasks, {(known == 0).sum()} of them as free")
            if swarm.standing[robot]:
                assert words.startswith(f"stands at task {np.flatnonzero(swarm.holders == robot)[0]};")
            elif target < 0:
                assert words.startswith("knows no free task that it can do;")
            else:
                way = (swarm.tasks[target] - swarm.positions[robot] + 10) % 20 - 10
                away, holder = np.hypot(*way), swarm.holders[target]
                assert words.startswith(f"walks to task {target}, {away:.1f} units away: it ")
                assert ("it sees that" in words) == (away <= 2)
                assert ("it saw or heard that it is free" in words) == (away > 2)
                assert (f", but robot {holder} has it" in words) == (holder >= 0)
            met.add(re.sub(r"[\d.]+", "0", words.split(";")[0]))
    assert len(met) == 5


@pytest.mark.parametrize(
    ("changes", "step", "words"),
    [
        ({}, 10, "acts from step 30 on"),
        (
            {"acting.start": "declared", "decision.strategy": "quiet-census"},
            10,
            "acts once it declares feasible",
        ),
        ({"tasks.count": 40}, 90, "doesn't act: it knows more tasks than there are robots"),
        (
            {"tasks.count": 40, "decision.strategy": "quiet-census", "acting.start": "declared"},
            120,
            "doesn't act: it has declared infeasible",
        ),
        ({"acting.hold": "tag"}, 25, r"has marked task \d+, and acts from step 30 on"),
        ({"acting.hold": "tag"}, 30, r"walks to task \d+, [\d.]+ units away: it has marked it"),
        ({}, 31, r"walks to task \d+, [\d.]+ units away: it (saw or heard|sees) that it is free"),
    ],
)
def test_a_robot_says_why_it_does_not_act_yet(changes, step, words):
    swarm = swarm_at(step, SCENARIO.replace(changes), 3)
    assert any(re.match(rf"{words}(, but robot \d+ has it)?;", said(swarm, robot)) for robot in range(20))


def test_a_robot_walks_to_a_task_that_has_vanished():
    swarm, words = swarm_at(35, CHANGING, 3), []
    for robot in np.flatnonzero(swarm.targets >= 0).tolist():
        gone = swarm.targets[robot] not in swarm.task_numbers
        assert ("but it has vanished" in said(swarm, robot)) == gone
        words.append(gone)
    assert set(words) == {True, False}


def test_a_robot_walks_to_a_task_that_is_done():
    swarm, words = swarm_at(35, WORKING, 3), []
    while swarm.step < 80:
        swarm.advance()
        words += [said(swarm, robot) for robot in range(20)]
    assert any("saw or heard that it is free, but it is done;" in each for each in words)
    assert swarm.acting.achieved.endswith(f" of 20 tasks and have done {(swarm.holders == -2).sum()}")
