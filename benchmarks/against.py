"""Compare the speed of two versions of feasibee, each in a process of its own, asked in turn.

``python benchmarks/against.py WORKLOAD`` prints one measurement for each line that it reads.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from cases import BEYOND_RUN, LARGE, QUICK, RUN, VAST, Plan, playing
from measure import Sample, command_cpu_seconds, peak_mebibytes, quartiles, ratios
from worlds import BEYOND, PAPER_STEPS, Tables, paper, steps_only, whole_runs, world

OURS = Path(__file__).parents[1] / "src"


def workloads(plan: Plan) -> dict[str, Sample]:
    """Return what is compared, by name."""
    samples = {"the paper's swarm": whole_runs(paper(), PAPER_STEPS, plan.runs)}
    for name, changes in _changes().items():
        samples[f"{name}, 20 robots"] = whole_runs(paper(changes), PAPER_STEPS, plan.runs // 8)
    for robots in (100, 1000, LARGE, 100_000, VAST):
        if robots <= plan.sizes[-1]:
            runs = max(1, plan.robot_steps // (robots * plan.steps))
            samples[f"{robots:,} robots"] = steps_only(world(robots, robots), plan.steps, runs)
    for name, changes in BEYOND.items():
        samples[f"{name}, {LARGE:,} robots"] = steps_only(world(LARGE, LARGE, changes), plan.steps)
    return samples


def _changes() -> dict[str, Tables]:
    knowledge = {name: {"decision": {"strategy": name}} for name in ("census", "tally")}
    return {**BEYOND, **knowledge}


class Worker:
    """A process that measures one version."""

    def __init__(self, source: Path, quick: bool) -> None:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(_paths(source))}
        command = [sys.executable, __file__, *["--quick"] * quick]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def ask(self, name: str) -> float:
        """Return one measurement."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(name + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"{name}: the process ended; see its message above")
        return float(answer)

    def close(self) -> None:
        """End the process."""
        self.process.communicate()


def _paths(source: Path) -> list[str]:
    others = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return [str(source.resolve()), *filter(None, others)]


def print_ratios(source: Path, plan: Plan) -> None:
    """Print how many times as fast this version is as the one in another source folder."""
    if not (source / "feasibee").is_dir():
        raise SystemExit(f"--against {source}: has no folder feasibee; pass the src folder of a working tree")
    print(f"CPU times in turn: median and quartiles of the ratios; above 1 is better than {source}")
    workers = [Worker(OURS, plan == QUICK), Worker(source, plan == QUICK)]
    for name in workloads(plan):
        repeats = 3 if name.startswith(f"{VAST:,}") else plan.repeats
        print_ratio(name, *ask_in_turn(workers, name, repeats), "ns/robot-step")
    for worker in workers:
        worker.close()
    print_first_runs(source, plan)
    print_memory(source, plan)


def ask_in_turn(workers: Sequence[Worker], name: str, repeats: int) -> tuple[list[float], list[float]]:
    """Return the measurements of two workers; in every second turn the other one begins."""
    taken: tuple[list[float], list[float]] = ([], [])
    for worker in workers:
        worker.ask(name)  # warms up
    for turn in range(repeats):
        for which in (0, 1) if turn % 2 == 0 else (1, 0):
            taken[which].append(workers[which].ask(name))
    return taken


def print_ratio(name: str, new: list[float], old: list[float], unit: str) -> None:
    """Print one line of the table."""
    low, middle, high = quartiles(ratios(old, new))
    values = f"{median(new):,.1f} against {median(old):,.1f} {unit}"
    print(f"  {name:42} {middle:5.2f} ({low:.2f} to {high:.2f})  {values}", flush=True)


def print_first_runs(source: Path, plan: Plan) -> None:
    """Print the ratios of the CPU times of runs with an empty cache."""
    for name, command in (("first run", RUN), ("first run with walls, collisions", BEYOND_RUN)):
        taken: list[list[float]] = [[], []]
        for _ in range(plan.processes):
            for values, path in zip(taken, (OURS, source), strict=True):
                with tempfile.TemporaryDirectory() as folder:
                    paths = os.pathsep.join(_paths(path))
                    environment = {"FEASIBEE_CACHE": folder, "PYTHONPATH": paths}
                    values.append(command_cpu_seconds(command, environment))
        print_ratio(name, *taken, "s")


def print_memory(source: Path, plan: Plan) -> None:
    """Print the ratio of the memory of each robot of a large swarm."""
    robots, each = plan.memory_robots, []
    for path in (OURS, source):
        environment = {"PYTHONPATH": os.pathsep.join(_paths(path))}
        small, large = (
            peak_mebibytes(playing(tables, 5), environment) for tables in (paper(), world(robots, robots))
        )
        each.append([(large - small) * 2**20 / robots])
    print_ratio(f"memory of each of {robots:,} robots", *each, "bytes")


def answer(plan: Plan) -> None:
    """Measure what each line of the input names; warm it up the first time."""
    samples, warmed = workloads(plan), set()
    for line in sys.stdin:
        sample = samples[line.strip()]
        if line not in warmed:
            sample.warm()
            warmed.add(line)
        print(sample.take(), flush=True)


if __name__ == "__main__":
    answer(QUICK if "--quick" in sys.argv else Plan())
