"""Measure CPU time and memory, and describe the machine."""

from __future__ import annotations

import os
import platform
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

NS_PER_ROBOT_STEP = "ns/robot-step"
NS_OF_WALL = "ns of wall time"

REPORT_PEAK = """
import pathlib, re, resource, sys
status = pathlib.Path("/proc/self/status")
if status.exists():
    print(re.search(r"VmHWM:\\s*(\\d+)", status.read_text())[1])
else:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(peak // 1024 if sys.platform == "darwin" else peak)
"""
"""Code that prints the peak memory of its process, in KiB.

On Linux it reads VmHWM, because ru_maxrss starts at the size of the parent process.
"""


@dataclass(frozen=True)
class Goal:
    """A bound on one figure of a row."""

    figure: str  # "ratio", "best", or "speed" in million robot-steps per second
    limit: float
    least: bool

    def __str__(self) -> str:
        """Return the bound as text."""
        unit = " M" if self.figure == "speed" else ""
        return f"{'≥' if self.least else '≤'} {self.limit:,g}{unit}"


@dataclass(frozen=True)
class Row:
    """A row of the benchmark's table."""

    name: str
    unit: str
    best: float
    median: float
    ratio: float | None = None
    low: float | None = None  # quartiles of the ratio
    high: float | None = None
    ratio_to: str = ""
    robots: int | None = None
    goal: Goal | None = None

    @classmethod
    def of(cls, name: str, unit: str, values: list[float], robots: int | None = None) -> Row:
        """Return the row of repeated measurements; the smallest is the best."""
        return cls(name, unit, min(values), statistics.median(values), robots=robots)

    @property
    def robot_steps_per_second(self) -> float | None:
        """Robot-steps per second of the best measurement, if the unit is a time per robot-step."""
        return 1e9 / self.best if self.unit in (NS_PER_ROBOT_STEP, NS_OF_WALL) else None

    def compared(self, ratios: list[float], label: str) -> Row:
        """Return this row with the median and the quartiles of ratios, each of two neighbours in time."""
        low, median, high = quartiles(ratios)
        return replace(self, ratio=median, low=low, high=high, ratio_to=label)

    def aiming(self, figure: str, *, least: float | None = None, most: float | None = None) -> Row:
        """Return this row with a bound on its ratio, its best value or its speed."""
        limit = least if least is not None else most
        return replace(self, goal=Goal(figure, limit, least is not None) if limit is not None else None)

    @property
    def meets(self) -> bool | None:
        """Whether the row is within its bound; None without one."""
        if self.goal is None:
            return None
        speed = (self.robot_steps_per_second or 0.0) / 1e6
        value = {"ratio": self.ratio, "best": self.best, "speed": speed}[self.goal.figure]
        assert value is not None, self.name
        return value >= self.goal.limit if self.goal.least else value <= self.goal.limit


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """Return the quartiles of some values, or of one."""
    if len(values) == 1:
        return values[0], values[0], values[0]
    low, median, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, median, high


class Sample(NamedTuple):
    """Something to measure: what loads it, and what returns one measurement."""

    warm: Callable[[], object]
    take: Callable[[], float]


def in_turn(samples: Mapping[str, Sample], repeats: int) -> dict[str, list[float]]:
    """Measure several things in turn, so that a change of the machine's speed changes all of them."""
    for sample in samples.values():
        sample.warm()
    taken: dict[str, list[float]] = {name: [] for name in samples}
    for _ in range(repeats):
        for name, sample in samples.items():
            taken[name].append(sample.take())
    return taken


def ratios(values: list[float], others: list[float]) -> list[float]:
    """Return the ratio of each measurement to the other of its turn."""
    return [value / other for value, other in zip(values, others, strict=True)]


def seconds(work: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Measure the time of one call, by default the CPU time of all threads of this process."""
    start = clock()
    work()
    return clock() - start


def command_cpu_seconds(arguments: list[str], environment: Mapping[str, str] | None = None) -> float:
    """Measure the CPU time of ``python ARGUMENTS``, start of the interpreter included."""
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    run_python(arguments, environment)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return end.ru_utime - start.ru_utime + end.ru_stime - start.ru_stime


def peak_mebibytes(code: str, environment: Mapping[str, str] | None = None) -> float:
    """Measure the peak memory of a new Python process that runs some code, in MiB."""
    return int(run_python(["-c", code + REPORT_PEAK], environment).split()[-1]) / 1024


def run_python(arguments: list[str], environment: Mapping[str, str] | None = None) -> str:
    """Run Python in a new process and return its output."""
    command = [sys.executable, *arguments]
    environment = {**os.environ, **(environment or {})}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}\nfailed with status {done.returncode}:\n{done.stderr}")
    return done.stdout


def machine() -> dict[str, str]:
    """Return date, processor, system and versions of the measurements."""
    return {
        "date": date.today().isoformat(),
        "load": f"{os.getloadavg()[0]:.1f} processes in the minute before, {os.cpu_count()} cores",
        "processor": f"{processor_name()}, {os.cpu_count()} cores",
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: package_version(name) for name in ("numba", "numpy", "mesa", "feasibee")},
    }


def processor_name() -> str:
    """Return the model of the processor, or \"unknown\"."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


def package_version(name: str) -> str:
    """Return the version of an installed package."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
