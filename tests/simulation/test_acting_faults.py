"""Runs in which robots act end although some lie or stop (model.md 6.25.14, 6.26.5), in both backends."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.reference import play
from feasibee.reference.mind import HONEST
from tests.equal import assert_equal

ACTING = {"arena.side": 12.0, "acting.start": 0, "run.steps": 400, "run.stop_when_taken": True}
SMALL = {**ACTING, "robots.count": 8, "tasks.count": 8}
LIAR = {"faults.byzantine": {"count": 1}}
SKILLED = {
    "robots.classes": [
        {"name": "arm", "count": 2, "skills": ["lift"]},
        {"name": "eye", "count": 6, "skills": ["scan"]},
    ],
    "tasks.classes": [
        {"name": "load", "count": 4, "needs": {"lift": 1}},
        {"name": "look", "count": 4, "needs": {"scan": 1}},
    ],
}


def faulty_arms(scenario, runs):
    """Return for each run how many of the two robots that lift are faulty."""
    swarms = [next(play(scenario, 1, run)) for run in range(runs)]
    return np.array([sum(robot.fault != HONEST for robot in swarm.robots[:2]) for swarm in swarms])


@pytest.mark.parametrize(
    ("changes", "tasks"),
    [
        (LIAR, 7),
        ({"faults.stopped": {"count": 2}}, 6),
        ({"faults.stopped": {"count": 1}, "faults.stop_step": 15}, 7),
        ({"faults.stubborn": {"count": 2}}, 8),
        ({**LIAR, "tasks.count": 9, "events": [{"step": 5, "tasks": -1}]}, 7),
    ],
)
def test_a_run_ends_once_tasks_are_taken_by_all_robots_that_are_honest_and_work(changes, tasks):
    record = assert_equal(Scenario().replace({**SMALL, **changes}), 1, runs=6)
    assert set(record.tasks_taken) == {tasks}
    np.testing.assert_array_equal(record.all_taken_step, record.last_step)


def test_robots_that_stop_later_may_have_taken_all_tasks_before():
    stopping = {"faults.stopped": {"count": 1}, "faults.stop_step": 390}
    record = assert_equal(Scenario().replace({**SMALL, **stopping}), 1, runs=6)
    assert set(record.tasks_taken) == {8}
    assert (record.all_taken_step < 390).all()


def test_which_tasks_can_be_taken_depends_on_the_skills_of_those_that_lie():
    """Two of eight robots lift: a liar among them leaves one more task, another liar leaves none."""
    scenario = Scenario().replace({**ACTING, **SKILLED, **LIAR})
    record, faulty = assert_equal(scenario, 1, runs=20), faulty_arms(scenario, 20)
    assert set(faulty) == {0, 1}
    np.testing.assert_array_equal(record.tasks_taken, 6 - faulty)
    np.testing.assert_array_equal(record.all_taken_step, record.last_step)


@pytest.mark.parametrize("stop_step", [0, 25])
def test_tasks_that_no_honest_working_robot_can_do_need_not_be_done(stop_step):
    """What robots did before they stopped doesn't stand for tasks that others can still do."""
    stopping = {"faults.stopped": {"count": 5}, "faults.stop_step": stop_step}
    scenario = Scenario().replace({**ACTING, **SKILLED, **stopping, "tasks.work": 10})
    record, faulty = assert_equal(scenario, 1, runs=12), faulty_arms(scenario, 12)
    assert set(faulty) == {0, 1, 2}
    np.testing.assert_array_equal(record.all_done_step, record.last_step)
    assert (record.tasks_taken[faulty < 2] == 8).all()
    assert (record.tasks_taken[faulty == 2] < 8).any()
    for run in np.flatnonzero(faulty == 2):
        swarms = [*islice(play(scenario, 1, int(run)), int(record.all_done_step[run]) + 1)]
        assert {4, 5, 6, 7} <= swarms[-1].work.done
