"""Sensitivity of right decisions to fields: rank correlations over a Latin hypercube."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.figures.style import GREY, PALETTE, figure
from feasibee.results.statistics import Interval
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.studies.objectives import objective_for, scored
from feasibee.studies.space import Dimension
from feasibee.sweeps.plan import DesignPoint
from feasibee.sweeps.sweep import Execution, Rounds

RESAMPLES = 2000


@dataclass(frozen=True)
class Sensitivity:
    """Rank correlation of a field with the share of right swarms.

    Parameters
    ----------
    path : str
        The field.
    correlation : Interval
        Spearman's correlation over the points, -1 to 1, with its 95 % interval (bootstrap).
    """

    path: str
    correlation: Interval

    @property
    def matters(self) -> bool:
        """Whether the interval of the correlation excludes 0."""
        return self.correlation.low > 0 or self.correlation.high < 0


def sensitivities(
    scenario: Scenario,
    space: Sequence[Dimension],
    points: int = 200,
    runs: int = 20,
    seed: int = 0,
    execution: Execution | None = None,
) -> tuple[list[Sensitivity], NDArray[np.float64], NDArray[np.float64]]:
    """Vary all fields at once; correlate each with the share of right swarms.

    Parameters
    ----------
    scenario : Scenario
        What all points have in common.
    space : sequence of Dimension
        Fields to vary.
    points : int
        Number of points of the Latin hypercube.
    runs : int
        Number of runs at each point.
    seed : int
        Seed of the hypercube and of the runs.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Returns
    -------
    list of Sensitivity
        The strongest first.
    float64 array, shape (points, fields)
        Place of each point in each field, as a share of the way from its low end to its high end.
    float64 array, shape (points,)
        Share of swarms that are right at the last step, at each point; in a world that changes, share of
        steps at which they are right.
    """
    Runs(points * runs, seed)  # raises before anything is computed
    places = latin_hypercube(points, len(space), seed)
    designs = [_design(scenario, space, place, number * runs) for number, place in enumerate(places)]
    with Rounds(execution, points * runs) as rounds:
        found_runs = scored(rounds, designs, runs, seed, objective_for(scenario))
        shares = np.array([each.values.mean() for each in found_runs])
    found = [
        Sensitivity(each.path, spearman(places[:, column], shares, seed)) for column, each in enumerate(space)
    ]
    return sorted(found, key=lambda each: -abs(each.correlation.estimate)), places, shares


def _design(
    scenario: Scenario, space: Sequence[Dimension], place: NDArray[np.float64], first_run: int
) -> DesignPoint:
    values = {each.path: each.at(float(share)) for each, share in zip(space, place, strict=True)}
    changed = scenario.replace({**values, "run.stop_at_decision": False})
    return DesignPoint(values, changed, first_run)


def latin_hypercube(points: int, dimensions: int, seed: int) -> NDArray[np.float64]:
    """Return points in the unit cube: each axis has as many slices as points, and each slice one point.

    References
    ----------
    McKay, Beckman, Conover, "A comparison of three methods for selecting values of input variables", 1979.
    """
    random = np.random.default_rng(seed)
    slices = np.stack([random.permutation(points) for _ in range(dimensions)], axis=1)
    places: NDArray[np.float64] = (slices + random.random((points, dimensions))) / points
    return places


def spearman(one: NDArray[np.float64], other: NDArray[np.float64], seed: int) -> Interval:
    """Return the rank correlation of two quantities with a bootstrap interval; 0 if one is constant."""
    random = np.random.default_rng(seed)
    drawn = random.integers(0, one.size, (RESAMPLES, one.size))
    resampled = np.array([_correlation(one[rows], other[rows]) for rows in drawn])
    low, high = np.quantile(resampled, (0.025, 0.975))
    return Interval(_correlation(one, other), float(low), float(high))


def _correlation(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    first, second = (_ranks(each) for each in (one, other))
    first, second = first - first.mean(), second - second.mean()
    scale = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return float((first * second).sum() / scale) if scale > 0 else 0.0


def _ranks(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ranks; equal values share their mean."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    ranks: NDArray[np.float64] = (last - (counts - 1) / 2)[inverse]
    return ranks


def draw_sensitivities(found: Sequence[Sensitivity]) -> Figure:
    """Draw each field's correlation with its interval, the strongest on top; grey if it may be 0."""
    with figure(5.0, 1.0 + 0.28 * len(found)) as (drawn, ax):
        rows = np.arange(len(found))[::-1]
        ax.axvline(0, color="0.8", linewidth=0.8, zorder=0)
        for row, each in zip(rows, found, strict=True):
            middle, low, high = each.correlation
            colour = PALETTE[0] if each.matters else GREY
            ax.errorbar(
                middle, row, xerr=[[middle - low], [high - middle]], fmt="o", color=colour, markersize=4
            )
        ax.set_yticks(rows, [each.path for each in found])
        ax.set(xlim=(-1, 1), ylim=(-0.6, len(found) - 0.4), xlabel="rank correlation with right decisions")
    return drawn
