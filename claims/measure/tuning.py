"""Measure tune with theory against tune without: shares of right swarms of what they find, and their runs.

The margin was set before: 3 percentage points, the 95 % interval of a difference between 2,000 runs each.
"""

from __future__ import annotations

import json
from typing import Any

from feasibee import Scenario
from feasibee.results.measures import ended_right
from feasibee.results.statistics import decision_times, mean_difference
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.space import dimensions
from feasibee.studies.tuning import tune
from feasibee.sweeps.sweep import Execution

SEED, JUDGES = 7193, 10_000
MARGIN = 0.03
BOTH = ("decision.exploration", "decision.gain")
WORLDS: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"tasks.count": 10, "run.steps": 500}, BOTH),
    ({"tasks.count": 16, "run.steps": 500}, BOTH),
    ({"tasks.count": 40, "run.steps": 200}, BOTH),
    (
        {"robots.count": 30, "tasks.count": 20, "run.steps": 500},
        ("decision.exploration=6:40", "decision.gain"),
    ),
    ({"robots.count": 15, "tasks.count": 25, "arena.side": 16.0, "run.steps": 300}, ("decision.gain",)),
    (
        {"robots.count": 12, "tasks.count": 6, "radio.range": 3.0, "sensing.range": 3.0, "run.steps": 800},
        ("decision.exploration=6:60", "radio.range=1.5:5"),
    ),
]


def main() -> None:
    """Print for each world both results on the same fresh runs, as JSON."""
    print(json.dumps({"worlds": [world(*each) for each in WORLDS], "margin": MARGIN}))


def world(fields: dict[str, Any], over: tuple[str, ...]) -> dict[str, Any]:
    """Return what both searches found in one world, and by how much theory's is better."""
    scenario = Scenario().replace(fields)
    theory, runs = (search(scenario, over, theory) for theory in (True, False))
    better = mean_difference(theory.pop("values"), runs.pop("values"))
    return {
        "robots": scenario.robots.count,
        "tasks": scenario.tasks.count,
        "steps": scenario.run.steps,
        "varied": ", ".join(each.partition("=")[0].replace("decision.", "") for each in over),
        "theory": theory,
        "without": runs,
        "better": better._asdict(),
    }


def search(scenario: Scenario, over: tuple[str, ...], theory: bool) -> dict[str, Any]:
    """Return what a search found, judged on runs that no search has used, and the number of its runs."""
    counts = [0]
    execution = Execution(progress=lambda progress: counts.append(progress.runs_done))
    tuned = tune(scenario, dimensions(scenario, over), seed=SEED, execution=execution, theory=theory)
    assert (tuned.predicted is not None) == theory
    chosen = scenario.replace({**tuned.values, "run.stop_at_decision": False})
    record = simulate_record(chosen, Runs(JUDGES, SEED + 1, 0))
    right = ended_right(record, chosen)
    return {
        "found": tuned.values,
        "values": right.astype(float),
        "right": float(right.mean()),
        "predicted": tuned.predicted,
        "median_step": decision_times(record.decision_step).median,
        "runs": max(counts),
    }


if __name__ == "__main__":
    main()
