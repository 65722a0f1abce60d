"""Figures of physical limits, by step, and with the words of robots in front: the frontier."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.figures.decisions import draw_shares
from feasibee.figures.style import Look, as_text, figure, note, spaced_by_ratio, text_colour

LOOKS: Final[Mapping[str, Look]] = {
    "pooled": Look("#0072B2"),
    "area": Look("#009E73", dashes=(0, (1, 1.2))),
    "flooding": Look("#D55E00"),
    "complete_map": Look("#CC79A7", dashes="--"),
    "least_sum": Look("#56B4E9", dashes="--"),
    "least_maximum": Look("#56B4E9"),
    "mapped_maximum": Look("#E69F00"),
}
"""The limits that may be there, in the order in which they are drawn."""
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
    taken, looks = {}, {}
    for name in (name for name in LOOKS if name in steps):
        reached = steps[name][steps[name] >= 0]
        label = words(name) if reached.size else f"{words(name)}: never"
        taken[label], looks[label] = reached, LOOKS[name]
    end, runs = max(_end(each, most) for each in steps.values()), max(each.size for each in steps.values())
    with figure(5.6, 3.0) as (drawn, ax):
        draw_shares(ax, taken, runs, most, "runs that got there (%)", looks, end)
    return drawn


def words(name: str) -> str:
    """Return the name of a limit in words."""
    return name.replace("_", " ")


def _end(steps: NDArray[np.int64], most: int) -> float:
    """Return the last step to show: nearly all runs have reached the limit, if they ever do."""
    ordered = np.sort(np.where(steps < 0, most, steps))
    return float(min(most, 1.08 * ordered[int(SHOWN * (ordered.size - 1))] + 1))


WORD = "#0072B2"
"""Colour of the words of contenders."""
RELIABLE: Final = 0.99
"""Share of swarms that are right by their own word above which a marker is filled."""
BANDS: Final = ("pooled", "flooding", "complete_map")
"""The limits that are drawn, by their names in `feasibee.figures.limits.LOOKS`."""
STRIP: Final = 2.4
"""Height of the strip above the rows, where the bands are named, in rows."""
CAPTION: Final = (
    "bits: mean over {most:,} steps; ok: share that is right by its own word by then; "
    "filled: at least {reliable:g}; dot and line: half to 95 % of the swarms; bands: limits of any strategy"
)


class Word(NamedTuple):
    """What the robots of a contender declared at one number of tasks."""

    contender: str
    bits: float
    """Bits sent per robot-step."""
    ok: float
    """Share of swarms that were right by their own word."""
    median: int | None
    """Step by which enough robots had spoken in half of the swarms; None if never."""
    p95: int | None
    """The same in 95 % of the swarms."""


class Panel(NamedTuple):
    """One number of tasks."""

    title: str
    words: Sequence[Word]
    """One per contender, in the same order in all panels."""
    limits: Mapping[str, tuple[int | None, int | None]]
    """Median and 95 % of the step of each limit."""


def draw_frontier(panels: Sequence[Panel], most: int) -> Figure:
    """Draw each contender as a row: its bits, and for each number of tasks its time and accuracy.

    Parameters
    ----------
    panels : sequence of Panel
        Numbers of tasks, from left to right.
    most : int
        Number of steps of a run.
    """
    bits = np.array([[word.bits for word in panel.words] for panel in panels]).mean(axis=0)
    order = np.argsort(bits, kind="stable")
    widths = {"width_ratios": [1.1, *[1.5] * len(panels)]}
    size = 1.9 + 1.95 * len(panels), 1.3 + 0.24 * (len(order) + STRIP)
    with figure(*size, columns=len(panels) + 1, sharey=True, gridspec_kw=widths) as (drawn, axes):
        _draw_bits(axes[0], bits[order], [panels[0].words[k] for k in order])
        for ax, panel in zip(axes[1:], panels, strict=True):
            _draw_panel(ax, panel, [panel.words[k] for k in order], most)
        _label_bands(axes[1], panels[0], len(order))
        axes[0].set_ylim(-0.7, len(order) - 0.4 + STRIP)
        drawn.supxlabel(CAPTION.format(most=most, reliable=RELIABLE), fontsize=8, color="0.3")
    return drawn


def _draw_bits(ax: Axes, bits: Sequence[float], words: Sequence[Word]) -> None:
    """Draw each contender's bits per robot-step, with its name."""
    for place, cost in enumerate(bits):
        ax.plot(cost, place, "s", color=WORD, markersize=3.5)
        note(ax, f"{cost:.3g}", (cost, place), (4, 0), fontsize=7.5, color=WORD)
    ax.set_yticks(range(len(bits)), [as_text(word.contender) for word in words])
    ax.set(xlabel="bits per robot-step", xlim=(0.6 * min(bits), 8 * max(bits)))
    _finish(ax, 1.5 * max(bits))


def _draw_panel(ax: Axes, panel: Panel, words: Sequence[Word], most: int) -> None:
    """Draw the limits as bands, and each contender's time and accuracy in front."""
    beside = ax.get_yaxis_transform()
    for name in BANDS:
        middle, late = panel.limits[name]
        if middle is not None:
            end = most if late is None else late
            ax.axvspan(middle, end, color=LOOKS[name].colour, alpha=0.2, linewidth=0)
    for place, word in enumerate(words):
        ax.axhline(place, color="0.9", linewidth=0.6, zorder=0)
        if word.median is not None:
            colour, end = WORD, 2 * most if word.p95 is None else word.p95
            ax.plot([word.median, end], [place, place], color=colour, linewidth=1.8)
            fill = colour if word.ok >= RELIABLE else "white"
            ax.plot(word.median, place, "o", color=colour, markerfacecolor=fill, markersize=4.5)
        note(ax, f"{word.ok:.3f}", (1.0, place), (4, 0), beside, fontsize=7.5, color=WORD)
    note(ax, "ok", (1.0, len(words) - 0.1), (4, 0), beside, fontsize=7.5, color="black", va="baseline")
    ax.set(xlabel="time (steps)", xlim=(10, 1.25 * most))
    ax.set_title(panel.title)
    _finish(ax, most)


def _finish(ax: Axes, most: float) -> None:
    """Space the x axis by ratio, with a tick per decade up to a value, and leave out those of the rows."""
    ax.tick_params(axis="y", length=0)
    spaced_by_ratio(ax, [10.0**power for power in range(-9, 12) if 10.0**power <= most])


def _label_bands(ax: Axes, panel: Panel, rows: int) -> None:
    """Name the bands, above the rows."""
    for name in BANDS:
        middle, late = panel.limits[name]
        if middle is not None:
            place = float(np.sqrt(max(1, middle) * (late or middle))), rows - 0.5 + STRIP
            look: dict[str, Any] = {"rotation": 90, "ha": "center", "va": "top", "fontsize": 6.5}
            note(ax, words(name), place, color=text_colour(LOOKS[name].colour), **look)
