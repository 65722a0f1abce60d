"""Runs judged by the truth: of the step of their decision, and of their end."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, simulate
from feasibee.base.record import Record
from feasibee.results.measures import decided_right, ended_agreed, ended_right, mean_bits, robot_steps
from feasibee.studies.comparison import compare

CHANGING = Scenario(run={"steps": 3}, events=[{"step": 2, "tasks": 5}])


def changing():
    """Four runs whose tasks are infeasible from step 2 on; robots join at step 2."""
    record = Record.empty(0, 4, 0, 4)
    record.truth[:] = [1, 1, 0, 0]
    record.held[:] = [[-1, 1, 1, 1], [-1, -1, 1, 0], [-1, 0, 0, 0], [-1, -1, -1, -1]]
    record.decision[:] = 1, 1, 0, -1
    record.decision_step[:] = 1, 2, 1, -1
    record.robots_present[:] = [20, 20, 30, 30]
    record.bits_sent[:] = 80, 0, 40, 40
    return record


def test_a_decision_is_right_if_it_was_true_at_its_step():
    assert decided_right(changing(), CHANGING).tolist() == [True, False, False, False]


def test_a_decision_of_the_start_is_judged_by_the_truth_before_any_change():
    record = Record.empty(0, 2, 0, 4)
    record.truth[:] = [1, 0, 0, 0]
    record.decision[:], record.decision_step[:] = 1, [0, 1]
    assert decided_right(record, CHANGING).tolist() == [True, False]


def test_a_run_ends_right_if_it_holds_the_last_truth():
    assert ended_right(changing(), CHANGING).tolist() == [False, True, True, False]
    assert ended_right(changing(), CHANGING, True).tolist() == [True, False, False, False]
    assert ended_agreed(changing(), CHANGING).tolist() == [True, True, True, False]


def test_bits_are_per_robot_that_is_there():
    assert robot_steps(changing(), CHANGING).tolist() == [80] * 4
    assert mean_bits(changing(), CHANGING) == 160 / 320


def test_in_a_world_that_stays_the_truth_is_that_of_the_scenario():
    record = Record.empty(0, 3, 0)
    record.decision[:], record.decision_step[:] = [1, 0, -1], [4, 4, -1]
    record.feasible_at_end[:], record.infeasible_at_end[:] = [20, 0, 10], [0, 20, 10]
    record.bits_sent[:] = 1000
    for tasks, right in ((20, [True, False, False]), (21, [False, True, False])):
        scenario = Scenario(tasks={"count": tasks})
        assert decided_right(record, scenario).tolist() == right
        assert ended_right(record, scenario).tolist() == right
        np.testing.assert_array_equal(ended_agreed(record, scenario), [True, True, False])
    assert mean_bits(record, Scenario()) == 1000 / (20 * 1000)
    assert mean_bits(record, Scenario(run={"stop_at_decision": True})) == 3000 / (20 * (4 + 4 + 1000))
    record.last_step[:] = [5, 6, 1000]
    assert mean_bits(record, Scenario(run={"stop_at_declarations": True})) == 3000 / (20 * (5 + 6 + 1000))


def test_truths_of_too_many_runs_and_steps_are_refused_before_any_is_simulated():
    long = CHANGING.replace({"run.steps": 1_000_000})
    with pytest.raises(FeasibeeError, match=r"truths of 10000 runs .* simulate at most 2147 runs per call$"):
        simulate(long, runs=10_000)
    with pytest.raises(FeasibeeError, match="truths of 10000 runs"):
        compare({"long": long}, (), runs=10_000)
