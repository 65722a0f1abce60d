"""Style of figures, and how they are saved."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from matplotlib import rc_context, style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from feasibee.errors import FeasibeeError, quoted
from feasibee.files import FIGURES, atomic_write, check_output

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


@contextmanager
def figure(width: float, height: float, columns: int = 1, **options: Any) -> Iterator[tuple[Figure, Any]]:
    """Yield a figure of a size in inches, in feasibee's style, and its axes; open no window."""
    with style.context("default"), rc_context(STYLE):
        drawn = Figure((width, height), layout="constrained")
        yield drawn, drawn.subplots(1, columns, **options)


def save_figure(drawn: Figure, path: str | Path) -> None:
    """Save a figure in the format of its suffix, atomically and without a date."""
    check_output(path, FIGURES)
    metadata = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}.get(Path(path).suffix.lower())
    with atomic_write(path) as temporary, style.context("default"), rc_context(STYLE):
        drawn.savefig(temporary, metadata=metadata)


def save_both(drawn: Figure, stem: Path) -> None:
    """Save a figure as PNG and PDF; ``stem`` is the path of both without the suffix."""
    for suffix in ("png", "pdf"):
        save_figure(drawn, stem.with_name(f"{stem.name}.{suffix}"))


def spaced_by_ratio(ax: Axes) -> None:
    """Make an x axis logarithmic, with plain numbers at 1, 2, 5, 10, ...; call it after drawing."""
    ax.set_xscale("log")
    low, high = ax.get_xlim()
    steps = (1, 2, 5) if high / low < 2000 else (1,)
    ticks = [step * 10.0**power for power in range(-9, 12) for step in steps]
    ax.xaxis.set_major_locator(FixedLocator([tick for tick in ticks if low <= tick <= high]))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


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
