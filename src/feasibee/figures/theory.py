"""Figures of predictions: decisions over time, what drives them, and predictions over a field."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from feasibee.base.codes import COLOURS
from feasibee.figures.labels import label_ends
from feasibee.figures.style import (
    PALETTE,
    PERCENT,
    LineStyle,
    along,
    draw_intervals,
    figure,
    fill_band,
    name_of_axis,
    note,
    over_time,
    text_colour,
)
from feasibee.theory.predict import Agreement, Prediction

ENGINE = {"fmt": "o", "markersize": 4, "elinewidth": 0.8, "markerfacecolor": "white", "zorder": 3}
"""How runs of the engine are drawn."""
LATE = 0.99
"""Share of the decisions that the time axis shows."""


def draw_prediction(prediction: Prediction, agreement: Agreement | None = None) -> Figure:
    """Draw decisions over time, the drift of opinions with its noise, and where the noise comes from.

    The shares that the engine found are dots with 95 % intervals.
    """
    with figure(8.2, 2.7, columns=3, gridspec_kw={"width_ratios": [1.3, 1.3, 0.7]}) as (drawn, axes):
        _draw_times(axes[0], prediction, agreement)
        _draw_drift(axes[1], prediction)
        _draw_noise(axes[2], prediction)
    return drawn


def _draw_times(ax: Axes, prediction: Prediction, agreement: Agreement | None) -> None:
    decided = prediction.by_step.sum(1)
    last = min(int(np.searchsorted(decided, LATE * decided[-1])) + 1, len(decided) - 1)
    steps, error, ends = np.arange(last + 1), 100 * prediction.error, {}
    for column, name in enumerate(("feasible", "infeasible")):
        colour = COLOURS[name]
        share = 100 * prediction.by_step[: last + 1, column]
        ax.plot(steps, share, color=colour, linewidth=1.5)
        fill_band(ax, steps, np.maximum(share - error, 0), np.minimum(share + error, 100), colour)
        ends[name] = (last, share[-1])
        if agreement is not None:
            draw_intervals(ax, [last], [agreement.rates[name]], color=colour, clip_on=False, **ENGINE)
    over_time(ax, "swarms that have decided (%)", last)
    label_ends(ax, ends, {name: LineStyle(COLOURS[name]) for name in ends}, markers=False)
    ax.set_title("dots: engine, at the end" if agreement else "", loc="left", color="0.3")


def _draw_drift(ax: Axes, prediction: Prediction) -> None:
    along, robots = prediction.along, prediction.scenario.robots.count
    share = 100 * along.holders[:, 0] / robots
    spread = np.sqrt(along.noise)
    ax.axhline(0, color="0.6", linewidth=0.8)
    ax.plot(share, along.drift, color=PALETTE[2], linewidth=1.5)
    fill_band(ax, share, along.drift - spread, along.drift + spread, PALETTE[2])
    if prediction.tipping is not None:
        ax.axvline(100 * prediction.tipping.point, color="0.35", linewidth=0.8, linestyle=":")
        note(ax, "tips", (100 * prediction.tipping.point, 0.97), (3, 0), ax.get_xaxis_transform())
    ax.set(xlabel="feasible opinions (%)", ylabel="drift (robots per step)", xlim=(0, 100))
    ax.set_title("band: one standard deviation", loc="left", color="0.3")


def _draw_noise(ax: Axes, prediction: Prediction) -> None:
    ax.set(xlim=(-0.5, 0.5), xticks=[], ylim=(0, 100), ylabel="noise (% of the variance)")
    if prediction.tipping is None:
        note(ax, "does not tip", (0, 50), ha="center")
        return
    coins = 100 * prediction.tipping.coins_share
    for name, low, high, colour in (
        ("coins at\nthe start", 0.0, coins, PALETTE[4]),
        ("later\nsteps", coins, 100.0, "0.8"),
    ):
        ax.bar(0, high - low, bottom=low, color=colour, width=0.6)
        note(ax, f"{name}\n{high - low:.0f} %", (0, (low + high) / 2), ha="center", color="black")


def draw_field(path: str, points: Sequence[tuple[Any, Prediction, Agreement | None]]) -> Figure:
    """Draw shares, the tipping point with both consensus states, and times against a field.

    ``points`` has each value of the field, what the theory says, and what the engine found, if it was run.
    """
    values = [value for value, _, _ in points]
    found = [prediction for _, prediction, _ in points]
    runs = [(value, each) for value, _, each in points if each is not None]
    with figure(8.2, 2.7, columns=3) as (drawn, axes):
        share = 100 * np.array([each.feasible for each in found])
        error = 100 * np.array([each.error for each in found])
        axes[0].plot(values, share, color=PALETTE[0], linewidth=1.5)
        fill_band(axes[0], values, np.maximum(share - error, 0), np.minimum(share + error, 100), PALETTE[0])
        _draw_states(axes[1], values, found)
        times = np.array([[np.nan if q is None else q for q in each.steps.values()] for each in found], float)
        axes[2].plot(values, times[:, 1], color=PALETTE[2], linewidth=1.5)
        fill_band(axes[2], values, times[:, 0], times[:, 2], PALETTE[2])
        if runs:
            at = [value for value, _ in runs]
            draw_intervals(axes[0], at, [each.rates["feasible"] for _, each in runs], color="0.2", **ENGINE)
            medians = [np.nan if each.steps.median is None else each.steps.median for _, each in runs]
            axes[2].plot(at, medians, "o", color="0.2", markersize=4, markerfacecolor="white")
        axes[0].set(ylabel="decide feasible (%)", ylim=PERCENT)
        axes[1].set(ylabel="feasible opinions (%)", ylim=PERCENT)
        axes[2].set(ylabel="step of the decision", ylim=(0, None))
        for ax, title in zip(axes, ("band: tested error", "", "line: median; band: quartiles"), strict=True):
            ax.set_title(title, loc="left", color="0.3")
            along(ax, name_of_axis(path), values)
    return drawn


def _draw_states(ax: Axes, values: Sequence[Any], found: Sequence[Prediction]) -> None:
    """Draw the tipping point dashed, and the states that opinions drift to on either side."""
    tips = [np.nan if each.tipping is None else 100 * each.tipping.point for each in found]
    ax.plot(values, tips, color="0.35", linestyle="--", linewidth=1.5)
    for name, end in (("infeasible", 0), ("feasible", -1)):
        ends = [100 * each.along.holders[end, 0] / each.scenario.robots.count for each in found]
        ax.plot(values, ends, color=COLOURS[name], linewidth=1.5)
        offset = (2, 7 if end == 0 else -7)
        note(ax, f"all {name}", (values[0], ends[0]), offset, color=text_colour(COLOURS[name]))
    if np.isfinite(tips).any():
        first = int(np.flatnonzero(np.isfinite(tips))[0])
        note(ax, "tipping point", (values[first], tips[first]), (2, 8))
