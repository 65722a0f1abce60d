"""Figures of worlds that change: truth as a band behind what swarms hold, and delay against bits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.figures.labels import Point, label_ends, label_points, name_others
from feasibee.figures.style import (
    PALETTE,
    PLAIN,
    Look,
    also_in_seconds,
    axes_for,
    figure,
    looks,
    spaced_by_ratio,
)
from feasibee.model.codes import DECISIONS, FEASIBLE, INFEASIBLE
from feasibee.results.dataset import scenario_of
from feasibee.results.statistics import Quartiles, pareto

SHADE: Final = 0.87
"""Grey of steps at which the tasks are infeasible; feasible ones are white."""
LIMITS: Final = (-2, 110)
"""Of an axis of shares in percent, with room for the names above 100 %."""
NARROW: Final = 0.13
"""A stretch of the time axis that is shorter, as a share of the axis, has no name."""


class Tracked(NamedTuple):
    """What a figure shows of a contender in a world that changes."""

    bits: float
    """Bits per robot-step."""
    delay: Quartiles
    """Steps until swarms follow a change of truth."""


def plot_right_steps(results: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the percentage of swarms that hold the truth of each step, with the truth as a band behind.

    Parameters
    ----------
    results : Dataset
        From `feasibee.simulate`, of a world that changes.
    ax : matplotlib Axes, optional
        By default a new figure's.

    Raises
    ------
    FeasibeeError
        If the world of these results doesn't change.
    """
    if "truth" not in results or results["truth"].dims != ("run", "step"):
        raise FeasibeeError("the results have no truth of each step; simulate a world that changes")
    truth, held = results["truth"].values, results["held"].values
    with axes_for(ax, 3.6, 2.7) as axes:
        draw_truth(axes, infeasible_share(truth))
        axes.plot(100 * (held == truth).mean(axis=0), color=PALETTE[0], linewidth=1.5)
        axes.set(xlabel="time (steps)", ylabel="swarms that are right (%)", ylim=LIMITS)
        axes.set_xlim(0, truth.shape[1] - 1)
        also_in_seconds(axes, scenario_of(results).units.seconds)
        return axes


def infeasible_share(truth: NDArray[Any]) -> NDArray[np.float64]:
    """Return the share of runs whose tasks are infeasible at each step: shape (steps + 1,)."""
    share: NDArray[np.float64] = (truth == INFEASIBLE).mean(axis=0)
    return share


def draw_truth(ax: Axes, infeasible: NDArray[np.float64]) -> None:
    """Draw the truth behind a time axis: white where the tasks are feasible, grey where they aren't.

    If runs differ, the grey is as dark as many runs are infeasible. Stretches in which all runs agree have
    their name at the top.

    Parameters
    ----------
    ax : matplotlib Axes
        With steps along x.
    infeasible : float64 array, shape (steps + 1,)
        Share of the runs whose tasks are infeasible, by step.
    """
    shades = LinearSegmentedColormap.from_list("truth", ["1.0", str(SHADE)])
    edges = np.arange(infeasible.size + 1) - 0.5
    ax.pcolormesh(
        edges,
        [0, 1],
        infeasible[np.newaxis, :],
        cmap=shades,
        vmin=0,
        vmax=1,
        zorder=0,
        rasterized=True,
        transform=ax.get_xaxis_transform(),
    )
    if not np.isin(infeasible, (0, 1)).all():
        _write(ax, 0.5, "grey: share of runs whose tasks are infeasible", ax.transAxes)
        return
    starts = np.flatnonzero(np.diff(infeasible, prepend=-1))
    for start, end in zip(starts, [*starts[1:], infeasible.size - 1], strict=True):
        if end - start >= NARROW * infeasible.size:
            name = DECISIONS[INFEASIBLE if infeasible[start] else FEASIBLE]
            _write(ax, (start + end) / 2, name, ax.get_xaxis_transform())


def _write(ax: Axes, x: float, text: str, where: Any) -> None:
    """Write a text at the top of the axes."""
    look: dict[str, Any] = {"fontsize": 7.5, "color": "0.35", "ha": "center", "va": "top", "zorder": 1}
    ax.text(x, 0.985, text, transform=where, **look)


def draw_right_over_time(
    shares: Mapping[str, NDArray[np.float64]],
    infeasible: NDArray[np.float64],
    *,
    before: Mapping[str, Look] | None = None,
    seconds: float | None = None,
) -> Figure:
    """Draw each contender's share of right swarms at each step, with the truth as a band behind.

    Parameters
    ----------
    shares : mapping of str to float64 array, shape (steps + 1,)
        Share of the swarms that hold the truth of the step, by contender.
    infeasible : float64 array, shape (steps + 1,)
        Share of the runs whose tasks are infeasible, by step.
    before : mapping of str to Look, optional
        Looks of contenders in another figure.
    seconds : float, optional
        Length of a step in seconds, for a second axis.
    """
    means = {name: float(share.mean()) for name, share in shares.items()}
    found = looks(means, None, before)
    with figure(7.2, 3.4) as (drawn, ax):
        draw_truth(ax, infeasible)
        for name, share in shares.items():
            ax.plot(100 * share, **found[name].line)
        last = infeasible.size - 1
        ax.set(xlabel="time (steps)", ylabel="swarms that are right (%)", xlim=(0, last), ylim=LIMITS)
        also_in_seconds(ax, seconds)
        name_others(drawn, found)
        ends = {
            name: (last, 100 * float(shares[name][-1])) for name, look in found.items() if look.highlighted
        }
        label_ends(ax, ends, found, means, markers=False)
    return drawn


def draw_delay_against_bits(
    contenders: Mapping[str, Tracked], steps: int, *, before: Mapping[str, Look] | None = None
) -> Figure:
    """Draw the delay of detection against bits per robot-step, with the Pareto front: the frontier.

    A contender of which less than half of the changes are followed stands at the top, as *never*.

    Parameters
    ----------
    contenders : mapping of str to Tracked
        By name. The contenders of the front are highlighted, and the first.
    steps : int
        Number of steps of a run.
    before : mapping of str to Look, optional
        Looks of contenders in another figure.
    """
    known = {name: each.delay.median for name, each in contenders.items() if each.delay.median is not None}
    never = 1.15 * max([*(each.delay.q75 or each.delay.median or 0 for each in contenders.values()), 10])
    names = list(known)
    best = pareto([contenders[name].bits for name in names], [-float(known[name]) for name in names])
    found = _looks(list(contenders), {names[place]: -known[names[place]] for place in best}, before)
    with figure(7.2, 3.6) as (drawn, ax):
        _draw_front(ax, [(contenders[names[place]].bits, known[names[place]]) for place in best])
        points = [_point(ax, name, each, found[name], never) for name, each in contenders.items()]
        ax.set(xlabel="bits sent per robot-step", ylabel=f"delay of detection (steps, of {steps:,})")
        ax.set_ylim(0, 1.12 * never)
        if len(known) < len(contenders):
            ax.axhline(never, color="0.8", linewidth=0.8, linestyle=":", zorder=0)
            steps_of = [tick for tick in ax.get_yticks() if tick < 0.95 * never]
            ax.set_yticks([*steps_of, never], [*(f"{tick:g}" for tick in steps_of), "never"])
        _leave_room(ax, [each.bits for each in contenders.values()])
        label_points(ax, points)
    return drawn


def _looks(
    names: Sequence[str], front: Mapping[str, float], before: Mapping[str, Look] | None
) -> dict[str, Look]:
    """Return the looks of contenders: those of the front are highlighted, and the first."""
    scores = {name: front.get(name, -np.inf) for name in names if name in front or name == names[0]}
    return {name: looks(scores, None, before).get(name, PLAIN) for name in names}


def _draw_front(ax: Axes, front: Sequence[tuple[float, float]]) -> None:
    if front:
        wide: dict[str, Any] = {"color": "0.88", "linewidth": 4, "solid_capstyle": "round", "zorder": 0}
        ax.step(*zip(*front, strict=True), where="post", **wide)


def _point(ax: Axes, name: str, each: Tracked, look: Look, never: float) -> Point:
    """Draw a contender: its median, and its quartiles as a bar."""
    middle, low, high = (
        never if step is None else float(step) for step in (each.delay.median, each.delay.q25, each.delay.q75)
    )
    ax.plot([each.bits, each.bits], [low, high], color=look.colour, linewidth=0.8)
    face = look.colour if each.delay.median is not None else "white"
    ax.plot(each.bits, middle, look.marker or "o", color=look.colour, markerfacecolor=face, markersize=4.5)
    return Point(name, each.bits, middle, look, low, high)


def _leave_room(ax: Axes, bits: Sequence[float]) -> None:
    """Set the limits of the axis of bits so that names fit at both sides of the points."""
    least, most = min(bits), max(bits)
    if least > 0:
        ax.set_xlim(least / 2, most * 3)
        spaced_by_ratio(ax)
    else:
        ax.set_xlim(-0.2 * (most or 1), 1.3 * (most or 1))
