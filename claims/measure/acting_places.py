"""Measure how soon robots that act do all tasks in rooms: docs/places.md."""

from __future__ import annotations

import json
from typing import Any

from claims.measure.rooms import PLACES, WORST, scenario_in
from feasibee import Scenario, simulate
from feasibee.results.statistics import declare_times, wilson
from feasibee.simulation.flooding import flooded

RUNS, SEED = 400, 5
LONGEST = 2000
"""Steps that robots have for all tasks once they act."""
OPEN = "corridor of 100 by 4"
WAYS: dict[str, dict[str, Any]] = {"deflect": {}, "search": {"acting.start": "search"}}
"""What differs from robots that start when it is safe."""
COMMON: dict[str, Any] = {
    **{"decision.strategy": "quiet-census", "acting.start": "safe", "tasks.count": 20},
    **{"run.stop_when_taken": True, "run.stop_at_declarations": False},
}


def main() -> None:
    """Print the measures of each place."""
    names = [each for each in PLACES if each != OPEN]
    wide = in_time(flooded(safe_in(WORST).replace({"acting.reach": 2.0})))
    print(json.dumps({"runs": RUNS, "rows": [measured(name) for name in names], "wide": wide}, indent=1))


def safe_in(name: str) -> Scenario:
    """Return robots that deflect, and start when it is safe, in a place."""
    return flooded(scenario_in(*PLACES[name]).replace(COMMON))


def measured(name: str) -> dict[str, Any]:
    """Return how soon all tasks are taken in a place, and how often one of 21 is although that is in vain."""
    safe = safe_in(name)
    found = {way: in_time(flooded(safe.replace(changes))) for way, changes in WAYS.items()}
    few = safe.replace({"tasks.count": 21, "run.steps": safe.acts_from + 100, "run.stop_when_taken": False})
    began = simulate(few, RUNS, seed=SEED).starts_in_vain.values > 0
    return {"place": name, "start": safe.acts_from, **found, "vain": wilson(int(began.sum()), RUNS)._asdict()}


def in_time(scenario: Scenario) -> dict[str, Any]:
    """Return from when on robots act, in which share of swarms all tasks are taken, and by which steps."""
    start = scenario.acts_from
    steps = simulate(scenario.replace({"run.steps": start + LONGEST}), RUNS, seed=SEED).all_taken_step.values
    times, done = declare_times(steps), wilson(int((steps >= 0).sum()), RUNS)
    return {"start": start, **done._asdict(), "median": times.median, "p95": times.p95}


if __name__ == "__main__":
    main()
