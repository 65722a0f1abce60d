"""Robots that act and call for help (model.md 6.19, 6.25), in engine and reference."""

from __future__ import annotations

import numpy as np
import pytest
from test_equivalence import assert_equal

from feasibee import Scenario, simulate

SMALL = {"arena.side": 10.0, "robots.count": 5, "robots.know_count": True, "decision.strategy": "roster"}
CALLING = {"response.patience": 3, "response.delay": 20, "run.steps": 400, "robots.most": 15}


def calling(tasks, start, **changes):
    return Scenario().replace({**SMALL, **CALLING, "tasks.count": tasks, "acting.start": start, **changes})


@pytest.mark.parametrize("tasks", [3, 5, 7, 9])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"run.stop_when_taken": True, "acting.choose": "rank"},
        {"acting.hold": "tag", "events": [{"step": 60, "robots": 3}]},
        {"robots.failure_rate": 0.002, "tasks.lifetime": 200.0},
    ],
)
def test_engine_equals_reference_with_help(tasks, changes):
    assert_equal(calling(tasks, 30, **changes), 5, runs=2, first_run=0)


def test_robots_start_once_the_missing_ones_have_come():
    """Before that they know more tasks than robots. Who joins is announced, or they would never start."""
    found = simulate(calling(8, 60, **{"run.stop_when_taken": True}), runs=100, seed=1)
    assert (found.all_taken_step.values > 0).mean() > 0.95
    assert (found.robots_called.values >= 3).mean() > 0.95
    assert (found.starts_in_vain.values == 0).mean() > 0.9


def test_all_tasks_are_to_be_taken_if_robots_can_be_called():
    """Five robots stand at five of seven tasks, and tell nobody; without a call, that is all."""
    alone = calling(7, 0, **{"robots.know_count": False, "response.patience": 399})
    found = simulate(alone, runs=20, seed=1)
    assert set(found.tasks_taken.values) == {5}
    assert set(found.all_taken_step.values) == {-1}
    without = alone.replace({"response.patience": None, "response.delay": 100})
    assert (simulate(without, runs=20, seed=1).all_taken_step.values > 0).all()


def test_no_robot_that_acts_is_released():
    """Ten robots for five tasks hold feasible, and know that some are to spare."""
    acting = calling(5, 30, **{"robots.count": 10, "robots.most": None})
    resting = acting.replace({"acting.start": None})
    released = [simulate(each, runs=20, seed=1).robots_released.values for each in (acting, resting)]
    assert np.all(released[0] == 0)
    assert np.all(released[1] > 0)
