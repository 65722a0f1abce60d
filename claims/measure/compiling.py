"""CPU time of compiling a user's strategy: docs/install.md."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

STRATEGY = "def decide(mind, inbox):\n    return int(inbox.feasible_votes > inbox.infeasible_votes)\n"


def main() -> None:
    """Print how many seconds of CPU time a run takes more for the first time than again, as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        mine = Path(folder, "mine.py")
        mine.write_text(STRATEGY, "utf-8")
        first, again = (run_seconds(folder, mine) for _ in range(2))
    print(json.dumps({"own": first - again}))


def run_seconds(cache: str, strategy: Path) -> float:
    """Return the CPU time of a run of a strategy, with a folder for compiled code."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    options = ["--runs", "10", "--set", f"decision.strategy={strategy}"]
    command = [sys.executable, "-m", "feasibee", "run", *options]
    environment = {**os.environ, "FEASIBEE_CACHE": cache}
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


if __name__ == "__main__":
    main()
