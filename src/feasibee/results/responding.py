"""How well swarms are served that call for robots: how often there are enough, and how many are idle.

It is compared with a fixed number of robots that never asks, and with an operator who knows the numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.results.statistics import Interval, mean_of, mean_share, plain
from feasibee.scenario.scenario import Scenario

Counts = NDArray[np.int64]
PRESENT = ("robots_present", "tasks_present")
SHARES = (0.5, 0.7, 0.8, 0.9, 0.95, 0.99)
"""Shares of the steps in which fixed numbers of robots, to compare with, are enough."""


class Service(NamedTuple):
    """How often there were enough robots, and at what cost; steps are counted from step 1 on."""

    feasible_share: Interval
    """Share of steps at which the tasks were feasible, mean over runs."""
    idle: Interval
    """Robots in excess of the tasks, mean over steps and runs; 0 at steps with fewer robots than tasks."""
    calls: Interval
    """Number of calls per run."""
    too_many_per_call: float
    """Robots that came in excess of tasks and margin."""
    too_few_per_call: float
    """Robots that were still missing when the called ones came."""


class Judgement(NamedTuple):
    """The service of a swarm, and what it is to be compared with on the same tasks."""

    own: Service
    """Of the swarm and its operator (model.md 6.19)."""
    oracle: Service
    """Of an operator with the same delay and margin who knows the numbers of robots and tasks."""
    robots: int
    """Least fixed number of robots that never asks and has enough at least as often as the swarm."""
    fixed: Mapping[int, Service]
    """Of fixed numbers of robots that never ask, in order: that one, that of the start, and others."""

    @property
    def as_often(self) -> Service:
        """Of the least fixed number that has enough at least as often as the swarm."""
        return self.fixed[self.robots]

    def to_dict(self) -> dict[str, Any]:
        """Return the measures as plain tables, for programs."""
        fixed = [{"robots": number, **plain(each)} for number, each in self.fixed.items()]
        return {**plain(self.own), "oracle": plain(self.oracle), "fixed": fixed}


def judgement(results: Any, scenario: Scenario) -> Judgement | None:
    """Return how well swarms were served; None if nobody responds to what they hold.

    Parameters
    ----------
    results : Record or Dataset
        Runs of the scenario, with ``robots_present``, ``tasks_present`` and ``calls``.
    scenario : Scenario
        What the runs were simulated from; its tasks come and go whatever the robots do.
    """
    if scenario.response.patience is None:
        return None
    robots, tasks = (np.asarray(getattr(results, name), np.int64) for name in PRESENT)
    came = np.maximum(np.diff(robots, axis=1), 0)
    own = _service(robots, tasks, came, np.asarray(results.calls), scenario.response.margin)
    number = fixed_number(tasks, own.feasible_share.estimate)
    numbers = sorted({scenario.robots.count, number, *(fixed_number(tasks, share) for share in SHARES)})
    fixed = {each: fixed_service(tasks, each) for each in numbers}
    return Judgement(own, oracle_service(tasks, scenario), number, fixed)


def fixed_service(tasks: Counts, robots: int) -> Service:
    """Return the service of a fixed number of robots that never asks.

    Parameters
    ----------
    tasks : int64 array, shape (runs, steps + 1)
        Number of tasks at each step.
    robots : int
        Number of robots at each step.
    """
    none = np.zeros((tasks.shape[0], tasks.shape[1] - 1), np.int64)
    return _service(np.full_like(tasks, robots), tasks, none, none[:, 0], 0)


def fixed_number(tasks: Counts, share: float) -> int:
    """Return the least fixed number of robots that is enough in at least this share of the steps."""
    ordered = np.sort(tasks[:, 1:], axis=None)
    return int(ordered[max(0, int(np.ceil(share * ordered.size - 1e-9)) - 1)])


def oracle_service(tasks: Counts, scenario: Scenario) -> Service:
    """Return the service of an operator who knows the numbers of robots and tasks after each step.

    Delay, margin and largest number of robots are those of the scenario (model.md 6.19). There is no
    patience. Robots neither fail nor come by themselves.
    """
    margin, most = scenario.response.margin, scenario.most.robots
    runs, length = tasks.shape
    robots, came = np.empty_like(tasks), np.zeros((runs, length - 1), np.int64)
    robots[:, 0] = present = np.full(runs, scenario.robots.count)
    awaited, arrives_at, calls = np.zeros(runs, np.int64), np.full(runs, -1), np.zeros(runs, np.int64)
    for step in range(1, length):
        looks, gap = arrives_at < step, tasks[:, step - 1] - present
        asks = looks & (gap > 0)
        awaited[asks], arrives_at[asks] = gap[asks] + margin, step + scenario.response.delay
        calls += asks
        spare = np.where(looks & ~asks, np.clip(-gap - margin, 0, present - 1), 0)
        arriving = np.where(arrives_at == step, np.minimum(awaited, most - present), 0)
        came[:, step - 1] = arriving
        present = present - spare + arriving
        robots[:, step] = present
    return _service(robots, tasks, came, calls, margin)


def _service(robots: Counts, tasks: Counts, came: Counts, calls: Counts, margin: int) -> Service:
    """Return the measures; ``came`` is how many robots came at each step from step 1 on."""
    spare = (robots - tasks)[:, 1:]
    number = max(1, int(calls.sum()))
    return Service(
        mean_share((spare >= 0).mean(axis=1)),
        mean_of(np.maximum(spare, 0).mean(axis=1)),
        mean_of(calls),
        float(np.minimum(came, np.maximum(spare - margin, 0)).sum()) / number,
        float(np.where(came > 0, np.maximum(-spare, 0), 0).sum()) / number,
    )
