"""Measure what batteries change for the decisions of swarms, for docs/worlds.md."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from feasibee import Scenario, simulate
from feasibee.results.statistics import wilson
from feasibee.scenario.feasibility import truth

RUNS = 1000
BATTERY = {"robots.work": 300, "robots.charge": 100}
NAMING = {"robots.know_count": True, "run.steps": 1500}


def measured(changes: dict[str, Any]) -> dict[str, float]:
    """Return the share of swarms that are right at the end, or with a wrong declaration, and times."""
    scenario = Scenario().replace(changes)
    runs, feasible = simulate(scenario, runs=RUNS, seed=1), truth(scenario)
    right = runs.feasible_at_end if feasible else runs.infeasible_at_end
    share = wilson(int((right.values > 0.9 * scenario.robots.count).sum()), RUNS)
    found = {"right": share.estimate, "low": share.low, "high": share.high}
    if scenario.declares:
        wrong = (runs.declared_infeasible if feasible else runs.declared_feasible).values
        bad, steps = wilson(int((wrong > 0).sum()), RUNS), runs.declare_step.values
        found |= {"wrong": bad.estimate, "wrong_high": bad.high}
        found |= {"median": int(np.median(steps)), "p95": int(np.quantile(steps, 0.95, method="higher"))}
    return found


def main() -> None:
    """Print the measures as JSON."""
    opinions = [
        {"strategy": "dmmd", "tasks": tasks, "off": measured(plain), "on": measured({**plain, **BATTERY})}
        for tasks in (16, 24)
        for plain in [{"decision.strategy": "dmmd", "tasks.count": tasks}]
    ]
    declaring = [
        {"strategy": name, "off": measured(plain), "on": measured({**plain, **BATTERY})}
        for name in ("quiet-census", "turns")
        for plain in [{"decision.strategy": name, "tasks.count": 21, **NAMING}]
    ]
    print(json.dumps({"opinions": opinions, "declaring": declaring}))


if __name__ == "__main__":
    main()
