"""Statistics of declarations: how often robots were right by their own word, and when."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.results.judging import column, is_quorum
from feasibee.results.statistics import CONFIDENCE, Interval, wilson
from feasibee.scenario.scenario import Scenario

NEVER = np.iinfo(np.int64).max
"""Step that stands for never: later than any other."""


class DeclareTimes(NamedTuple):
    """Steps by which half and 95 % of all swarms had declared, with intervals; None is never."""

    median: int | None
    p95: int | None
    median_interval: tuple[int | None, int | None]
    p95_interval: tuple[int | None, int | None]


class Declarations(NamedTuple):
    """Declarations in the runs of a scenario."""

    ok: Interval
    """Share of runs in which more than the threshold's share of robots declared rightly, and none wrongly."""
    wrong: Interval
    """Share of runs in which at least one robot declared wrongly."""
    step_90: DeclareTimes
    """Steps by which more than the threshold's share of the robots had declared."""

    def to_dict(self) -> dict[str, Any]:
        """Return the statistics as plain tables, for programs."""
        return {
            "ok": self.ok._asdict(),
            "wrong": self.wrong._asdict(),
            "step_90": {
                name: list(value) if isinstance(value, tuple) else value
                for name, value in self.step_90._asdict().items()
            },
        }


def declarations(results: Any, scenario: Scenario, feasible: bool) -> Declarations | None:
    """Return the shares of runs that declared rightly and wrongly, and when; None without declarations.

    Parameters
    ----------
    results : Record, Dataset or DataFrame
        Runs of the scenario, with each outcome as an attribute.
    scenario : Scenario
        What the runs were simulated from.
    feasible : bool
        Whether the tasks are feasible: the ground truth.
    """
    if not scenario.manifest.declares or not results.decision.size:
        return None
    right, wrong = declared_right(results, scenario, feasible), declared_wrong(results, scenario, feasible)
    return Declarations(
        wilson(int(right.sum()), right.size),
        wilson(int(wrong.sum()), wrong.size),
        declare_times(column(results, "declare_step")),
    )


def declared_right(results: Any, scenario: Scenario, feasible: bool) -> NDArray[np.bool_]:
    """Return whether enough robots of each run declared rightly, and none wrongly: bool, shape (runs,)."""
    right = column(results, "declared_feasible" if feasible else "declared_infeasible")
    return is_quorum(right, results, scenario) & ~declared_wrong(results, scenario, feasible)


def declared_wrong(results: Any, scenario: Scenario, feasible: bool) -> NDArray[np.bool_]:
    """Return whether at least one robot of each run declared wrongly: bool, shape (runs,)."""
    return column(results, "declared_infeasible" if feasible else "declared_feasible") > 0


def declare_times(declare_step: NDArray[Any], confidence: float = CONFIDENCE) -> DeclareTimes:
    """Return the median and the 95 % quantile of the step of declaring, with intervals by order statistics.

    Parameters
    ----------
    declare_step : array of int, shape (runs,)
        First step at which enough robots had declared; -1 counts as later than any step.
    confidence : float
        Confidence level, between 0 and 1.

    References
    ----------
    David, Nagaraja, "Order Statistics", 2003, section 7.1.
    """
    steps = np.asarray(declare_step, np.int64)
    if not steps.size:
        return DeclareTimes(None, None, (None, None), (None, None))
    ordered = np.sort(np.where(steps < 0, NEVER, steps))
    (median, around_median), (p95, around_p95) = (
        _quantile(ordered, percent, confidence) for percent in (50, 95)
    )
    return DeclareTimes(median, p95, around_median, around_p95)


def _quantile(
    ordered: NDArray[np.int64], percent: int, confidence: float
) -> tuple[int | None, tuple[int | None, int | None]]:
    """Return a quantile of steps in order, and its interval."""
    middle = -(-percent * ordered.size // 100)
    low, high = _ranks(ordered.size, percent / 100, (1 - confidence) / 2)

    def at(rank: int) -> int | None:
        if rank < 1:
            return 0  # no step is earlier
        step = int(ordered[rank - 1]) if rank <= ordered.size else NEVER
        return None if step == NEVER else step

    return at(middle), (at(low), at(high))


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
