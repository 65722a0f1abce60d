"""Compare swarms in the Robotarium's simulator with those of feasibee: docs/recipes.md.

    PYTHONPATH=SIMULATOR python -m claims.measure.robotarium --jobs 2

runs the plan in the simulator and appends each run to robotarium.csv. Started again, it continues. Without
options, it prints the comparison as JSON. CI lacks the simulator, so only our swarms are computed again.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import feasibee
from claims.measure.equivalence import difference, mean_of, ratio, tested

ROOT = Path(__file__).parents[2]
FIGURES = Path(__file__).with_suffix(".csv")
RECIPE = ROOT / "examples" / "recipes" / "robotarium.py"
FIELDS = ("tasks", "seed", "decision", "steps")
TASKS, RUNS, FIRST_SEED = (3, 30), 100, 1001
"""The plan: numbers of tasks, runs of each in the simulator, seed of the first."""
RATE, STEPS = (-0.15, 0.15), (0.80, 1.25)
"""Margins for the difference of two shares, and for the ratio of mean steps."""
OURS = 20_000
"""Runs of feasibee."""


def main() -> None:
    """Run the plan if jobs are given, else compare."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--jobs", type=int, default=0, help="runs at a time in the simulator; by default none"
    )
    given = parser.parse_args()
    if given.jobs:
        run_all(given.jobs)
    else:
        rows = [compared(tasks, contact) for tasks in TASKS for contact in ("stand", "deflect")]
        print(json.dumps(rows, indent=2))


def run_all(jobs: int) -> None:
    """Run what the plan has and the file lacks, seed by seed in turn for both numbers of tasks."""
    done = {(int(each["tasks"]), int(each["seed"])) for each in read()}
    plan = [(tasks, seed) for seed in range(FIRST_SEED, FIRST_SEED + RUNS) for tasks in TASKS]
    with FIGURES.open("a", newline="", encoding="utf-8") as file, ThreadPoolExecutor(jobs) as pool:
        writer = csv.writer(file, lineterminator="\n")
        if not done:
            writer.writerow(FIELDS)
        for row in pool.map(run, [each for each in plan if each not in done]):
            writer.writerow(row)
            file.flush()


def run(planned: tuple[int, int]) -> list[str]:
    """Run the recipe once; return the row of a run. The simulator must report no error."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(RECIPE), *map(str, planned)]
        done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    assert "No hard errors detected" in done.stdout, (planned, done.stdout)
    lines = [line.split() for line in done.stdout.splitlines()]
    decision = next(line for line in lines if line[:1] in (["feasible"], ["infeasible"], ["undecided"]))
    return [*map(str, planned), *decision]


def read() -> list[dict[str, str]]:
    """Return the runs that the file has."""
    if not FIGURES.exists():
        return []
    with FIGURES.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def compared(tasks: int, contact: str) -> dict[str, Any]:
    """Return what both simulators find for a number of tasks and a rule of contact, with the verdicts."""
    runs = [each for each in read() if int(each["tasks"]) == tasks]
    theirs = (sum(each["decision"] == "feasible" for each in runs), len(runs))
    scenario = feasibee.Scenario.read(RECIPE.with_suffix(".toml"))
    scenario = scenario.replace({"tasks.count": tasks, "robots.contact": contact})
    swarms = feasibee.simulate(scenario, runs=OURS, seed=1)
    ours = (int((swarms.decision == 1).sum()), OURS)
    steps = np.where(swarms.decision_step < 0, scenario.run.steps, swarms.decision_step)
    means = mean_of([int(each["steps"]) for each in runs]), mean_of(steps)
    return {
        "tasks": tasks,
        "contact": contact,
        "runs": len(runs),
        "undecided": sum(each["decision"] == "undecided" for each in runs),
        "robotarium": feasibee.wilson(*theirs)._asdict() | {"steps": means[0].mean},
        "feasibee": feasibee.wilson(*ours)._asdict() | {"steps": means[1].mean},
        "tests": {
            "feasible": tested(difference(theirs, ours), RATE),
            "steps": tested(ratio(*means), STEPS),
        },
    }


if __name__ == "__main__":
    main()
