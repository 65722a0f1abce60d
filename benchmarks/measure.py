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

NS_PER_ROBOT_STEP = "ns/robot-step"

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
class Row:
    """A row of the benchmark's table."""

    name: str
    unit: str
    best: float
    median: float
    ratio: float | None = None
    ratio_to: str = ""
    target: float | None = None  # million robot-steps per second

    @classmethod
    def of(cls, name: str, unit: str, values: list[float]) -> Row:
        """Return the row of repeated measurements; the smallest is the best."""
        return cls(name, unit, min(values), statistics.median(values))

    @property
    def robot_steps_per_second(self) -> float | None:
        """Robot-steps per second of the best measurement, if the unit is a time per robot-step."""
        return 1e9 / self.best if self.unit == NS_PER_ROBOT_STEP else None

    def against(self, other: Row, label: str) -> Row:
        """Return this row with the ratio of its best value to that of another row."""
        return replace(self, ratio=self.best / other.best, ratio_to=label)

    def aiming(self, target: float | None) -> Row:
        """Return this row with a target speed."""
        return replace(self, target=target)


def speed(name: str, work: Callable[[], object], robot_steps: int, repeats: int) -> Row:
    """Measure the CPU time per robot-step of some work in this process."""
    work()  # loads and compiles, which isn't measured here
    return Row.of(name, NS_PER_ROBOT_STEP, [cpu_seconds(work) / robot_steps * 1e9 for _ in range(repeats)])


def cpu_seconds(work: Callable[[], object]) -> float:
    """Measure the CPU time of one call, summed over all threads of this process."""
    start = time.process_time()
    work()
    return time.process_time() - start


def command_cpu_seconds(arguments: list[str], environment: Mapping[str, str] | None = None) -> float:
    """Measure the CPU time of ``python ARGUMENTS``, start of the interpreter included."""
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    run_python(arguments, environment)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return end.ru_utime - start.ru_utime + end.ru_stime - start.ru_stime


def peak_mebibytes(code: str) -> float:
    """Measure the peak memory of a new Python process that runs some code, in MiB."""
    return int(run_python(["-c", code + REPORT_PEAK]).split()[-1]) / 1024


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
