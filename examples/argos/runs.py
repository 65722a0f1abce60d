"""Run an .argos file with many seeds, and print how the swarms decided. Standard library only.

Run it in this folder, after the build:

    python3 runs.py bodies.argos --tasks 10,20,40 --runs 200
"""

from __future__ import annotations

import argparse
import math
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

COLUMNS = "tasks  runs  feasible (95 % interval)  undecided  median step  mean step  metres/step  meetings"


def main() -> None:
    """Read the arguments, run, and print one line per number of tasks."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", type=Path, help="an .argos file, as `feasibee scenario --to argos` prints it")
    parser.add_argument(
        "--tasks", default="", help="numbers of tasks, such as 10,20,40; by default the file's"
    )
    parser.add_argument("--runs", type=int, default=100, help="runs per number of tasks; by default 100")
    parser.add_argument("--seed", type=int, default=1, help="random_seed of the first run; by default 1")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time; by default 1")
    parser.add_argument("--out", type=Path, help="a CSV file to which every run is written")
    given = parser.parse_args()
    experiment = ElementTree.parse(given.file).getroot()
    rows = ["tasks,seed,decision,decision_step,steps,metres_per_step,meetings_per_step\n"]
    print(COLUMNS)
    for tasks in given.tasks.split(",") if given.tasks else [world(experiment).get("tasks", "")]:
        seeds = range(given.seed, given.seed + given.runs)
        with ThreadPoolExecutor(given.jobs) as pool:
            lines = list(pool.map(partial(run, ElementTree.tostring(experiment), tasks), seeds))
        rows += [f"{tasks},{line}" for line in lines]
        print(summary(tasks, [line.split(",") for line in lines]), flush=True)
    if given.out:
        given.out.write_text("".join(rows))


def world(experiment: ElementTree.Element) -> ElementTree.Element:
    """Return the element of the loop functions that says how many tasks there are."""
    return next(experiment.iter("world"))


def run(text: bytes, tasks: str, seed: int) -> str:
    """Run ARGoS once; return its line of the file of runs."""
    experiment = ElementTree.fromstring(text)
    world(experiment).set("tasks", tasks)
    next(experiment.iter("experiment")).set("random_seed", str(seed))
    with tempfile.TemporaryDirectory() as folder:
        settings = next(experiment.iter("run"))
        settings.set("steps_file", "")
        settings.set("runs_file", f"{folder}/runs.csv")
        file = Path(folder, "run.argos")
        file.write_bytes(ElementTree.tostring(experiment))
        command = ["argos3", "--no-color", "--no-visualization", "--config-file", str(file)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return Path(folder, "runs.csv").read_text()


def summary(tasks: str, runs: list[list[str]]) -> str:
    """Return a line of the table: rates, steps until the decision, ways, and meetings per robot-step."""
    decisions = [each[1] for each in runs]
    steps = [int(each[2]) for each in runs if each[1] != "undecided"]
    feasible = decisions.count("feasible")
    low, high = wilson(feasible, len(runs))
    weights = [int(each[3]) for each in runs]
    way, meetings = (weighted([float(each[column]) for each in runs], weights) for column in (4, 5))
    return (
        f"{tasks:>5}  {len(runs):>4}  {feasible / len(runs):>8.3f} ({low:.3f} to {high:.3f})   "
        f"{decisions.count('undecided'):>9}  {statistics.median(steps or [math.nan]):>11g}  "
        f"{statistics.fmean(steps or [math.nan]):>9.1f}  {way:>11.4f}  {meetings:>8.4f}"
    )


def weighted(values: list[float], weights: list[int]) -> float:
    """Return the mean over all steps of all runs."""
    return sum(value * weight for value, weight in zip(values, weights, strict=True)) / sum(weights)


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % interval of Wilson for a share."""
    z = 1.959964
    middle = (successes + z * z / 2) / (trials + z * z)
    half = z / (trials + z * z) * math.sqrt(successes * (trials - successes) / trials + z * z / 4)
    return middle - half, middle + half


if __name__ == "__main__":
    main()
