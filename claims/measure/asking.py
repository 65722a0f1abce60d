"""Measure swarms that call for robots, and what they are to be compared with: docs/does-asking-pay.md.

Run with one of the names of `PARTS`; prints JSON.
"""

from __future__ import annotations

import json
import math
import sys
from typing import Any

import numpy as np

import feasibee
from feasibee.results.measures import tracking
from feasibee.results.responding import fixed_service, judgement
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

RUNS, TASKS, LIFETIME = 100, 20.5, 1800.0
BASE = {
    "tasks.arrival_rate": TASKS / LIFETIME,
    "tasks.lifetime": LIFETIME,
    "run.steps": 5000,
    "response.patience": 200,
    "response.delay": 100,
    "response.margin": 4,
    "decision.strategy": "roster",
}


def main(part: str) -> None:
    """Print the measures of a part as JSON."""
    print(json.dumps(PARTS[part](), indent=2))


def rates() -> dict[str, Any]:
    """Measure slower and faster changes."""
    lifetimes = (450.0, 900.0, 1800.0, 3600.0, 7200.0)
    changes = {each: {"tasks.lifetime": each, "tasks.arrival_rate": TASKS / each} for each in lifetimes}
    return {f"life_{each:.0f}": measured(changed) for each, changed in changes.items()}


def rules() -> dict[str, Any]:
    """Measure other patience, other delays and other margins."""
    values = {"patience": (50, 100, 400), "delay": (0, 400, 1600), "margin": (0, 2, 8)}
    return {
        f"{name}_{value}": measured({f"response.{name}": value})
        for name, some in values.items()
        for value in some
    }


def measured(changes: dict[str, Any]) -> dict[str, Any]:
    """Return the measures of a swarm, of an oracle, and of the fixed number that is feasible as often."""
    scenario = feasibee.Scenario().replace({**BASE, **changes})
    record = simulate_record(scenario, Runs(RUNS, 1))
    judged, track = judgement(record, scenario), tracking(record, scenario)
    flips = (np.diff(record.tasks_present > scenario.robots.count, axis=1) != 0).sum(axis=1).mean()
    return {
        "flips": float(flips) * 1000 / scenario.run.steps,
        "delay": track.detection_delay.median,
        "right": track.right_share.estimate,
        "robots": judged.robots,
        **{name: short(each) for name, each in services(judged).items()},
        **pays(judged.own, record.tasks_present.astype(np.int64)),
    }


def pays(own: Any, tasks: Any) -> dict[str, float | None]:
    """Return the costs of a step without enough robots, in idle robots, at which asking is cheapest."""
    low, high = 0.0, math.inf
    for number in range(int(tasks.min()), int(tasks.max()) + 1):
        fixed = fixed_service(tasks, number)
        saved = fixed.idle.estimate - own.idle.estimate
        more = fixed.feasible_share.estimate - own.feasible_share.estimate
        if more > 0:
            high = min(high, saved / more)
        elif more < 0:
            low = max(low, saved / more)
    return {"pays_from": low, "pays_to": high} if low < high else {"pays_from": None, "pays_to": None}


def services(judged: Any) -> dict[str, Any]:
    """Return the services to compare, by name."""
    return {"own": judged.own, "oracle": judged.oracle, "fixed": judged.as_often}


def short(service: Any) -> dict[str, float]:
    """Return the numbers of a service."""
    return {
        "enough": 100 * service.feasible_share.estimate,
        "idle": service.idle.estimate,
        "calls": service.calls.estimate,
        "too_many": service.too_many_per_call,
    }


PARTS = {"rates": rates, "rules": rules}

if __name__ == "__main__":
    main(sys.argv[1])
