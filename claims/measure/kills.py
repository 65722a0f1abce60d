"""Kill a sweep at random moments, resume it with the same command, compare the rows: docs/studies.md."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

MOMENTS = 10
LONGEST = 4.0
STUDY = """
runs = 200
seed = 1

[sweep]
"tasks.count" = [5, 10, 20]
"decision.strategy" = ["dmmd", "dmvd", "census"]
"""


def main() -> None:
    """Print the number of killed sweeps whose rows equal those of an uninterrupted sweep."""
    random.seed(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "study.toml").write_text(STUDY, encoding="utf-8")
        whole = rows(folder, "whole")
        equal = sum(killed_and_resumed(folder, f"killed{k}") == whole for k in range(MOMENTS))
    print(json.dumps({"moments": MOMENTS, "equal": equal}))


def killed_and_resumed(folder: Path, out: str) -> bytes:
    """Return the rows of a sweep that was killed, unless it ended before, and resumed."""
    with subprocess.Popen(
        command("sweep", "study.toml", "--out", out), cwd=folder, stderr=subprocess.DEVNULL
    ) as run:
        try:
            run.wait(random.uniform(0, LONGEST))
        except subprocess.TimeoutExpired:
            run.send_signal(signal.SIGKILL)
    return rows(folder, out)


def rows(folder: Path, out: str) -> bytes:
    """Compute the missing runs of a sweep, and return all rows as CSV."""
    for arguments in (
        ("sweep", "study.toml", "--out", out),
        ("results", "export", out, "--out", f"{out}.csv"),
    ):
        subprocess.run(command(*arguments), cwd=folder, check=True, capture_output=True)
    return (folder / f"{out}.csv").read_bytes()


def command(*arguments: str) -> list[str]:
    """Return the command line of feasibee."""
    return [sys.executable, "-m", "feasibee", *arguments]


if __name__ == "__main__":
    main()
