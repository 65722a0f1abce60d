"""How a swarm tracks a truth that changes: how often it is right, how late, and how often without reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.model.codes import DECISIONS
from feasibee.results.judging import robot_steps
from feasibee.results.replicates import Quartiles, event_rate, mean_share, quartiles
from feasibee.results.statistics import Interval, wilson
from feasibee.scenario.scenario import Scenario

PER: Final = 1000
"""Steps that false alarms are counted per."""
OF_RUNS: Final[Mapping[str, str]] = {
    "right_steps": "steps, from step 1 on, at which the swarm held the truth of that step",
    "changes": "changes of truth just before which the swarm was right",
    "missed": "changes of these that the swarm did not follow before the next one or the end",
    "first_delay": "steps until the swarm followed the first of these changes; -1: none, or missed",
    "false_alarms": "times that the swarm took up the wrong opinion though the truth had not changed",
    "robot_steps": "robots present, summed over the steps from step 1 on",
}
"""Measures of single runs, in words."""


class Changes(NamedTuple):
    """Changes of the truth just before which a swarm was right, in the order of runs and steps."""

    run: NDArray[np.int64]
    """Row of the run."""
    step: NDArray[np.int64]
    """Step of the change."""
    delay: NDArray[np.int64]
    """Steps until the swarm held the new truth; -1 if it did not before the next change or the end."""
    watched: NDArray[np.int64]
    """Last delay that could have been seen: up to the step before the next change, or up to the end."""


class Tracking(NamedTuple):
    """Measures of runs in a world that changes."""

    right_share: Interval
    """Share of steps at which the swarm held the truth of that step, mean over runs."""
    detection_delay: Quartiles
    """Steps from a change of truth to the first step at which the swarm held the new truth."""
    missed: Interval | None
    """Share of changes that the swarm did not follow before the next one or the end; None without any."""
    changes: int
    """Number of changes of truth just before which the swarm was right: those that delays are of."""
    false_alarms: Interval
    """Number of false alarms per 1,000 steps."""

    def to_dict(self) -> dict[str, Any]:
        """Return the measures as plain tables, for programs."""
        return {
            "right_share": self.right_share._asdict(),
            "detection_delay": {**self.detection_delay._asdict(), "changes": self.changes},
            "missed": None if self.missed is None else self.missed._asdict(),
            "false_alarms": self.false_alarms._asdict(),
        }


class RunCounts(NamedTuple):
    """What is counted of runs in a world that changes; runs of several scenarios can be joined."""

    steps: NDArray[np.int64]
    """Number of steps, by run."""
    right: NDArray[np.int64]
    """Number of steps at which the swarm was right, by run."""
    alarms: NDArray[np.int64]
    """Number of false alarms, by run."""
    delay: NDArray[np.int64]
    """Delay of each of the `Changes` of all runs."""
    watched: NDArray[np.int64]
    """Last delay that could have been seen of each."""


def tracking(results: Any, scenario: Scenario, first_step: int = 1) -> Tracking | None:
    """Return how swarms tracked the truth; None in a world that doesn't change, or without steps.

    Parameters
    ----------
    results : Record or Dataset
        Runs of the scenario, with ``truth`` and ``held``.
    scenario : Scenario
        What the runs were simulated from.
    first_step : int
        Steps before it, and changes and alarms at them, aren't counted: a warm-up.

    Notes
    -----
    A *change* is a step whose truth differs from that of the step before. A *false alarm* is a step at which
    a swarm takes up the wrong opinion, although the last opinion that it held since the last change of truth
    was right. Delay and false alarms are the two sides of quickest detection [1]_ [2]_.

    References
    ----------
    .. [1] Page, "Continuous inspection schemes", Biometrika 1954.
    .. [2] Basseville, Nikiforov, "Detection of Abrupt Changes: Theory and Application", 1993.
    """
    found = counts_of(results, first_step) if scenario.dynamic else None
    return None if found is None or not found.steps.sum() else summarised([found])


def counts_of(results: Any, first_step: int = 1) -> RunCounts:
    """Return what is counted of runs in a world that changes; the arguments are those of `tracking`."""
    truth, held = np.asarray(results.truth), np.asarray(results.held)
    changes = changes_of(truth, held, first_step)
    return RunCounts(
        steps_of(truth, first_step),
        right_steps_of(truth, held, first_step),
        false_alarms_of(truth, held, first_step),
        changes.delay,
        changes.watched,
    )


def summarised(parts: Sequence[RunCounts]) -> Tracking:
    """Return the measures of some runs together, at least one of which has a step."""
    steps, right, alarms, delay, watched = (np.concatenate(each) for each in zip(*parts, strict=True))
    played, missed = steps > 0, int((delay < 0).sum())
    rate = event_rate(alarms, steps)
    return Tracking(
        mean_share(right[played] / steps[played]),
        quartiles(delay, watched),
        wilson(missed, delay.size) if delay.size else None,
        delay.size,
        Interval(*(PER * each for each in rate)),
    )


def measures_of_runs(results: Any) -> dict[str, NDArray[np.int64]]:
    """Return the measures `OF_RUNS` of each run of a world that changes: shape (runs,)."""
    truth, held = np.asarray(results.truth), np.asarray(results.held)
    runs, changes = truth.shape[0], changes_of(truth, held)
    first = np.full(runs, -1, np.int64)
    first[changes.run[::-1]] = changes.delay[::-1]  # the first change of a run is written last
    return {
        "right_steps": right_steps_of(truth, held),
        "changes": np.bincount(changes.run, minlength=runs),
        "missed": np.bincount(changes.run[changes.delay < 0], minlength=runs),
        "first_delay": first,
        "false_alarms": false_alarms_of(truth, held),
        "robot_steps": robot_steps(results),
    }


def steps_of(truth: ArrayLike, first_step: int = 1) -> NDArray[np.int64]:
    """Return the number of simulated steps of each run from a step on: shape (runs,)."""
    counts: NDArray[np.int64] = (np.asarray(truth)[:, first_step:] >= 0).sum(axis=1)
    return counts


def right_steps_of(truth: ArrayLike, held: ArrayLike, first_step: int = 1) -> NDArray[np.int64]:
    """Return the number of steps of each run at which its swarm held the truth of that step: shape (runs,).

    Parameters
    ----------
    truth, held : int8 array, shape (runs, steps + 1)
        As in ``feasibee.model.record.Record``.
    first_step : int
        First step that counts.
    """
    counts: NDArray[np.int64] = _is_right(truth, held)[:, first_step:].sum(axis=1)
    return counts


def right_shares(results: Any, first_step: int = 1) -> NDArray[np.float64]:
    """Return the share of steps at which each swarm held the truth of that step: shape (runs,)."""
    steps = np.maximum(1, steps_of(results.truth, first_step))
    shares: NDArray[np.float64] = right_steps_of(results.truth, results.held, first_step) / steps
    return shares


def changes_of(truth: ArrayLike, held: ArrayLike, first_step: int = 1) -> Changes:
    """Return the changes of truth just before which a swarm was right, and when it followed them.

    Parameters
    ----------
    truth, held : int8 array, shape (runs, steps + 1)
        As in ``feasibee.model.record.Record``.
    first_step : int
        First step whose change counts.
    """
    truths, right = np.asarray(truth), _is_right(truth, held)
    length = truths.shape[1]
    row, step = np.nonzero(_changed(truths))
    end = (truths >= 0).sum(axis=1)[row]  # the step after the last one watched
    same = row[1:] == row[:-1]
    end[:-1][same] = step[1:][same]
    first = row * length + step
    found = np.append(np.flatnonzero(right.ravel()), right.size)
    followed = found[np.searchsorted(found, first)]
    delay = np.where(followed < row * length + end, followed - first, -1)
    counts = right[row, step - 1] & (step >= first_step)
    return Changes(row[counts], step[counts], delay[counts], (end - 1 - step)[counts])


def false_alarms_of(truth: ArrayLike, held: ArrayLike, first_step: int = 1) -> NDArray[np.int64]:
    """Return the number of false alarms of each run: shape (runs,).

    Parameters
    ----------
    truth, held : int8 array, shape (runs, steps + 1)
        As in ``feasibee.model.record.Record``.
    first_step : int
        First step whose alarm counts.
    """
    truths, opinions = np.asarray(truth), np.asarray(held)
    runs, length = truths.shape
    starts = _changed(truths)
    starts[:, :1] = True
    stretch = np.cumsum(starts.ravel())  # steps of one run and one truth have the same number
    at = np.flatnonzero(((opinions >= 0) & (truths >= 0)).ravel())
    right = _is_right(truth, held).ravel()[at]
    alarm = np.zeros(at.size, np.bool_)
    alarm[1:] = right[:-1] & ~right[1:] & (stretch[at[1:]] == stretch[at[:-1]])
    places = at[alarm]
    return np.bincount(places[places % length >= first_step] // length, minlength=runs)


def quartiles_of_present(feasible_count: ArrayLike, robots_present: ArrayLike) -> NDArray[np.float64]:
    """Return the quartiles over runs of the percentage of the robots present with opinion 1.

    Parameters
    ----------
    feasible_count, robots_present : int32 array, shape (runs, steps + 1)
        As in ``feasibee.model.record.Record``.

    Returns
    -------
    float64 array, shape (3, steps + 1)
        Lower quartile, median and upper quartile, in percent.
    """
    shares = 100.0 * np.asarray(feasible_count) / np.maximum(1, np.asarray(robots_present))
    return np.asarray(np.quantile(shares, (0.25, 0.5, 0.75), axis=0))


def truth_intervals(truth: ArrayLike) -> list[dict[str, Any]] | None:
    """Return the stretches of steps with one truth, if all runs share them; else None.

    Parameters
    ----------
    truth : int8 array, shape (runs, steps + 1)
        As in ``feasibee.model.record.Record``.

    Examples
    --------
    >>> from feasibee.results.tracking import truth_intervals
    >>> truth_intervals([[1, 1, 0]])
    [{'first': 0, 'last': 1, 'truth': 'feasible'}, {'first': 2, 'last': 2, 'truth': 'infeasible'}]
    """
    truths = np.asarray(truth)
    if not truths.size or (truths != truths[0]).any():
        return None
    shared = truths[0][truths[0] >= 0]
    edges = [0, *(np.flatnonzero(np.diff(shared)) + 1).tolist(), shared.size]
    return [
        {"first": first, "last": after - 1, "truth": DECISIONS[int(shared[first])]}
        for first, after in pairwise(edges)
    ]


def _is_right(truth: ArrayLike, held: ArrayLike) -> NDArray[np.bool_]:
    """Return whether each swarm held the truth at each step; False after the end of a run."""
    truths = np.asarray(truth)
    right: NDArray[np.bool_] = (np.asarray(held) == truths) & (truths >= 0)
    return right


def _changed(truths: NDArray[Any]) -> NDArray[np.bool_]:
    """Return whether the truth of each step differs from that of the step before."""
    changed = np.zeros(truths.shape, np.bool_)
    changed[:, 1:] = (truths[:, 1:] != truths[:, :-1]) & (truths[:, 1:] >= 0)
    return changed
