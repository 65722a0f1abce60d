"""Statistics of decisions: how often, how sure, how soon."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.errors import quoted
from feasibee.model.codes import DECISIONS, FEASIBLE, INFEASIBLE

CONFIDENCE = 0.95
MOST = 2**53
"""Runs, robots and steps are no more than this: whole numbers are exact as floats up to here."""


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
    TypeError
        If they aren't numbers.

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
    successes, trials = _counts(successes, trials)
    if trials < 1:
        raise ValueError(f"{successes} of {trials}: must be at least one trial")
    z = _z(confidence)
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

    Raises
    ------
    ValueError
        If there is anything else in it, or it has not one dimension.
    TypeError
        If it has no numbers.
    """
    values = _decisions(decision)
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
    steps = _whole_numbers("decision_step", decision_step).astype(np.int64)
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
    counts = _whole_numbers("feasible_count", feasible_count, dimensions=2)
    robots = _whole("robots", robots)
    if counts.size == 0 or robots < 1:
        raise ValueError(
            f"{counts.shape[0]} runs of {robots} robots: must be at least one run, step and robot"
        )
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
    values = _decisions(decision)
    right = values == (FEASIBLE if _is_true("feasible", feasible) else INFEASIBLE)
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
    bits, decided = _whole_numbers("bits_sent", bits_sent), _whole_numbers("decision_step", decision_step)
    robots, steps = _whole("robots", robots), _whole("steps", steps)
    if bits.size != decided.size:
        raise ValueError(f"{bits.size} and {decided.size} runs: must be as many of both")
    stops = _is_true("stop_at_decision", stop_at_decision)
    lasted = np.where(decided >= 0, decided, steps) if stops else np.full(decided.size, steps)
    return _sum(bits) / max(1, robots * _sum(lasted))


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
    >>> from feasibee.results.statistics import paired_difference
    >>> paired_difference([True, True, True, False], [True, False, False, False]).estimate
    0.5
    """
    first, second = _truths("one", one), _truths("other", other)
    if first.size == 0 or first.shape != second.shape:
        raise ValueError(f"{first.size} and {second.size} runs: must be as many of both, and at least one")
    runs = first.size
    gained, lost = int((first & ~second).sum()), int((second & ~first).sum())
    up, down = (gained + 1) / (runs + 2), (lost + 1) / (runs + 2)
    z = _z(confidence)
    half = z * math.sqrt((up + down - (up - down) ** 2) / (runs + 2))
    return Interval((gained - lost) / runs, max(-1.0, up - down - half), min(1.0, up - down + half))


def pareto(costs: Sequence[float], gains: Sequence[float]) -> list[int]:
    """Return which choices are best at their cost, from the cheapest on: all others gain less, or cost more.

    Examples
    --------
    >>> from feasibee.results.statistics import pareto
    >>> pareto([3.0, 1.0, 2.0, 2.0], [0.9, 0.5, 0.4, 0.8])
    [1, 3, 0]
    """
    if len(costs) != len(gains) or any(map(math.isnan, (*costs, *gains))):
        raise ValueError(f"{len(costs)} costs and {len(gains)} gains: must be as many numbers of both")
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
    >>> from feasibee.results.statistics import confidence_sequence
    >>> _, low, high = confidence_sequence(80, 100)
    >>> round(low, 3), round(high, 3)
    (0.648, 0.909)
    """
    successes, trials = _counts(successes, trials)
    _z(confidence)
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


def _whole(name: str, value: float, most: int = MOST) -> int:
    """Return a whole number from 0 on, of any library, as an int."""
    if isinstance(value, float):
        number = int(value) if value.is_integer() else -1
    else:
        try:
            number = operator.index(value)
        except TypeError:
            raise TypeError(f"{name} = {quoted(value)}: must be a whole number") from None
    if not 0 <= number <= most:
        raise ValueError(f"{name} = {quoted(value)}: must be a whole number from 0 to {most}")
    return number


def _counts(successes: int, trials: int) -> tuple[int, int]:
    """Return how often something happened, of how many times, as ints."""
    trials = _whole("trials", trials)
    return _whole("successes", successes, trials), trials


def _z(confidence: float) -> float:
    """Return how many standard deviations lie on each side of the mean with a confidence."""
    if not isinstance(confidence, float | int | np.number):
        raise TypeError(f"confidence = {quoted(confidence)}: must be a number; 0.95 is usual")
    if not 0 < confidence < 1 or 0.5 + confidence / 2 == 1:
        raise ValueError(f"confidence = {quoted(confidence)}: must be between 0 and 1; 0.95 is usual")
    return NormalDist().inv_cdf(0.5 + confidence / 2)


def _is_true(name: str, value: bool) -> bool:
    if not isinstance(value, bool | np.bool_ | int) or value not in (0, 1):
        raise TypeError(f"{name} = {quoted(value)}: must be True or False")
    return bool(value)


def _whole_numbers(name: str, values: ArrayLike, dimensions: int = 1) -> NDArray[np.signedinteger[Any]]:
    """Return whole numbers as an array of so many dimensions."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{name} = {quoted(values)}: must be whole numbers")
    if array.ndim != dimensions:
        rule = "a number a run" if dimensions == 1 else "a number a run and step"
        raise ValueError(f"{name} has {array.ndim} dimensions: must have {dimensions}, {rule}")
    if array.dtype.kind in "uf" and array.size and not (np.abs(array) < 2.0**63).all():
        raise ValueError(f"{name}: must be whole numbers of 63 bits")
    whole = array if array.dtype.kind == "i" else array.astype(np.int64)  # curves take gigabytes: no copy
    if array.dtype.kind == "f" and (whole != array).any():
        raise ValueError(f"{name}: must be whole numbers")
    return whole


def _decisions(decision: ArrayLike) -> NDArray[np.signedinteger[Any]]:
    """Return the decisions of runs."""
    values = _whole_numbers("decision", decision)
    if values.size and not -1 <= values.min() <= values.max() <= 1:
        raise ValueError("decision: must be 1 feasible, 0 infeasible, or -1 undecided")
    return values


def _truths(name: str, values: ArrayLike) -> NDArray[np.bool_]:
    """Return what holds and what doesn't."""
    whole = _whole_numbers(name, values)
    if ((whole != 0) & (whole != 1)).any():
        raise ValueError(f"{name}: must be True or False, run by run")
    return whole.astype(np.bool_)


def _sum(numbers: NDArray[np.signedinteger[Any]]) -> int:
    """Return the sum of whole numbers, however large: in halves, since 64 bits may not hold it."""
    values = numbers.astype(np.int64)
    return (int((values >> 32).sum()) << 32) + int((values & 0xFFFFFFFF).sum())
