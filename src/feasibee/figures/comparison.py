"""Figures of a comparison: accuracy against ratio, time, and bits on the air."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.figures.style import figure, spaced_by_ratio
from feasibee.results.statistics import Interval, pareto

MARKERS = "os^vDP<>Xhpd*8"
DASHES = ("-", "--", "-.", ":")


def draw_against_ratio(
    ratios: Sequence[str],
    tasks: Sequence[int],
    shares: Mapping[str, Sequence[Interval] | None],
    label: str = "swarms that are right at the end (%)",
    wrong: Mapping[str, Sequence[Interval]] = MappingProxyType({}),
) -> Figure:
    """Draw each contender's share of swarms at each ratio, evenly spaced, with intervals.

    Parameters
    ----------
    ratios, tasks : sequence
        Ratio of robots to tasks, as text, and number of tasks, of each place on the x axis.
    shares : mapping of str to sequence of Interval
        A share per ratio by contender. A contender with None isn't drawn, and keeps its colour.
    label : str
        What the share is of.
    wrong : mapping of str to sequence of Interval
        Shares of swarms in which a robot declared wrongly; those above 0 are marked by a cross.
    """
    places = np.arange(len(ratios))
    with figure(7.2, 3.6) as (drawn, ax):
        for look, (name, intervals) in zip(_looks(shares), shares.items(), strict=True):
            if intervals is None:
                continue
            middle, low, high = 100 * np.array(intervals).T
            spread = (middle - low, high - middle)
            ax.errorbar(places, middle, yerr=spread, markersize=4, elinewidth=0.6, label=name, **look)
            marked = 100 * np.array([each.estimate for each in wrong.get(name, ())])
            some = np.flatnonzero(marked)
            ax.plot(places[some], marked[some], "x", color=look["color"], markersize=6, zorder=3)
        if wrong:
            ax.errorbar([], [], fmt="x", color="0.4", markersize=6, label="a robot wrongly")
        labels = [f"{ratio}\n{number}" for ratio, number in zip(ratios, tasks, strict=True)]
        ax.set(
            xticks=places,
            xticklabels=labels,
            xlabel="robot-to-task ratio n/m, and below it the number of tasks m",
        )
        ax.set(ylabel=label, ylim=(-2, 102))
        _legend(ax)
    return drawn


def draw_against_time(shares: Mapping[str, NDArray[np.float64]]) -> Figure:
    """Draw the share of right swarms at each step: the mean over the ratios, and the least.

    ``shares`` has, for each contender, an array of shape (ratio, step).
    """
    sums: dict[str, Any] = {"Mean over the ratios": np.mean, "At the hardest ratio": np.min}
    if all(share.shape[0] == 1 for share in shares.values()):
        sums = {"": np.mean}
    width = 3.0 + 2.1 * len(sums)
    with figure(width, 3.2, columns=len(sums), sharey=True, squeeze=False) as (drawn, axes):
        for ax, (title, sum_up) in zip(axes[0], sums.items(), strict=True):
            for look, (name, share) in zip(_looks(shares), shares.items(), strict=True):
                look.pop("marker")
                steps = np.arange(share.shape[1])
                ax.plot(steps[1:], 100 * sum_up(share, axis=0)[1:], label=name, **look)
            ax.set(xlabel="step", title=title, xlim=(10, None))
            spaced_by_ratio(ax)
        axes[0][0].set(ylabel="swarms that are right (%)", ylim=(-2, 102))
        _legend(axes[0][-1])
    return drawn


def draw_against_bits(
    totals: Mapping[str, tuple[float, Interval]], label: str = "swarms that are right at the end (%)"
) -> Figure:
    """Draw accuracy against bits per robot-step, and the Pareto front."""
    bits = [cost for cost, _ in totals.values()]
    shares = [100 * accuracy.estimate for _, accuracy in totals.values()]
    best = pareto(bits, shares)
    with figure(7.2, 3.6) as (drawn, ax):
        ax.step(
            [bits[place] for place in best],
            [shares[place] for place in best],
            where="post",
            color="0.75",
            linewidth=4,
            solid_capstyle="round",
            zorder=0,
            label="Pareto front",
        )
        for look, (name, (cost, accuracy)) in zip(_looks(totals), totals.items(), strict=True):
            middle, low, high = (100 * value for value in accuracy)
            ax.errorbar(
                cost,
                middle,
                yerr=[[middle - low], [high - middle]],
                markersize=6,
                elinewidth=0.8,
                label=name,
                **{**look, "linestyle": ""},
            )
        ax.set(xlabel="bits sent per robot-step", ylim=(None, 102))
        spaced_by_ratio(ax)
        ax.set(ylabel=label)
        _legend(ax)
    return drawn


def _looks(names: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a colour, a marker and dashes for each name, so that no two differ by colour alone."""
    colours = colormaps["turbo"](np.linspace(0.05, 0.95, len(names)))
    for number in range(len(names)):
        yield {
            "color": colours[number],
            "marker": MARKERS[number % len(MARKERS)],
            "linestyle": DASHES[number % len(DASHES)],
            "linewidth": 1.2,
        }


def _legend(ax: Any) -> None:
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
