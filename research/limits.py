"""Find how soon robots of any strategy can be sure, and how soon robots can stand at all tasks.

An oracle's robots look, broadcast all that they know, and hear in every step, on the trajectories of swarms
with the same seed. What a strategy's robot knows at a step, the oracle's robot of that number knows, too.
So no robot that is never wrong declares infeasible before enough robots can know more tasks than there are
robots ("names"), or feasible before they can know that all of the area was seen ("map").
"""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

import feasibee

EXAMPLE = "example: python research/limits.py --tasks 21 --runs 500"
CELLS = 4  # per range of sight, along each side: the area is seen if the centres of all cells are


def apart(scenario: feasibee.Scenario, one: Any, other: Any) -> Any:
    """Return the distances between places, in units: shape (len(one), len(other))."""
    way = np.abs(one[:, None] - other[None])
    if scenario.arena.boundary == "torus":
        way = np.minimum(way, np.array(scenario.arena.size) - way)
    return np.hypot(way[..., 0], way[..., 1])


def ways_of(scenario: feasibee.Scenario, swarm: feasibee.Swarm) -> Any:
    """Return the steps from each honest robot to each task, on a straight way: shape (robots, tasks)."""
    distance = apart(scenario, swarm.positions, swarm.tasks)[swarm.counted]
    return (distance - scenario.acting.reach) / scenario.robots.speed


def assigned(ways: Any) -> tuple[int, int]:
    """Return the step of the last arrival at as many tasks as robots can take at once, and the steps of all.

    Robots and tasks are assigned so that the last robot arrives as soon as possible. The steps of all robots
    together are those of another assignment, with the fewest.
    """
    steps = np.maximum(1, np.ceil(ways - 1e-6))  # nobody arrives before step 1
    fewest = steps[linear_sum_assignment(steps)].sum()
    lengths = np.unique(steps)
    first, last = 0, lengths.size - 1
    while first < last:
        middle = (first + last) // 2
        late = steps > lengths[middle]
        if late[linear_sum_assignment(late)].any():
            first = middle + 1
        else:
            last = middle
    return int(lengths[first]), int(fewest)


def cells_seen(scenario: feasibee.Scenario, robots: Any) -> Any:
    """Return the cells whose centres are in sight of each robot: shape (robots, cells)."""
    squares = []
    for axis, side in enumerate(scenario.arena.size):
        number = math.ceil(side * CELLS / scenario.sensing.range)
        way = np.abs(robots[:, axis, None] - (np.arange(number) + 0.5) * side / number)
        if scenario.arena.boundary == "torus":
            way = np.minimum(way, side - way)
        squares.append(way**2)
    seen = squares[0][:, None] + squares[1][:, :, None] <= scenario.sensing.range**2
    return seen.reshape(len(robots), -1)


def limits_of(scenario: feasibee.Scenario, seed: int, run: int) -> dict[str, float]:
    """Return the step of each limit in one run; infinity if it is never reached."""
    swarm = feasibee.Swarm(scenario, seed, run)
    honest, tasks = swarm.counted, len(swarm.tasks)
    arrival, fewest = assigned(ways_of(scenario, swarm))
    needed, quorum = min(tasks, len(honest) + 1), math.floor(scenario.decision.threshold * honest.sum()) + 1
    known: Any = np.zeros((len(honest), tasks + cells_seen(scenario, swarm.positions).shape[1]), bool)
    found = dict.fromkeys(("pooled names", "names", "pooled map", "map"), math.inf)
    while math.inf in found.values() and swarm.step < scenario.run.steps:
        swarm.advance()
        robots = swarm.positions
        hears = (
            apart(scenario, robots, robots) <= scenario.radio.range
        ) & honest  # a liar's words don't count
        told = np.array([known[senders].any(axis=0) for senders in hears])  # what they knew before this step
        seen = apart(scenario, robots, swarm.tasks) <= scenario.sensing.range
        known |= told | np.concatenate([seen, cells_seen(scenario, robots)], axis=1)
        mine, every = known[honest], known[honest].any(axis=0)
        reached = {
            "pooled names": every[:tasks].sum() >= needed,
            "names": (mine[:, :tasks].sum(axis=1) >= needed).sum() >= quorum,
            "pooled map": every[tasks:].all(),
            "map": mine[:, tasks:].all(axis=1).sum() >= quorum,
        }
        found |= {name: swarm.step for name, now in reached.items() if now and found[name] == math.inf}
    return {**found, "all taken": arrival, "distance": fewest * scenario.robots.speed / len(honest)}


def main() -> None:
    """Print the steps by which half and 95 % of the runs reached each limit."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument(
        "file", nargs="?", help="scenario in TOML, without walls inside; default: the paper's"
    )
    parser.add_argument("--tasks", type=int, help="number of tasks, instead of the scenario's")
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    scenario = feasibee.Scenario.read(given.file) if given.file else feasibee.Scenario()
    if given.tasks is not None:
        scenario = scenario.replace({"tasks.count": given.tasks})
    rows = [limits_of(scenario, given.seed, run) for run in range(given.runs)]
    found: dict[str, Any] = {"runs": given.runs, "tasks": scenario.tasks.count}
    for name in rows[0]:
        values = np.sort([row[name] for row in rows])
        at = [values[math.ceil(share * given.runs) - 1] for share in (0.5, 0.95)]
        shown = dict(zip(("median", "p95"), at, strict=True))
        found[name] = {key: None if value == math.inf else float(value) for key, value in shown.items()}
    found["distance"] = float(np.mean([row["distance"] for row in rows]))
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
