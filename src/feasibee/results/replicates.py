"""Statistics whose unit is the run: steps of one run depend on each other, runs don't."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.results.statistics import CONFIDENCE, Interval, normal_quantile

SHARES = (0.25, 0.5, 0.75)
"""Shares of the durations that the quartiles bound."""
ROUNDING = 1e-9
"""A product of floats may exceed the exact share by so much."""


class Quartiles(NamedTuple):
    """Durations by which a quarter, half and three quarters of all events had happened; None if unknown."""

    q25: int | None
    median: int | None
    q75: int | None


def mean_share(shares: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return the mean of the runs' shares of steps, with an adjusted Wald interval over runs.

    The interval is that of Wald with one further run of share 0 and one of share 1. Its width is never zero.

    Parameters
    ----------
    shares : array of float, shape (runs,)
        A share of each run, 0 to 1, at least one.
    confidence : float
        Confidence level, between 0 and 1.

    Raises
    ------
    ValueError
        If there are no runs, or a share isn't between 0 and 1.

    References
    ----------
    Runs as units: Law, "Simulation Modeling and Analysis", 2015, section 9.5 (replication/deletion).
    The adjustment: Bonett, Price, "Adjusted Wald confidence interval for a difference of binomial
    proportions based on paired data", 2012, after Agresti and Coull, 1998.

    Examples
    --------
    >>> from feasibee.results.replicates import mean_share
    >>> [round(each, 3) for each in mean_share([0.9, 0.8, 1.0] * 30)]
    [0.9, 0.866, 0.917]
    """
    values = np.asarray(shares, np.float64)
    if not values.size or not ((values >= 0) & (values <= 1)).all():
        raise ValueError(f"shares of {values.size} runs: must be at least one, each from 0 to 1")
    sums = float(values.sum()) + 1, float(values @ values) + 1
    centre, half = _wald(*sums, values.size + 2, confidence)
    estimate = float(values.mean())
    return Interval(estimate, max(0.0, min(estimate, centre - half)), min(1.0, max(estimate, centre + half)))


def event_rate(events: ArrayLike, exposure: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return events per unit of exposure, with a score interval that allows for events in clusters.

    The interval is the score interval of a Poisson rate. If the runs' counts vary more than Poisson counts
    do, events and exposure are divided by the dispersion first: events of one run that come together count
    as fewer.

    Parameters
    ----------
    events : array of int, shape (runs,)
        Number of events of each run.
    exposure : array of float, shape (runs,)
        For how long each run was watched, such as its steps; above 0 in total.
    confidence : float
        Confidence level, between 0 and 1.

    Raises
    ------
    ValueError
        If the exposure isn't above 0 in total.

    References
    ----------
    McCullagh, Nelder, "Generalized Linear Models", 1989, section 6.2 (dispersion). Barker, "A comparison of
    nine confidence intervals for a Poisson parameter when the expected number of events is <= 5", 2002.

    Examples
    --------
    >>> from feasibee.results.replicates import event_rate
    >>> [round(each, 5) for each in event_rate([0] * 10, [100] * 10)]
    [0.0, 0.0, 0.00384]
    """
    counts, watched = np.asarray(events, np.float64), np.asarray(exposure, np.float64)
    total, time = float(counts.sum()), float(watched.sum())
    if time <= 0:
        raise ValueError(f"exposure = {time:g} in total: must be above 0")
    z, dispersion = normal_quantile(confidence), _dispersion(counts, watched, total / time)
    total, time = total / dispersion, time / dispersion
    half = z * math.sqrt(total + z * z / 4)
    centre = total + z * z / 2
    return Interval(total / time, max(0.0, centre - half) / time, (centre + half) / time)


def _dispersion(counts: NDArray[np.float64], watched: NDArray[np.float64], rate: float) -> float:
    """Return by how much counts vary more than Poisson counts of one rate do; at least 1."""
    used = watched > 0
    if rate == 0 or used.sum() < 2:
        return 1.0
    expected = rate * watched[used]
    return max(1.0, float(((counts[used] - expected) ** 2 / expected).sum() / (used.sum() - 1)))


def quartiles(durations: ArrayLike, watched: ArrayLike) -> Quartiles:
    """Return the quartiles of durations until an event, by the product-limit estimate.

    If nothing was censored before the last event, they are those of `decision_times`: an event that did not
    happen counts as later than any.

    Parameters
    ----------
    durations : array of int
        Duration until each event; -1 if it was censored: it did not happen while it was watched.
    watched : array of int, same shape
        Last duration at which the event was watched for.

    Returns
    -------
    Quartiles
        First durations by which the estimated share of events is at least a quarter, half and three quarters;
        None if the estimate does not reach it.

    References
    ----------
    Kaplan, Meier, "Nonparametric estimation from incomplete observations", JASA 1958.

    Examples
    --------
    >>> from feasibee.results.replicates import quartiles
    >>> quartiles([30, 50, -1, 40], [500, 500, 20, 500])
    Quartiles(q25=30, median=40, q75=50)
    """
    first, last = np.asarray(durations, np.int64), np.asarray(watched, np.int64)
    ends = np.where(first >= 0, first, last)
    times, events = np.unique(first[first >= 0], return_counts=True)
    at_risk = ends.size - np.searchsorted(np.sort(ends), times)  # an end at the same time is after it
    happened = 1 - np.cumprod(1 - events / at_risk)
    places = np.searchsorted(happened, np.array(SHARES) - ROUNDING)
    return Quartiles(*(int(times[place]) if place < times.size else None for place in places))


def mean_difference(one: ArrayLike, other: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return the mean share of ``one`` minus that of ``other`` in the same runs, with its interval.

    The interval is that of Wald with one further run of difference 1 and one of -1. If each share is 0 or 1,
    it is that of ``paired_difference``.

    Parameters
    ----------
    one, other : array of float, shape (runs,)
        A share of each run, 0 to 1, at least one.
    confidence : float
        Confidence level, between 0 and 1.

    Examples
    --------
    >>> from feasibee.results.replicates import mean_difference
    >>> mean_difference([0.9, 0.8], [0.4, 0.3]).estimate
    0.5
    """
    differences = np.asarray(one, np.float64) - np.asarray(other, np.float64)
    if not differences.size or not (np.abs(differences) <= 1).all():
        raise ValueError(f"shares of {differences.size} runs: must be at least one, each from 0 to 1")
    sums = float(differences.sum()), float(differences @ differences) + 2
    centre, half = _wald(*sums, differences.size + 2, confidence)
    return Interval(float(differences.mean()), max(-1.0, centre - half), min(1.0, centre + half))


def _wald(total: float, squares: float, runs: int, confidence: float) -> tuple[float, float]:
    """Return a mean and half the width of its Wald interval, by the sum of the runs and that of squares."""
    centre = total / runs
    variance = squares / runs - centre * centre
    return centre, normal_quantile(confidence) * math.sqrt(variance / runs)


def mean_of(values: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return the mean of a number of each run, with its normal interval; NaN without two runs.

    Parameters
    ----------
    values : array of float, shape (runs,)
        Numbers without bounds, such as delays.
    confidence : float
        Confidence level, between 0 and 1.
    """
    numbers = np.asarray(values, np.float64)
    if numbers.size < 2:
        return Interval(float(numbers.mean()) if numbers.size else math.nan, math.nan, math.nan)
    mean = float(numbers.mean())
    half = normal_quantile(confidence) * float(numbers.std(ddof=1)) / math.sqrt(numbers.size)
    return Interval(mean, mean - half, mean + half)
