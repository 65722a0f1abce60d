"""Damage journals at random, and test whether an export differs without an error: docs/studies.md."""

from __future__ import annotations

import json
import random
import shutil
import sqlite3
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from click.testing import CliRunner, Result

from feasibee.cli import main as feasibee
from feasibee.sweeps import executors, schedule
from feasibee.sweeps.plan import Study
from feasibee.sweeps.schema import NAME, SEAL
from feasibee.sweeps.sweep import Progress, sweep

TIMES = 1000
OWN = """
def decide(mind, inbox):
    return inbox.heard_opinion
"""
STUDY = """
runs = 24
seed = 5
curves = true
[scenario]
arena.side = 6.0
robots.count = 5
run.steps = 40
[sweep]
"tasks.count" = [2, 5, 9]
"decision.strategy" = ["dmmd", "voter", "own.py"]
"""
RUNS = 9 * 24
LOG = f"{NAME}-wal"
KINDS = ("closed", "open", "halfway")
"""Kinds of journals: closed, copied while open (much of it in its log), with part of its log in the file."""


def keep_journals(folder: Path) -> None:
    """Sweep a study into a journal of each kind, in chunks of three runs."""
    (folder / "own.py").write_text(OWN, encoding="utf-8")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    before = schedule.CHUNK_WORK, schedule.CHUNK_SECONDS
    schedule.CHUNK_WORK, schedule.CHUNK_SECONDS = 600, 1e9
    try:
        for kind, midway in (("open", -1), ("halfway", 120)):
            shutil.rmtree(folder / "closed", ignore_errors=True)
            plan = Study.read(folder / "study.toml")
            sweep(plan, folder / "closed", executors.threads(1), progress=_copying(folder, kind, midway))
    finally:
        schedule.CHUNK_WORK, schedule.CHUNK_SECONDS = before


def _copying(folder: Path, kind: str, midway: int) -> Callable[[Progress], None]:
    def tell(progress: Progress) -> None:
        if progress.runs_new == midway:
            with closing(sqlite3.connect(folder / "closed" / NAME)) as other:
                other.execute("PRAGMA wal_checkpoint(PASSIVE)")
        if progress.runs_done == progress.runs:
            (folder / kind).mkdir()
            for name in (NAME, LOG, SEAL):
                shutil.copy(folder / "closed" / name, folder / kind / name)

    return tell


def copied(kept: Path, kind: str, to: Path) -> Path:
    """Replace a folder by a copy of a journal."""
    shutil.rmtree(to, ignore_errors=True)
    return Path(shutil.copytree(kept / kind, to))


def damage(folder: Path, chance: random.Random) -> None:
    """Flip a bit of a journal's file or log, truncate it, zero a page of it, or delete its log."""
    path = chance.choice([path for path in sorted(folder.iterdir()) if path.name in (NAME, LOG)])
    if chance.random() < 0.05:
        path = folder / SEAL
    data = bytearray(path.read_bytes())
    how = chance.choices(["flip", "header", "cut", "zero", "lose"], [5, 2, 2, 2, 1])[0]
    if how == "flip":
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    elif how == "header":  # of a page: the positions of its rows
        place = chance.randrange(0, len(data), 4096) + chance.randrange(24)
        data[min(place, len(data) - 1)] ^= 1 << chance.randrange(8)
    elif how == "cut":
        del data[chance.randrange(len(data)) :]
    elif how == "zero":
        size = chance.choice([512, 4096])
        start = chance.randrange(0, len(data), size)
        data[start : start + size] = bytes(len(data[start : start + size]))
    elif path.name == LOG:
        path.unlink()
        return
    path.write_bytes(bytes(data))


def invoke(*arguments: object) -> Result:
    """Run a command; raise any exception that it doesn't report itself."""
    result = CliRunner().invoke(feasibee, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def export(folder: Path) -> bytes | None:
    """Return the table of a journal; None if the command ended with a one-line error."""
    table = folder / "table.csv"
    result = invoke("results", "export", folder, "--out", table)
    if result.exit_code == 0:
        return table.read_bytes()
    if result.exit_code != 2 or len(result.stderr.splitlines()) != 1 or table.exists():
        raise AssertionError(result.output)
    return None


def try_damages(
    kept: Path, folder: Path, times: int, seed: int, each: Callable[[Path, bool], None]
) -> Counter[str]:
    """Damage journals repeatedly; count the exports that are the same, an error, or another.

    ``each`` gets the damaged journal, and whether its export was an error.
    """
    chance, found = random.Random(seed), Counter[str]()
    whole = export(copied(kept, "closed", folder))
    for _ in range(times):
        damage(copied(kept, chance.choice(KINDS), folder), chance)
        told = export(folder)
        found["same" if told == whole else "another" if told else "refused"] += 1
        each(folder, told is None)
    return found


def main() -> None:
    """Print the number of exports that were the same, an error, or another."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        keep_journals(folder)
        found = try_damages(folder, folder / "out", TIMES, 1, lambda folder, refused: None)
    print(json.dumps({"times": TIMES, **{key: found[key] for key in ("same", "refused", "another")}}))


if __name__ == "__main__":
    sys.exit(main())
