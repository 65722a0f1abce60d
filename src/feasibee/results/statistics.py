"""Statistics: rates with confidence intervals, paired differences, and times.

The unit is the run: steps of one run depend on each other, runs don't. ``confidence`` is the level of an
interval, between 0 and 1.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.base.codes import DECISIONS
from feasibee.base.errors import quoted

CONFIDENCE = 0.95
MOST = 2**53
"""Largest number of runs, robots or steps: whole numbers are exact as floats up to here."""
SHARES = (0.25, 0.5, 0.75)
"""Shares of the events that quartiles bound."""
ROUNDING = 1e-9
"""A product of floats may exceed the exact share by so much."""
NEVER = np.iinfo(np.int64).max
"""Step that stands for never: later than any other."""


class Interval(NamedTuple):
    """An estimate with its confidence interval."""

    estimate: float
    low: float
    high: float


OF_THE_RUNS = " of the runs"


def in_percent(share: Interval, of: str = "") -> str:
    """Return a share with its interval as people say them: in whole percent, unless more is known.

    A number near 0 or 100 has a decimal, so that it is neither unless it is exact.

    Examples
    --------
    >>> in_percent(wilson(341, 400), " of the runs"), in_percent(Interval(0.95, 0.8, 0.997))
    ('85 % of the runs (81 to 88)', '95 % (80 to 99.7)')
    >>> in_percent(wilson(34100, 40000))
    '85.2 % (84.9 to 85.6)'
    """
    middle, low, high = (_percent(each, share.high - share.low < 0.01) for each in share)
    return f"{middle} %{of} ({low} to {high})"


def _percent(share: float, is_narrow: bool) -> str:
    percent = 100 * share
    if percent in (0, 100) or (1 <= percent <= 99 and not is_narrow):
        return f"{percent:.0f}"
    return f"{min(max(percent, 0.1), 99.9):.1f}"


class Quartiles(NamedTuple):
    """Steps by which a quarter, half and three quarters of all events had happened; None if never."""

    q25: int | None
    median: int | None
    q75: int | None


class DeclareTimes(NamedTuple):
    """Steps by which half and 95 % of all swarms had declared, or acted, with intervals; None is never."""

    median: int | None
    p95: int | None
    median_interval: tuple[int | None, int | None]
    p95_interval: tuple[int | None, int | None]


def plain(found: Any) -> Any:
    """Return named tuples as tables and other tuples as lists, at any depth, for programs."""
    if isinstance(found, tuple):
        named = getattr(found, "_asdict", None)
        return [plain(each) for each in found] if named is None else plain(named())
    return {name: plain(each) for name, each in found.items()} if isinstance(found, dict) else found


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return a rate with its Wilson score interval, which is never of zero width, even for 0 of 100.

    Parameters
    ----------
    successes, trials : int
        Number of successes and of trials, at least one.
    confidence : float
        Confidence level, between 0 and 1.

    Raises
    ------
    ValueError, TypeError
        If there are no trials, or a value is out of its range or no number.

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
    z = normal_quantile(confidence)
    rate = successes / trials
    centre = (rate + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * math.sqrt(rate * (1 - rate) / trials + z * z / (4 * trials * trials))
    low = 0.0 if successes == 0 else centre - half
    high = 1.0 if successes == trials else centre + half
    return Interval(rate, low, high)


def decision_counts(decision: ArrayLike) -> dict[str, int]:
    """Return the number of runs that decided feasible, decided infeasible, and stayed undecided.

    Parameters
    ----------
    decision : array of int, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided.

    Raises
    ------
    ValueError
        If it contains other values, or doesn't have one dimension.
    TypeError
        If it doesn't contain numbers.
    """
    values = _whole_numbers("decision", decision)
    if values.size and not -1 <= values.min() <= values.max() <= 1:
        raise ValueError("decision: must be 1 feasible, 0 infeasible, or -1 undecided")
    return {name: int((values == code).sum()) for code, name in DECISIONS.items()}


def decision_rates(decision: ArrayLike, confidence: float = CONFIDENCE) -> dict[str, Interval]:
    """Return the shares of runs that decided feasible, infeasible or not at all, with Wilson intervals."""
    counts = decision_counts(decision)
    return {name: wilson(count, sum(counts.values()), confidence) for name, count in counts.items()}


def decision_times(decision_step: ArrayLike) -> Quartiles:
    """Return the quartiles of the decision step over all runs; undecided runs count as later than any step.

    Parameters
    ----------
    decision_step : array of int, shape (runs,)
        First step of a decision; -1 for an undecided run, which is censored, not left out.

    Returns
    -------
    Quartiles
        The first step by which at least a quarter, half and three quarters of all runs had decided.
    """
    ordered = _ordered(_whole_numbers("decision_step", decision_step))
    return Quartiles(*(_at_rank(ordered, max(1, math.ceil(share * ordered.size))) for share in SHARES))


def _ordered(steps: NDArray[np.generic]) -> NDArray[np.int64]:
    """Return steps in ascending order, those that never came last."""
    whole = steps.astype(np.int64)
    return np.sort(np.where(whole < 0, NEVER, whole))


def _at_rank(ordered: NDArray[np.int64], rank: int) -> int | None:
    """Return the step of a rank from 1 on; 0 below rank 1, and None if never or above all ranks."""
    step = 0 if rank < 1 else NEVER if rank > ordered.size else int(ordered[rank - 1])
    return None if step == NEVER else step


def opinion_quartiles(feasible_count: ArrayLike, robots: int | ArrayLike) -> NDArray[np.float64]:
    """Return the quartiles over runs of the percentage of robots with opinion 1.

    Parameters
    ----------
    feasible_count : array of int, shape (runs, steps + 1)
        Counts per run and step; after the end of a run (-1), its last value is used.
    robots : int or array of int, shape (runs, steps + 1)
        Number of robots; or of those present at each step, if robots come and go.

    Returns
    -------
    float64 array, shape (3, steps + 1)
        Lower quartile, median and upper quartile, in percent.
    """
    counts: NDArray[Any] = _whole_numbers("feasible_count", feasible_count, dimensions=2)
    if np.ndim(robots) == 2:
        counts, robots = counts / np.maximum(1, np.asarray(robots)), 1
    robots = _whole("robots", robots)
    if counts.size == 0 or robots < 1:
        raise ValueError(
            f"{counts.shape[0]} runs of {robots} robots: must be at least one run, step and robot"
        )
    if counts.min(initial=0) < 0:
        held = np.maximum.accumulate(np.where(counts >= 0, np.arange(counts.shape[1]), 0), axis=1)
        counts = np.take_along_axis(counts, held, axis=1)
    quartiles: NDArray[np.float64] = np.quantile(counts, SHARES, axis=0) * (100.0 / robots)
    return quartiles


def accuracy(decision: ArrayLike, feasible: bool, confidence: float = CONFIDENCE) -> Interval:
    """Return the share of runs with the right decision, with its Wilson interval.

    Parameters
    ----------
    decision : array of int, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided, which is never right.
    feasible : bool
        Whether the tasks are feasible: the ground truth.
    """
    return decision_rates(decision, confidence)[
        "feasible" if _is_true("feasible", feasible) else "infeasible"
    ]


def bits_per_robot_and_step(bits_sent: ArrayLike, robot_steps: ArrayLike) -> float:
    """Return the mean number of bits sent per robot and step, over the steps that the runs lasted.

    Parameters
    ----------
    bits_sent, robot_steps : array of int, shape (runs,)
        Bits sent in each run, and the robots that were there, summed over its steps.
    """
    bits, lasted = _whole_numbers("bits_sent", bits_sent), _whole_numbers("robot_steps", robot_steps)
    if bits.size != lasted.size:
        raise ValueError(f"{bits.size} and {lasted.size} runs: both must have the same number")
    return float(sum(bits.tolist()) / max(1, sum(lasted.tolist())))  # 64 bits may overflow


def declare_times(declare_step: NDArray[Any]) -> DeclareTimes:
    """Return the median and the 95 % quantile of a step of each run, with intervals by order statistics.

    Parameters
    ----------
    declare_step : array of int, shape (runs,)
        First step at which enough robots had declared, or acted; -1 counts as later than any step.

    References
    ----------
    David, Nagaraja, "Order Statistics", 2003, section 7.1.
    """
    ordered = _ordered(np.asarray(declare_step))
    if not ordered.size:
        return DeclareTimes(None, None, (None, None), (None, None))
    median, p95 = (_at_rank(ordered, -(-percent * ordered.size // 100)) for percent in (50, 95))
    ranks = (_ranks(ordered.size, share, (1 - CONFIDENCE) / 2) for share in (0.5, 0.95))
    around = ((_at_rank(ordered, low), _at_rank(ordered, high)) for low, high in ranks)
    return DeclareTimes(median, p95, *around)


def _ranks(runs: int, share: float, tail: float) -> tuple[int, int]:
    """Return the ranks between which a quantile lies, except with a chance of ``tail`` on each side.

    The number of runs below the quantile is binomial. A rank of 0 or above ``runs`` means no limit.
    """
    count = np.arange(1, runs + 1)
    steps = np.log((runs - count + 1) / count) + np.log(share / (1 - share))
    below = np.cumsum(np.exp(runs * np.log1p(-share) + np.r_[0.0, np.cumsum(steps)]))
    low = int(np.searchsorted(below, tail, side="right"))  # most with P(fewer than low) <= tail
    high = int(np.searchsorted(below, 1 - tail)) + 1  # least with P(high or more) <= tail
    return low, high


def paired_difference(one: ArrayLike, other: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return the share of ``one`` minus that of ``other`` in the same runs, with its adjusted Wald interval.

    Pairing makes the interval narrower: runs in which both hold or neither holds don't widen it.

    Parameters
    ----------
    one, other : array of bool, shape (runs,)
        Whether each holds, per run.

    Raises
    ------
    ValueError
        If there are no runs, or the arrays differ in length.

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
        raise ValueError(f"{first.size} and {second.size} runs: both must have the same number, at least 1")
    return mean_difference(first, second, confidence)


def pareto(costs: Sequence[float], gains: Sequence[float]) -> list[int]:
    """Return the indices of the Pareto front, from the cheapest choice on: no other gains as much for less.

    Examples
    --------
    >>> from feasibee.results.statistics import pareto
    >>> pareto([3.0, 1.0, 2.0, 2.0], [0.9, 0.5, 0.6, 0.8])
    [1, 3, 0]
    """
    if len(costs) != len(gains) or any(map(math.isnan, (*costs, *gains))):
        raise ValueError(
            f"{len(costs)} costs and {len(gains)} gains: both must have the same number of numbers"
        )
    best: list[int] = []
    for place in sorted(range(len(costs)), key=lambda place: (costs[place], -gains[place])):
        if not best or gains[place] > gains[best[-1]]:
            best.append(place)
    return best


def confidence_sequence(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return a rate with an interval that is valid at all numbers of trials at once, for a stopping rule.

    Wilson's interval is for a fixed number of trials. This one is the set of rates that a test by a mixture
    of likelihood ratios, Beta(1/2, 1/2), has not rejected.

    Parameters
    ----------
    successes, trials : int
        Number of successes and of trials so far.
    confidence : float
        Confidence level, between 0 and 1, for all numbers of trials together.

    Raises
    ------
    ValueError
        If a value is out of its range.

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
    normal_quantile(confidence)
    if trials == 0:
        return Interval(math.nan, 0.0, 1.0)
    failures = trials - successes
    rejected = _rejection(successes, failures, confidence)
    rate = successes / trials
    low = 0.0 if successes == 0 else _edge(rejected, 0.0, rate)
    high = 1.0 if failures == 0 else _edge(rejected, 1.0, rate)
    return Interval(rate, low, high)


def _rejection(successes: int, failures: int, confidence: float) -> Callable[[float], bool]:
    """Return the test of a rate by a mixture of likelihood ratios: whether it rejects that rate."""
    mixture = math.lgamma(successes + 0.5) + math.lgamma(failures + 0.5)
    mixture -= math.lgamma(successes + failures + 1.0)
    bar = mixture - math.log(math.pi) + math.log(1.0 - confidence)

    def rejected(rate: float) -> bool:
        likelihood = successes * math.log(rate) if successes else 0.0
        likelihood += failures * math.log1p(-rate) if failures else 0.0
        return likelihood <= bar

    return rejected


def _edge(rejected: Callable[[float], bool], outer: float, inner: float) -> float:
    """Return the limit between rejected rates (outer) and the others, by bisection, on the rejected side."""
    for _ in range(60):
        middle = (outer + inner) / 2
        if rejected(middle):
            outer = middle
        else:
            inner = middle
    return outer


def mean_share(shares: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return the mean of the runs' shares of steps, with an adjusted Wald interval over runs.

    The interval is that of Wald with one further run of share 0 and one of share 1. Its width is never zero.

    Parameters
    ----------
    shares : array of float, shape (runs,)
        A share of each run, 0 to 1, at least one.

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
    >>> from feasibee.results.statistics import mean_share
    >>> [round(each, 3) for each in mean_share([0.9, 0.8, 1.0] * 30)]
    [0.9, 0.866, 0.917]
    """
    return _adjusted(np.asarray(shares, np.float64), 0.0, 1.0, confidence)


def _adjusted(values: NDArray[np.float64], least: float, most: float, confidence: float) -> Interval:
    """Return the mean of values from ``least`` to ``most``, with Wald's interval of them and these two.

    Above 95 %, each of the two has the weight z²/4 for the quantile z, as Agresti and Coull add z²/2
    successes and failures. With a weight of 1, few runs that differ would make the interval too narrow.
    """
    if not values.size or not ((values >= least) & (values <= most)).all():
        raise ValueError(f"shares of {values.size} runs: must be at least one, each from 0 to 1")
    quantile = normal_quantile(confidence)
    weights = np.append(np.ones(values.size), [max(1.0, quantile**2 / 4)] * 2)
    with_both, total = np.append(values, (least, most)), float(weights.sum())
    centre, estimate = float(np.average(with_both, weights=weights)), float(values.mean())
    variance = float(np.average((with_both - centre) ** 2, weights=weights))
    half = quantile * math.sqrt(variance / total)
    low, high = min(estimate, centre - half), max(estimate, centre + half)
    return Interval(estimate, max(least, low), min(most, high))


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
    >>> from feasibee.results.statistics import event_rate
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
    >>> from feasibee.results.statistics import quartiles
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

    Examples
    --------
    >>> from feasibee.results.statistics import mean_difference
    >>> mean_difference([0.9, 0.8], [0.4, 0.3]).estimate
    0.5
    """
    differences = np.asarray(one, np.float64) - np.asarray(other, np.float64)
    return _adjusted(differences, -1.0, 1.0, confidence)


def mean_of(values: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Return the mean of a number of each run, with its normal interval; NaN without two runs.

    Parameters
    ----------
    values : array of float, shape (runs,)
        Numbers without bounds, such as delays.
    """
    numbers = np.asarray(values, np.float64)
    if numbers.size < 2:
        return Interval(float(numbers.mean()) if numbers.size else math.nan, math.nan, math.nan)
    mean = float(numbers.mean())
    half = normal_quantile(confidence) * float(numbers.std(ddof=1)) / math.sqrt(numbers.size)
    return Interval(mean, mean - half, mean + half)


def _whole(name: str, value: Any, most: int = MOST) -> int:
    """Validate a whole number of any library from 0 to ``most``; return it as a built-in int."""
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
    """Validate numbers of successes and trials; return them as built-in ints."""
    trials = _whole("trials", trials)
    return _whole("successes", successes, trials), trials


def normal_quantile(confidence: float) -> float:
    """Return the quantile of the normal distribution for a two-sided interval of a confidence level."""
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
    """Validate an array of whole numbers with a number of dimensions; return it as signed integers."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{name} = {quoted(values)}: must be whole numbers")
    if array.ndim != dimensions:
        rule = "one number per run" if dimensions == 1 else "one number per run and step"
        raise ValueError(f"{name} has {array.ndim} dimensions: must have {dimensions}, {rule}")
    if array.dtype.kind in "uf" and array.size and not (np.abs(array) < 2.0**63).all():
        raise ValueError(f"{name}: must be whole numbers of 63 bits")
    whole = array if array.dtype.kind == "i" else array.astype(np.int64)  # no copy: curves take gigabytes
    if array.dtype.kind == "f" and (whole != array).any():
        raise ValueError(f"{name}: must be whole numbers")
    return whole


def _truths(name: str, values: ArrayLike) -> NDArray[np.bool_]:
    """Validate an array of truth values; return it as bool."""
    whole = _whole_numbers(name, values)
    if ((whole != 0) & (whole != 1)).any():
        raise ValueError(f"{name}: must be True or False for each run")
    return whole.astype(np.bool_)
