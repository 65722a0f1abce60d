"""CPU time of compiling the fast path and the general engine, and the size of the code: docs/install.md."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

PAPER: list[str] = []
WALLS = ["--set", "arena.boundary=walls"]


def main() -> None:
    """Print seconds of CPU time, and kilobytes of code, as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        fast, general = (compile_seconds(folder, changes) for changes in (PAPER, WALLS))
        kilobytes = sum(path.stat().st_size for path in Path(folder).rglob("*.nbc")) / 1000
    measured = {"fast": fast, "general": general, "kilobytes": kilobytes}
    print(json.dumps({**measured, "date": date.today().isoformat()}))


def compile_seconds(cache: str, changes: list[str]) -> float:
    """Return how much more CPU time a command takes for the first time than again."""
    first, again = (run_seconds(cache, changes) for _ in range(2))
    return first - again


def run_seconds(cache: str, changes: list[str]) -> float:
    """Return the CPU time of a run with compiled code in a folder."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "feasibee", "run", "--runs", "10", *changes]
    environment = {**os.environ, "FEASIBEE_CACHE": cache}
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


if __name__ == "__main__":
    main()
