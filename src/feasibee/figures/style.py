"""Style of figures: sizes, colours, which lines are highlighted, logarithmic axes, saving."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib import rc_context, style
from matplotlib.axes import Axes
from matplotlib.category import StrCategoryFormatter
from matplotlib.colors import to_hex, to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from feasibee.base.errors import FeasibeeError, one_line, quoted
from feasibee.base.files import FIGURES, atomic_write, check_output
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.units import SYMBOLS, symbol_of

MARKERS = {"feasible": "o", "infeasible": "s", "undecided": "^"}
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9,
    "legend.handlelength": 2.4,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.dpi": 150,
    "savefig.dpi": 200,
    "pdf.fonttype": 42,
    "svg.hashsalt": "feasibee",
}
JOURNAL: Final[dict[Any, Any]] = {
    **STYLE,
    "font.size": 8,
    "axes.titlesize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.linewidth": 0.6,
    "savefig.dpi": 600,
}
"""Style of a figure in a column of a journal."""
PALETTE: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
"""Colours of highlighted lines, as many as a figure may have; of Okabe and Ito, for any colour vision."""
PERCENT: Final = (-2, 102)
"""Limits of an axis of percentages."""
RATIO: Final = "robots per task $n/m$"
"""Label of the axis that `robots_per_task` makes."""
FLATTEST: Final = 0.62
"""Least height of a figure in a journal's column, as a share of its width."""
NAME_LIMIT: Final = 60
"""Largest length of a name in a figure, in characters; a longer one is shortened in its middle."""
GREY: Final = "0.72"
"""Colour of all other lines."""
MARKS: Final = ("o", "s", "^", "D", "v")
"""Marker of each colour of `PALETTE`, so that no two lines differ by colour alone."""
DASHES: Final = ("-", (0, (4, 1.4)), (0, (1.4, 1)), (0, (6, 1.4, 1.4, 1.4)), (0, (9, 2)))
"""Dashes of each colour of `PALETTE`: of two lines in one place, both are seen."""


class LineStyle(NamedTuple):
    """How a line is drawn."""

    colour: str
    marker: str = ""
    """Empty for a line that isn't highlighted."""
    dashes: Any = "-"

    @property
    def highlighted(self) -> bool:
        """Whether the line has a colour, markers and a label."""
        return bool(self.marker)

    @property
    def line(self) -> dict[str, Any]:
        """Options of matplotlib's ``plot`` for the line; dashed lines lie above solid ones."""
        if not self.highlighted:
            return {"color": self.colour, "linewidth": 0.8, "zorder": 1.5}
        above = 2 + PALETTE.index(self.colour) / 10
        return {"color": self.colour, "linestyle": self.dashes, "linewidth": 1.5, "zorder": above}

    @property
    def bars(self) -> dict[str, Any]:
        """Options of matplotlib's ``errorbar`` for markers with intervals."""
        size, above = (4.5, 2.6) if self.highlighted else (3.5, 1.5)
        shape = {"fmt": self.marker or "o", "markersize": size, "elinewidth": 0.8}
        return {"color": self.colour, "zorder": above, **shape}


PLAIN: Final = LineStyle(GREY)
"""Look of a line that isn't highlighted."""


def looks(
    scores: Mapping[str, float],
    keep: Sequence[str] | None = None,
    before: Mapping[str, LineStyle] | None = None,
) -> dict[str, LineStyle]:
    """Return the look of each line of a figure: as many as `PALETTE` has colours are highlighted.

    ``scores`` has what the figure shows of each line, as one number: the lines with the largest ones are
    highlighted. So are those in ``keep``, by default the first, to which others are compared. Lines keep
    their look in ``before``, another figure, as far as its colours are free.
    """
    kept = list(scores)[:1] if keep is None else [name for name in keep if name in scores]
    ranked = sorted(scores, key=lambda name: -scores[name])
    chosen = list(dict.fromkeys([*kept, *ranked]))[: len(PALETTE)]
    found = {name: before[name] for name in chosen if before and name in before and before[name].highlighted}
    taken = [look.colour for look in found.values()]
    free = (LineStyle(*each) for each in zip(PALETTE, MARKS, DASHES, strict=True) if each[0] not in taken)
    found |= {name: next(free) for name in chosen if name not in found}
    return {name: found.get(name, PLAIN) for name in scores}


def as_text(name: object) -> str:
    """Return a name as matplotlib draws it: one printable line, in which a dollar sign starts no formula."""
    return one_line(str(name), NAME_LIMIT).replace("$", r"\$")


def with_formulas(text: str) -> str:
    """Return a text that a user wrote for a figure; if its formulas are invalid, they are drawn as text."""
    try:
        for line in text.split("\n"):
            MathTextParser("path").parse(line)
    except ValueError:
        return text.replace("$", r"\$")
    return text


def text_colour(colour: str) -> str:
    """Return a darker shade of a colour, in which text is readable on white."""
    red, green, blue = to_rgb(colour)
    return to_hex((0.65 * red, 0.65 * green, 0.65 * blue))


@contextmanager
def figure(
    width: float, height: float, columns: int = 1, rows: int = 1, journal: float = 0.0, **options: Any
) -> Iterator[tuple[Figure, Any]]:
    """Yield a figure of a size in inches, in feasibee's style, and its axes; open no window.

    ``journal`` is the width of a journal's column, if the figure is for one.
    """
    if journal:
        width, height = journal, journal * max(FLATTEST, height / width)
    with style.context("default"), rc_context(JOURNAL if journal else STYLE):
        drawn = Figure((width, height), layout="constrained")
        yield drawn, drawn.subplots(rows, columns, **options)


@contextmanager
def small_multiples(
    count: int,
    columns: int,
    size: tuple[float, float, float],
    xlabel: str,
    ylabel: str,
    journal: float = 0.0,
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Yield a figure of panels with labels at its edges; ``size`` has its width, and heights: head, row."""
    rows, (width, above, each) = -(-count // columns), size
    shape: dict[str, Any] = {"sharex": True, "sharey": True, "squeeze": False}
    with figure(width, above + each * rows, columns, rows, journal, **shape) as (drawn, grid):
        for place, ax in enumerate(grid.flat):
            lowest = place + columns >= count
            ax.set_visible(place < count)
            ax.tick_params(labelbottom=lowest)
            ax.set(xlabel=xlabel if lowest else "", ylabel="" if place % columns else ylabel)
        yield drawn, list(grid.flat[:count])


def name_of_axis(path: str, journal: float = 0.0, unit: str | None = None) -> str:
    """Return the label of a field: its symbol and unit, after its name in words unless for a journal."""
    unit = dimension_of(path).unit if unit is None else unit
    group, _, last = path.replace("_", " ").partition(".")
    words = f"{group.removesuffix('s')} {last}" if last else group
    words = f"number of {group}" if last == "count" else words
    base, _, index = symbol_of(path).partition("_")
    text = f"${base}_\\mathrm{{{index}}}$" if index else f"${base}$" if path in SYMBOLS else base
    if not journal:
        text = f"{words} {text}" if path in SYMBOLS else words
    return f"{text} ({unit})" if unit else text


def draw_intervals(ax: Axes, places: Any, shares: Any, **look: Any) -> None:
    """Draw shares with their intervals, of shape (places, 3), in percent."""
    middle, low, high = 100 * np.reshape(shares, (-1, 3)).T
    ax.errorbar(places, middle, yerr=(middle - low, high - middle), **look)


def note(
    ax: Axes,
    text: str,
    place: tuple[float, float],
    offset: tuple[float, float] = (0, 0),
    where: Any = "data",
    **look: Any,
) -> None:
    """Write a text at an offset in points from a place, such as a number in a row or a name above axes."""
    look = {"fontsize": 8, "color": "0.35", "va": "center", **look}
    ax.annotate(text, place, offset, where, "offset points", annotation_clip=False, **look)


def over_time(ax: Axes, label: str, last: float, limits: tuple[float, float] = PERCENT) -> None:
    """Label axes of percentages by step."""
    ax.set(xlabel="time (steps)", ylabel=label, xlim=(0, last), ylim=limits)


def save_figure(
    drawn: Figure, path: str | Path, settings: Mapping[Any, Any] = STYLE, made: str | None = None
) -> None:
    """Save a figure in the format of its suffix, atomically and without a date; `JOURNAL` is sharper.

    The file may say how it was ``made``.
    """
    check_output(path, FIGURES)
    is_pdf, is_svg = (Path(path).suffix.lower() == each for each in (".pdf", ".svg"))
    metadata: dict[str, str | None] = {"CreationDate": None} if is_pdf else {"Date": None} if is_svg else {}
    if made:
        metadata["Subject" if is_pdf else "Description"] = made
    with atomic_write(path) as temporary, style.context("default"), rc_context(dict(settings)):
        drawn.savefig(temporary, metadata=metadata)


def save_both(drawn: Figure, stem: Path) -> None:
    """Save a figure as PNG and PDF; ``stem`` is the path of both without the suffix."""
    for suffix in ("png", "pdf"):
        save_figure(drawn, stem.with_name(f"{stem.name}.{suffix}"))


def are_spaced_by_ratio(values: Iterable[float]) -> bool:
    """Return whether numbers belong on a logarithmic axis: they span a decade, or were spaced by ratio."""
    once = sorted(set(values))
    if not once or once[0] <= 0:
        return False
    if once[-1] >= 10 * once[0]:
        return True
    ratios = [larger / less for less, larger in pairwise(once)]
    steps = [larger - less for less, larger in pairwise(once)]
    even = max(steps, default=0) <= 1.001 * min(steps, default=0)
    return len(once) > 2 and not even and max(ratios) <= 1.1 * min(ratios)


def spaced_by_ratio(ax: Axes, ticks: Sequence[float] = ()) -> None:
    """Make an x axis logarithmic, with plain numbers at given ones or round ones; call it after drawing."""
    ax.set_xscale("log")
    low, high = ax.get_xlim()
    steps = (1, 1.5, 2, 3, 5, 7) if high / low < 8 else (1, 2, 5) if high / low < 2000 else (1,)
    ticks = ticks or [step * 10.0**power for power in range(-9, 12) for step in steps]
    ax.xaxis.set_major_locator(FixedLocator([tick for tick in ticks if low <= tick <= high]))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def along(ax: Axes, label: str, values: Sequence[Any]) -> None:
    """Label an x axis, and make it logarithmic if its values are numbers that belong on such an axis."""
    ax.set_xlabel(label)
    words = ax.xaxis.get_major_formatter()
    if isinstance(words, StrCategoryFormatter):
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, place: as_text(words(value, place))))
    if all(isinstance(value, int | float) for value in values) and are_spaced_by_ratio(values):
        spaced_by_ratio(ax)


def robots_per_task(ax: Axes, ticks: Sequence[float] = (), label: str = RATIO) -> None:
    """Make an x axis that of every figure over the ratio: spaced by it, with more robots to the right.

    Call it after drawing. A figure whose panels share one label passes an empty one.
    """
    spaced_by_ratio(ax, ticks)
    ax.set_xlabel(label)


def fill_band(ax: Axes, x: Any, low: Any, high: Any, colour: str) -> None:
    """Fill the band between two lines, with thin edges that separate it from bands that overlap it."""
    face, edge = to_rgba(colour, 0.15), to_rgba(colour, 0.6)
    ax.fill_between(x, low, high, facecolor=face, edgecolor=edge, linewidth=0.5)


@contextmanager
def axes_for(ax: Axes | None, width: float, height: float) -> Iterator[Axes]:
    """Yield the given axes, or those of a new figure in feasibee's style."""
    if ax is None:
        with figure(width, height) as (_, made):
            yield made
    elif isinstance(ax, Axes):
        yield ax
    else:
        raise FeasibeeError(f"ax = {quoted(ax)}: must be Axes of matplotlib; leave it out for a new figure")


def also_in_seconds(ax: Axes, seconds: float | None) -> None:
    """Add an axis in seconds above one in steps, if it is known how long a step is."""
    if seconds is not None:
        ways: Any = (lambda value: value * seconds, lambda value: value / seconds)
        above = ax.secondary_xaxis("top", functions=ways)
        above.set_xlabel("time (s)", fontsize="medium")


def in_metres(ax: Axes, metres: float | None) -> None:
    """Label axes x and y in metres instead of units, if it is known how long a unit is."""
    if metres is not None:
        for name, axis in {"x": ax.xaxis, "y": ax.yaxis}.items():
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value * metres:g}"))
            axis.set_label_text(f"{name} (m)")
