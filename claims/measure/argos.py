"""Compare swarms in ARGoS3 with swarms in feasibee: docs/argos.md.

Those of ARGoS are in argos.csv, as `runs.py` in examples/argos measured them. CI has no ARGoS, so they are
not computed again. Those of feasibee are.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

import feasibee
from feasibee.scenario.argos import FOOTBOT_DIAMETER

FIGURES = Path(__file__).with_suffix(".csv")
WORLDS = {
    "torus": {},
    "walls": {"arena.boundary": "walls"},
    "bodies": {"arena.boundary": "walls", "robots.avoid_collisions": True},
}
RUNS, MOVING_RUNS, MOVING_STEPS, SIGHT = 2000, 100, 200, 2.0


def main() -> None:
    """Print each row of ARGoS with that of feasibee, and how robots move and meet in feasibee, as JSON."""
    with FIGURES.open(newline="", encoding="utf-8") as file:
        rows = [compared(row) for row in csv.DictReader(file)]
    moving = [
        {"world": world, "argos": in_argos(world, rows), "feasibee": motion(WORLDS[world])}
        for world in WORLDS
    ]
    print(json.dumps({"rows": rows, "moving": moving}, indent=2))


def compared(row: dict[str, str]) -> dict[str, Any]:
    """Return rates with intervals and steps until the decision, in ARGoS and in feasibee."""
    tasks, runs, feasible = (int(row[name]) for name in ("tasks", "runs", "feasible"))
    changes = {"tasks.count": tasks, "run.stop_at_decision": True, **WORLDS[row["world"]]}
    swarms = feasibee.simulate(feasibee.Scenario().replace(changes), runs=RUNS, seed=1)
    steps = swarms.decision_step.to_numpy()
    decided = steps[steps >= 0]
    return {
        "world": row["world"],
        "tasks": tasks,
        "runs": runs,
        "argos": {
            "feasible": feasibee.wilson(feasible, runs)._asdict(),
            "median": float(row["median"]),
            "mean": float(row["mean"]),
            "metres": float(row["metres"]),
            "meetings": float(row["meetings"]),
        },
        "feasibee": {
            "feasible": feasibee.decision_rates(swarms.decision.to_numpy())["feasible"]._asdict(),
            "median": float(np.median(decided)),
            "mean": float(decided.mean()),
        },
    }


def in_argos(world: str, rows: list[dict[str, Any]]) -> dict[str, float]:
    """Return way, in units, and meetings per robot-step in ARGoS: means over the rows of a world."""
    of_world = [row["argos"] for row in rows if row["world"] == world]
    ways, meetings = ([row[name] for row in of_world] for name in ("metres", "meetings"))
    return {"way": float(np.mean(ways)) / FOOTBOT_DIAMETER, "meetings": float(np.mean(meetings))}


def motion(changes: dict[str, object]) -> dict[str, float]:
    """Return way and meetings per robot-step, with 20 robots; a meeting is a robot that comes into sight."""
    scenario = feasibee.Scenario().replace(changes)
    torus = scenario.arena.boundary == "torus"
    ways, meetings = [], []
    for run in range(MOVING_RUNS):
        swarm = feasibee.Swarm(scenario, seed=1, run=run)
        before, seen = swarm.positions, in_sight(swarm.positions, torus)
        for _ in range(MOVING_STEPS):
            swarm.advance()
            now, sees = swarm.positions, in_sight(swarm.positions, torus)
            ways.append(np.linalg.norm(way(now - before, torus), axis=-1).mean())
            meetings.append((sees & ~seen).sum(axis=1).mean())
            before, seen = now, sees
    return {"way": float(np.mean(ways)), "meetings": float(np.mean(meetings))}


def in_sight(places: np.ndarray, torus: bool) -> np.ndarray:
    """Return which robots see which others."""
    distances = np.linalg.norm(way(places[:, None] - places[None], torus), axis=-1)
    return (distances <= SIGHT) & ~np.eye(len(places), dtype=bool)


def way(difference: np.ndarray, torus: bool) -> np.ndarray:
    """Return differences of places, the short way round on the torus."""
    return (difference + 10.0) % 20.0 - 10.0 if torus else difference


if __name__ == "__main__":
    main()
