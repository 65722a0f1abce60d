"""Compute the weights of `evolved.py` again: `python examples/rivals/evolve.py` prints them.

The loss is the mean share of robots that are wrong at the end, in swarms of 20 robots. Ratios and seeds
differ from those of docs/findings.md, which evaluates the net. It needs SciPy 1.15 or later, and takes six
minutes on two cores. With `--check` it prints the loss of the weights that `evolved.py` has.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import differential_evolution

from feasibee import Scenario, simulate

FILE = Path(__file__).with_name("evolved.py")
TASKS = (5, 8, 12, 16, 25, 32, 60)
"""Numbers of tasks in training: feasible, from 5 to 16, and infeasible, from 25 to 60."""
RUNS, SEED = 16, 20_261_128
BOUND, GENERATIONS, POPULATION = 4.0, 40, 3
"""Weights are between -BOUND and BOUND; there are POPULATION candidates per weight."""


def wrong(weights: np.ndarray, names: list[str], tasks: tuple[int, ...] = TASKS) -> float:
    """Return the mean share of robots that are wrong at the end."""
    parameters = {name: round(float(weight), 3) for name, weight in zip(names, weights, strict=True)}
    shares = []
    for count in tasks:
        scenario = Scenario(
            tasks={"count": count}, decision={"strategy": str(FILE), "parameters": parameters}
        )
        found = simulate(scenario, runs=RUNS, seed=SEED + count)
        feasible = float(found["feasible_at_end"].mean()) / scenario.robots.count
        shares.append(1.0 - feasible if count <= scenario.robots.count else feasible)
    return float(np.mean(shares))


def main() -> None:
    """Print the loss of each generation and the weights; or the loss of those that the file has."""
    weights = Scenario(decision={"strategy": str(FILE)}).decision.parameters
    names = list(weights)
    if "--check" in sys.argv:
        print(json.dumps({"wrong": wrong(np.array(list(weights.values())), names)}))
        return
    found = differential_evolution(
        wrong,
        [(-BOUND, BOUND)] * len(names),
        args=(names,),
        maxiter=GENERATIONS,
        popsize=POPULATION,
        polish=False,
        rng=SEED,
        callback=lambda intermediate_result: print(f"# {intermediate_result.fun:.4f}", flush=True),
    )
    for name, weight in zip(names, found.x, strict=True):
        print(f'    "{name}": {weight:.3f},')


if __name__ == "__main__":
    main()
