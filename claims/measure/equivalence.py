"""Test whether two simulators are equivalent within margins, by two one-sided tests: docs/argos.md.

Both tests at 5 % show equivalence exactly if the 90 % interval of the difference lies within the margins.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from feasibee.results.statistics import Interval, normal_quantile, wilson

RATE = (-0.05, 0.05)
"""Margins for the difference of two shares."""
RATIO = (0.90, 1.10)
"""Margins for the ratio of two means."""
CONFIDENCE = 0.90


class Mean(NamedTuple):
    """A mean with its standard error."""

    mean: float
    error: float


def mean_of(values: ArrayLike, weights: ArrayLike | None = None) -> Mean:
    """Return the mean over independent runs, weighted by their lengths, with its standard error."""
    values = np.asarray(values, np.float64)
    weights = np.ones(values.size) if weights is None else np.asarray(weights, np.float64)
    mean = np.average(values, weights=weights)
    spread = (weights**2 * (values - mean) ** 2).sum() * values.size / (values.size - 1)
    return Mean(float(mean), float(math.sqrt(spread) / weights.sum()))


def difference(one: tuple[int, int], other: tuple[int, int]) -> Interval:
    """Return the share of one minus that of another, each as successes and runs, with its 90 % interval.

    References
    ----------
    Newcombe, "Interval estimation for the difference between independent proportions", 1998, method 10.
    """
    first, second = (wilson(*each, confidence=CONFIDENCE) for each in (one, other))
    estimate = first.estimate - second.estimate
    below = math.hypot(first.estimate - first.low, second.high - second.estimate)
    above = math.hypot(first.high - first.estimate, second.estimate - second.low)
    return Interval(estimate, estimate - below, estimate + above)


def mean_difference(found: Sequence[Interval]) -> Interval:
    """Return the mean of independent differences with its 90 % interval, from their 90 % intervals.

    References
    ----------
    Zou, Donner, "Construction of confidence limits about effect measures: a general approach", 2008.
    """
    estimate = math.fsum(each.estimate for each in found) / len(found)
    below = math.hypot(*(each.estimate - each.low for each in found)) / len(found)
    above = math.hypot(*(each.high - each.estimate for each in found)) / len(found)
    return Interval(estimate, estimate - below, estimate + above)


def ratio(one: Mean, other: Mean) -> Interval:
    """Return the ratio of two independent means, with its 90 % interval: normal for the logarithm."""
    estimate = one.mean / other.mean
    half = normal_quantile(CONFIDENCE) * math.hypot(one.error / one.mean, other.error / other.mean)
    return Interval(estimate, estimate * math.exp(-half), estimate * math.exp(half))


def verdict(found: Interval, margins: tuple[float, float]) -> str:
    """Return whether an interval shows that a difference is within its margins, beyond them, or neither."""
    low, high = margins
    if low < found.low and found.high < high:
        return "equivalent"
    return "different" if found.high < low or high < found.low else "not shown"


def tested(found: Interval, margins: tuple[float, float]) -> dict[str, Any]:
    """Return an interval with its verdict."""
    return {**found._asdict(), "verdict": verdict(found, margins)}


def overall(verdicts: Sequence[str]) -> str:
    """Return the verdict on several rows: equivalent if all are, different if one is."""
    if "different" in verdicts:
        return "different"
    return "equivalent" if set(verdicts) == {"equivalent"} else "not shown"


def power(rows: Sequence[tuple[float, tuple[int, int]]]) -> float:
    """Return the probability that the mean difference of equal shares is found equivalent, by normal errors.

    Parameters
    ----------
    rows : sequence of (share, (runs, runs))
        The share that both have, and the numbers of runs of one and of the other.
    """
    variances = [share * (1 - share) * sum(1 / each for each in runs) for share, runs in rows]
    error = math.sqrt(sum(variances)) / len(rows)
    return max(0.0, 2 * NormalDist().cdf(RATE[1] / error - normal_quantile(CONFIDENCE)) - 1)
