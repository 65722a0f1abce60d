"""Declarations of robots as figures."""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes

from feasibee.errors import FeasibeeError
from feasibee.figures.decisions import draw_shares_by_step, mark_median
from feasibee.figures.style import Look, axes_for
from feasibee.model.codes import COLOURS
from feasibee.model.outcomes import DECLARES, OUTCOMES
from feasibee.results.dataset import scenario_of
from feasibee.results.measures import declared_wrong
from feasibee.results.statistics import declare_times
from feasibee.scenario.feasibility import truth


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
    looks = {"rightly": Look(COLOURS[right_name]), "a robot wrongly": Look(COLOURS[wrong_name], dashes="--")}
    spoken = {"rightly": ~wrong, "a robot wrongly": wrong}
    taken = {name: declare_step[chosen & (declare_step >= 0)] for name, chosen in spoken.items()}
    with axes_for(ax, 3.6, 2.7) as axes:
        draw_shares_by_step(axes, taken, declare_step.size, steps, looks)
        mark_median(axes, declare_times(declare_step).median)
        axes.set_ylabel("runs that had declared (%)")
        return axes
