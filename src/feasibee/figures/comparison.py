"""Figures of a comparison: right swarms against ratio, time and bits, calibration, delays, and service.

``keep`` names contenders that are highlighted in any case, by default the first. ``before`` has the looks of
contenders in another figure.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from feasibee.figures.decisions import LIMITS, draw_truth
from feasibee.figures.labels import Point, draw_points, label_ends, label_points
from feasibee.figures.style import (
    GREY,
    PALETTE,
    PERCENT,
    PLAIN,
    LineStyle,
    along,
    also_in_seconds,
    draw_intervals,
    figure,
    looks,
    name_of_axis,
    note,
    over_time,
    robots_per_task,
    spaced_by_ratio,
    text_colour,
)
from feasibee.results.calibration import Calibration
from feasibee.results.statistics import Interval, Quartiles, pareto

BESIDE = 0.006
"""Distance of two highlighted lines, as a share of the axis of ratios, so that their bars do not overlap."""
APART = 0.03
"""Least distance of two numbers of tasks above the axes, as a share of the axis of ratios."""


def draw_against_ratio(
    robots: int,
    tasks: Sequence[int],
    shares: Mapping[str, Sequence[Interval] | None],
    label: str = "swarms that are right at the end (%)",
    wrong: Mapping[str, Sequence[Interval]] = MappingProxyType({}),
    *,
    before: Mapping[str, LineStyle] | None = None,
) -> Figure:
    """Draw each contender's share of swarms at each ratio of robots to tasks, with intervals.

    The contenders with the largest mean share are highlighted; see ``feasibee.figures.style.looks``.

    Parameters
    ----------
    robots : int
        Number of robots.
    tasks : sequence of int
        Numbers of tasks. None at all is drawn as if it were half a task.
    shares : mapping of str to sequence of Interval
        A share per number of tasks by contender. A contender with None isn't drawn.
    label : str
        What the share is of.
    wrong : mapping of str to sequence of Interval
        Shares of swarms in which a robot declared wrongly; those above 0 are marked by a cross.
    """
    known = {name: np.array(share) for name, share in shares.items() if share is not None}
    means = {name: float(share[:, 0].mean()) for name, share in known.items()}
    found = looks(means, before=before)
    ratios = robots / np.maximum(tasks, 0.5)
    order, beside, ends = np.argsort(ratios), _beside(found, ratios), {}
    with figure(7.2, 3.8) as (drawn, ax):
        for name, share in known.items():
            look, places = found[name], beside.get(name, ratios)
            ax.plot(places[order], 100 * share[order, 0], **look.line)
            ends[name] = (float(places[order[-1]]), 100 * float(share[order[-1], 0]))
            if look.highlighted:
                draw_intervals(ax, places, share, **look.bars)
            _draw_crosses(ax, places, wrong.get(name, ()), look)
        _finish_ratios(ax, ratios, tasks)
        ax.set(ylabel=label, ylim=PERCENT)
        if any(each.estimate for share in wrong.values() for each in share):
            ax.plot([], [], "x", color="0.4", markersize=6, label="with a robot that declared wrongly (%)")
            ax.legend(loc="best")
        label_ends(ax, ends, found, means)
    return drawn


def draw_against_time(
    shares: Mapping[str, NDArray[np.float64]],
    *,
    keep: Sequence[str] | None = None,
    before: Mapping[str, LineStyle] | None = None,
    seconds: float | None = None,
) -> Figure:
    """Draw the share of right swarms at each step: the mean over the ratios, and the least.

    The contenders with the largest mean share over ratios and steps are highlighted. Shares of a contender go
    from 0 to 1: shape (ratios, steps + 1). If a step has a length in ``seconds``, there is a second axis.
    """
    sums: dict[str, Any] = {"mean over the ratios": np.mean, "at the hardest ratio": np.min}
    if all(share.shape[0] == 1 for share in shares.values()):
        sums = {"": np.mean}
    means = {name: float(share.mean()) for name, share in shares.items()}
    found = looks(means, keep, before)
    with figure(2.5 + 2.3 * len(sums), 3.2, columns=len(sums), sharey=True, squeeze=False) as (drawn, axes):
        for ax, (title, sum_up) in zip(axes[0], sums.items(), strict=True):
            lines = {name: 100 * sum_up(share, axis=0) for name, share in shares.items()}
            last = max(line.size for line in lines.values()) - 1
            for name, line in lines.items():
                ax.plot(np.arange(line.size)[1:], line[1:], **found[name].line)
            limits = 10 if last > 10 else 1, max(last, 2)
            ax.set(xlabel="time (steps)", title=title, xlim=limits, ylim=PERCENT)
            spaced_by_ratio(ax)
            also_in_seconds(ax, seconds)
        axes[0][0].set(ylabel="swarms that are right (%)")
        ends = {name: (line.size - 1, float(line[-1])) for name, line in lines.items()}
        label_ends(axes[0][-1], ends, found, means, markers=False)
    return drawn


def draw_calibration(
    found: Mapping[str, Calibration],
    *,
    keep: Sequence[str] | None = None,
    before: Mapping[str, LineStyle] | None = None,
) -> Figure:
    """Draw calibration curves: on the diagonal, tasks are feasible as often as the swarms say.

    The contenders with the best Brier scores are highlighted; the options are those of `draw_against_time`.
    """
    scores = {name: -each.brier.estimate for name, each in found.items()}
    chosen, ends = looks(scores, keep, before), {}
    with figure(4.6, 3.4) as (drawn, ax):
        ax.plot([0, 100], [0, 100], color=GREY, linewidth=0.8, linestyle="--", zorder=0)
        for name, each in found.items():
            look, said = chosen[name], 100 * np.array([part.said for part in each.bins])
            shares = [part.feasible for part in each.bins]
            ax.plot(said, [100 * share.estimate for share in shares], **look.line)
            if look.highlighted:
                draw_intervals(ax, said, shares, **look.bars)
            ends[name] = (float(said[-1]), 100 * shares[-1].estimate)
        ax.set_xlabel("probability that swarms give to feasible (%)")
        ax.set(ylabel="swarms whose tasks are feasible (%)", xlim=PERCENT, ylim=PERCENT)
        label_ends(ax, ends, chosen, scores)
    return drawn


def draw_against_bits(
    totals: Mapping[str, tuple[float, Interval]],
    label: str = "swarms that are right at the end (%)",
    *,
    keep: Sequence[str] | None = None,
    before: Mapping[str, LineStyle] | None = None,
) -> Figure:
    """Draw accuracy against bits per robot-step, with the Pareto front and names at the points.

    The contenders of the Pareto front are highlighted, those with the largest share first. All others, which
    another contender beats in both, are grey. ``totals`` has bits per robot-step, and what ``label`` says, by
    contender. The axis of bits is logarithmic unless some are 0.
    """
    points = {name: (cost, *(100 * each for each in accuracy)) for name, (cost, accuracy) in totals.items()}
    scores = {name: middle for name, (_, middle, _, _) in points.items()}
    with _against_bits(points, scores, keep, before) as (drawn, ax):
        ax.set(ylabel=label, ylim=(None, 104))
        bits = [cost for cost, _ in totals.values()]
        span = max(bits) / min(bits) if min(bits) > 0 else 1.0
        _leave_room(ax, bits, max(span**0.2, 1.5), max(span**0.12, 1.3), 1.2)
    return drawn


@contextmanager
def _against_bits(
    heights: Mapping[str, tuple[float, ...]],
    scores: Mapping[str, float],
    keep: Sequence[str] | None,
    before: Mapping[str, LineStyle] | None,
) -> Iterator[tuple[Figure, Axes]]:
    """Yield a figure of contenders against bits, with the Pareto front, which is highlighted; then name them.

    ``heights`` has bits, and height of the point and of the ends of its bar. Points without score are hollow.
    """
    names = list(scores)
    front = [names[place] for place in pareto([heights[name][0] for name in names], list(scores.values()))]
    kept = list(heights)[:1] if keep is None else keep
    shown = {name: scores[name] if name in front else -np.inf for name in heights if name in {*front, *kept}}
    found = dict.fromkeys(heights, PLAIN) | looks(shown, kept, before)
    with figure(7.2, 3.6) as (drawn, ax):
        wide: dict[str, Any] = {"color": "0.88", "linewidth": 4, "solid_capstyle": "round", "zorder": 0}
        ax.step(*np.reshape([heights[name][:2] for name in front], (-1, 2)).T, where="post", **wide)
        points = [
            Point(name, bits, height, found[name], low, high, name not in scores)
            for name, (bits, height, low, high) in heights.items()
        ]
        draw_points(ax, points)
        ax.set_xlabel("bits sent per robot-step")
        yield drawn, ax
        label_points(ax, points)


def _leave_room(ax: Axes, bits: Sequence[float], left: float, right: float, linear: float) -> None:
    """Set the limits of the axis of bits so that names fit at both sides of the points.

    The axis is spaced by ratio, with room by these factors, unless some contender sends nothing.
    """
    least, most = min(bits), max(bits)
    if least > 0:
        ax.set_xlim(least / left, most * right)
        spaced_by_ratio(ax)
    else:
        ax.set_xlim(-0.2 * (most or 1), linear * (most or 1))


def _finish_ratios(ax: Axes, ratios: NDArray[np.float64], tasks: Sequence[int]) -> None:
    """Make the axis of ratios, and above it write the numbers of tasks that have room."""
    robots_per_task(ax)
    shown: dict[float, int] = {}
    for ratio, number in sorted(zip(ratios.tolist(), tasks, strict=True)):
        if not shown or ratio >= max(shown) * _factor(ratios, APART):
            shown[ratio] = number
    above = ax.secondary_xaxis("top")
    above.set_xticks(list(shown), [str(number) for number in shown.values()])
    above.set_xticks([], minor=True)
    above.tick_params(labelsize="small")
    above.set_xlabel(name_of_axis("tasks.count"), fontsize="medium")


def _beside(found: Mapping[str, LineStyle], ratios: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Return the places of each highlighted line along the axis of ratios."""
    names = [name for name, look in found.items() if look.highlighted]
    shifts = BESIDE * (np.arange(len(names)) - (len(names) - 1) / 2)
    return {name: ratios * _factor(ratios, shift) for name, shift in zip(names, shifts, strict=True)}


def _factor(ratios: NDArray[np.float64], share: float) -> float:
    """Return the factor between two ratios that are a share of their axis apart."""
    return float(max(ratios.max() / ratios.min(), 1.2) ** share)


def _draw_crosses(ax: Axes, places: NDArray[np.float64], wrong: Sequence[Interval], look: LineStyle) -> None:
    """Mark the shares above 0 of swarms in which a robot declared wrongly."""
    marked = 100 * np.array([each.estimate for each in wrong])
    some = np.flatnonzero(marked)
    ax.plot(places[some], marked[some], "x", color=look.colour, markersize=6, zorder=3)


def draw_right_over_time(
    shares: Mapping[str, NDArray[np.float64]],
    infeasible: NDArray[np.float64],
    *,
    before: Mapping[str, LineStyle] | None = None,
) -> Figure:
    """Draw each contender's share of right swarms at each step, with the truth as a band behind.

    ``shares`` has the share of the swarms that hold the truth of each step, by contender, and ``infeasible``
    that of the runs whose tasks are infeasible: shape (steps + 1,).
    """
    means = {name: float(share.mean()) for name, share in shares.items()}
    found = looks(means, None, before)
    with figure(7.2, 3.4) as (drawn, ax):
        draw_truth(ax, infeasible)
        for name, share in shares.items():
            ax.plot(100 * share, **found[name].line)
        last = infeasible.size - 1
        over_time(ax, "swarms that are right (%)", last, LIMITS)
        ends = {name: (last, 100 * float(share[-1])) for name, share in shares.items()}
        label_ends(ax, ends, found, means, markers=False)
    return drawn


def draw_delay_against_bits(
    contenders: Mapping[str, tuple[float, Quartiles]],
    steps: int,
    *,
    before: Mapping[str, LineStyle] | None = None,
) -> Figure:
    """Draw the delay of detection against bits per robot-step, with the Pareto front: the frontier.

    ``contenders`` has bits per robot-step, and steps until swarms follow a change of truth, by name. Those of
    the front are highlighted, and the first. One of which less than half of the changes are followed stands
    at the top, as *never*. A run has so many ``steps``.
    """
    known = {name: -float(each.median) for name, (_, each) in contenders.items() if each.median is not None}
    never = 1.15 * max([*(each.q75 or each.median or 0 for _, each in contenders.values()), 10])
    heights = {
        name: (bits, *(never if step is None else step for step in (delay.median, delay.q25, delay.q75)))
        for name, (bits, delay) in contenders.items()
    }
    with _against_bits(heights, known, None, before) as (drawn, ax):
        ax.set(ylabel=f"delay of detection (steps, of {steps:,})", ylim=(0, 1.12 * never))
        if len(known) < len(contenders):
            ax.axhline(never, color="0.8", linewidth=0.8, linestyle=":", zorder=0)
            steps_of = [tick for tick in ax.get_yticks() if tick < 0.95 * never]
            ax.set_yticks([*steps_of, never], [*(f"{tick:g}" for tick in steps_of), "never"])
        _leave_room(ax, [bits for bits, _ in contenders.values()], 2, 3, 1.3)
    return drawn


class Side(NamedTuple):
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


def draw_sizing(panels: Sequence[Side], target: float) -> Figure:
    """Draw the share of right swarms against the values of one or two panels, with the share asked for."""
    size = 1.0 + 3.4 * len(panels), 3.0
    with figure(*size, columns=len(panels), sharey=True, squeeze=False) as (drawn, axes):
        for ax, panel in zip(axes[0], panels, strict=True):
            _draw(ax, panel, target)
        axes[0][0].set(ylabel="swarms that are right (%)", ylim=(-2, 108), yticks=range(0, 101, 20))
        where = axes[0][-1].get_yaxis_transform()
        note(axes[0][-1], f"{100 * target:g} %", (1.0, 100 * target), (4, 0), where)
    return drawn


def _draw(ax: Any, panel: Side, target: float) -> None:
    values = [value for value, _ in panel.points]
    ax.axhline(100 * target, color="0.45", linewidth=0.8, linestyle="--", zorder=0)
    look = {"color": PALETTE[0], "marker": "o", "markersize": 3.5, "linewidth": 1.2, "elinewidth": 0.7}
    draw_intervals(ax, values, [share for _, share in panel.points], **look)
    along(ax, panel.label, values)
    if ax.get_xscale() == "linear" and all(float(value).is_integer() for value in values):
        ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))  # no half robots
    above: dict[str, Any] = {"where": ax.get_xaxis_transform(), "va": "bottom"}
    if panel.least is not None:
        ax.axvline(panel.least, color=PALETTE[0], linewidth=0.8, linestyle=":")
        note(ax, f"enough from {panel.least:g}", (panel.least, 1.01), ha="center", color=PALETTE[0], **above)
    if panel.band is not None:
        first, last = panel.band
        ax.axvspan(first - 0.5, last + 0.5, color=PALETTE[1], alpha=0.15, linewidth=0, zorder=0)
        middle = float(np.sqrt(first * last)) if ax.get_xscale() == "log" else (first + last) / 2
        ends = f"{first:g}" if first == last else f"{first:g} to {last:g}"
        note(
            ax, f"blind band: {ends}", (middle, 101), ha="center", va="bottom", color=text_colour(PALETTE[1])
        )
    if panel.truth is not None:
        ax.axvline(panel.truth + 0.5, ymax=0.9, color="0.45", linewidth=0.8, linestyle=":")
        for side, text in (("right", "feasible  "), ("left", "  infeasible")):
            note(ax, text, (panel.truth + 0.5, 1.01), ha=side, color="0.45", **above)
