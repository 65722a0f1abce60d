"""Measure what batteries change for the decisions of swarms, for docs/worlds.md."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from feasibee import Scenario, simulate
from feasibee.results.statistics import wilson

RUNS = 1000
BATTERIES = {"off": {}, "on": {"robots.work": 300, "robots.charge": 100}}
OPINIONS = {"decision.strategy": "dmmd", "tasks.count": 16}
DECLARING = {
    "decision.strategy": "quiet-census",
    "tasks.count": 21,
    "robots.know_count": True,
    "run.steps": 1500,
}


def right(changes: dict[str, Any]) -> dict[str, float]:
    """Return the share of swarms that hold *feasible* at the end, with its interval."""
    runs = simulate(Scenario().replace(changes), runs=RUNS, seed=1)
    share = wilson(int((runs.feasible_at_end.values > 18).sum()), RUNS)
    return {"right": share.estimate, "low": share.low, "high": share.high}


def declared(changes: dict[str, Any]) -> dict[str, int]:
    """Return the step by which half of the swarms have declared."""
    runs = simulate(Scenario().replace(changes), runs=RUNS, seed=1)
    return {"median": int(np.median(runs.declare_step.values))}


def main() -> None:
    """Print the measures as JSON."""
    opinions = {name: right({**OPINIONS, **battery}) for name, battery in BATTERIES.items()}
    declaring = {name: declared({**DECLARING, **battery}) for name, battery in BATTERIES.items()}
    print(json.dumps({"opinions": opinions, "declaring": declaring}))


if __name__ == "__main__":
    main()
