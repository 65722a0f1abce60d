"""CPU time of compiling a user's strategy and the general engine, and the size of that: docs/install.md."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

STRATEGY = "def decide(mind, inbox):\n    return int(inbox.feasible_votes > inbox.infeasible_votes)\n"
WALLS = ["--set", "arena.boundary=walls"]


def main() -> None:
    """Print seconds of CPU time, and kilobytes of code, as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        mine = Path(folder, "mine.py")
        mine.write_text(STRATEGY, "utf-8")
        choice = ["--set", f"decision.strategy={mine}"]
        own, general = (compile_seconds(folder, changes) for changes in (choice, WALLS))
        kilobytes = sum(path.stat().st_size for path in Path(folder).rglob("*.nbc")) / 1000
    measured = {"own": own, "general": general, "kilobytes": kilobytes}
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
