"""Figures of a sweep: a share against a field, in lines or as a heat map over two fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from feasibee.errors import FeasibeeError, UnknownFieldError
from feasibee.figures.style import figure, spaced_by_ratio
from feasibee.sweeps.table import SOURCE, Summary, share

SHOWN = ("accuracy", "feasible", "infeasible", "undecided")
MARKERS = "os^vDP<>Xhpd"


def draw_lines(points: Sequence[Summary], x: str, hue: str | None, show: str) -> Figure:
    """Draw a share of the runs against a field, a line for each value of another, with 95 % bands."""
    lines: dict[Any, dict[Any, list[Summary]]] = {}
    for each in points:
        line = _value(each, hue) if hue else ""
        lines.setdefault(line, {}).setdefault(_value(each, x), []).append(each)
    numeric = all(isinstance(value, int | float) for line in lines.values() for value in line)
    colours = colormaps["viridis"](np.linspace(0, 0.88, len(lines)))
    with figure(4.8, 3.0) as (drawn, ax):
        for number, (name, line) in enumerate(lines.items()):
            values = sorted(line) if numeric else list(line)
            middle, low, high = 100 * np.array([_share(line[value], show) for value in values]).T
            marker = MARKERS[number % len(MARKERS)]
            ax.plot(
                values,
                middle,
                color=colours[number],
                marker=marker,
                markersize=4,
                linewidth=1.2,
                label=str(name),
            )
            ax.fill_between(values, low, high, color=colours[number], alpha=0.18, linewidth=0)
        if numeric and _spans_decades([value for line in lines.values() for value in line]):
            spaced_by_ratio(ax)
        ax.set(xlabel=x, ylabel=_label(show), ylim=(-2, 102))
        if hue:
            ax.legend(title=hue, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return drawn


def draw_map(points: Sequence[Summary], x: str, y: str, show: str) -> Figure:
    """Draw a share of the runs over two fields."""
    cells: dict[tuple[Any, Any], list[Summary]] = {}
    for each in points:
        cells.setdefault((_value(each, x), _value(each, y)), []).append(each)
    columns, rows = (_in_order([cell[axis] for cell in cells]) for axis in (0, 1))
    shares = np.full((len(rows), len(columns)), np.nan)
    for (column, row), group in cells.items():
        shares[rows.index(row), columns.index(column)] = 100 * _share(group, show)[0]
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
        drawn.colorbar(image, ax=ax, label=_label(show))
    return drawn


def _value(point: Summary, path: str) -> Any:
    """Return what a point has in a field, whether the study varies it or not."""
    if path == SOURCE:
        return point.row.source or "built in"
    try:
        value = point.row.scenario.get(path)
    except UnknownFieldError:
        raise FeasibeeError(f"{path}: isn't a field of the scenarios; such as tasks.count") from None
    return value if isinstance(value, int | float | str) else str(value)


def _share(group: Sequence[Summary], show: str) -> tuple[float, float, float]:
    if not any(each.runs for each in group):
        return (np.nan, np.nan, np.nan)
    hits = sum(each.right if show == "accuracy" else each.counts[show] for each in group)
    return share(group, hits)


def _label(show: str) -> str:
    return "right decisions (%)" if show == "accuracy" else f"runs that decide {show} (%)"


def _spans_decades(values: Sequence[float]) -> bool:
    return min(values) > 0 and max(values) / min(values) >= 20


def _in_order(values: Sequence[Any]) -> list[Any]:
    """Return each value once: numbers from small to large, words as they come."""
    once = list(dict.fromkeys(values))
    return once if any(isinstance(value, str) for value in once) else sorted(once)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
