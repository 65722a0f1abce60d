"""Figures of the runs of one scenario: opinions, the truth behind them, decisions and declarations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.base.codes import COLOURS, DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.base.errors import FeasibeeError, quoted
from feasibee.base.outcomes import DECLARES, OUTCOMES
from feasibee.figures.labels import label_ends
from feasibee.figures.style import (
    GREY,
    MARKERS,
    PALETTE,
    PERCENT,
    RATIO,
    LineStyle,
    also_in_seconds,
    as_text,
    axes_for,
    draw_intervals,
    figure,
    fill_band,
    looks,
    note,
    over_time,
    robots_per_task,
    small_multiples,
)
from feasibee.results.dataset import scenario_of
from feasibee.results.measures import declared_wrong
from feasibee.results.statistics import Interval, decision_times, declare_times, opinion_quartiles
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import check_integer
from feasibee.scenario.scenario import Scenario

SHADE: Final = 0.87
"""Grey of steps at which the tasks are infeasible; feasible ones are white."""
LIMITS: Final = (-2, 110)
"""Of an axis of shares in percent, with room for the names above 100 %."""
NARROW: Final = 0.13
"""A stretch of the time axis that is shorter, as a share of the axis, has no name."""


def draw_runs(results: xr.Dataset) -> Figure:
    """Draw all figures of the runs of a scenario in one row: opinions, decisions, and what else they have."""
    scenario = scenario_of(results)
    panels: dict[str, Callable[[xr.Dataset, Axes], Axes]] = {
        "Median and quartiles over the runs": plot_opinions,
        "Collective decisions": plot_decision_steps,
    }
    if scenario.dynamic:
        panels["Right at each step"] = plot_right_steps
    if scenario.declares:
        panels["Declarations"] = plot_declare_steps
    with figure(3.6 * len(panels), 2.8, columns=len(panels)) as (drawn, axes):
        for ax, (title, draw) in zip(axes, panels.items(), strict=True):
            draw(results, ax)
            ax.set_title(title)
    return drawn


def plot_opinions(
    results: xr.Dataset | Mapping[str, xr.Dataset], ax: Axes | None = None, until: int | None = None
) -> Axes:
    """Draw the percentage of robots with opinion 1 over time: median over runs and quartile band (Fig. 2).

    In a world that changes, the truth is a band behind the lines: grey where the tasks are infeasible.

    Parameters
    ----------
    results : Dataset, or mapping of str to Dataset
        Results with curves; one line each, with the keys as labels. The first five lines have colours.
    ax : matplotlib Axes, optional
        By default a new figure's.
    until : int, optional
        Last step to show.

    Raises
    ------
    FeasibeeError
        If the results have no curves.
    """
    named: dict[str, Any] = {"": results}
    if isinstance(results, Mapping) and not isinstance(results, xr.Dataset):  # a Dataset is a Mapping too
        named = dict(results)
    scenarios = {name: scenario_of(dataset) for name, dataset in named.items()}
    if not named or any("feasible_count" not in dataset for dataset in named.values()):
        raise FeasibeeError("the results have no curves; simulate with curves=True")
    until = None if until is None else check_integer("until", until, 1, 2**31)
    bands = {str(name): _quartiles(dataset, scenarios[name]) for name, dataset in named.items()}
    truths = [dataset["truth"].values for name, dataset in named.items() if scenarios[name].dynamic]
    lengths = {scenario.units.seconds for scenario in scenarios.values()}
    found = looks(dict.fromkeys(bands, 0.0))
    with axes_for(ax, 3.6, 2.7) as axes:
        for name, (low, median, high) in bands.items():
            fill_band(axes, np.arange(median.size), low, high, found[name].colour)
            axes.plot(median, label=as_text(name), **found[name].line)
        last = until or max(median.size - 1 for _, median, _ in bands.values())
        over_time(axes, "opinion feasible (% of robots)", last)
        if truths and len({each.shape[1] for each in truths}) == 1:
            draw_truth(axes, infeasible_share(np.concatenate(truths)))
            axes.set_ylim(LIMITS)
        also_in_seconds(axes, lengths.pop() if len(lengths) == 1 else None)
        return axes


def _quartiles(dataset: xr.Dataset, scenario: Scenario) -> NDArray[np.float64]:
    robots = dataset["robots_present"] if scenario.dynamic else scenario.robots.count
    return opinion_quartiles(dataset["feasible_count"], robots)


def draw_opinion_panels(
    bands: Mapping[str, NDArray[np.float64]], colours: Sequence[str], until: int
) -> Figure:
    """Draw quartiles as small multiples: each band in a panel of its own, the other medians in grey.

    ``bands`` have lower quartile, median and upper quartile, in percent of the robots, by title of the panel:
    shape (3, steps + 1). There is a colour for each panel, and ``until`` is the last step to show.
    """
    shape, labels = (6.4, 0.7, 1.55), ("time (steps)", "opinion feasible\n(% of robots)")
    with small_multiples(len(bands), 3, shape, *labels) as (drawn, grid):
        for ax, (title, (low, median, high)), colour in zip(grid, bands.items(), colours, strict=True):
            for other in bands.values():
                ax.plot(other[1], color=GREY, linewidth=0.8, zorder=1.5)
            fill_band(ax, np.arange(median.size), low, high, colour)
            ax.plot(median, color=colour, linewidth=1.6)
            ax.set(title=title, xlim=(0, until), ylim=PERCENT, yticks=(0, 50, 100))
    return drawn


def plot_decisions(
    ratios: Sequence[float], rates: Mapping[str, Sequence[Interval]], ax: Axes | None = None
) -> Axes:
    """Draw the percentage of runs by their decision against the ratio of robots to tasks (Fig. 3).

    Parameters
    ----------
    ratios : sequence of float
        Robots per task.
    rates : mapping of str to sequence of Interval
        For ``"feasible"``, ``"infeasible"`` and ``"undecided"``, one interval per ratio.
    ax : matplotlib Axes, optional
        By default a new figure's.

    Raises
    ------
    FeasibeeError
        If a ratio isn't above 0, or the numbers of ratios and intervals differ.
    """
    _check_rates(ratios, rates)
    with axes_for(ax, 3.8, 2.8) as axes:
        axes.axvline(1, color="0.8", linewidth=0.8, zorder=0)
        _draw_rates(axes, ratios, rates, markersize=3.5, linewidth=1.0, elinewidth=0.8)
        axes.set(ylabel="runs (%)", ylim=PERCENT)
        robots_per_task(axes)
        last = int(np.argmax(ratios))
        ends = {name: (ratios[last], 100 * intervals[last][0]) for name, intervals in rates.items()}
        label_ends(axes, ends, {name: LineStyle(COLOURS[name], MARKERS[name]) for name in rates})
        return axes


def plot_decision_steps(results: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the share of runs that had decided feasible, and infeasible, by each step.

    Parameters
    ----------
    results : Dataset
        From `feasibee.simulate`.
    ax : matplotlib Axes, optional
        By default a new figure's.
    """
    scenario = scenario_of(results)
    if not {"decision", "decision_step"} <= set(results.data_vars) or results["decision"].dims != ("run",):
        raise FeasibeeError("the results have no decisions of runs; use the results of feasibee.simulate")
    spoken, steps = results["decision"].values, results["decision_step"].values
    taken = {name: steps[spoken == code] for code, name in DECISIONS.items() if code != UNDECIDED}
    found = {name: LineStyle(COLOURS[name], dashes="-" if name == "feasible" else "--") for name in taken}
    with axes_for(ax, 3.6, 2.7) as axes:
        draw_shares(axes, taken, steps.size, scenario.run.steps, "runs that had decided (%)", found)
        also_in_seconds(axes, scenario.units.seconds)
        _mark_median(axes, decision_times(steps).median)
        return axes


def draw_shares(
    ax: Axes,
    taken: Mapping[str, NDArray[Any]],
    runs: int,
    steps: int,
    label: str,
    found: Mapping[str, LineStyle],
) -> None:
    """Draw the percentage of runs whose step in ``taken`` had passed by each step.

    Names stand at the ends of the lines. Of lines that end in one place, that of the earliest is on top.
    """
    ends, early = {}, {}
    for name, at in taken.items():
        share = 100 * np.arange(at.size + 1) / runs
        look = {"color": found[name].colour, "linestyle": found[name].dashes, "label": name}
        ax.step(np.r_[0, np.sort(at), steps], np.r_[share, share[-1]], where="post", **look)
        ends[name] = float(steps), 100 * float((at <= steps).sum()) / runs
        early[name] = -float(np.sum(at))
    over_time(ax, label, float(steps))
    label_ends(ax, ends, found, early, markers=False)


def _mark_median(ax: Axes, median: int | None) -> None:
    """Mark the median of a step over the runs, named where few curves pass; do nothing if it is None."""
    if median is not None:
        label = f"half of the runs: step {median}"
        ax.axvline(median, color="0.6", linewidth=0.8, linestyle=":", label=label)
        late = median > 0.6 * ax.get_xlim()[1]
        note(ax, label, (median, 30), (-4 if late else 4, 0), ha="right" if late else "left")


def _check_rates(ratios: Sequence[float], rates: Mapping[str, Sequence[Interval]]) -> None:
    """Raise an error unless there is a ratio above 0 with three counts by decision for each."""
    numbers = _floats(ratios)
    if numbers.ndim != 1 or not numbers.size or not (np.isfinite(numbers) & (numbers > 0)).all():
        raise FeasibeeError(f"ratios = {quoted(ratios)}: must be numbers above 0; such as [0.5, 1.0, 2.0]")
    if not isinstance(rates, Mapping) or not rates or not set(rates) <= set(MARKERS):
        raise FeasibeeError(f"rates = {quoted(rates)}: must be a dict; its keys are {', '.join(MARKERS)}")
    for name, intervals in rates.items():
        if _floats(intervals).shape != (numbers.size, 3):
            rule = f"must be {numbers.size} intervals, one a ratio"
            raise FeasibeeError(f"rates[{name!r}] = {quoted(intervals)}: {rule}; such as [wilson(3, 10)]")


def _floats(values: object) -> NDArray[np.float64]:
    """Return values as an array of floats; without dimensions if they can't be one."""
    try:
        return np.asarray(values, np.float64)
    except (OverflowError, TypeError, ValueError):
        return np.array(np.nan)


class Panel(NamedTuple):
    """One of several small figures of decisions against the ratio."""

    title: str
    ratios: Sequence[float]
    rates: Mapping[str, Sequence[Interval]]
    tip: float
    """The ratio at which the tasks become infeasible."""


def draw_panels(panels: Sequence[Panel]) -> Figure:
    """Draw decisions against the ratio as small multiples, the first panel faintly in all others."""
    with small_multiples(len(panels), 4, (7.2, 0.5, 1.75), RATIO, "runs (%)") as (drawn, grid):
        for ax, panel in zip(grid, panels, strict=True):
            if panel is not panels[0]:
                for name in ("feasible", "infeasible"):
                    middle = 100 * np.array(panels[0].rates[name])[:, 0]
                    ax.plot(panels[0].ratios, middle, color=COLOURS[name], linewidth=2.6, alpha=0.22)
            tip: dict[str, Any] = {"color": "0.45", "linewidth": 0.9, "linestyle": ":", "zorder": 0}
            ax.axvline(panel.tip, label="infeasible to its left", **tip)
            _draw_rates(ax, panel.ratios, panel.rates, markersize=2.4, linewidth=0.9, elinewidth=0.7)
            ax.set(ylim=(-3, 103), yticks=(0, 25, 50, 75, 100))
            robots_per_task(ax, (0.1, 0.5, 1, 2, 10), ax.get_xlabel())
            ax.set_title(panel.title, fontsize=8.5)
            ax.tick_params(labelsize=8)
        handles, labels = grid[0].get_legend_handles_labels()
        faint = grid[0].plot([], [], color=COLOURS["undecided"], linewidth=2.6, alpha=0.4)[0]
        where: dict[str, Any] = {"loc": "outside upper center", "ncols": len(handles) + 1}
        drawn.legend([*handles, faint], [*labels, panels[0].title], **where)
    return drawn


def _draw_rates(
    ax: Axes, ratios: Sequence[float], rates: Mapping[str, Sequence[Interval]], **widths: float
) -> None:
    """Draw shares with their intervals, in points as wide as said."""
    for name, intervals in rates.items():
        look = {"color": COLOURS[name], "marker": MARKERS[name], "label": name}
        draw_intervals(ax, ratios, intervals, **look, **widths)


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
        over_time(axes, "swarms that are right (%)", truth.shape[1] - 1, LIMITS)
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
    edges, behind = np.arange(infeasible.size + 1) - 0.5, ax.get_xaxis_transform()
    shown: dict[str, Any] = {"cmap": shades, "vmin": 0, "vmax": 1, "zorder": 0, "rasterized": True}
    ax.pcolormesh(edges, [0, 1], infeasible[np.newaxis, :], transform=behind, **shown)
    top: dict[str, Any] = {"fontsize": 7.5, "ha": "center", "va": "top", "zorder": 1}
    if not np.isin(infeasible, (0, 1)).all():
        note(ax, "grey: share of runs whose tasks are infeasible", (0.5, 0.985), where=ax.transAxes, **top)
        return
    starts = np.flatnonzero(np.diff(infeasible, prepend=-1))
    for start, end in zip(starts, [*starts[1:], infeasible.size - 1], strict=True):
        if end - start >= NARROW * infeasible.size:
            name = DECISIONS[INFEASIBLE if infeasible[start] else FEASIBLE]
            note(ax, name, ((start + end) / 2, 0.985), where=behind, **top)


def plot_declare_steps(results: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the share of runs that had declared by each step: all robots rightly, or at least one wrongly.

    A run has declared when more than the threshold's share of its robots have.

    Parameters
    ----------
    results : Dataset
        From `feasibee.simulate`, with a strategy that defines ``declare``.
    ax : matplotlib Axes, optional
        By default a new figure's.

    Raises
    ------
    FeasibeeError
        If the robots of these results can't declare.
    """
    scenario = scenario_of(results)
    needed = {each.name for each in OUTCOMES if each.needs is DECLARES}
    if not needed <= set(results.data_vars) or results["declare_step"].dims != ("run",):
        raise FeasibeeError("the results have no declarations; simulate a strategy that defines declare")
    feasible, steps = truth(scenario), scenario.run.steps
    declare_step = results["declare_step"].values
    wrong = declared_wrong(results, scenario)
    right_name, wrong_name = ("feasible", "infeasible") if feasible else ("infeasible", "feasible")
    shown = {
        "rightly": LineStyle(COLOURS[right_name]),
        "a robot wrongly": LineStyle(COLOURS[wrong_name], dashes="--"),
    }
    spoken = {"rightly": ~wrong, "a robot wrongly": wrong}
    taken = {name: declare_step[chosen & (declare_step >= 0)] for name, chosen in spoken.items()}
    with axes_for(ax, 3.6, 2.7) as axes:
        draw_shares(axes, taken, declare_step.size, steps, "runs that had declared (%)", shown)
        _mark_median(axes, declare_times(declare_step).median)
        return axes
