"""Measure how often robots declare wrongly if they measure positions of tasks with errors: docs/worlds.md."""

from __future__ import annotations

import json
from typing import Any

from feasibee import Scenario, simulate
from feasibee.results.statistics import wilson

RUNS, TASKS = 1000, 20
CASES = (0.0, 8), (0.05, 6), (0.05, 8), (0.2, 6), (0.2, 8)


def main() -> None:
    """Print the shares by error and gate as JSON."""
    print(json.dumps({"decisions": [decided(*each) for each in CASES]}, indent=2))


def decided(error: float, gate: int) -> dict[str, Any]:
    """Return shares of the swarms in which a robot declares wrongly; the gate is in errors."""
    row: dict[str, Any] = {"error": error, "gate": gate}
    for tasks in (TASKS, TASKS + 1):
        world = Scenario().replace(
            {"tasks.count": tasks, "robots.know_count": True, "sensing.position_error": error}
        )
        world = world.replace({"sensing.gate": gate * error}) if error else world
        results = simulate(world.replace({"decision.strategy": "quiet-census"}), runs=RUNS, seed=1)
        declared = results.declared_infeasible if tasks == TASKS else results.declared_feasible
        row[f"quiet_{tasks}"] = wilson(int((declared.values > 0).sum()), RUNS)._asdict()
    return row


if __name__ == "__main__":
    main()
