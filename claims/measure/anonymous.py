"""How well one who pools all sightings, but no names, distinguishes n tasks from n + 1: docs/limits.md.

A robot *visits* a task from the step at which the task comes into range to that at which it leaves. In the
paper's world the visits of one robot to one task are independent of those of any other pair, and how long
they last says nothing of the number of tasks. So the observer counts visits: over all pairs their number is
nearly normal, with the mean and the variance of a pair times the number of pairs.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import erf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee import Scenario, Swarm

ROBOTS = 20
LOOKS = (50, 100, 200, 500, 1000)
TASKS = (10, 16, 18, 19, 20, 21, 22, 25)
PAIRS = (400, 200)
"""Robots and tasks of the worlds from which the moments of a pair are: 80,000 pairs each."""
WORLDS, SWARMS = 5, 400


def visits(robots: int, tasks: int, run: int) -> Iterator[NDArray[np.int64]]:
    """Yield the visits of each robot to each task so far, at each look."""
    scenario = Scenario(robots={"count": robots}, tasks={"count": tasks})
    swarm, side = Swarm(scenario, seed=1, run=run), scenario.arena.size[0]
    count, before = np.zeros((robots, tasks), np.int64), np.zeros((robots, tasks), np.bool_)
    for step in range(1, LOOKS[-1] + 1):
        swarm.advance()
        apart = np.abs(swarm.positions[:, None] - swarm.tasks[None])
        seen = (np.minimum(apart, side - apart) ** 2).sum(axis=2) <= scenario.sensing.range**2
        count += seen & ~before
        before = seen
        if step in LOOKS:
            yield count.copy()


def moments() -> list[tuple[float, float]]:
    """Return mean and variance of the visits of a pair at each look."""
    looks = zip(*(visits(*PAIRS, run) for run in range(WORLDS)), strict=True)
    return [(float(np.mean(each)), float(np.var(each))) for each in looks]


def predicted(mean: float, variance: float, tasks: int) -> float:
    """Return how often the number of visits is on the right side of that between n tasks and n + 1."""
    away = abs(ROBOTS + 0.5 - tasks) * ROBOTS * mean / sqrt(ROBOTS * tasks * variance)
    return 0.5 * (1.0 + erf(away / sqrt(2.0)))


def simulated(means: list[float]) -> NDArray[np.float64]:
    """Return the share of swarms whose visits are on the right side: one row per look, one column per number.

    Robots move alike whatever the tasks, so the first m tasks of a swarm are those of a swarm with m.
    """
    right: Any = 0
    limits = ROBOTS * np.array(means) * (ROBOTS + 0.5)
    for run in range(SWARMS):
        by_task = np.array([each.sum(axis=0) for each in visits(ROBOTS, TASKS[-1], run)])
        total = by_task.cumsum(axis=1)[:, np.array(TASKS) - 1]
        right = right + ((total < limits[:, None]) == (np.array(TASKS) <= ROBOTS))
    return np.asarray(right / SWARMS)


pairs = moments()
found = simulated([mean for mean, _ in pairs])
rows = [
    {
        "tasks": tasks,
        "step": step,
        "predicted": predicted(*pair, tasks),
        "simulated": float(found[row, column]),
    }
    for column, tasks in enumerate(TASKS)
    for row, (step, pair) in enumerate(zip(LOOKS, pairs, strict=True))
]
farthest = max(abs(each["predicted"] - each["simulated"]) for each in rows)
spread = [variance / mean for mean, variance in pairs]
print(json.dumps({"rows": rows, "swarms": SWARMS, "farthest": farthest, "spread": spread}))
