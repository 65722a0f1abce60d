"""Figures of a sweep: a measure against a field, as lines or as heat maps over two fields, in panels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from feasibee.figures.labels import label_ends
from feasibee.figures.style import (
    PERCENT,
    Look,
    along,
    as_text,
    fill_band,
    looks,
    name_of_axis,
    small_multiples,
    with_formulas,
)
from feasibee.results.measures import MEASURES
from feasibee.results.statistics import Interval

ROW: Final = 3
"""Most panels side by side."""
NO_UNITS: Final[Mapping[str, str]] = MappingProxyType({})
Line = Mapping[Any, Interval]
"""A measure by value of the field along the horizontal axis."""
Panels = Mapping[Any, Mapping[Any, Line]]


class Shown(NamedTuple):
    """What a figure of a sweep shows, its size and its texts; by default it chooses size and texts itself."""

    x: str
    """Field along the horizontal axis."""
    show: str
    """Name of the measure."""
    hue: str | None = None
    """Field with one line per value."""
    y: str | None = None
    """Field along the vertical axis of a heat map."""
    facet: str | None = None
    """Field with one panel per value."""
    journal: bool = False
    """Whether it has the style of a journal, with symbols at the axes."""
    width: float | None = None
    height: float | None = None
    """Inches."""
    title: str = ""
    xlabel: str = ""
    ylabel: str = ""

    @property
    def axes(self) -> list[str]:
        """The fields that it shows, that of the horizontal axis first."""
        return [field for field in (self.x, self.hue, self.y, self.facet) if field]

    @property
    def scale(self) -> float:
        """By what the measure is multiplied."""
        return 100.0 if MEASURES[self.show].unit == "%" else 1.0


def draw_lines(
    panels: Panels, shown: Shown, over: Sequence[str] = (), units: Mapping[str, str] = NO_UNITS
) -> Figure:
    """Draw a measure against a field, one line per value of another field, with 95 % bands.

    The best lines and the first are in colour. The x axis is logarithmic if its values span a decade or so.

    Parameters
    ----------
    panels : mapping
        By value of the panel, of ``hue``, then of ``x``: the measure, shares from 0 to 1.
    shown : Shown
        What the figure shows.
    over : sequence of str
        Names of other fields, over whose values the measure is averaged.
    units : mapping of str to str, optional
        Units of fields, by path; by default those of scenarios.
    """
    known = [(_text(name), line) for lines in panels.values() for name, line in lines.items()]
    parts = [(name, _mean(line, shown.show)) for name, line in known]
    means = {name: float(np.mean([mean for other, mean in parts if other == name])) for name, _ in parts}
    found, positions = looks(means), [value for _, line in known for value in line]
    part = 0.7 if len(panels) > 1 else 1.0
    size = part * (5.6 if shown.hue else 4.8), part * 3.0
    with _panels(panels, size, shown, over, units) as (drawn, axes, names):
        ends = [_draw(ax, lines, found, shown) for ax, lines in zip(axes, panels.values(), strict=True)]
        for ax in axes:
            along(ax, ax.get_xlabel(), positions)
            ax.set(ylim=PERCENT if shown.scale > 1 else (0, None))
        if shown.hue:
            last = _columns(len(axes)) - 1
            label_ends(axes[last], ends[last], found, means, title=names[shown.hue])
        return drawn


def _draw(
    ax: Any, lines: Mapping[Any, Line], found: Mapping[str, Look], shown: Shown
) -> dict[str, tuple[float, float]]:
    """Draw the lines of a panel; return the end of each."""
    ends = {}
    for name, line in lines.items():
        look = found[_text(name)]
        values = sorted(line) if all(isinstance(value, int | float) for value in line) else list(line)
        middle, low, high = shown.scale * np.array([line[value] for value in values]).T
        ax.plot(values, middle, marker=look.marker, markersize=4, **look.line)
        if look.highlighted:
            fill_band(ax, values, low, high, look.colour)
        if (known := np.flatnonzero(np.isfinite(middle))).size:
            ends[_text(name)] = (float(ax.xaxis.convert_units(values[known[-1]])), float(middle[known[-1]]))
    _say_never(ax, lines, shown.show)
    return ends


def _columns(count: int) -> int:
    """Return how many of some panels stand side by side: in as few rows as possible, filled alike."""
    return -(-count // -(-count // ROW))


@contextmanager
def _panels(
    panels: Panels, size: tuple[float, float], shown: Shown, over: Sequence[str], units: Mapping[str, str]
) -> Iterator[tuple[Figure, list[Axes], dict[str, str]]]:
    """Yield a figure with its texts, an axes of a size for each panel, and names of the fields."""
    names = {path: name_of_axis(path, shown.journal, units.get(path)) for path in shown.axes}
    ylabel = with_formulas(shown.ylabel) or (names[shown.y] if shown.y else _label(shown.show))
    columns, column = _columns(len(panels)), (shown.width or 0.0) if shown.journal else 0.0
    shape, xlabel = (columns * size[0], 0.0, size[1]), with_formulas(shown.xlabel) or names[shown.x]
    with small_multiples(len(panels), columns, shape, xlabel, ylabel, column) as (drawn, axes):
        inches = drawn.get_size_inches()
        drawn.set_size_inches(shown.width or inches[0], shown.height or inches[1])
        if shown.facet:
            for ax, value in zip(axes, panels, strict=True):
                ax.set_title(f"{names[shown.facet]} = {as_text(_text(value))}")
        averaged = ", ".join(name_of_axis(path, unit="") for path in over)
        heading = [with_formulas(shown.title), f"averaged over {averaged}" if over else ""]
        if any(heading):
            drawn.suptitle("\n".join(filter(None, heading)), fontsize="medium")
        yield drawn, axes, names


def _mean(line: Line, show: str) -> float:
    """Return the mean of a line, negative if less is better; minus infinity if some value is unknown."""
    mean = float(np.mean([each.estimate for each in line.values()]))
    if np.isnan(mean):
        return -np.inf
    return -mean if MEASURES[show].less else mean


def _label(show: str) -> str:
    measure = MEASURES[show]
    return f"{measure.label}:\n{measure.ends}" if measure.ends else measure.label


def _say_never(ax: Axes, lines: Mapping[Any, Line], show: str) -> None:
    """Write at the top of the axes which lines have no value at all, if a delay is shown."""
    never = [
        as_text(_text(name))
        for name, line in lines.items()
        if all(np.isnan(each.estimate) for each in line.values())
    ]
    if never and MEASURES[show].ends:
        text = f"half of the changes never followed: {', '.join(never)}" if any(never) else "never"
        ax.text(0.01, 0.98, text, transform=ax.transAxes, va="top", fontsize=7.5, color="0.35")


def draw_maps(
    panels: Panels, shown: Shown, over: Sequence[str] = (), units: Mapping[str, str] = NO_UNITS
) -> Figure:
    """Draw a measure over two fields as `draw_lines` draws it, with values of ``y`` in place of lines."""
    columns = _in_order([value for cells in panels.values() for line in cells.values() for value in line])
    rows = _in_order([value for cells in panels.values() for value in cells])
    shares = np.full((len(panels), len(rows), len(columns)), np.nan)
    for place, cells in enumerate(panels.values()):
        for row, line in cells.items():
            for column, interval in line.items():
                shares[place, rows.index(row), columns.index(column)] = shown.scale * interval.estimate
    top = 100.0 if shown.scale > 1 else max(1e-9, float(np.nanmax(shares, initial=0)))
    size = (1.8 + 0.42 * len(columns), 1.2 + 0.32 * len(rows))
    with _panels(panels, size, shown, over, units) as (drawn, axes, _):
        for ax, known in zip(axes, shares, strict=True):
            image = ax.imshow(known, origin="lower", aspect="auto", vmin=0, vmax=top, cmap="cividis")
            for row, column in np.argwhere(np.isfinite(known)):
                share = known[row, column]
                colour = "white" if share < 0.55 * top else "black"
                text = f"{share:.0f}" if top >= 10 else f"{share:.2g}"
                ax.text(column, row, text, ha="center", va="center", fontsize=7, color=colour)
            ax.set_xticks(range(len(columns)), [as_text(_text(value)) for value in columns])
            ax.set_yticks(range(len(rows)), [as_text(_text(value)) for value in rows])
            ax.spines[:].set_visible(False)
        drawn.colorbar(image, ax=axes, label=_label(shown.show))
    return drawn


def _in_order(values: Sequence[Any]) -> list[Any]:
    """Return each value once: numbers in ascending order, words in the given order."""
    once = list(dict.fromkeys(values))
    return once if any(isinstance(value, str) for value in once) else sorted(once)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
