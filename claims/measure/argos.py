"""Compare swarms in ARGoS3 with swarms in feasibee: docs/argos.md.

Those of ARGoS are in argos.csv, as `runs.py` in examples/argos measured them. CI has no ARGoS, so they are
not computed again. Those of feasibee are.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import feasibee
from feasibee.scenario.argos import FOOTBOT_DIAMETER

FIGURES = Path(__file__).with_suffix(".csv")
WALLS = {"arena.boundary": "walls"}
BODIES = {**WALLS, "robots.avoid_collisions": True}
WORLDS = {
    "torus": {"": {}},
    "walls": {"": WALLS},
    "bodies": {"stand": BODIES, "deflect": {**BODIES, "robots.contact": "deflect"}},
}
"""Changes of the paper's scenario by world and rule of contact."""
RUNS, MOVING_RUNS, MOVING_STEPS, SIGHT = 2000, 100, 200, 2.0


def main() -> None:
    """Print each row of ARGoS with those of feasibee, and how robots move and meet in feasibee, as JSON."""
    with FIGURES.open(newline="", encoding="utf-8") as file:
        rows = [found for row in csv.DictReader(file) for found in compared(row)]
    moving = [
        {"world": world, "contact": contact, "argos": in_argos(world, rows), "feasibee": motion(changes)}
        for world, rules in WORLDS.items()
        for contact, changes in rules.items()
    ]
    print(json.dumps({"rows": rows, "moving": moving}, indent=2))


def compared(row: dict[str, str]) -> Iterator[dict[str, Any]]:
    """Yield rates with intervals and steps until the decision, in ARGoS and with each rule of feasibee.

    ``errors``: standard errors by which the rate of ARGoS is above that of feasibee.
    """
    tasks, runs, feasible = (int(row[name]) for name in ("tasks", "runs", "feasible"))
    argos = {
        "feasible": feasibee.wilson(feasible, runs)._asdict(),
        **{name: float(row[name]) for name in ("median", "mean", "metres", "meetings")},
    }
    for contact, changes in WORLDS[row["world"]].items():
        ours = decisions({"tasks.count": tasks, "run.stop_at_decision": True, **changes})
        shares = [(each["feasible"]["estimate"], count) for each, count in ((argos, runs), (ours, RUNS))]
        spread = sum(share * (1 - share) / count for share, count in shares) ** 0.5
        yield {
            **{"world": row["world"], "contact": contact, "tasks": tasks, "runs": runs},
            **{"argos": argos, "feasibee": ours, "errors": (shares[0][0] - shares[1][0]) / spread},
        }


def decisions(changes: dict[str, object]) -> dict[str, Any]:
    """Return the rate of feasible decisions with its interval, and median and mean of their steps."""
    swarms = feasibee.simulate(feasibee.Scenario().replace(changes), runs=RUNS, seed=1)
    steps = swarms.decision_step.to_numpy()
    decided = steps[steps >= 0]
    return {
        "feasible": feasibee.decision_rates(swarms.decision.to_numpy())["feasible"]._asdict(),
        "median": float(np.median(decided)),
        "mean": float(decided.mean()),
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
