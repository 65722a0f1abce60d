"""Measure the theory against the engine: over the paper's ratios, and for random controllers within reach.

Seeds were drawn once. Nobody looked at these runs while the theory was written.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np

from feasibee import Scenario, ScenarioError
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.paper import TASKS
from feasibee.theory.predict import compare, predict
from feasibee.theory.reach import ERRORS, check_fields, check_swarm
from feasibee.theory.rule import swarm_of

CONTROLLERS, CONTROLLER_RUNS, SEED = 40, 10_000, 9241
UNRELIABLE, UNRELIABLE_RUNS = 20, 2_000
PAPER_RUNS = 10_000
SIGHTS, SIGHT_RUNS, SIGHT_SEED = 50, 2_000, 480_113
FAULTS, FAULTY_RUNS = ("stubborn", "opposite", "feasible", "infeasible", "random"), 2_000


def main() -> None:
    """Print the largest errors of shares and of median steps, as JSON."""
    paper = [errors(Scenario(tasks={"count": tasks}), PAPER_RUNS, SEED + tasks) for tasks in TASKS]
    voters = [
        errors(
            Scenario(tasks={"count": tasks}, decision={"strategy": "dmvd"}), PAPER_RUNS, SEED + 500 + tasks
        )
        for tasks in TASKS
    ]
    random = [
        {**errors(scenario, CONTROLLER_RUNS, SEED + 1_000 + number), **about(scenario)}
        for number, scenario in enumerate(controllers(CONTROLLERS))
    ]
    unreliable = [
        {**errors(scenario, UNRELIABLE_RUNS, SEED + 2_000 + number), **about(scenario, FAILING)}
        for number, scenario in enumerate(controllers(UNRELIABLE, FAILING))
    ]
    sights = list(first_sights(SIGHTS))
    found = [errors(each, SIGHT_RUNS, SIGHT_SEED + 1 + number) for number, each in enumerate(sights)]
    sighted = [
        {**each, "strategy": sight.decision.strategy} for each, sight in zip(found, sights, strict=True)
    ]
    faulty = {
        name: [
            errors(scenario, FAULTY_RUNS, SEED + 10_000 + 1_000 * kind + number)
            for number, scenario in enumerate(with_faults(name))
        ]
        for kind, name in enumerate(FAULTS)
    }
    sets = {
        **{f"says_{name}": found for name, found in faulty.items()},
        "paper": paper,
        "dmvd": voters,
        "random": random,
        "unreliable": unreliable,
        "first_sight": sighted,
    }
    print(
        json.dumps(
            {
                **{name: summary(found) for name, found in sets.items()},
                "controllers": random,
                "first_sights": sighted,
                "unreliable_controllers": unreliable,
            }
        )
    )


def with_faults(name: str) -> Iterator[Scenario]:
    """Yield swarms of 20 with one to three stubborn robots, or Byzantine ones that say ``name``."""
    for count, tasks in product((1, 2, 3), (5, 10, 16, 20, 25, 40, 80)):
        robots = {"count": count}
        faults = {name: robots} if name == "stubborn" else {"byzantine": robots, "byzantine_says": name}
        yield Scenario(tasks={"count": tasks}, faults=faults, run={"stop_at_decision": True})


def errors(scenario: Scenario, runs: int, seed: int) -> dict[str, float]:
    """Return the larger error of both shares, and the relative error of the median step."""
    prediction = predict(scenario)
    found = compare(prediction, simulate_record(scenario, Runs(runs, seed, 0)))
    share = max(
        abs(getattr(prediction, name) - found.rates[name].estimate) for name in ("feasible", "infeasible")
    )
    theory, engine = prediction.steps["median"], found.steps.median
    return {"share": share, "time": abs(math.log(theory / engine)) if theory and engine else float("nan")}


def about(scenario: Scenario, failing: Mapping[str, tuple[float, float]] = {}) -> dict[str, Any]:
    """Return the fields that were drawn."""
    return {path: scenario.get(path) for path in (*DRAWN, *failing)}


def summary(found: list[dict[str, Any]]) -> dict[str, float]:
    """Return the mean and the largest error of a share, and of the median step."""
    return {
        f"{name}_{kind}": float(of([each[name] for each in found]))
        for name in ("share", "time")
        for kind, of in (("mean", np.nanmean), ("largest", np.nanmax))
    }


LONG = {"run.steps": 3_000, "run.stop_at_decision": True}
DRAWN = {
    "robots.count": (10, 40),
    "robots.speed": (0.5, 2.0),
    "arena.side": (14.0, 34.0),
    "sensing.range": (1.3, 3.5),
    "walk.mean_run": (3.0, 30.0),
    "decision.exploration": (6.0, 50.0),
    "decision.gain": (4.0, 60.0),
    "tasks.count": (0.33, 3.0),
}
"""Fields and their ranges; numbers are drawn evenly by ratio, that of tasks relative to robots."""


FAILING = {"radio.range": (1.3, 3.5), "sensing.miss": (0.05, 0.7), "radio.loss": (0.05, 0.7)}
"""Further fields of controllers that miss things and messages, and hear as far as drawn."""


def controllers(count: int, failing: Mapping[str, tuple[float, float]] = {}) -> Iterator[Scenario]:
    """Yield random controllers within the theory's reach."""
    random = np.random.default_rng(SEED + len(failing))
    while count:
        scenario = draw(random, failing)
        try:
            warned = predict(scenario).warnings
        except ScenarioError:
            continue
        if not warned:
            count -= 1
            yield scenario


def first_sights(count: int) -> Iterator[Scenario]:
    """Yield random controllers with first sight within the theory's reach, of each strategy in turn."""
    random, number = np.random.default_rng(SIGHT_SEED), 0
    while number < count:
        strategy = tuple(ERRORS)[number % len(ERRORS)]
        scenario = draw(random).replace({"decision.start": "first-sight", "decision.strategy": strategy})
        try:
            check_fields(scenario)
            check_swarm(scenario, swarm_of(scenario))
        except ScenarioError:
            continue
        number += 1
        yield scenario


def draw(random: np.random.Generator, failing: Mapping[str, tuple[float, float]] = {}) -> Scenario:
    """Return a random controller, which may be beyond the theory's reach."""
    drawn = {
        path: float(np.exp(random.uniform(*np.log(ends)))) for path, ends in {**DRAWN, **failing}.items()
    }
    drawn["tasks.count"] *= drawn["robots.count"]
    fields = {
        path: round(value) if path.endswith("count") else float(f"{value:.3g}")
        for path, value in drawn.items()
    }
    listen = ("always", "dissemination")[int(random.integers(2))]
    return Scenario().replace({**fields, "decision.listen": listen, **LONG})


if __name__ == "__main__":
    main()
