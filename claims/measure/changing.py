"""Measure how swarms notice changes of their world: docs/changing-worlds.md.

Run with one of the names of `PARTS`; prints JSON.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

import feasibee
from feasibee.results.measures import changes_of, tracking
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

CHANGE, STEPS, SETTLED = 500, 1500, 500
CASES = {
    "10 to 40": (10, 30, 0),
    "16 to 25": (16, 9, 0),
    "40 to 10": (40, -30, 0),
    "25 to 16": (25, -9, 0),
    "20 to 21": (20, 1, 0),
    "21 to 20": (21, -1, 0),
}
STRATEGIES: dict[str, dict[str, Any]] = {"roster": {}}
BASELINES = {
    "dmmd": {},
    "dmmd, stubborn": {"decision.strategy": "dmmd", "faults.stubborn": 0.1},
    "census": {},
}
HARMS = {
    "none": {},
    "a tenth missed": {"sensing.miss": 0.1},
    "a fifth lost": {"radio.loss": 0.2},
    "walls and bodies": {"arena.boundary": "walls", "robots.avoid_collisions": True},
    "1 Byzantine robot": {"faults.byzantine": 0.05, "faults.byzantine_says": "colluding"},
    "2 Byzantine robots": {"faults.byzantine": 0.1, "faults.byzantine_says": "colluding"},
}
REMEDIES = {
    "roster": {
        "a tenth missed": {"looks": 4.0},
        "1 Byzantine robot": {"tolerates": 1.0},
        "2 Byzantine robots": {"tolerates": 2.0},
    },
}
"""Parameters against some harms."""
STREAM = {"tasks.arrival_rate": 20.5 / 1800, "tasks.lifetime": 1800.0, "run.steps": 2500}
FLIPS = [{"step": step, "tasks": 9 if step % 1000 else -9} for step in range(500, 2500, 500)]


def main(part: str) -> None:
    """Print the measures of a part as JSON."""
    print(json.dumps(PARTS[part](), indent=2))


def noticing() -> dict[str, Any]:
    """Measure each case for each strategy and, with fewer runs, for the baselines."""
    found = {name: {case: noticed(name, case, own) for case in CASES} for name, own in STRATEGIES.items()}
    for name, own in BASELINES.items():
        found[name] = {case: noticed(name, case, own, 200) for case in CASES}
    return found


def leaving() -> dict[str, Any]:
    """Measure whether 5 of 20 robots that leave are noticed, with 18 tasks."""
    return measured("roster", (18, 0, -5), {}, 1000)


def standing() -> dict[str, Any]:
    """Measure worlds that stay; an event at the last step changes nothing, so that truth is kept by step."""
    found: dict[str, Any] = {}
    for name, own in STRATEGIES.items():
        for tasks in (10, 16, 20, 21, 25, 40):
            events = [{"step": STEPS, "radio": {"loss": 0.0}}]
            scenario = scenario_of(name, (tasks, 0, 0), {**own, "events": events})
            record = simulate_record(scenario, Runs(1000, 1))
            track = tracking(record, scenario, SETTLED)
            found.setdefault(name, {})[str(tasks)] = {
                "alarms": int(
                    np.rint(track.false_alarms.estimate * record.runs * (STEPS - SETTLED + 1) / 1000)
                ),
            }
    return found


def harming() -> dict[str, Any]:
    """Measure 16 to 25 tasks and back under each harm."""
    found: dict[str, Any] = {}
    for name, own in STRATEGIES.items():
        for harm, changes in HARMS.items():
            everything = {**own, **changes}
            for parameter, value in REMEDIES[name].get(harm, {}).items():
                everything[f"decision.parameters.{parameter}"] = value
            found.setdefault(name, {})[harm] = {
                case: noticed(name, case, everything, 200) for case in ("16 to 25", "25 to 16")
            }
    return found


def streaming() -> dict[str, Any]:
    """Measure the default stream, and 16 and 25 tasks that alternate every 500 steps."""
    found: dict[str, Any] = {}
    for name, own in {**STRATEGIES, **BASELINES}.items():
        for stream, tasks, changes in (
            ("stream", 20, STREAM),
            ("flips", 16, {"events": FLIPS, "run.steps": 2500}),
        ):
            scenario = scenario_of(name, (tasks, 0, 0), {**own, **changes})
            record = simulate_record(scenario, Runs(500, 1))
            track = tracking(record, scenario)
            found.setdefault(name, {})[stream] = {
                **track.to_dict(),
                "never_changing": float(np.maximum(true := record.truth[:, 1:].mean(1), 1 - true).mean()),
                "taken_back": taken_back(record.truth, 50),
            }
    return found


def taken_back(truth: np.ndarray, soon: int) -> float:
    """Return the share of the changes of truth that the next one takes back within so many steps."""
    changes = [np.flatnonzero(np.diff(each)) for each in truth.astype(np.int8)]
    gaps = np.concatenate([np.diff(steps) for steps in changes])
    return float((gaps < soon).sum() / sum(steps.size for steps in changes))


def scenario_of(name: str, case: tuple[int, int, int], changes: dict[str, Any]) -> feasibee.Scenario:
    """Return a scenario in which tasks and robots come or go at one step."""
    tasks, appear, join = case
    events = [{"step": CHANGE, "tasks": appear, "robots": join}] if appear or join else []
    usual = {
        "decision.strategy": name.split(",", maxsplit=1)[0],
        "tasks.count": tasks,
        "run.steps": STEPS,
        "events": events,
    }
    return feasibee.Scenario().replace({**usual, **changes})


def noticed(name: str, case: str, changes: dict[str, Any], runs: int = 1000) -> dict[str, Any]:
    """Return the measures of a case."""
    return measured(name, CASES[case], changes, runs)


def measured(name: str, case: tuple[int, int, int], changes: dict[str, Any], runs: int) -> dict[str, Any]:
    """Return the share of swarms right just before the change, and how soon these noticed it."""
    scenario = scenario_of(name, case, changes)
    record = simulate_record(scenario, Runs(runs, 1))
    delay = changes_of(record.truth, record.held).delay
    late = np.where(delay < 0, STEPS, delay)
    shares = {f"within_{most}": float((late <= most).mean()) if late.size else None for most in (150, 300)}
    return {
        "right_before": late.size / runs,
        **shares,
        "median": int(np.median(late)) if late.size else None,
        "p90": int(np.quantile(late, 0.9)) if late.size else None,
    }


PARTS = {
    "noticing": noticing,
    "leaving": leaving,
    "standing": standing,
    "harming": harming,
    "streaming": streaming,
}

if __name__ == "__main__":
    main(sys.argv[1])
