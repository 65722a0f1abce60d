"""Figures of a sweep: a measure against a field, as lines or as heat maps over two fields, in panels."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from urllib.parse import quote, unquote

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError
from feasibee.base.outcomes import ACTS, CHANGES
from feasibee.figures.labels import label_ends
from feasibee.figures.style import (
    PERCENT,
    LineStyle,
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
from feasibee.scenario.comments import meaning_of
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import outside, symbol_of
from feasibee.simulation.table import Summary, by_value, leaves, pooled_fields, shares_by_line, value_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARK = "feasibee results plot "
"""What stands in a figure's file before the table of what it shows."""
WIDTHS = 1.0, 20.0
"""Least and largest width and height of a figure, in inches."""
MOST_PANELS = 12
"""Largest number of panels of a figure."""
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

    def drawable(self, found: Sequence[Summary], folder: Path) -> list[Summary]:
        """Return the points that have runs and the measure; raise an error without any."""
        points = [each for each in found if each.found.runs]
        if not points:
            raise FeasibeeError(f"{folder}: has no runs yet; run feasibee sweep first")
        needs = MEASURES[self.show].needs
        points = [each for each in points if needs is None or needs.is_met(each.row.scenario)]
        if not points:
            lacks = f"no robots of {folder} {'act' if needs is ACTS else 'declare'}"
            lacks = f"no world of {folder} changes" if needs is CHANGES else lacks
            raise FeasibeeError(f"--show {self.show}: {lacks}; use --show accuracy")
        return points

    def over(self, points: Sequence[Summary], varying: Sequence[str]) -> list[str]:
        """Return the fields over which the measure is averaged, of all that the sweep varies."""
        others = [field for field in varying if field not in self.axes]
        return pooled_fields([each.row for each in points], self.axes, others)

    def save(self, points: Sequence[Summary], over: Sequence[str], path: Path) -> None:
        """Draw the figure into a file, which says what it shows."""
        from feasibee.figures.style import JOURNAL, STYLE, save_figure

        made = MARK + quote(json.dumps(self._asdict()), safe=":,")  # letters that all formats keep
        save_figure(self._drawn(points, over), path, JOURNAL if self.journal else STYLE, made)

    def _drawn(self, points: Sequence[Summary], over: Sequence[str]) -> Figure:
        titled = () if self.journal else over  # the caption says it
        scenario, *others = (each.row.scenario for each in points)
        alike = scenario if all(each.units == scenario.units for each in others) else Scenario()
        shown = {path: outside(alike, dimension_of(path)) for path in self.axes}
        sizes = {path: size for path, (_, size) in shown.items()}
        groups = by_value(points, self.facet, sizes)
        if len(groups) > MOST_PANELS:
            rule = f"has {len(groups)} values; must have at most {MOST_PANELS}; use --hue {self.facet}"
            raise FeasibeeError(f"--facet {self.facet}: {rule}, or sweep fewer values")
        rows = self.y or self.hue
        panels = {
            value: shares_by_line(each, self.x, rows, self.show, sizes) for value, each in groups.items()
        }
        units = {path: unit for path, (unit, _) in shown.items()}
        return (draw_maps if self.y else draw_lines)(panels, self, titled, units)


def draw_lines(
    panels: Panels, shown: Shown, over: Sequence[str] = (), units: Mapping[str, str] = NO_UNITS
) -> Figure:
    """Draw a measure against a field, one line per value of another field, with 95 % bands.

    The best lines and the first are in colour. The x axis is logarithmic if its values span a decade or so.
    ``panels`` has shares from 0 to 1, by value of the panel, of ``hue``, then of ``x``.

    The measure is averaged over values of the fields in ``over``. ``units`` of fields are by path, by default
    those of scenarios.
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
    ax: Any, lines: Mapping[Any, Line], found: Mapping[str, LineStyle], shown: Shown
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


def view_in(path: Path) -> Shown | None:
    """Return what the figure in a file shows; None if it isn't that of a sweep."""
    found = re.search(re.escape(MARK).encode() + rb"([\w%:,.~-]+)", path.read_bytes())
    try:
        view = Shown(**json.loads(unquote(found[1].decode()))) if found else None
    except (TypeError, ValueError):
        return None
    return view if view is not None and _is_valid(view) else None


def _is_valid(view: Shown) -> bool:
    low, high = WIDTHS
    texts = view.show, *view.axes, view.title, view.xlabel, view.ylabel
    fields = all(isinstance(each, str) for each in texts) and isinstance(view.journal, bool)
    sizes = [each for each in (view.width, view.height) if each is not None]
    fits = all(isinstance(each, float) and low <= each <= high for each in sizes)
    return fields and fits and view.show in MEASURES


def text_of(view: Shown, points: Sequence[Summary], varying: Sequence[str], made_by: str) -> str:
    """Return the caption of a sweep's figure, its methods, and a line for each point.

    ``varying`` are all fields that the sweep varies; ``made_by`` is the version of feasibee.
    """
    caption = _caption(view.axes, view.show, view.over(points, varying))
    methods = _methods(points, varying, made_by)
    lines = [
        f"{', '.join(f'{path} = {value_of(row, path)}' for path in varying) or 'the only point'}: "
        f"{found.runs:,} runs, seed {row.seed}, scenario {row.hash}"
        for row, found in points
    ]
    return "\n".join(["Caption", "", caption, "", "Methods", "", methods, "", "Points", "", *lines, ""])


def _caption(axes: Sequence[str], show: str, over: Sequence[str]) -> str:
    measure, names = MEASURES[show], [symbol_of(path) for path in axes]
    shown = measure.label[0].upper() + measure.label[1:]
    parts = [
        f"{shown} against {' and '.join(names)}",
        f"Intervals: {measure.ends or '95 %'}",
        *(f"{name}: {meaning_of(path).rstrip('.')}" for name, path in zip(names, axes, strict=True)),
        *([f"Averaged over {', '.join(over)}"] if over else []),
    ]
    return "".join(f"{part}. " for part in parts).rstrip()


def _methods(points: Sequence[Summary], varying: Sequence[str], made_by: str) -> str:
    runs, seeds = [found.runs for _, found in points], sorted({row.seed for row, _ in points})
    each = f"{min(runs):,}" if min(runs) == max(runs) else f"{min(runs):,} to {max(runs):,}"
    fixed = ", ".join(f"{path} = {value}" for path, value in _fixed(points, varying))
    return (
        f"We simulated {sum(runs):,} runs with feasibee {made_by} (model version "
        f"{MODEL_VERSION}): {each} runs of each of {len(points)} points, with seed "
        f"{', '.join(map(str, seeds))}. Scenario, seed and number of a run determine all its results. Points "
        f"differ in {', '.join(varying) or 'nothing'}. All other fields of the scenario have the defaults of "
        f"feasibee{f', except {fixed}' if fixed else ''}. The figure was drawn with matplotlib "
        f"{version('matplotlib')}. The command `feasibee run --again` simulates the runs again."
    )


def _fixed(points: Sequence[Summary], varying: Sequence[str]) -> Iterator[tuple[str, object]]:
    """Yield the fields that don't vary and differ from the default, with their values."""
    tables = [dict(leaves(row.scenario.to_dict())) for row, _ in points]
    usual = dict(leaves(Scenario().to_dict()))
    for path, value in tables[0].items():
        same = all(table.get(path) == value for table in tables)
        if same and path not in varying and value != usual.get(path):
            yield path, value
