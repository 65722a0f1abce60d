"""Measure the theory against the engine: over the paper's ratios, and for random controllers within reach.

Seeds were drawn once. Nobody looked at these runs while the theory was written.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from feasibee import Scenario, ScenarioError
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.studies.paper import TASKS
from feasibee.theory.against import compare
from feasibee.theory.predict import predict

CONTROLLERS, CONTROLLER_RUNS, SEED = 40, 10_000, 6173
PAPER_RUNS = 10_000


def main() -> None:
    """Print the largest errors of shares and of median steps, as JSON."""
    paper = [errors(Scenario(tasks={"count": tasks}), PAPER_RUNS, SEED + tasks) for tasks in TASKS]
    random = [
        {**errors(scenario, CONTROLLER_RUNS, SEED + 1_000 + number), **about(scenario)}
        for number, scenario in enumerate(controllers(CONTROLLERS))
    ]
    print(json.dumps({"paper": summary(paper), "random": summary(random), "controllers": random}))


def errors(scenario: Scenario, runs: int, seed: int) -> dict[str, float]:
    """Return the larger error of both shares, and the relative error of the median step."""
    prediction = predict(scenario)
    found = compare(prediction, simulate_record(scenario, Runs(runs, seed, 0)))
    share = max(
        abs(getattr(prediction, name) - found.rates[name].estimate) for name in ("feasible", "infeasible")
    )
    theory, engine = prediction.steps["median"], found.steps.median
    return {"share": share, "time": abs(math.log(theory / engine)) if theory and engine else float("nan")}


def about(scenario: Scenario) -> dict[str, Any]:
    """Return the fields that were drawn."""
    return {path: scenario.get(path) for path in DRAWN}


def summary(found: list[dict[str, Any]]) -> dict[str, float]:
    """Return the mean and the largest error of a share, and of the median step."""
    return {
        f"{name}_{kind}": float(of([each[name] for each in found]))
        for name in ("share", "time")
        for kind, of in (("mean", np.nanmean), ("largest", np.nanmax))
    }


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


def controllers(count: int) -> Iterator[Scenario]:
    """Yield random controllers within the theory's reach."""
    random = np.random.default_rng(SEED)
    while count:
        drawn = {path: float(np.exp(random.uniform(*np.log(ends)))) for path, ends in DRAWN.items()}
        drawn["tasks.count"] *= drawn["robots.count"]
        fields = {
            path: round(value) if path.endswith("count") else float(f"{value:.3g}")
            for path, value in drawn.items()
        }
        listen = ("always", "dissemination")[int(random.integers(2))]
        scenario = Scenario().replace({**fields, "decision.listen": listen, "run.steps": 3_000})
        try:
            warned = predict(scenario).warnings
        except ScenarioError:
            continue
        if not warned:
            count -= 1
            yield scenario


if __name__ == "__main__":
    main()
