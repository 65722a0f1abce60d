"""Figure of a sizing: the share of right swarms against a field, and against tasks with the blind band."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from feasibee.figures.style import PALETTE, along, draw_intervals, figure, note, text_colour
from feasibee.results.statistics import Interval

BLUE, ORANGE, GREY = *PALETTE[:2], "0.45"


class Panel(NamedTuple):
    """One side of the figure."""

    label: str
    """Of the horizontal axis."""
    points: Sequence[tuple[float, Interval]]
    """Finding values, ascending, and their shares."""
    least: float | None = None
    """First value that is enough."""
    band: tuple[float, float] | None = None
    """First and last value of the blind band."""
    truth: float | None = None
    """Largest feasible number of tasks."""


def draw_sizing(panels: Sequence[Panel], target: float) -> Figure:
    """Draw the share of right swarms against the values of each panel.

    Parameters
    ----------
    panels : sequence of Panel
        One or two.
    target : float
        Share of swarms that must be right.
    """
    size = 1.0 + 3.4 * len(panels), 3.0
    with figure(*size, columns=len(panels), sharey=True, squeeze=False) as (drawn, axes):
        for ax, panel in zip(axes[0], panels, strict=True):
            _draw(ax, panel, target)
        axes[0][0].set(ylabel="swarms that are right (%)", ylim=(-2, 108), yticks=range(0, 101, 20))
        where = axes[0][-1].get_yaxis_transform()
        note(axes[0][-1], f"{100 * target:g} %", (1.0, 100 * target), (4, 0), where)
    return drawn


def _draw(ax: Any, panel: Panel, target: float) -> None:
    values = [value for value, _ in panel.points]
    ax.axhline(100 * target, color=GREY, linewidth=0.8, linestyle="--", zorder=0)
    look = {"color": BLUE, "marker": "o", "markersize": 3.5, "linewidth": 1.2, "elinewidth": 0.7}
    draw_intervals(ax, values, [share for _, share in panel.points], **look)
    along(ax, panel.label, values)
    above: dict[str, Any] = {"where": ax.get_xaxis_transform(), "va": "bottom"}
    if panel.least is not None:
        ax.axvline(panel.least, color=BLUE, linewidth=0.8, linestyle=":")
        note(ax, f"enough from {panel.least:g}", (panel.least, 1.01), ha="center", color=BLUE, **above)
    if panel.band is not None:
        first, last = panel.band
        ax.axvspan(first - 0.5, last + 0.5, color=ORANGE, alpha=0.15, linewidth=0, zorder=0)
        middle = float(np.sqrt(first * last)) if ax.get_xscale() == "log" else (first + last) / 2
        ends = f"{first:g}" if first == last else f"{first:g} to {last:g}"
        note(ax, f"blind band: {ends}", (middle, 101), ha="center", va="bottom", color=text_colour(ORANGE))
    if panel.truth is not None:
        ax.axvline(panel.truth + 0.5, ymax=0.9, color=GREY, linewidth=0.8, linestyle=":")
        for side, text in (("right", "feasible  "), ("left", "  infeasible")):
            note(ax, text, (panel.truth + 0.5, 1.01), ha=side, color=GREY, **above)
