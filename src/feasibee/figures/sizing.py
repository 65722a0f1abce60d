"""Figure of a sizing: the share of right swarms against a field, and against tasks with the blind band."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from feasibee.figures.style import draw_intervals, figure, spaced_by_ratio
from feasibee.results.statistics import Interval

BLUE, ORANGE, DARK_ORANGE, GREY = "#0072B2", "#D55E00", "#9c4400", "0.45"
DECADE: Final = 10
"""Ratio of the largest to the least value from which an axis is spaced by ratio."""


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
    with figure(1.0 + 3.4 * len(panels), 3.0, columns=len(panels), sharey=True, squeeze=False) as (
        drawn,
        axes,
    ):
        for ax, panel in zip(axes[0], panels, strict=True):
            _draw(ax, panel, target)
        axes[0][0].set(ylabel="swarms that are right (%)", ylim=(-2, 108), yticks=range(0, 101, 20))
        axes[0][0].text(
            0.99,
            100 * target - 2,
            f"{100 * target:g} %",
            ha="right",
            va="top",
            color=GREY,
            fontsize=8,
            transform=axes[0][0].get_yaxis_transform(),
        )
    return drawn


def _draw(ax: Any, panel: Panel, target: float) -> None:
    values = np.array([value for value, _ in panel.points])
    ax.axhline(100 * target, color=GREY, linewidth=0.8, linestyle="--", zorder=0)
    look = {"color": BLUE, "marker": "o", "markersize": 3.5, "linewidth": 1.2, "elinewidth": 0.7}
    draw_intervals(ax, values, [share for _, share in panel.points], **look)
    if values.min() > 0 and values.max() / values.min() >= DECADE:
        spaced_by_ratio(ax)
    ax.set(xlabel=panel.label)
    if panel.least is not None:
        _mark(ax, panel.least, f"enough from {panel.least:g}")
    if panel.band is not None:
        first, last = panel.band
        ax.axvspan(first - 0.5, last + 0.5, color=ORANGE, alpha=0.15, linewidth=0, zorder=0)
        middle_of_band = np.sqrt(first * last) if ax.get_xscale() == "log" else (first + last) / 2
        ends = f"{first:g}" if first == last else f"{first:g} to {last:g}"
        ax.text(
            middle_of_band,
            101,
            f"blind band: {ends}",
            ha="center",
            va="bottom",
            color=DARK_ORANGE,
            fontsize=8,
        )
    if panel.truth is not None:
        ax.axvline(panel.truth + 0.5, color=GREY, linewidth=0.8, linestyle=":")
        for side, text in (("right", "feasible  "), ("left", "  infeasible")):
            _above(ax, panel.truth + 0.5, text, GREY, side)


def _mark(ax: Any, value: float, text: str) -> None:
    ax.axvline(value, color=BLUE, linewidth=0.8, linestyle=":")
    _above(ax, value, text, BLUE, "center")


def _above(ax: Any, value: float, text: str, colour: str, side: str) -> None:
    """Write above the axes."""
    place = ax.get_xaxis_transform()
    ax.text(value, 1.01, text, ha=side, va="bottom", color=colour, fontsize=8, transform=place)
