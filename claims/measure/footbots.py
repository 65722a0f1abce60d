"""Run the plan of argos.py in ARGoS3 and write argos.csv: docs/argos.md.

    python -m claims.measure.footbots examples/argos runs --jobs 2

The first folder has the built example, and argos3 is in PATH. The second keeps every run. Started again, it
continues where it was ended, and it writes argos.csv after each block. Worlds that
are named take turns in blocks.
"""

from __future__ import annotations

import argparse
import csv
import runpy
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

from claims.measure.argos import BLOCK, FIGURES, PLAN, WORLDS, Row, figures, first_seed, read

EXPORT = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "argos" / "export.py"))
DECISIONS = {"feasible": 1, "infeasible": 0, "undecided": -1}


def main() -> None:
    """Run world after world, and in each a block of each row after another, until all have their runs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("example", type=Path, help="examples/argos, after its build")
    parser.add_argument("kept", type=Path, help="folder in which runs are kept")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time; by default 1")
    parser.add_argument("--world", action="append", choices=WORLDS, help="a world to run; by default all")
    given = parser.parse_args()
    given.kept.mkdir(exist_ok=True)
    for worlds in [given.world] if given.world else [[world] for world in WORLDS]:
        rows = {row: runs for row, runs in PLAN.items() if row.world in worlds}
        for first, row in product(range(0, max(rows.values()), BLOCK), rows):
            block = given.kept / f"{'-'.join(map(str, row))}-{first:04}.csv"
            if not block.exists():
                run(row, first, given.example, block, given.jobs)
                write(given.kept)


def run(row: Row, first: int, example: Path, block: Path, jobs: int) -> None:
    """Run a block of a row in ARGoS, and keep it when it is complete."""
    with tempfile.TemporaryDirectory() as temporary:
        experiment, part = Path(temporary, "row.argos"), block.resolve().with_suffix(".part")
        experiment.write_text(EXPORT["argos_text"](row.scenario()), encoding="utf-8")
        options = {"runs": BLOCK, "seed": first_seed(row) + first, "jobs": jobs, "out": part}
        arguments = [text for name, value in options.items() for text in (f"--{name}", str(value))]
        subprocess.run([sys.executable, "runs.py", experiment, *arguments], cwd=example, check=True)
    part.replace(block)


def write(kept: Path) -> None:
    """Write the figures of all rows that have runs, here or in the file as it is."""
    found = {row: written(each) for row, each in read(FIGURES)}
    found |= {row: written(measured(row, kept)) for row in PLAN if blocks(row, kept)}
    rows = [{**row._asdict(), **found[row]} for row in PLAN if row in found]
    with FIGURES.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def blocks(row: Row, kept: Path) -> list[Path]:
    """Return the complete blocks of a row."""
    return sorted(kept.glob(f"{'-'.join(map(str, row))}-????.csv"))


def written(found: dict[str, float]) -> dict[str, str]:
    """Return figures to six digits."""
    return {name: f"{value:.6g}" for name, value in found.items()}


def measured(row: Row, kept: Path) -> dict[str, float]:
    """Return the figures of a row; lengths are in units."""
    found = []
    for block in blocks(row, kept):
        with block.open(newline="", encoding="utf-8") as file:
            found += list(csv.DictReader(file))
    decision = np.array([DECISIONS[each["decision"]] for each in found])
    names = ("steps", "metres_per_step", "meetings_per_step", "robots_in_sight", "tasks_in_sight")
    steps, way, *sights = (np.array([float(each[name]) for each in found]) for name in names)
    return figures(decision, steps, steps, [way / EXPORT["FOOTBOT_DIAMETER"], *sights])


if __name__ == "__main__":
    main()
