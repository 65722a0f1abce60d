"""The benchmarks of past releases, one JSON file each, and how today's compare with them.

``python benchmarks/history.py`` prints that of the latest release, where docs/speed.md has its numbers from.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from measure import NS_OF_WALL, NS_PER_ROBOT_STEP

FOLDER = Path(__file__).parent / "history"
YARDSTICK = "brute-force loop in numba"
"""Measured in every session. Times are compared in units of its time, so that the machine cancels out."""
NOTABLE = 0.1
"""Smaller changes are within what two sessions on one machine differ by."""


class Change(NamedTuple):
    """One row, today and in a release."""

    title: str
    name: str
    ratio: float
    """Today's figure divided by the release's: above 1 is slower, or larger."""


def save(tables: dict[str, Any], folder: Path = FOLDER) -> Path:
    """Write today's figures as those of the installed version; return the file."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{tables['machine']['feasibee']}.json"
    path.write_text(json.dumps(tables, indent=2) + "\n", encoding="utf-8")
    return path


def latest(folder: Path = FOLDER) -> Path | None:
    """Return the file of the highest version, if any."""
    return max(folder.glob("*.json"), key=_version, default=None)


def read(path: Path) -> dict[str, Any]:
    """Read the figures of a release."""
    tables: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return tables


def changes(today: dict[str, Any], then: dict[str, Any]) -> Iterator[Change]:
    """Yield every row that both sessions have, with the ratio of its best figures."""
    before = {(title, row["name"]): row for title, rows in then["cases"].items() for row in rows}
    scale = _yardstick(then) / _yardstick(today)
    for title, rows in today["cases"].items():
        for row in rows:
            old = before.get((title, row["name"]))
            if old and old["unit"] == row["unit"] and row["name"] != YARDSTICK:
                timed = row["unit"] in (NS_PER_ROBOT_STEP, NS_OF_WALL, "s")
                yield Change(title, row["name"], row["best"] / old["best"] * (scale if timed else 1.0))


def _yardstick(tables: dict[str, Any]) -> float:
    rows = [row for rows in tables["cases"].values() for row in rows if row["name"] == YARDSTICK]
    return float(rows[0]["best"])


def _version(path: Path) -> tuple[int, ...]:
    return tuple(int(part) for part in path.stem.split(".") if part.isdigit())


if __name__ == "__main__":
    newest = latest()
    if newest is None:
        raise SystemExit(f"{FOLDER}: has no file; run `make bench SAVE=1`")
    print(newest.read_text(encoding="utf-8"), end="")
