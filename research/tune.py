"""Search for parameters with which swarms are right more often, by Optuna (pip install optuna).

The best of many trials was also lucky, so it is judged on fresh runs.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import optuna

import feasibee

EXAMPLE = "example: python research/tune.py --tasks 10 --trials 60"
SPACE = {"decision.exploration": (2.0, 50.0), "decision.gain": (2.0, 50.0)}


def right(tasks: int, values: dict[str, Any], runs: int, seed: int) -> Any:
    """Return the share of swarms whose decision is right, with its 95 % interval."""
    scenario = feasibee.Scenario().replace({"tasks.count": tasks, "run.steps": 500, **values})
    decisions = feasibee.simulate(scenario, runs, seed).decision.values
    return feasibee.wilson(int((decisions == feasibee.truth(scenario)).sum()), runs)


def main() -> None:
    """Print the best parameters, and how often swarms are right with them, on fresh runs."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("--tasks", type=int, default=10)
    parser.add_argument("--trials", type=int, default=60)
    parser.add_argument(
        "--runs", type=int, default=200, help="runs of a trial; the result has ten times as many"
    )
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()

    def score(trial: optuna.Trial) -> float:
        values = {path: trial.suggest_float(path, *ends, log=True) for path, ends in SPACE.items()}
        return float(right(given.tasks, values, given.runs, given.seed).estimate)

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    search = optuna.create_study(direction="maximize", sampler=optuna.samplers.TPESampler(seed=given.seed))
    search.enqueue_trial({path: feasibee.Scenario().get(path) for path in SPACE})
    search.optimize(score, given.trials)
    fresh = {
        name: right(given.tasks, values, 10 * given.runs, given.seed + 1)._asdict()
        for name, values in (("start", {}), ("best", search.best_params))
    }
    print(json.dumps({"values": search.best_params, **fresh}, indent=1))


if __name__ == "__main__":
    main()
