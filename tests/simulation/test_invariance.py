"""The same bytes, however the work is cut."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.base.outcomes import OUTCOMES
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

SCENARIOS = {
    "few": Scenario(tasks={"count": 30}, run={"steps": 200}),
    "many": Scenario(robots={"count": 50}, arena={"side": 10.0}, run={"steps": 100}),
    "stopping": Scenario(tasks={"count": 4}, run={"stop_at_decision": True}),
}


def bytes_of(record):
    return record.decision.tobytes(), record.decision_step.tobytes(), record.feasible_count.tobytes()


@pytest.mark.parametrize("name", SCENARIOS)
def test_threads_and_chunks_change_nothing(name):
    expected = bytes_of(simulate_record(SCENARIOS[name], Runs(23, 9), curves=True, threads=1, chunk=23))
    for threads, chunk in ((1, 1), (2, 1), (2, 7), (3, None), (1, None)):
        record = simulate_record(SCENARIOS[name], Runs(23, 9), curves=True, threads=threads, chunk=chunk)
        assert bytes_of(record) == expected, (threads, chunk)


@pytest.mark.parametrize("name", SCENARIOS)
def test_any_subset_of_runs_is_the_same(name):
    whole = simulate_record(SCENARIOS[name], Runs(12, 4), curves=True)
    part = simulate_record(SCENARIOS[name], Runs(5, 4, 6), curves=True)
    assert bytes_of(part) == bytes_of(whole.part(6, 11))


def test_curves_change_no_decision():
    without = simulate_record(SCENARIOS["few"], Runs(10, 4))
    assert without.feasible_count.shape == (10, 0)
    np.testing.assert_array_equal(
        without.decision_step, simulate_record(SCENARIOS["few"], Runs(10, 4), curves=True).decision_step
    )


def test_stopping_at_the_decision_changes_no_decision():
    going_on = SCENARIOS["stopping"].replace({"run.stop_at_decision": False})
    stopped = simulate_record(SCENARIOS["stopping"], Runs(50, 8), curves=True)
    whole = simulate_record(going_on, Runs(50, 8), curves=True)
    np.testing.assert_array_equal(stopped.decision, whole.decision)
    np.testing.assert_array_equal(stopped.decision_step, whole.decision_step)
    for row, last in enumerate(stopped.decision_step):
        np.testing.assert_array_equal(
            stopped.feasible_count[row, : last + 1], whole.feasible_count[row, : last + 1]
        )
        assert (stopped.feasible_count[row, last + 1 :] == -1).all()


def test_seeds_and_runs_differ():
    curves = [
        simulate_record(SCENARIOS["few"], Runs(2, seed), curves=True).feasible_count[row].tobytes()
        for seed in (0, 1, 2**32, 2**64 - 1)
        for row in (0, 1)
    ]
    assert len(set(curves)) == 8


@pytest.mark.parametrize("stop", [0, 250])
def test_stopping_at_the_declarations_changes_bits_alone(stop):
    """Also if a robot stops later: it counts no longer from that step on (model.md 6.15.8)."""
    going_on = Scenario(
        tasks={"count": 21},
        decision={"strategy": "quiet-census"},
        faults={"stopped": {"count": 1}, "stop_step": stop},
        run={"steps": 300},
    )
    stopping = going_on.replace({"run.stop_at_declarations": True})
    stopped = simulate_record(stopping, Runs(50, 8), curves=True)
    whole = simulate_record(going_on, Runs(50, 8), curves=True)
    assert (whole.last_step == 300).all()
    assert stop <= stopped.last_step.min() < 300
    assert (stopped.bits_sent < whole.bits_sent).all()
    for name in {each.name for each in OUTCOMES} - {"bits_sent", "last_step"}:
        np.testing.assert_array_equal(getattr(stopped, name), getattr(whole, name), name)
    for row, last in enumerate(stopped.last_step):
        counts = whole.feasible_count[row]
        np.testing.assert_array_equal(stopped.feasible_count[row, : last + 1], counts[: last + 1])
        assert (stopped.feasible_count[row, last + 1 :] == -1).all()
        assert (counts[last:] == counts[last]).all()
