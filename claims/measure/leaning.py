"""Measure at how many tasks half of the swarms decide feasible, and why: docs/model.md, docs/opinions.md."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from statistics import NormalDist
from typing import Any

import numpy as np

from feasibee import Scenario, Swarm
from feasibee.results.statistics import Interval
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

NORMAL = NormalDist()
NEAR = range(190, 231, 10)
SWARMS: dict[str, tuple[int, Iterable[int], int, dict[str, Any]]] = {
    "twenty": (20, range(17, 23), 20_000, {}),
    "thousand": (1000, range(1000, 1121, 30), 400, {}),
    "coin": (200, NEAR, 2000, {}),
    "first_sight": (200, NEAR, 2000, {"decision.start": "first-sight"}),
    "own_vote": (200, NEAR, 2000, {"decision.own_vote": False}),
    "long": (200, NEAR, 1000, {"decision.exploration": 40.0}),
}
"""Number of robots, numbers of tasks, number of runs at each, and what differs from the paper's robots."""
STEPS = 4000
"""So many that every swarm decides."""


def main() -> None:
    """Print the ratio of tasks to visible robots at which half decide feasible, and a mean quality."""
    found = {name: half(*swarm)._asdict() for name, swarm in SWARMS.items()}
    print(json.dumps({**found, "quality": mean_quality()._asdict()}))


def half(robots: int, numbers: Iterable[int], runs: int, changes: dict[str, Any]) -> Interval:
    """Return the ratio with its 95 % interval, by a probit fit, at the paper's density."""
    rows = []
    for tasks in numbers:
        share = feasible_share(swarm_of(robots, tasks, changes), runs)
        score = NORMAL.inv_cdf(share)
        weight = runs * NORMAL.pdf(score) ** 2 / share / (1 - share)
        rows.append((math.log(tasks / (robots - 1)), score, weight))
    x, y, weights = np.array(rows).T
    design = np.column_stack([np.ones_like(x), x])
    covariance = np.linalg.inv(design.T @ (weights[:, None] * design))
    start, slope = covariance @ design.T @ (weights * y)
    root = -start / slope
    gradient = np.array([1.0, root]) / slope
    error = 1.96 * math.sqrt(gradient @ covariance @ gradient)
    return Interval(math.exp(root), math.exp(root - error), math.exp(root + error))


def swarm_of(robots: int, tasks: int, changes: dict[str, Any]) -> Scenario:
    """Return a swarm at the paper's density."""
    own = {"robots.count": robots, "tasks.count": tasks, "arena.side": round(math.sqrt(20 * robots), 2)}
    return Scenario().replace({**own, "run.stop_at_decision": True, "run.steps": STEPS, **changes})


def feasible_share(scenario: Scenario, runs: int) -> float:
    """Return the share of swarms that decide feasible, of those that decide."""
    decided = simulate_record(scenario, Runs(runs, 1)).decision
    return float((decided == 1).sum() / (decided >= 0).sum())


def mean_quality(runs: int = 200, steps: int = 100) -> Interval:
    """Return the mean quality of feasible with 199 tasks, which a robot sees as often as the other robots."""
    means = []
    for run in range(runs):
        swarm = Swarm(swarm_of(200, 199, {"run.stop_at_decision": False}), seed=1, run=run)
        qualities = []
        for _ in range(steps):
            before = swarm.disseminating
            swarm.advance()
            began = np.flatnonzero(swarm.disseminating & ~before)
            qualities += [swarm.robot(int(number)).feasible_quality for number in began]
        means.append(np.mean(qualities))
    mean, error = float(np.mean(means)), 1.96 * float(np.std(means, ddof=1)) / math.sqrt(runs)
    return Interval(mean, mean - error, mean + error)


if __name__ == "__main__":
    main()
