"""The paper's claims, each checked against the data: ``holds``, ``fails`` or ``can't tell``.

The interval of a claim has 95 % confidence for the claim as a whole. A claim about several ratios gives each
its share of the error (Bonferroni). A claim holds if its whole interval lies on its side of the bar. It fails
if the whole interval lies on the other side. Otherwise there are too few runs to tell.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import FEASIBLE, INFEASIBLE
from feasibee.results.statistics import CONFIDENCE, Interval, wilson

HOLDS, FAILS, CANNOT_TELL = "holds", "fails", "can't tell"
RESAMPLES = 1000


@dataclass(frozen=True)
class RatioSummary:
    """Outcome of the runs at one ratio of robots to tasks.

    Parameters
    ----------
    robots, tasks : int
        Number of robots, and of tasks.
    first_run : int
        Number of the first run.
    decision : int8 array, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided.
    decision_step : int32 array, shape (runs,)
        First step at which the swarm had decided; -1 if undecided.
    quartiles : float64 array, shape (3, steps + 1)
        Quartiles over the runs of the percentage of robots with opinion 1; empty where nothing draws them.
    thinned : float32 array, shape (runs, steps // 25 + 1)
        That percentage in each run at every 25th step; empty likewise.
    """

    robots: int
    tasks: int
    first_run: int
    decision: NDArray[np.int8]
    decision_step: NDArray[np.int32]
    quartiles: NDArray[np.float64]
    thinned: NDArray[np.float32]

    @property
    def ratio(self) -> float:
        """Robots per task."""
        return self.robots / self.tasks

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.decision.size

    def rate(self, decision: int, confidence: float = CONFIDENCE) -> Interval:
        """Return the share of runs with a decision, with its interval."""
        return wilson(int((self.decision == decision).sum()), self.runs, confidence)


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper, the statistic that tests it, and the verdict."""

    claim: str
    source: str
    statistic: str
    estimate: float
    low: float
    high: float
    bar: str
    verdict: str


def check_claims(points: Sequence[RatioSummary], seed: int) -> list[Claim]:
    """Check every claim of the paper's results.

    Parameters
    ----------
    points : sequence of RatioSummary
        Ratios symmetrical on a log scale, 1, 2 and 10 among them; the last two with curves.
    seed : int
        Seed of the bootstrap.
    """
    ordered = sorted(points, key=lambda point: point.ratio)
    return [
        _correct(
            "more than 75 % of runs decide feasible at ratios larger than 2",
            FEASIBLE,
            [point for point in ordered if point.ratio > 2],
        ),
        _correct(
            "more than 75 % of runs decide infeasible at ratios smaller than 0.5",
            INFEASIBLE,
            [point for point in ordered if point.ratio < 0.5],
        ),
        _symmetrical(ordered),
        _diverging(_at(ordered, 1.0)),
        _earlier([point for point in ordered if point.ratio >= 2]),
        _narrower(_at(ordered, 10.0), _at(ordered, 2.0), seed),
    ]


def _correct(claim: str, decision: int, points: Sequence[RatioSummary]) -> Claim:
    """Compare the least share of right decisions over several ratios with 75 %."""
    each = [point.rate(decision, 1 - (1 - CONFIDENCE) / len(points)) for point in points]
    worst = points[int(np.argmin([rate.estimate for rate in each]))]
    least = Interval(*(min(values) for values in zip(*each, strict=True)))
    statistic = f"least share of right decisions over {len(points)} ratios (at {worst.ratio:.3g})"
    return _claim(claim, "section III, Fig. 3", statistic, least, 0.75, above=True)


def _symmetrical(points: Sequence[RatioSummary]) -> Claim:
    """Compare the shares of right decisions at mirrored ratios: within 10 percentage points on average."""
    pairs = [(low, high) for low, high in zip(points, points[::-1], strict=True) if low.ratio < high.ratio]
    rates = [(high.rate(FEASIBLE), low.rate(INFEASIBLE)) for low, high in pairs]
    mean = sum(feasible.estimate - infeasible.estimate for feasible, infeasible in rates) / len(pairs)
    variance = sum(
        _variance(feasible.estimate, high.runs) + _variance(infeasible.estimate, low.runs)
        for (feasible, infeasible), (low, high) in zip(rates, pairs, strict=True)
    )
    half = _z() * math.sqrt(variance) / len(pairs)
    claim = "feasible and infeasible decisions are symmetrical around ratio 1"
    statistic = f"right at n/m less right at m/n, on average over {len(pairs)} pairs"
    interval = Interval(mean, mean - half, mean + half)
    bar = "between -0.1 and 0.1 (our reading of symmetrical)"
    inside = interval.low > -0.1 and interval.high < 0.1
    outside = interval.high < -0.1 or interval.low > 0.1
    return Claim(claim, "section III, Fig. 3", statistic, *interval, bar, _verdict(inside, outside))


def _diverging(point: RatioSummary) -> Claim:
    """Compare the rarer decision's share at ratio 1 with the 25 % that a reliable swarm would stay under."""
    rarer = min((point.rate(FEASIBLE), point.rate(INFEASIBLE)), key=lambda rate: rate.estimate)
    claim = "the opinions diverge when the ratio is close to 1"
    return _claim(
        claim, "section III, Fig. 2b", "share of the rarer decision at ratio 1", rarer, 0.25, above=True
    )


def _earlier(points: Sequence[RatioSummary]) -> Claim:
    """Correlate, over runs, the ratio with the decision step; undecided runs come last."""
    ratio = np.concatenate([np.full(point.runs, point.ratio) for point in points])
    step = np.concatenate([point.decision_step for point in points])
    step = np.where(step < 0, np.iinfo(np.int32).max, step)
    if np.ptp(step) == 0:
        r, half = 0.0, math.inf  # all runs decided at one step, or none did
    else:
        r = float(np.clip(np.corrcoef(_ranks(ratio), _ranks(step))[0, 1], -1 + 1e-12, 1 - 1e-12))
        # Fisher's transformation with Bonett and Wright's variance for ranks (Psychometrika, 2000).
        half = _z() * math.sqrt((1 + r * r / 2) / (ratio.size - 3))
    interval = Interval(r, math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half))
    claim = "consensus is reached earlier when the ratio is larger"
    statistic = "rank correlation of ratio and decision step, ratios from 2 up"
    return _claim(claim, "section III, Fig. 2a", statistic, interval, 0.0, above=False)


def _narrower(large: RatioSummary, small: RatioSummary, seed: int) -> Claim:
    """Compare the quartile bands of Fig. 2a at ratios 10 and 2, averaged over time, by resampling runs."""
    random = np.random.Generator(np.random.Philox(key=seed))

    def difference(large_runs: NDArray[np.float32], small_runs: NDArray[np.float32]) -> float:
        return float(_band(large_runs) - _band(small_runs))

    resampled = [
        difference(*(point.thinned[random.integers(point.runs, size=point.runs)] for point in (large, small)))
        for _ in range(RESAMPLES)
    ]
    low, high = np.quantile(resampled, (0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2))
    interval = Interval(difference(large.thinned, small.thinned), float(low), float(high))
    claim = "the interquartile range is smaller at ratio 10 than at ratio 2"
    statistic = "mean width of the quartile band, ratio 10 less ratio 2, percentage points"
    return _claim(claim, "section III, Fig. 2a", statistic, interval, 0.0, above=False)


def _claim(claim: str, source: str, statistic: str, interval: Interval, bar: float, *, above: bool) -> Claim:
    on_side = interval.low > bar if above else interval.high < bar
    on_other = interval.high <= bar if above else interval.low >= bar
    words = f"{'above' if above else 'below'} {bar:g}"
    return Claim(claim, source, statistic, *interval, words, _verdict(on_side, on_other))


def _verdict(holds: bool, fails: bool) -> str:
    return HOLDS if holds else FAILS if fails else CANNOT_TELL


def _at(points: Sequence[RatioSummary], ratio: float) -> RatioSummary:
    return min(points, key=lambda point: abs(math.log(point.ratio / ratio)))


def _z() -> float:
    return NormalDist().inv_cdf(0.5 + CONFIDENCE / 2)


def _variance(rate: float, runs: int) -> float:
    """Return the variance of a rate, with one added success and one added failure: 0 of 100 isn't certain."""
    shrunk = (rate * runs + 1) / (runs + 2)
    return shrunk * (1 - shrunk) / (runs + 2)


def _ranks(values: NDArray[np.generic]) -> NDArray[np.float64]:
    """Return ranks, equal values sharing their mean rank."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(count)
    mean: NDArray[np.float64] = last - (count - 1) / 2
    return mean[place]


def _band(percentages: NDArray[np.float32]) -> float:
    low, high = np.quantile(percentages, (0.25, 0.75), axis=0)
    return float((high - low).mean())
