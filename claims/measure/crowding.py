"""Measure density and sightings with walls and with collisions: docs/worlds.md."""

from __future__ import annotations

import json

import numpy as np

import feasibee

WORLDS = {
    "paper": {},
    "walls": {"arena.boundary": "walls"},
    "bodies": {"robots.avoid_collisions": True},
    "both": {"arena.boundary": "walls", "robots.avoid_collisions": True},
}
RUNS, FIRST, LAST, EVERY = 100, 50, 500, 5
SIDE, RADIUS, REACH = 20.0, 0.5, 2.0


def main() -> None:
    """Print the measures of each world as JSON."""
    print(json.dumps({name: measures(changes) for name, changes in WORLDS.items()}, indent=2))


def measures(changes: dict[str, object]) -> dict[str, float]:
    """Return means over runs and steps, with 20 robots and 20 tasks.

    ``at_edge``: density within a unit of the edge that the robots' centres can reach, over the mean density.
    ``robots``, ``tasks``: mean number of other robots, and of tasks, in sight of a robot.
    """
    scenario = feasibee.Scenario().replace(changes)
    torus = scenario.arena.boundary == "torus"
    at_edge, robots, tasks = [], [], []
    for run in range(RUNS):
        swarm = feasibee.Swarm(scenario, seed=1, run=run)
        swarm.advance(FIRST)
        while swarm.step < LAST:
            places = swarm.positions
            edge = np.minimum(places, SIDE - places).min(axis=1)
            at_edge.append((edge < RADIUS + 1).mean())
            robots.append((distances(places, places, torus) <= REACH).sum(axis=1).mean() - 1)
            tasks.append((distances(places, swarm.tasks, torus) <= REACH).sum(axis=1).mean())
            swarm.advance(EVERY)
    inner = SIDE - 2 * RADIUS if not torus else SIDE
    margin = 1 if not torus else RADIUS + 1
    share = 1 - ((inner - 2 * margin) / inner) ** 2
    return {"at_edge": np.mean(at_edge) / share, "robots": np.mean(robots), "tasks": np.mean(tasks)}


def distances(places: np.ndarray, others: np.ndarray, torus: bool) -> np.ndarray:
    """Return the distance from each position to each of the others."""
    apart = np.abs(places[:, None, :] - others[None, :, :])
    if torus:
        apart = np.minimum(apart, SIDE - apart)
    return np.hypot(*apart.transpose(2, 0, 1))


if __name__ == "__main__":
    main()
