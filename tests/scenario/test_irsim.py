"""Lines of sight against the kept answers of IR-SIM (examples/irsim)."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "irsim"
pytest.importorskip("yaml")


def row(name):
    """Return a row of the table in README.md: the numbers of both places."""
    line = next(
        line for line in (FOLDER / "README.md").read_text().splitlines() if line.startswith(f"| {name}")
    )
    return dict(zip(("polygons", "hall"), map(int, re.findall(r"\| (\d+)", line)), strict=True))


@pytest.mark.quick(4)
def test_robots_see_what_irsim_says_but_for_the_pairs_that_the_page_counts(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pairs = runpy.run_path(str(FOLDER / "pairs.py"))
    kept = json.loads((FOLDER / "irsim.json").read_text())
    for name, _, world in pairs["worlds"]():
        theirs = f"{int(kept[name], 16):010000b}"
        ours = pairs["sights"](world)
        differ = [a + b for a, b in zip(theirs, "".join(ours), strict=True) if a != b]
        assert len(differ) == row("pairs that differ")[name]
        assert differ.count("10") == row("of these, visible in IR-SIM only")[name]
        assert theirs.count("1") == row("pairs visible in IR-SIM")[name]
