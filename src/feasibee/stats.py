"""Statistics of decisions: how often, how sure, how soon."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.vocabulary import DECISIONS, FEASIBLE, INFEASIBLE

CONFIDENCE = 0.95


class Interval(NamedTuple):
    """An estimate and where the truth lies with the confidence asked for."""

    estimate: float
    low: float
    high: float


class DecisionTimes(NamedTuple):
    """By which step a quarter, half and three quarters of all runs had decided; None: not in time."""

    q25: int | None
    median: int | None
    q75: int | None


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return a rate with its Wilson score interval.

    Parameters
    ----------
    successes, trials : int
        How often it happened, of how many times; at least one trial.
    confidence : float
        Between 0 and 1.

    Returns
    -------
    Interval
        Within [0, 1]; never of zero width, even for 0 of 100.

    Raises
    ------
    ValueError
        If there are no trials, or not 0 <= successes <= trials, or not 0 < confidence < 1.

    References
    ----------
    Wilson, "Probable inference, the law of succession, and statistical inference", JASA 1927.

    Examples
    --------
    >>> from feasibee import wilson
    >>> _, low, high = wilson(0, 100)
    >>> round(low, 3), round(high, 3)
    (0.0, 0.037)
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise ValueError(f"{successes} of {trials}: must be 0 <= successes <= trials, and at least one trial")
    if not 0 < confidence < 1:
        raise ValueError(f"confidence = {confidence}: must be between 0 and 1; 0.95 is usual")
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    rate = successes / trials
    centre = (rate + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * math.sqrt(rate * (1 - rate) / trials + z * z / (4 * trials * trials))
    low = 0.0 if successes == 0 else centre - half
    high = 1.0 if successes == trials else centre + half
    return Interval(rate, low, high)


def decision_counts(decision: ArrayLike) -> dict[str, int]:
    """Return how many runs decided feasible, decided infeasible, and stayed undecided.

    Parameters
    ----------
    decision : array of int, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided.
    """
    values = np.asarray(decision)
    return {name: int((values == code).sum()) for code, name in DECISIONS.items()}


def decision_rates(decision: ArrayLike, confidence: float = CONFIDENCE) -> dict[str, Interval]:
    """Return the shares of the runs that decided each way, with Wilson intervals."""
    counts = decision_counts(decision)
    return {name: wilson(count, sum(counts.values()), confidence) for name, count in counts.items()}


def decision_times(decision_step: ArrayLike) -> DecisionTimes:
    """Return the quartiles of the decision step over all runs, undecided ones being later than any step.

    Parameters
    ----------
    decision_step : array of int, shape (runs,)
        -1 for an undecided run: it is censored, not left out.

    Returns
    -------
    DecisionTimes
        The first step by which at least that share of all runs had decided.
    """
    steps = np.asarray(decision_step, np.int64)
    if steps.size == 0:
        return DecisionTimes(None, None, None)
    ordered = np.sort(np.where(steps < 0, np.iinfo(np.int64).max, steps))
    found = (int(ordered[math.ceil(share * steps.size) - 1]) for share in (0.25, 0.5, 0.75))
    return DecisionTimes(*(step if step < np.iinfo(np.int64).max else None for step in found))


def opinion_quartiles(feasible_count: ArrayLike, robots: int) -> NDArray[np.float64]:
    """Return the quartiles over runs of the percentage of robots with opinion 1.

    Parameters
    ----------
    feasible_count : array of int, shape (runs, steps + 1)
        A run that has ended (-1) keeps its last value.
    robots : int
        Size of the swarm.

    Returns
    -------
    float64 array, shape (3, steps + 1)
        Lower quartile, median, upper quartile, in per cent.
    """
    counts = np.asarray(feasible_count)
    if counts.min(initial=0) < 0:
        held = np.maximum.accumulate(np.where(counts >= 0, np.arange(counts.shape[1]), 0), axis=1)
        counts = np.take_along_axis(counts, held, axis=1)
    quartiles: NDArray[np.float64] = np.quantile(counts, (0.25, 0.5, 0.75), axis=0) * (100.0 / robots)
    return quartiles


def accuracy(decision: ArrayLike, feasible: bool, confidence: float = CONFIDENCE) -> Interval:
    """Return the share of the runs that decided as the truth, with its Wilson interval.

    Parameters
    ----------
    decision : array of int, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided, which is never right.
    feasible : bool
        The truth.
    confidence : float
        Between 0 and 1.
    """
    values = np.asarray(decision)
    right = values == (FEASIBLE if feasible else INFEASIBLE)
    return wilson(int(right.sum()), values.size, confidence)


def bits_per_robot_and_step(
    bits_sent: ArrayLike, decision_step: ArrayLike, robots: int, steps: int, stop_at_decision: bool
) -> float:
    """Return the mean bits sent a robot and step, over the steps that the runs lasted.

    Parameters
    ----------
    bits_sent, decision_step : array of int, shape (runs,)
        Of each run; -1 for a decision step that there isn't.
    robots, steps : int
        Number of robots, and of steps of a run that goes on to its end.
    stop_at_decision : bool
        Whether runs ended at their decision.
    """
    decided = np.asarray(decision_step, np.int64)
    lasted = np.where(stop_at_decision & (decided >= 0), decided, steps)
    return float(np.asarray(bits_sent).sum() / max(1, robots * int(lasted.sum())))


def paired_difference(one: ArrayLike, other: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return how much more often one thing holds than another in the same runs, with its interval.

    Runs in which both hold or neither does tell nothing about the difference, and don't widen the interval
    as they would if the runs weren't the same.

    Parameters
    ----------
    one, other : array of bool, shape (runs,)
        Whether each held, run by run.
    confidence : float
        Between 0 and 1.

    Returns
    -------
    Interval
        Of the difference of the shares, within [-1, 1].

    Raises
    ------
    ValueError
        If there are no runs, or not as many of both.

    References
    ----------
    Bonett, Price, "Adjusted Wald confidence interval for a difference of binomial proportions based on paired
    data", 2012.

    Examples
    --------
    >>> from feasibee.stats import paired_difference
    >>> paired_difference([True, True, True, False], [True, False, False, False]).estimate
    0.5
    """
    first, second = np.asarray(one, np.bool_), np.asarray(other, np.bool_)
    if first.size == 0 or first.shape != second.shape:
        raise ValueError(f"{first.size} and {second.size} runs: must be as many of both, and at least one")
    runs = first.size
    gained, lost = int((first & ~second).sum()), int((second & ~first).sum())
    up, down = (gained + 1) / (runs + 2), (lost + 1) / (runs + 2)
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    half = z * math.sqrt((up + down - (up - down) ** 2) / (runs + 2))
    return Interval((gained - lost) / runs, max(-1.0, up - down - half), min(1.0, up - down + half))


def pareto(costs: Sequence[float], gains: Sequence[float]) -> list[int]:
    """Return which choices are best at their cost, from the cheapest on: all others gain less, or cost more.

    Examples
    --------
    >>> from feasibee.stats import pareto
    >>> pareto([3.0, 1.0, 2.0, 2.0], [0.9, 0.5, 0.4, 0.8])
    [1, 3, 0]
    """
    best: list[int] = []
    for place in sorted(range(len(costs)), key=lambda place: (costs[place], -gains[place])):
        if not best or gains[place] > gains[best[-1]]:
            best.append(place)
    return best


def confidence_sequence(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return a rate with an interval that stays valid however often one looks at it while trials go on.

    An interval for a fixed number of trials, such as Wilson's, is wrong far more often than it says when it
    decides when to stop. This one covers the true rate at all times at once with the confidence asked for;
    it is the set of rates that a test by a mixture of likelihood ratios, Beta(1/2, 1/2), hasn't refuted.

    Parameters
    ----------
    successes, trials : int
        How often it happened so far, of how many times.
    confidence : float
        Between 0 and 1.

    Raises
    ------
    ValueError
        If not 0 <= successes <= trials, or not 0 < confidence < 1.

    References
    ----------
    Robbins, "Statistical methods related to the law of the iterated logarithm", 1970; Howard, Ramdas,
    McAuliffe, Sekhon, "Time-uniform, nonparametric, nonasymptotic confidence sequences", 2021.

    Examples
    --------
    >>> from feasibee.stats import confidence_sequence
    >>> _, low, high = confidence_sequence(80, 100)
    >>> round(low, 3), round(high, 3)
    (0.648, 0.909)
    """
    if not 0 <= successes <= trials:
        raise ValueError(f"{successes} of {trials}: must be 0 <= successes <= trials")
    if not 0 < confidence < 1:
        raise ValueError(f"confidence = {confidence}: must be between 0 and 1; 0.95 is usual")
    if trials == 0:
        return Interval(math.nan, 0.0, 1.0)
    failures = trials - successes
    mixture = math.lgamma(successes + 0.5) + math.lgamma(failures + 0.5) - math.lgamma(trials + 1.0)
    bar = mixture - math.log(math.pi) + math.log(1.0 - confidence)

    def refuted(rate: float) -> bool:
        likelihood = successes * math.log(rate) if successes else 0.0
        likelihood += failures * math.log1p(-rate) if failures else 0.0
        return likelihood <= bar

    rate = successes / trials
    low = 0.0 if successes == 0 else _edge(refuted, 0.0, rate)
    high = 1.0 if failures == 0 else _edge(refuted, 1.0, rate)
    return Interval(rate, low, high)


def _edge(refuted: Callable[[float], bool], outer: float, inner: float) -> float:
    """Return where a refuted rate on one side meets the others, on the refuted side."""
    for _ in range(60):
        middle = (outer + inner) / 2
        if refuted(middle):
            outer = middle
        else:
            inner = middle
    return outer
