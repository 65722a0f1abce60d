"""Search by theory which rules at 6 bits are right most often near ratio one, and simulate the best."""

from __future__ import annotations

import json
from itertools import product
from typing import Any

import numpy as np

from feasibee import Scenario
from feasibee.results.measures import mean_bits
from feasibee.results.statistics import accuracy
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.theory.reach import ERRORS
from feasibee.theory.screen import Screen

FIELDS = "decision.strategy", "decision.start", "decision.exploration", "decision.gain"
TASKS = 16, 25
STARTS = "coin", "first-sight"
EXPLORATIONS = 10.0, 14.0, 20.0, 28.0, 40.0
GAINS = 10.0, 20.0, 28.0, 40.0
RUNS, SEED = 2000, 77


def main() -> None:
    """Print the best rule of each strategy, predicted and simulated, as JSON."""
    screen = Screen(max(EXPLORATIONS), 0.075)  # with first sight, dmvd and voter are so far off
    rules = [
        dict(zip(FIELDS, values, strict=True)) for values in product(ERRORS, STARTS, EXPLORATIONS, GAINS)
    ]
    found = [(predicted(screen, rule), rule) for rule in rules]
    within = sorted(((shares, rule) for shares, rule in found if shares), key=lambda each: -sum(each[0]))
    best = {rule["decision.strategy"]: (shares, rule) for shares, rule in reversed(within)}
    rows = [row(*each) for each in best.values()]
    rows.sort(key=lambda each: -sum(each["predicted"]))
    print(json.dumps({"rules": len(within), "best": rows}))


def predicted(screen: Screen, rule: dict[str, Any]) -> list[float]:
    """Return the shares of right swarms; empty beyond the theory's reach."""
    shares = [screen.right(Scenario().replace({**rule, "tasks.count": tasks})) for tasks in TASKS]
    return [] if None in shares else [float(share or 0) for share in shares]


def row(shares: list[float], rule: dict[str, Any]) -> dict[str, Any]:
    """Return a rule, with its shares by theory and by fresh runs, median steps and mean bits."""
    right, steps, bits = [], [], []
    for tasks in TASKS:
        scenario = Scenario().replace({**rule, "tasks.count": tasks})
        record = simulate_record(scenario, Runs(RUNS, SEED))
        right.append(accuracy(record.decision, tasks < scenario.robots.count)._asdict())
        steps.append(int(np.median(record.decision_step[record.decision >= 0])))
        bits.append(mean_bits(record, scenario))
    short = {path.removeprefix("decision."): value for path, value in rule.items()}
    return {**short, "predicted": shares, "right": right, "steps": steps, "bits": float(np.mean(bits))}


if __name__ == "__main__":
    main()
