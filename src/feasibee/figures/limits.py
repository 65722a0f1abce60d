"""Figure of the physical limits of a swarm: the share of runs that have reached each limit, by step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.figures.decisions import draw_share_by_step
from feasibee.figures.style import figure, text_colour


class Look(NamedTuple):
    """How a limit is drawn, here and behind strategies."""

    label: str
    colour: str
    dashes: Any
    height: float
    """Where its curve is labelled, as a share of the runs."""
    side: str = "left"
    """Which end of the label is at the curve."""


LOOKS: Final[Mapping[str, Look]] = {
    "pooled": Look("pooled", "#0072B2", "-", 0.62),
    "area": Look("area", "#009E73", (0, (1, 1.2)), 0.4, "right"),
    "flooding": Look("flooding", "#D55E00", "-", 0.20),
    "complete_map": Look("complete map", "#CC79A7", "--", 0.62),
}
"""The limits, in the order in which they are drawn."""
SHOWN: Final = 0.995
"""Share of the runs of each limit that the time axis shows."""


def draw_limits(steps: Mapping[str, NDArray[np.int64]], most: int) -> Figure:
    """Draw the share of runs that have reached each limit by each step.

    Parameters
    ----------
    steps : mapping of str to int64 array, shape (runs,)
        First step of each limit; -1 for a run that never reached it.
    most : int
        Number of steps of a run.
    """
    with figure(5.6, 3.0) as (drawn, ax):
        end = max(_end(steps[name], most) for name in LOOKS)
        never = 0
        for name, look in LOOKS.items():
            reached, runs = np.sort(steps[name][steps[name] >= 0]), steps[name].size
            curve = {"color": look.colour, "linestyle": look.dashes, "linewidth": 1.6}
            draw_share_by_step(ax, reached, runs, most, **curve)
            if reached.size:
                rank = min(max(1, round(look.height * runs)), reached.size)
                _write(ax, look.label, (reached[rank - 1], 100 * rank / runs), look)
            else:
                never += 1
                _write(ax, f"{look.label}: never", (end, 7.0 * never - 4), look._replace(side="right"))
        ax.set(xlabel="time (steps)", ylabel="runs that got there (%)", xlim=(0, end), ylim=(-2, 102))
    return drawn


def _end(steps: NDArray[np.int64], most: int) -> float:
    """Return the last step to show: nearly all runs have reached the limit, if they ever do."""
    ordered = np.sort(np.where(steps < 0, most, steps))
    return float(min(most, 1.08 * ordered[int(SHOWN * (ordered.size - 1))] + 1))


def _write(ax: Axes, text: str, place: tuple[float, float], look: Look) -> None:
    """Write a label below a point of a curve to its right, or above it to its left."""
    left = look.side == "left"
    ends: dict[str, Any] = {"ha": look.side, "va": "top" if left else "bottom"}
    offset = (5, -3) if left else (-5, 3)
    ax.annotate(
        text, place, offset, textcoords="offset points", color=text_colour(look.colour), fontsize=8, **ends
    )
