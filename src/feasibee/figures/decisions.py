"""Opinions over time and collective decisions as figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib import rc_context, style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError, quoted
from feasibee.figures.labels import label_ends
from feasibee.figures.style import GREY, MARKERS, STYLE, Look, also_in_seconds, axes_for, fill_band, looks
from feasibee.figures.tracking import LIMITS, draw_truth, infeasible_share
from feasibee.model.codes import COLOURS, DECISIONS, FEASIBLE, UNDECIDED
from feasibee.results.dataset import scenario_of
from feasibee.results.statistics import (
    Interval,
    decision_times,
    opinion_quartiles,
    quartiles_of_present,
)
from feasibee.scenario.runs import check_integer


def plot_opinions(
    results: xr.Dataset | Mapping[str, xr.Dataset], ax: Axes | None = None, until: int | None = None
) -> Axes:
    """Draw the percentage of robots with opinion 1 over time: median over runs and quartile band (Fig. 2).

    In a world that changes, the truth is a band behind the lines: grey where the tasks are infeasible.

    Parameters
    ----------
    results : Dataset, or mapping of str to Dataset
        Results with curves; one line each, with the keys as labels.
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
    bands = {
        str(name): quartiles_of_present(dataset["feasible_count"], dataset["robots_present"])
        if scenarios[name].dynamic
        else opinion_quartiles(dataset["feasible_count"], scenarios[name].robots.count)
        for name, dataset in named.items()
    }
    axes = draw_opinion_bands(bands, ax, until)
    truths = [dataset["truth"].values for name, dataset in named.items() if scenarios[name].dynamic]
    if truths and len({each.shape[1] for each in truths}) == 1:
        draw_truth(axes, infeasible_share(np.concatenate(truths)))
        axes.set_ylim(LIMITS)
    lengths = {scenario.units.seconds for scenario in scenarios.values()}
    also_in_seconds(axes, lengths.pop() if len(lengths) == 1 else None)
    return axes


def draw_opinion_bands(
    bands: Mapping[str, NDArray[np.float64]], ax: Axes | None = None, until: int | None = None
) -> Axes:
    """Draw quartiles, each of shape (3, steps + 1), with thin edges that separate overlapping bands.

    The first lines have colours, as many as a figure may have; further ones are grey.
    """
    found = looks(dict.fromkeys(bands, 0.0))
    with axes_for(ax, 3.6, 2.7) as axes:
        for name, (low, median, high) in bands.items():
            look = found[name]
            steps = np.arange(median.size)
            fill_band(axes, steps, low, high, look.colour)
            axes.plot(steps, median, label=name, **look.line)
        axes.set(xlabel="time (steps)", ylabel="opinion feasible (% of robots)", ylim=(-2, 102))
        axes.set_xlim(0, until or max(median.size - 1 for _, median, _ in bands.values()))
        return axes


def draw_opinion_panels(
    bands: Mapping[str, NDArray[np.float64]], colours: Sequence[str], until: int, columns: int = 3
) -> Figure:
    """Draw quartiles as small multiples: each band in a panel of its own, the other medians in grey.

    Parameters
    ----------
    bands : mapping of str to float64 array, shape (3, steps + 1)
        Lower quartile, median and upper quartile, in percent of the robots, by title of the panel.
    colours : sequence of str
        One for each panel.
    until : int
        Last step to show.
    columns : int
        Panels side by side.
    """
    rows = -(-len(bands) // columns)
    with style.context("default"), rc_context(STYLE):
        drawn = Figure((6.4, 0.7 + 1.55 * rows), layout="constrained")
        grid = drawn.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for ax, (title, (low, median, high)), colour in zip(grid.flat, bands.items(), colours, strict=False):
            for other in bands.values():
                ax.plot(other[1], color=GREY, linewidth=0.8, zorder=1.5)
            fill_band(ax, np.arange(median.size), low, high, colour)
            ax.plot(median, color=colour, linewidth=1.6)
            ax.set(title=title, xlim=(0, until), ylim=(-2, 102), yticks=(0, 50, 100))
        for ax in grid.flat[len(bands) :]:
            ax.set_visible(False)
        drawn.supylabel("opinion feasible (% of robots)", fontsize=9)
        drawn.supxlabel("time (steps)", fontsize=9)
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
        _draw_rates(axes, ratios, rates, marker=3.5, line=1.0, bar=0.8)
        axes.set(xscale="log", xlabel="robot-to-task ratio n/m", ylabel="runs (%)", ylim=(-2, 102))
        ticks = [tick for tick in (0.1, 0.2, 0.5, 1, 2, 5, 10) if min(ratios) <= tick <= max(ratios)]
        if len(ticks) >= 2:
            axes.xaxis.set_major_locator(FixedLocator(ticks))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        ends = {
            name: (max(ratios), 100 * intervals[int(np.argmax(ratios))][0])
            for name, intervals in rates.items()
        }
        label_ends(axes, ends, {name: Look(COLOURS[name], MARKERS[name]) for name in rates})
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
    runs = results.sizes["run"]
    with axes_for(ax, 3.6, 2.7) as axes:
        looks_of, taken = {}, {}
        for code, name in DECISIONS.items():
            if code != UNDECIDED:
                taken[name] = results["decision_step"].values[results["decision"].values == code]
                looks_of[name] = Look(COLOURS[name], dashes="-" if code == FEASIBLE else "--")
        draw_shares_by_step(axes, taken, runs, scenario.run.steps, looks_of)
        also_in_seconds(axes, scenario.units.seconds)
        mark_median(axes, decision_times(results["decision_step"].values).median)
        axes.set_ylabel("runs that had decided (%)")
        return axes


def draw_shares_by_step(
    ax: Axes, taken: Mapping[str, NDArray[Any]], runs: int, steps: int, found: Mapping[str, Look]
) -> None:
    """Draw lines of `draw_share_by_step` with their names at the ends."""
    for name, at in taken.items():
        look = {"color": found[name].colour, "linestyle": found[name].dashes, "label": name}
        draw_share_by_step(ax, at, runs, steps, **look)
    ax.set(xlabel="time (steps)", xlim=(0, steps), ylim=(-2, 102))
    ends = {name: (float(steps), 100 * at.size / runs) for name, at in taken.items()}
    label_ends(ax, ends, found, markers=False)


def draw_share_by_step(ax: Axes, taken: NDArray[Any], runs: int, steps: int, **look: Any) -> None:
    """Draw the percentage of runs whose step in ``taken`` had passed by each step."""
    share = 100 * np.arange(taken.size + 1) / runs
    ax.step(np.r_[0, np.sort(taken), steps], np.r_[share, share[-1]], where="post", **look)


def mark_median(ax: Axes, median: int | None) -> None:
    """Mark the median of a step over the runs, named where few curves pass; do nothing if it is None."""
    if median is not None:
        label = f"half of the runs: step {median}"
        ax.axvline(median, color="0.6", linewidth=0.8, linestyle=":", label=label)
        late = median > 0.6 * ax.get_xlim()[1]
        look: dict[str, Any] = {
            "ha": "right" if late else "left",
            "va": "center",
            "fontsize": 8,
            "color": "0.4",
        }
        ax.annotate(label, (median, 30), (-4 if late else 4, 0), textcoords="offset points", **look)


def _check_rates(ratios: Sequence[float], rates: Mapping[str, Sequence[Interval]]) -> None:
    """Raise an error unless there is a ratio above 0 with three counts by decision for each."""
    try:
        numbers = np.asarray(ratios, np.float64)
        fit = numbers.ndim == 1 and numbers.size > 0 and bool((np.isfinite(numbers) & (numbers > 0)).all())
    except (OverflowError, TypeError, ValueError):
        fit = False
    if not fit:
        raise FeasibeeError(f"ratios = {quoted(ratios)}: must be numbers above 0; such as [0.5, 1.0, 2.0]")
    if not isinstance(rates, Mapping) or not rates or not set(rates) <= set(MARKERS):
        raise FeasibeeError(f"rates = {quoted(rates)}: must be a dict; its keys are {', '.join(MARKERS)}")
    for name, intervals in rates.items():
        try:
            shape = np.asarray(intervals, np.float64).shape
        except (OverflowError, TypeError, ValueError):
            shape = ()
        if shape != (numbers.size, 3):
            rule = f"must be {numbers.size} intervals, one a ratio"
            raise FeasibeeError(f"rates[{name!r}] = {quoted(intervals)}: {rule}; such as [wilson(3, 10)]")


class Panel(NamedTuple):
    """One of several small figures of decisions against the ratio."""

    title: str
    ratios: Sequence[float]
    rates: Mapping[str, Sequence[Interval]]
    tip: float
    """The ratio at which the tasks become infeasible."""


def draw_panels(panels: Sequence[Panel], columns: int = 4) -> Figure:
    """Draw decisions against the ratio as small multiples, the first panel faintly in all others.

    Parameters
    ----------
    panels : sequence of Panel
        The first is what the others are compared with.
    columns : int
        Panels side by side.
    """
    rows = -(-len(panels) // columns)
    with style.context("default"), rc_context(STYLE):
        drawn = Figure((7.2, 0.5 + 1.75 * rows), layout="constrained")
        grid = drawn.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for ax, panel in zip(grid.flat, panels, strict=False):
            if panel is not panels[0]:
                for name in ("feasible", "infeasible"):
                    middle = 100 * np.array(panels[0].rates[name])[:, 0]
                    ax.plot(panels[0].ratios, middle, color=COLOURS[name], linewidth=2.6, alpha=0.22)
            _draw_panel(ax, panel)
        for place, ax in enumerate(grid.flat[len(panels) :], start=len(panels)):
            ax.set_visible(False)
            if place >= columns:
                grid.flat[place - columns].tick_params(labelbottom=True)
        drawn.supylabel("runs (%)", fontsize=9)
        drawn.supxlabel("ratio of robots to places asked for", fontsize=9)
        handles, labels = grid.flat[0].get_legend_handles_labels()
        faint = grid.flat[0].plot([], [], color=COLOURS["undecided"], linewidth=2.6, alpha=0.4)[0]
        drawn.legend(
            [*handles, faint], [*labels, panels[0].title], loc="outside upper center", ncols=len(handles) + 1
        )
    return drawn


def _draw_rates(
    ax: Axes,
    ratios: Sequence[float],
    rates: Mapping[str, Sequence[Interval]],
    *,
    marker: float,
    line: float,
    bar: float,
) -> None:
    """Draw shares with their intervals, in points as wide as said."""
    for name, intervals in rates.items():
        middle, low, high = 100 * np.array(intervals).T
        ax.errorbar(
            ratios,
            middle,
            yerr=(middle - low, high - middle),
            color=COLOURS[name],
            marker=MARKERS[name],
            markersize=marker,
            linewidth=line,
            elinewidth=bar,
            label=name,
        )


def _draw_panel(ax: Axes, panel: Panel) -> None:
    ax.axvline(
        panel.tip, color="0.45", linewidth=0.9, linestyle=":", zorder=0, label="infeasible to its left"
    )
    _draw_rates(ax, panel.ratios, panel.rates, marker=2.4, line=0.9, bar=0.7)
    ax.set(xscale="log", ylim=(-3, 103), yticks=(0, 25, 50, 75, 100))
    ax.set_title(panel.title, fontsize=8.5)
    ax.xaxis.set_major_locator(FixedLocator([0.1, 0.5, 1, 2, 10]))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.tick_params(labelsize=8)
