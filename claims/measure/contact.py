"""Measure walled swarms whose blocked robots stand still or deflect: docs/worlds.md."""

from __future__ import annotations

import json

import numpy as np

import feasibee

TASKS = (4, 10, 16, 20, 25, 40, 100)
RUNS, WATCHED, STEPS, ROBOTS = 2000, 100, 200, 20
SIDE, REACH, BESIDE = 20.0, 2.0, 1.5


def main() -> None:
    """Print the measures of each rule of contact as JSON."""
    found = {contact: measures(contact) for contact in ("stand", "deflect")}
    pairs = zip(found["stand"]["tasks"], found["deflect"]["tasks"], strict=True)
    ratios = [stand["mean"] / deflect["mean"] for stand, deflect in pairs]
    print(json.dumps({**found, "ratio": {"low": min(ratios), "high": max(ratios)}}, indent=2))


def measures(contact: str) -> dict[str, object]:
    """Return decisions by number of tasks, and how robots move with 20 tasks."""
    changes = {"arena.boundary": "walls", "robots.avoid_collisions": True, "robots.contact": contact}
    world = feasibee.Scenario().replace(changes)
    return {"tasks": [decisions(world, tasks) for tasks in TASKS], **motion(world)}


def decisions(world: feasibee.Scenario, tasks: int) -> dict[str, float]:
    """Return the share of swarms that decide feasible, and median and mean of the step of the decision."""
    scenario = world.replace({"tasks.count": tasks, "run.stop_at_decision": True})
    results = feasibee.simulate(scenario, runs=RUNS, seed=1)
    steps = results.decision_step.values[results.decision_step.values >= 0]
    return {
        "tasks": tasks,
        "feasible": float((results.decision.values == 1).mean()),
        "median": float(np.median(steps)),
        "mean": float(steps.mean()),
    }


def motion(world: feasibee.Scenario) -> dict[str, float]:
    """Return means per robot and step, over the first steps of some runs.

    ``contacts``: robots that come into sight. ``moved``: distance in units. ``standing``: share of the steps
    without a move. ``beside_wall``: share of the steps within 1.5 units of a wall.
    """
    sums = np.zeros(4)
    for run in range(WATCHED):
        swarm = feasibee.Swarm(world, seed=1, run=run)
        before, seen = swarm.positions, sights(swarm.positions)
        for _ in range(STEPS):
            swarm.advance()
            after = swarm.positions
            sees, moved = sights(after), np.hypot(*(after - before).T)
            beside = np.minimum(after, SIDE - after).min(axis=1) < BESIDE
            sums += (sees & ~seen).sum(), moved.sum(), (moved == 0).sum(), beside.sum()
            before, seen = after, sees
    names = ("contacts", "moved", "standing", "beside_wall")
    return dict(zip(names, (sums / (WATCHED * STEPS * ROBOTS)).tolist(), strict=True))


def sights(places: np.ndarray) -> np.ndarray:
    """Return which robots see which, themselves included."""
    return np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) <= REACH


if __name__ == "__main__":
    main()
