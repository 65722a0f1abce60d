"""What robots that act achieved: whether and when all tasks were taken, and at what cost (model.md 6.25)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.results.statistics import DeclareTimes, Interval, declare_times, mean_of, wilson
from feasibee.scenario.scenario import Scenario


class ActsOfRuns(NamedTuple):
    """What robots did in each run; each array has the shape (runs,)."""

    first_taken_step: NDArray[np.int64]
    all_taken_step: NDArray[np.int64]
    """Steps as the outcomes have them, -1 for never."""
    started_in_vain: NDArray[np.bool_]
    """Whether a robot took a task although the tasks were infeasible."""
    tasks_taken: NDArray[np.int64]
    vain_arrivals: NDArray[np.int64]
    distance: NDArray[np.float64]
    """Mean distance per robot of the start, in units."""
    all_done_step: NDArray[np.int64]
    """As the outcomes have it, -1 for never; empty unless tasks take time."""


class Acting(NamedTuple):
    """What robots that act achieved in all runs together, with 95 % confidence intervals."""

    done: Interval
    """Share of runs in which all tasks were taken, or as many as there were robots for."""
    started_in_vain: Interval
    """Share of runs in which a robot took a task although the tasks were infeasible."""
    first_taken_step: DeclareTimes
    """Steps by which a first task was taken."""
    all_taken_step: DeclareTimes
    """Steps by which all tasks were taken: the makespan."""
    tasks_taken: Interval
    """Number of tasks taken at the end of a run."""
    vain_arrivals: Interval
    """Number of arrivals per run at tasks that others had."""
    distance: Interval
    """Distance that a robot walked until all tasks were taken, in units."""
    all_done_step: DeclareTimes | None
    """Steps by which all tasks were done, if they take time (model.md 6.26)."""

    @property
    def makespan(self) -> Interval:
        """The median of the makespan, NaN for never."""
        steps = self.all_taken_step.median, *self.all_taken_step.median_interval
        return Interval(*(np.nan if each is None else float(each) for each in steps))


def acts_of(results: Any, scenario: Scenario) -> ActsOfRuns:
    """Return what robots did in each run of a scenario in which they act."""
    first, last, taken, vain, in_vain, walked = (
        np.asarray(getattr(results, name), np.int64)
        for name in (
            *("first_taken_step", "all_taken_step", "tasks_taken", "vain_arrivals"),
            *("starts_in_vain", "distance_walked"),
        )
    )
    distance = walked.astype(np.float64) * (scenario.robots.speed / scenario.robots.count)
    done = np.asarray(results.all_done_step if scenario.tasks.work else [], np.int64)
    return ActsOfRuns(first, last, in_vain > 0, taken, vain, distance, done)


def achieved(parts: Sequence[ActsOfRuns]) -> Acting | None:
    """Return what robots achieved in the runs of all parts; None without runs."""
    if not sum(each.distance.size for each in parts):
        return None
    together = ActsOfRuns(*map(np.concatenate, zip(*parts, strict=True)))
    done, vain = together.all_taken_step >= 0, together.started_in_vain
    return Acting(
        wilson(int(done.sum()), done.size),
        wilson(int(vain.sum()), vain.size),
        declare_times(together.first_taken_step),
        declare_times(together.all_taken_step),
        mean_of(together.tasks_taken),
        mean_of(together.vain_arrivals),
        mean_of(together.distance),
        declare_times(together.all_done_step) if together.all_done_step.size else None,
    )
