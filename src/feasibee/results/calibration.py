"""Calibration: whether tasks are feasible as often as a swarm's robots say so.

The probability that a swarm gives to *feasible* is the mean of what its robots say at the last step, if their
strategy has a probability of its own. Else a swarm is read as an ensemble forecast: it is the share of its
robots that hold *feasible*. Scores and curves compare these probabilities with the ground truth.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.base.codes import CERTAIN
from feasibee.results.measures import column, counted_robots
from feasibee.results.statistics import Interval, mean_share, wilson
from feasibee.scenario.scenario import Scenario

OWN, SHARES = "robots' own probability", "share of robots"
"""What the probability of a swarm is: that of its robots, or the share of them that hold *feasible*."""
BINS: Final = 10
"""Number of bins of a calibration curve, of equal width."""
SURE: Final = 0.9
"""Probability of either truth from which on a swarm is called sure."""
ROUNDING: Final = 1e-9
"""A share this close to the edge of a bin is taken to be on it."""


class Bin(NamedTuple):
    """Runs in which the swarm gave about the same probability to *feasible*."""

    said: float
    """Mean of these probabilities."""
    runs: int
    """Number of these runs."""
    feasible: Interval
    """Share of these runs whose tasks are feasible."""


class Calibration(NamedTuple):
    """How good the probabilities are that swarms give to *feasible*."""

    brier: Interval
    """Mean squared distance of the probability from the truth, 1 or 0. 0 is best; always 1/2 gives 0.25."""
    sure: Interval | None
    """Share of runs that are right, of those with at least 90 % on one side; None without any."""
    reliability: float
    """Mean squared distance, in a bin, of what was said from the share of feasible tasks. 0 is best."""
    resolution: float
    """By how much the worlds differ from bin to bin. At most the uncertainty, which is best."""
    uncertainty: float
    """Variance of the truth: the score of always saying the share of feasible tasks in all runs."""
    bins: tuple[Bin, ...]
    """The calibration curve, by rising probability; empty bins are left out."""


def said_feasible(results: Any, scenario: Scenario) -> NDArray[np.float64]:
    """Return the probability that each swarm gives to *feasible* at its last step: shape (runs,).

    It is the mean of what the counted robots say, or what `held_feasible` returns if their strategy has no
    probability of its own. ``results`` has each outcome as an attribute.
    """
    if not scenario.gives_probability:
        return held_feasible(results, scenario)
    said = column(results, "said_at_end") / CERTAIN
    mean: NDArray[np.float64] = said / np.maximum(1, counted_robots(results, scenario))
    return mean


def held_feasible(results: Any, scenario: Scenario) -> NDArray[np.float64]:
    """Return the share of the counted robots that hold *feasible* at the last step: shape (runs,).

    A robot without an opinion counts as half. In a world that changes, no run has a share.
    """
    if scenario.dynamic:
        return np.empty(0)
    feasible, infeasible = (column(results, f"{name}_at_end") for name in ("feasible", "infeasible"))
    lead: NDArray[np.float64] = (feasible - infeasible) / np.maximum(1, counted_robots(results, scenario))
    return 0.5 + 0.5 * lead


def calibration(said: ArrayLike, feasible: ArrayLike) -> Calibration | None:
    """Return how good probabilities are; None unless there are worlds of both truths.

    The score is reliability - resolution + uncertainty. Resolution has a part of each bin for probabilities
    that differ in it, without which that wouldn't hold.

    Parameters
    ----------
    said : array of float, shape (runs,)
        Probability that each swarm gave to *feasible*.
    feasible : array of bool, shape (runs,)
        Whether the tasks of each run are feasible.

    References
    ----------
    Brier, "Verification of forecasts expressed in terms of probability", 1950; its parts: Murphy, "A new
    vector partition of the probability score", 1973; the part within bins: Stephenson, Coelho, Jolliffe, "Two
    extra components in the Brier score decomposition", 2008.

    Examples
    --------
    >>> from feasibee.results.calibration import calibration
    >>> calibration([1.0, 1.0, 0.5, 0.0], [True, True, False, False]).brier.estimate
    0.0625
    """
    said, true = np.asarray(said, np.float64), np.asarray(feasible, np.bool_)
    if not said.size or true.all() or not true.any():
        return None
    sure = np.abs(said - 0.5) >= SURE - 0.5 - ROUNDING
    right = (said > 0.5) == true
    which = np.minimum(np.floor(BINS * said + ROUNDING), BINS - 1)
    each_bin = [which == each for each in np.unique(which)]
    return Calibration(
        mean_share((said - true) ** 2),
        _share(right[sure]) if sure.any() else None,
        *_parts([said[rows] for rows in each_bin], [true[rows] for rows in each_bin]),
        tuple(Bin(float(said[rows].mean()), int(rows.sum()), _share(true[rows])) for rows in each_bin),
    )


def _parts(said: list[NDArray[np.float64]], true: list[NDArray[np.bool_]]) -> tuple[float, float, float]:
    """Return reliability, resolution and uncertainty, from the probabilities and truths of each bin."""
    base, runs = np.concatenate(true).mean(), sum(each.size for each in said)
    reliability = resolution = 0.0
    for told, came in zip(said, true, strict=True):
        differing = told - told.mean()
        reliability += told.size * (told.mean() - came.mean()) ** 2
        resolution += told.size * (came.mean() - base) ** 2 + (differing * (2 * came - differing)).sum()
    return float(reliability / runs), float(resolution / runs), float(base * (1 - base))


def _share(holds: NDArray[np.bool_]) -> Interval:
    return wilson(int(holds.sum()), holds.size)
