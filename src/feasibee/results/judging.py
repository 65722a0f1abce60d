"""Judge each run by the ground truth; in a world that changes, by that of the step in question."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import exact
from feasibee.results.statistics import bits_per_robot_and_step
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario


def decided_right(results: Any, scenario: Scenario) -> NDArray[np.bool_]:
    """Return whether the first collective decision of each run was the truth of its step: shape (runs,).

    Parameters
    ----------
    results : Record, Dataset or DataFrame
        Runs of the scenario, with each outcome as an attribute.
    scenario : Scenario
        What the runs were simulated from.
    """
    there = truth_of_decisions(results) if scenario.dynamic else int(truth(scenario))
    right: NDArray[np.bool_] = column(results, "decision") == there
    return right


def truth_of_decisions(results: Any) -> NDArray[np.int8]:
    """Return the truth of the step of each run's first decision; of an undecided run, that of step 0."""
    truths, step = np.asarray(results.truth), np.maximum(column(results, "decision_step"), 0)
    there: NDArray[np.int8] = truths[np.arange(step.size), step]
    return there


def ended_right(results: Any, scenario: Scenario, feasible: bool | None = None) -> NDArray[np.bool_]:
    """Return whether more than the threshold's share of each run's robots were right at the end.

    Parameters
    ----------
    results : Record, Dataset or DataFrame
        Runs of the scenario, with each outcome as an attribute.
    scenario : Scenario
        What the runs were simulated from.
    feasible : bool, optional
        The opinion that is right; by default the ground truth at the end of each run.
    """
    if scenario.dynamic:
        there = np.asarray(results.truth)[:, -1] if feasible is None else int(feasible)
        agreed: NDArray[np.bool_] = np.asarray(results.held)[:, -1] == there
        return agreed
    wanted = truth(scenario) if feasible is None else feasible
    return is_quorum(column(results, "feasible_at_end" if wanted else "infeasible_at_end"), results, scenario)


def ended_agreed(results: Any, scenario: Scenario) -> NDArray[np.bool_]:
    """Return whether more than the threshold's share of each run's robots agreed at the end, on either."""
    return ended_right(results, scenario, True) | ended_right(results, scenario, False)


def mean_bits(results: Any, scenario: Scenario) -> float:
    """Return the mean number of bits per robot-step over all runs; robots count while they are present."""
    if scenario.dynamic:
        return int(column(results, "bits_sent").sum()) / max(1, int(robot_steps(results).sum()))
    return bits_per_robot_and_step(
        column(results, "bits_sent"),
        column(results, "decision_step"),
        scenario.robots.count,
        scenario.run.steps,
        scenario.run.stop_at_decision,
    )


def robot_steps(results: Any) -> NDArray[np.int64]:
    """Return the number of robot-steps of each run in a world that changes: shape (runs,)."""
    present = np.asarray(results.robots_present)[:, 1:]
    total: NDArray[np.int64] = np.maximum(present, 0).sum(axis=1, dtype=np.int64)
    return total


def is_quorum(counts: NDArray[Any], results: Any, scenario: Scenario) -> NDArray[np.bool_]:
    """Return whether a number of robots of each run is more than the threshold's share of those that count.

    Robots may stop working during a run. A run may end at its decision, before they do.
    """
    needed, stop = exact(scenario.decision.threshold), scenario.faults.stop_step
    last = np.full(counts.size, scenario.run.steps)
    if scenario.run.stop_at_decision:
        decided = column(results, "decision_step")
        last = np.where(decided >= 0, decided, last)
    counted = np.where(last < stop, scenario.counted(0), scenario.counted(stop))
    enough: NDArray[np.bool_] = counts * needed.denominator > counted * needed.numerator
    return enough


def column(results: Any, name: str) -> NDArray[np.int64]:
    """Return an outcome as 64-bit integers: shape (runs,)."""
    return np.asarray(getattr(results, name)).astype(np.int64)
