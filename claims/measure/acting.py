"""Measure how soon robots that act do all tasks: docs/ask-first.md.

The targets are those of a prototype of our own, in another language and with other seeds. Medians are to be
within 3 % of its, and 95 % within 10 %, or sooner.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from feasibee import Scenario, simulate
from feasibee.results.statistics import declare_times, wilson

RUNS = 2000
COMMON: dict[str, Any] = {
    **{"decision.strategy": "quiet-census", "robots.know_count": True, "run.steps": 4000},
    **{"run.stop_at_decision": False, "run.stop_when_taken": True},
}
TARGETS: dict[str, tuple[dict[str, Any], int, int]] = {
    "start 0": ({"acting.start": 0}, 194, 530),
    "start 40": ({"acting.start": 40}, 75, 132),
    "tag, start 60": ({"acting.start": 60, "acting.hold": "tag"}, 72, 95),
    "rank, start 100": ({"acting.start": 100, "acting.choose": "rank"}, 112, 113),
}
"""By rule: its changes, and the median and 95 % of the prototype at 20 robots and 20 tasks."""
MIXED: dict[str, Any] = {
    "robots": {
        "classes": [
            {"name": "a", "count": 8, "skills": ["a"]},
            {"name": "b", "count": 4, "skills": ["b"]},
            {"name": "both", "count": 8, "skills": ["a", "b"]},
        ]
    },
    "tasks": {
        "classes": [
            {"name": "a", "count": 12, "needs": {"a": 1}},
            {"name": "b", "count": 8, "needs": {"b": 1}},
        ]
    },
    "acting": {"start": 40},
    "decision": {"strategy": "census"},
    "run": {"steps": 2000, "stop_at_decision": False, "stop_when_taken": True},
}
"""A team of specialists and all-rounders that is enough for all tasks."""
DRIFTS = (0.0, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2)
"""Of odometry in own frames, in units per step."""


def main() -> None:
    """Print the times of the rules, how far they are from the targets, and how often 21 tasks were begun."""
    rules = [measured(name) for name in TARGETS]
    mixed, relieved = (Scenario(**MIXED).replace({"acting.relieve": each}) for each in (False, True))
    teams = {"mixed": taken(mixed, RUNS, 1), "relieved": taken(relieved, RUNS, 1)}
    found = {"runs": RUNS, "rules": rules, "tail": tail(), "vain": in_vain(), "frames": frames(), **teams}
    print(json.dumps(found, indent=1))


def measured(name: str) -> dict[str, Any]:
    """Return the times of a rule, and their ratios to the targets."""
    changes, median, p95 = TARGETS[name]
    times = timed(changes)
    return {
        **{"rule": name, "aimed": f"{median}/{p95}", **times},
        "median_off": None if times["median"] is None else times["median"] / median - 1,
        "p95_off": None if times["p95"] is None else times["p95"] / p95 - 1,
    }


def tail() -> dict[str, float]:
    """Return the 95 % of the times from step 40 on, of ten times as many runs, with its 95 % interval."""
    changes = {**COMMON, **TARGETS["start 40"][0]}
    steps = simulate(Scenario().replace(changes), runs=10 * RUNS, seed=1).all_taken_step.values
    half = 1.96 * math.sqrt(0.95 * 0.05 / steps.size)
    low, p95, high = np.quantile(steps, [0.95 - half, 0.95, 0.95 + half], method="higher").tolist()
    return {"low": low, "p95": p95, "high": high}


def frames() -> list[dict[str, Any]]:
    """Return the times of robots in own frames, from steps 0 and 40 on, by what they know."""
    known = {
        "own eyes only": {"acting.tell": False},
        **{f"{each:g}": {"acting.drift": each} for each in DRIFTS},
    }
    return [
        {
            "known": name,
            "once": timed({"acting.start": 0, **changes}),
            "later": timed({"acting.start": 40, **changes}),
        }
        for name, changes in known.items()
    ]


def timed(changes: dict[str, Any]) -> dict[str, Any]:
    """Return how soon all tasks are taken, how far robots walk, and how often in vain."""
    found = simulate(Scenario().replace({**COMMON, **changes}), runs=RUNS, seed=1)
    times = declare_times(found.all_taken_step.values)
    return {
        **{"median": times.median, "p95": times.p95},
        **{"low": times.median_interval[0], "high": times.median_interval[1]},
        "vain": float(found.vain_arrivals.values.mean()),
        "distance": float(found.distance_walked.values.mean()) / 20,
    }


def in_vain() -> dict[str, float]:
    """Return the share of swarms of which a robot starts in vain, at 21 tasks, from step 100 on by rank."""
    changes = {"acting.start": 100, "acting.choose": "rank", "tasks.count": 21}
    quick = {**COMMON, **changes, "run.steps": 200}
    found = simulate(Scenario().replace(quick), runs=RUNS, seed=1)
    return wilson(int((found.starts_in_vain.values > 0).sum()), RUNS)._asdict()


def taken(scenario: Scenario, runs: int, seed: int) -> dict[str, Any]:
    """Return in which share of swarms all tasks are taken, and by which steps."""
    steps = simulate(scenario, runs, seed=seed).all_taken_step.values
    times, done = declare_times(steps), wilson(int((steps >= 0).sum()), runs)
    return {**done._asdict(), "median": times.median, "p95": times.p95}


if __name__ == "__main__":
    main()
