"""Figures of a comparison: accuracy against ratio, time, and bits on the air."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.figures.labels import Point, label_ends, label_points, name_others
from feasibee.figures.style import PLAIN, Look, also_in_seconds, figure, looks, spaced_by_ratio
from feasibee.results.statistics import Interval, pareto

BESIDE = 0.06
"""Distance of two highlighted lines along the axis of ratios, so that their bars do not overlap."""


def draw_against_ratio(
    ratios: Sequence[str],
    tasks: Sequence[int],
    shares: Mapping[str, Sequence[Interval] | None],
    label: str = "swarms that are right at the end (%)",
    wrong: Mapping[str, Sequence[Interval]] = MappingProxyType({}),
    *,
    keep: Sequence[str] | None = None,
    before: Mapping[str, Look] | None = None,
) -> Figure:
    """Draw each contender's share of swarms at each ratio, evenly spaced, with intervals.

    The contenders with the largest mean share are highlighted; see ``feasibee.figures.style.looks``.

    Parameters
    ----------
    ratios, tasks : sequence
        Ratio of robots to tasks, as text, and number of tasks, of each place on the x axis.
    shares : mapping of str to sequence of Interval
        A share per ratio by contender. A contender with None isn't drawn.
    label : str
        What the share is of.
    wrong : mapping of str to sequence of Interval
        Shares of swarms in which a robot declared wrongly; those above 0 are marked by a cross.
    keep : sequence of str, optional
        Contenders that are highlighted in any case; by default the first.
    before : mapping of str to Look, optional
        Looks of contenders in another figure.
    """
    drawn_shares = {name: 100 * np.array(share) for name, share in shares.items() if share is not None}
    means = {name: float(share[:, 0].mean()) for name, share in drawn_shares.items()}
    found = looks(means, keep, before)
    beside = _beside(found)
    with figure(7.2, 3.6) as (drawn, ax):
        ends = {}
        for name, share in drawn_shares.items():
            look, places = found[name], np.arange(float(len(ratios))) + beside.get(name, 0.0)
            ax.plot(places, share[:, 0], **look.line)
            if look.highlighted:
                _draw_bars(ax, places, share, look)
                ends[name] = (float(places[-1]), float(share[-1, 0]))
            _draw_crosses(ax, places, wrong.get(name, ()), look)
        _finish_ratios(ax, ratios, tasks)
        ax.set(ylabel=label, ylim=(-2, 102))
        if any(each.estimate for share in wrong.values() for each in share):
            ax.plot([], [], "x", color="0.4", markersize=6, label="with a robot that declared wrongly (%)")
            ax.legend(loc="best")
        name_others(drawn, found)
        label_ends(ax, ends, found, means)
    return drawn


def draw_against_time(
    shares: Mapping[str, NDArray[np.float64]],
    *,
    keep: Sequence[str] | None = None,
    before: Mapping[str, Look] | None = None,
    seconds: float | None = None,
) -> Figure:
    """Draw the share of right swarms at each step: the mean over the ratios, and the least.

    The contenders with the largest mean share over ratios and steps are highlighted.

    Parameters
    ----------
    shares : mapping of str to float64 array, shape (ratios, steps + 1)
        Shares by contender, from 0 to 1.
    keep : sequence of str, optional
        Contenders that are highlighted in any case; by default the first.
    before : mapping of str to Look, optional
        Looks of contenders in another figure.
    seconds : float, optional
        Length of a step in seconds, for a second axis.
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
            ax.set(
                xlabel="time (steps)",
                title=title,
                xlim=(10 if last > 10 else 1, max(last, 2)),
                ylim=(-2, 102),
            )
            spaced_by_ratio(ax)
            also_in_seconds(ax, seconds)
        axes[0][0].set(ylabel="swarms that are right (%)")
        name_others(drawn, found)
        shown = [name for name, look in found.items() if look.highlighted]
        ends = {name: (lines[name].size - 1, float(lines[name][-1])) for name in shown}
        label_ends(axes[0][-1], ends, found, means, markers=False)
    return drawn


def draw_against_bits(
    totals: Mapping[str, tuple[float, Interval]],
    label: str = "swarms that are right at the end (%)",
    *,
    keep: Sequence[str] | None = None,
    before: Mapping[str, Look] | None = None,
) -> Figure:
    """Draw accuracy against bits per robot-step, with the Pareto front and names at the points.

    The contenders of the Pareto front are highlighted, those with the largest share first. All others, which
    another contender beats in both, are grey.

    Parameters
    ----------
    totals : mapping of str to pair of float and Interval
        Bits per robot-step and share of right swarms, by contender. The axis of bits is logarithmic unless
        some are 0.
    label : str
        What the share is of.
    keep : sequence of str, optional
        Contenders that are highlighted in any case; by default the first.
    before : mapping of str to Look, optional
        Looks of contenders in another figure.
    """
    names = list(totals)
    bits = [cost for cost, _ in totals.values()]
    shares = [100 * accuracy.estimate for _, accuracy in totals.values()]
    best = pareto(bits, shares)
    found = _looks_of_front({names[place]: shares[place] for place in best}, names, keep, before)
    with figure(7.2, 3.6) as (drawn, ax):
        front: dict[str, Any] = {"color": "0.88", "linewidth": 4, "solid_capstyle": "round", "zorder": 0}
        ax.step([bits[each] for each in best], [shares[each] for each in best], where="post", **front)
        points = []
        for name, (cost, accuracy) in totals.items():
            share, look = 100 * np.array([accuracy]), found[name]
            _draw_bars(ax, np.array([cost]), share, look)
            points.append(Point(name, cost, share[0, 0], look, share[0, 1], share[0, 2]))
        ax.set(xlabel="bits sent per robot-step", ylabel=label, ylim=(None, 104))
        _leave_room(ax, min(bits), max(bits))
        label_points(ax, points)
    return drawn


def _leave_room(ax: Axes, least: float, most: float) -> None:
    """Set the limits of the axis of bits so that names fit at both sides of the points."""
    if least > 0:
        span = most / least
        ax.set_xlim(least / max(span**0.2, 1.5), most * max(span**0.12, 1.3))
        spaced_by_ratio(ax)
    else:
        ax.set_xlim(-0.2 * (most or 1), 1.2 * (most or 1))


def _looks_of_front(
    front: Mapping[str, float],
    names: Sequence[str],
    keep: Sequence[str] | None,
    before: Mapping[str, Look] | None,
) -> dict[str, Look]:
    """Return the looks of points: those of the front are highlighted, and those to keep."""
    kept = list(names[:1] if keep is None else keep)
    scores = {name: front.get(name, -1.0) for name in names if name in front or name in kept}
    shown = looks(scores, kept, before)
    return {name: shown.get(name, PLAIN) for name in names}


def _finish_ratios(ax: Axes, ratios: Sequence[str], tasks: Sequence[int]) -> None:
    """Write the ratio and the number of tasks at each place of the x axis."""
    labels = [f"{ratio}\n{number}" for ratio, number in zip(ratios, tasks, strict=True)]
    ax.set_xticks(range(len(ratios)), labels)
    ax.set_xlabel("robot-to-task ratio n/m, and below it the number of tasks m")
    ax.set_xlim(-0.4, len(ratios) - 0.6)


def _beside(found: Mapping[str, Look]) -> dict[str, float]:
    """Return how far each highlighted line is moved along the axis of ratios."""
    names = [name for name, look in found.items() if look.highlighted]
    return {name: BESIDE * (number - (len(names) - 1) / 2) for number, name in enumerate(names)}


def _draw_crosses(ax: Axes, places: NDArray[np.float64], wrong: Sequence[Interval], look: Look) -> None:
    """Mark the shares above 0 of swarms in which a robot declared wrongly."""
    marked = 100 * np.array([each.estimate for each in wrong])
    some = np.flatnonzero(marked)
    ax.plot(places[some], marked[some], "x", color=look.colour, markersize=6, zorder=3)


def _draw_bars(ax: Axes, places: NDArray[np.float64], share: NDArray[np.float64], look: Look) -> None:
    """Draw markers with intervals: ``share`` has estimate, low and high, in percent, of each place."""
    middle, low, high = share.T
    ax.errorbar(
        places,
        middle,
        yerr=(middle - low, high - middle),
        fmt=look.marker or "o",
        color=look.colour,
        markersize=4.5 if look.highlighted else 3.5,
        elinewidth=0.8,
        zorder=2.6 if look.highlighted else 1.5,
    )
