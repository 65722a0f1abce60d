"""Figures of a sweep: a measure against a field, as lines or as a heat map over two fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from feasibee.figures.labels import label_ends
from feasibee.figures.style import (
    PERCENT,
    along,
    figure,
    fill_band,
    looks,
    name_of_axis,
)
from feasibee.results.measures import MEASURES
from feasibee.results.statistics import Interval


def draw_lines(
    lines: Mapping[Any, Mapping[Any, Interval]],
    x: str,
    hue: str | None,
    show: str,
    over: Sequence[str] = (),
    journal: float = 0.0,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Figure:
    """Draw a measure against a field, one line per value of another field, with 95 % bands.

    The best lines and the first are in colour. The x axis is logarithmic if its values span a decade or so.

    Parameters
    ----------
    lines : mapping
        By value of ``hue``, then of ``x``: the measure, shares from 0 to 1.
    x, hue : str or None
        Names of the fields along the horizontal axis and with one line per value; no hue for a single line.
    show : str
        Name of the measure.
    over : sequence of str
        Names of other fields, over whose values the measure is averaged.
    journal : float
        Width in inches of a journal's column, for which the axes have symbols; 0 for none.
    units : mapping of str to str, optional
        Units of fields, by path; by default those of scenarios.
    """
    scale = 100.0 if MEASURES[show].unit == "%" else 1.0
    positions = [value for line in lines.values() for value in line]
    numeric = all(isinstance(value, int | float) for value in positions)
    means = {_text(name): _mean(line, show) for name, line in lines.items()}
    found, ends = looks(means), {}
    with figure(5.6 if hue else 4.8, 3.0, journal=journal) as (drawn, ax):
        for (name, look), line in zip(found.items(), lines.values(), strict=True):
            values = sorted(line) if numeric else list(line)
            middle, low, high = scale * np.array([line[value] for value in values]).T
            ax.plot(values, middle, marker=look.marker, markersize=4, **look.line)
            if look.highlighted:
                fill_band(ax, values, low, high, look.colour)
            if (known := np.flatnonzero(np.isfinite(middle))).size:
                ends[name] = (float(ax.convert_xunits(values[known[-1]])), float(middle[known[-1]]))
        along(ax, name_of_axis(x, journal, units.get(x)), positions)
        ax.set(ylabel=_label(show), ylim=PERCENT if scale > 1 else (0, None))
        _say_over(ax, over)
        _say_never(ax, lines, show)
        if hue:
            label_ends(ax, ends, found, means, title=name_of_axis(hue, journal, units.get(hue)))
        return drawn


def _mean(line: Mapping[Any, Interval], show: str) -> float:
    """Return the mean of a line, negative if less is better; minus infinity if some value is unknown."""
    mean = float(np.mean([each.estimate for each in line.values()]))
    if np.isnan(mean):
        return -np.inf
    return -mean if MEASURES[show].less else mean


def _say_over(ax: Axes, over: Sequence[str]) -> None:
    """Write above the axes over which fields a measure is averaged, if any."""
    names = ", ".join(name_of_axis(path, unit="") for path in over)
    ax.set_title(f"averaged over {names}" if over else "", loc="left", color="0.3")


def _label(show: str) -> str:
    measure = MEASURES[show]
    return f"{measure.label}:\n{measure.ends}" if measure.ends else measure.label


def _say_never(ax: Axes, lines: Mapping[Any, Mapping[Any, Interval]], show: str) -> None:
    """Write at the top of the axes which lines have no value at all, if a delay is shown."""
    never = [
        _text(name) for name, line in lines.items() if all(np.isnan(each.estimate) for each in line.values())
    ]
    if never and MEASURES[show].ends:
        text = f"half of the changes never followed: {', '.join(never)}" if any(never) else "never"
        ax.text(0.01, 0.98, text, transform=ax.transAxes, va="top", fontsize=7.5, color="0.35")


def draw_map(
    cells: Mapping[tuple[Any, Any], Interval],
    x: str,
    y: str,
    show: str,
    over: Sequence[str] = (),
    journal: float = 0.0,
    units: Mapping[str, str] = MappingProxyType({}),
) -> Figure:
    """Draw a measure over two fields.

    Parameters
    ----------
    cells : mapping
        By value of ``x`` and value of ``y``: the measure, shares from 0 to 1.
    x, y : str
        Names of the fields along the axes.
    show : str
        Name of the measure.
    over : sequence of str
        Names of other fields, over whose values the measure is averaged.
    journal : float
        Width in inches of a journal's column, for which the axes have symbols; 0 for none.
    units : mapping of str to str, optional
        Units of fields, by path; by default those of scenarios.
    """
    columns, rows = (_in_order([cell[axis] for cell in cells]) for axis in (0, 1))
    scale = 100.0 if MEASURES[show].unit == "%" else 1.0
    shares = np.full((len(rows), len(columns)), np.nan)
    for (column, row), interval in cells.items():
        shares[rows.index(row), columns.index(column)] = scale * interval.estimate
    top = 100.0 if scale > 1 else max(1e-9, float(np.nanmax(shares, initial=0)))
    with figure(1.8 + 0.42 * len(columns), 1.2 + 0.32 * len(rows), journal=journal) as (drawn, ax):
        image = ax.imshow(shares, origin="lower", aspect="auto", vmin=0, vmax=top, cmap="cividis")
        for row, column in np.argwhere(np.isfinite(shares)):
            share = shares[row, column]
            colour = "white" if share < 0.55 * top else "black"
            text = f"{share:.0f}" if top >= 10 else f"{share:.2g}"
            ax.text(column, row, text, ha="center", va="center", fontsize=7, color=colour)
        ax.set(xlabel=name_of_axis(x, journal, units.get(x)), ylabel=name_of_axis(y, journal, units.get(y)))
        ax.set_xticks(range(len(columns)), [_text(value) for value in columns])
        ax.set_yticks(range(len(rows)), [_text(value) for value in rows])
        ax.spines[:].set_visible(False)
        _say_over(ax, over)
        drawn.colorbar(image, ax=ax, label=_label(show))
    return drawn


def _in_order(values: Sequence[Any]) -> list[Any]:
    """Return each value once: numbers in ascending order, words in the given order."""
    once = list(dict.fromkeys(values))
    return once if any(isinstance(value, str) for value in once) else sorted(once)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
