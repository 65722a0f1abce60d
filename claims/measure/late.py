"""Measure how late messages change decisions, and wrong declarations: docs/worlds.md."""

from __future__ import annotations

import json
from typing import Any

from feasibee import Scenario, simulate
from feasibee.results.statistics import accuracy, declare_times, wilson

DELAYS = (0, 20, 100)
RUNS = 1000
FEWER = 16
OPINIONS: dict[str, dict[str, Any]] = {
    f"dmmd_{tasks}": {"decision.strategy": "dmmd", "tasks.count": tasks} for tasks in (FEWER, 24)
}
DECLARING = {"decision.strategy": "quiet-census", "robots.know_count": True, "run.stop_at_declarations": True}


def main() -> None:
    """Print by delay how often opinions are right, and how often and when robots declare."""
    print(json.dumps({"delays": [{"delay": delay, **measured(delay)} for delay in DELAYS]}, indent=2))


def measured(delay: int) -> dict[str, Any]:
    """Return shares and times at one delay."""
    late = {"radio.delay": delay}
    found: dict[str, Any] = {}
    for name, changes in OPINIONS.items():
        world = Scenario().replace({**changes, **late})
        results = simulate(world, runs=RUNS, seed=1)
        found[name] = accuracy(results.decision.values, changes["tasks.count"] == FEWER).estimate
    for tasks in (20, 21):
        world = Scenario().replace({**DECLARING, **late, "tasks.count": tasks, "run.steps": 1500})
        results = simulate(world, runs=RUNS, seed=1)
        declared = results.declared_infeasible if tasks == 20 else results.declared_feasible
        times = declare_times(results.declare_step.values)
        wrong = wilson(int((declared.values > 0).sum()), RUNS)
        found[f"declared_{tasks}"] = {
            **{"wrong": wrong.estimate, "high": wrong.high, "median": times.median, "p95": times.p95}
        }
    return found


if __name__ == "__main__":
    main()
