"""Run an .argos file with many seeds, and print how the swarms decided. Standard library only.

Run it in this folder, after the build:

    python3 runs.py bodies.argos --tasks 10,20,40 --runs 200
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
import statistics
import subprocess
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TextIO
from xml.etree import ElementTree

COLUMNS = "tasks  runs  feasible (95 % interval)  undecided  median step  mean step  metres/step  meetings"

WRITTEN = "seed,decision,decision_step,steps,metres_per_step,meetings_per_step,robots_in_sight,tasks_in_sight"


def main() -> None:
    """Read the arguments, run, and print one line per number of tasks."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", type=Path, help="an .argos file, as export.py prints it")
    parser.add_argument(
        "--tasks", default="", help="numbers of tasks, such as 10,20,40; by default the file's"
    )
    parser.add_argument("--runs", type=int, default=100, help="runs per number of tasks; by default 100")
    parser.add_argument("--seed", type=int, default=1, help="random_seed of the first run; by default 1")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time; by default 1")
    parser.add_argument("--out", type=Path, help="a CSV file to which every run is written")
    given = parser.parse_args()
    if shutil.which("argos3") is None:
        parser.error("argos3 isn't in PATH; install ARGoS3, or add the folder that holds argos3 to PATH")
    text = ElementTree.tostring(ElementTree.parse(given.file).getroot())
    print(COLUMNS)
    with (given.out or Path(os.devnull)).open("w") as out:
        out.write(f"tasks,{WRITTEN}\n")
        for tasks in given.tasks.split(",") if given.tasks else [""]:
            print(summary(tasks, list(runs(text, tasks, given, out))), flush=True)


def runs(text: bytes, tasks: str, given: argparse.Namespace, out: TextIO) -> Iterator[list[str]]:
    """Yield the columns of each run, and write them to a file as they come."""
    seeds = range(given.seed, given.seed + given.runs)
    with ThreadPoolExecutor(given.jobs) as pool:
        for line in pool.map(partial(run, text, tasks), seeds):
            out.write(f"{tasks},{line}")
            out.flush()
            yield line.strip().split(",")


def run(text: bytes, tasks: str, seed: int) -> str:
    """Run ARGoS once; return its line of the file of runs."""
    experiment = ElementTree.fromstring(text)
    if tasks:
        next(experiment.iter("world")).set("tasks", tasks)
    next(experiment.iter("experiment")).set("random_seed", str(seed))
    with tempfile.TemporaryDirectory() as folder:
        settings = next(experiment.iter("run"))
        settings.set("steps_file", "")
        settings.set("runs_file", f"{folder}/runs.csv")
        file = Path(folder, "run.argos")
        file.write_bytes(ElementTree.tostring(experiment))
        command = ["argos3", "--no-color", "--no-visualization", "--config-file", str(file)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(
                f"argos3 ended with status {done.returncode}, random_seed={seed}:\n{done.stderr}"
            )
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
        f"{tasks or 'file':>5}  {len(runs):>4}  {feasible / len(runs):>8.3f} ({low:.3f} to {high:.3f})   "
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
    return max(0.0, middle - half), min(1.0, middle + half)


if __name__ == "__main__":
    main()
