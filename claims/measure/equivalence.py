"""Test whether two simulators are equivalent within margins, by two one-sided tests: docs/argos.md.

Both tests at 5 % show equivalence exactly if the 90 % interval of the difference lies within the margins.
"""

from __future__ import annotations

import math
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


def power(share: float, runs: tuple[int, int]) -> float:
    """Return the probability that two equal shares are found equivalent, by the normal approximation."""
    error = math.sqrt(share * (1 - share) * sum(1 / each for each in runs))
    return max(0.0, 2 * NormalDist().cdf(RATE[1] / error - normal_quantile(CONFIDENCE)) - 1)
