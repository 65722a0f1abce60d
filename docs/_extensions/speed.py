"""Draw the figure of docs/speed.md from the stored benchmarks of the latest release."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from feasibee.figures.style import figure, save_figure, text_colour

ROOT = Path(__file__).parent.parent.parent
TICKS = (20, 100, 1000, 10_000, 100_000, 1_000_000)


class Look(NamedTuple):
    """How a program is drawn, and where its label stands."""

    table: str
    row: str
    label: str
    colour: str
    marker: str
    dashes: Any
    place: tuple[float, float]
    """Offset of the label from the last point, in points; to the left of it unless positive."""


LOOKS = (
    Look("Other programs", "Mesa", "Mesa", "#009E73", "^", "-", (9, -3)),
    Look("Other programs", "brute-force", "all pairs, a loop in numba", "#D55E00", "s", "-", (9, -3)),
    Look("Growth", "", "feasibee, one thread", "#0072B2", "o", "-", (0, 9)),
    Look("Threads", "2 threads", "two threads, wall time", "#CC79A7", "D", "--", (0, -30)),
)
"""The programs: the beginning of the table's title, and part of the names of its rows."""
LARGE = 10_000
"""Smallest swarm whose time on two threads is drawn."""


def stored() -> dict[str, Any]:
    """Return the stored benchmarks of the latest release."""
    command = [sys.executable, str(ROOT / "benchmarks" / "history.py")]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    tables: dict[str, Any] = json.loads(done.stdout)
    return tables


def draw_cost(tables: dict[str, Any]) -> Figure:
    """Draw the cost of a robot-step against the number of robots, for each program."""
    with figure(6.2, 3.6) as (drawn, ax):
        for look in LOOKS:
            _draw(ax, look, _points(tables, look))
        ax.set(xscale="log", yscale="log", xlim=(15, 2.2e6))
        ax.set(xlabel="robots, with one task each", ylabel="CPU time of a robot-step (ns)")
        ax.xaxis.set_major_locator(FixedLocator(TICKS))
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
            axis.set_minor_formatter(NullFormatter())
        ax.grid(axis="y", linewidth=0.5, alpha=0.3)
    return drawn


def _points(tables: dict[str, Any], look: Look) -> list[tuple[int, float]]:
    """Return the number of robots and the median cost of the rows of a program.

    That on two threads is the cost on one, divided by the ratio of wall times, which were measured in turn.
    """
    rows = [row for row in _rows(tables, look.table) if look.row in row["name"]]
    if look.table != "Threads":
        return [(row["robots"], row["median"]) for row in rows]
    one = {row["robots"]: row["median"] for row in _rows(tables, "Growth")}
    return [(n, one[n] / row["ratio"]) for row in rows if (n := row["robots"]) >= LARGE and n in one]


def _rows(tables: dict[str, Any], start: str) -> list[dict[str, Any]]:
    """Return the rows of the table whose title starts so."""
    return next(rows for title, rows in tables["cases"].items() if title.startswith(start))


def _draw(ax: Axes, look: Look, points: list[tuple[int, float]]) -> None:
    """Draw one program with its label at the last point."""
    if not points:
        return
    line = {"color": look.colour, "linestyle": look.dashes, "marker": look.marker}
    ax.plot(*zip(*points, strict=True), linewidth=1.6, markersize=4, **line)
    text = {"color": text_colour(look.colour), "fontsize": 8, "ha": "right" if look.place[0] <= 0 else "left"}
    ax.annotate(look.label, points[-1], look.place, textcoords="offset points", **text)


def draw(app: Any) -> None:
    """Write the figure before any page is read."""
    path = Path(app.srcdir) / "made" / "speed" / "cost.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    save_figure(draw_cost(stored()), path)


def setup(app: Any) -> dict[str, bool]:
    """Register the drawing."""
    app.connect("builder-inited", draw)
    return {"parallel_read_safe": True}
