"""Figures of a sweep: a share of the runs against a field, as lines or as a heat map over two fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from feasibee.figures.style import figure, spaced_by_ratio
from feasibee.results.statistics import Interval

MARKERS = "os^vDP<>Xhpd"
SHARES: Mapping[str, str] = {
    "accuracy": "right decisions",
    "right_at_end": "runs that are right at the end",
    "declared_ok": "runs that declared rightly",
    "declared_wrong": "runs with a robot that declared wrongly",
    "feasible": "runs that decide feasible",
    "infeasible": "runs that decide infeasible",
    "undecided": "runs that stay undecided",
}
"""What a share may be of, in words."""


def draw_lines(lines: Mapping[Any, Mapping[Any, Interval]], x: str, hue: str | None, show: str) -> Figure:
    """Draw a share of the runs against a field, one line per value of another field, with 95 % bands.

    Parameters
    ----------
    lines : mapping
        By value of ``hue``, then of ``x``: a share of the runs, 0 to 1.
    x : str
        Name of the field along the horizontal axis.
    hue : str or None
        Name of the field with one line per value; None for a single line.
    show : str
        What the share is of: a key of `SHARES`.
    """
    positions = [value for line in lines.values() for value in line]
    numeric = all(isinstance(value, int | float) for value in positions)
    colours = colormaps["viridis"](np.linspace(0, 0.88, len(lines)))
    with figure(4.8, 3.0) as (drawn, ax):
        for number, (name, line) in enumerate(lines.items()):
            values = sorted(line) if numeric else list(line)
            middle, low, high = 100 * np.array([line[value] for value in values]).T
            look: dict[str, Any] = {"color": colours[number], "marker": MARKERS[number % len(MARKERS)]}
            ax.plot(values, middle, **look, markersize=4, linewidth=1.2, label=str(name))
            ax.fill_between(values, low, high, color=colours[number], alpha=0.18, linewidth=0)
        if numeric and _spans_decades(positions):
            spaced_by_ratio(ax)
        ax.set(xlabel=x, ylabel=f"{SHARES[show]} (%)", ylim=(-2, 102))
        if hue:
            ax.legend(title=hue, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return drawn


def draw_map(cells: Mapping[tuple[Any, Any], Interval], x: str, y: str, show: str) -> Figure:
    """Draw a share of the runs over two fields.

    Parameters
    ----------
    cells : mapping
        By value of ``x`` and value of ``y``: a share of the runs, 0 to 1.
    x, y : str
        Names of the fields along the axes.
    show : str
        What the share is of, as for `draw_lines`.
    """
    columns, rows = (_in_order([cell[axis] for cell in cells]) for axis in (0, 1))
    shares = np.full((len(rows), len(columns)), np.nan)
    for (column, row), interval in cells.items():
        shares[rows.index(row), columns.index(column)] = 100 * interval.estimate
    with figure(1.8 + 0.42 * len(columns), 1.2 + 0.32 * len(rows)) as (drawn, ax):
        image = ax.imshow(shares, origin="lower", aspect="auto", vmin=0, vmax=100, cmap="cividis")
        for row, column in np.argwhere(np.isfinite(shares)):
            share = shares[row, column]
            colour = "white" if share < 55 else "black"
            ax.text(column, row, f"{share:.0f}", ha="center", va="center", fontsize=7, color=colour)
        ax.set(xlabel=x, ylabel=y)
        ax.set_xticks(range(len(columns)), [_text(value) for value in columns])
        ax.set_yticks(range(len(rows)), [_text(value) for value in rows])
        ax.spines[:].set_visible(False)
        drawn.colorbar(image, ax=ax, label=f"{SHARES[show]} (%)")
    return drawn


def _spans_decades(values: Sequence[float]) -> bool:
    return min(values) > 0 and max(values) / min(values) >= 20


def _in_order(values: Sequence[Any]) -> list[Any]:
    """Return each value once: numbers in ascending order, words in the given order."""
    once = list(dict.fromkeys(values))
    return once if any(isinstance(value, str) for value in once) else sorted(once)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
