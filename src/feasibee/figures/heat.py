"""Heat maps of an arena: where robots were, which places they saw, and which opinions were where."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.figures.arena import draw_ground, frame_arena
from feasibee.figures.style import figure
from feasibee.model.codes import COLOURS
from feasibee.scenario.plan import Plan
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import STEPS_LIMIT, check_progress, check_scenario, check_span
from feasibee.simulation.snapshot import FLAGS
from feasibee.simulation.swarm import Swarm

BINS: Final = 50
"""Number of squares of a heat map along the longer side of the arena."""
COUNTED: Final = ("there", "working", "feasible", "neutral")
"""Flags of robots that are counted in each square."""
RUNS: Final = 20
EVERY: Final = 5
"""Number of steps between two looks at the robots."""


class Heat(NamedTuple):
    """Means over runs and steps, in squares; row 0 has the lowest y."""

    side: float
    """Side of a square, in units."""
    robots: NDArray[np.float64]
    """Number of robots per square unit: shape (rows, columns)."""
    sightings: NDArray[np.float64]
    """Number of robots in whose sight the centre of each square is: shape (rows, columns)."""
    feasible: NDArray[np.float64]
    """Share of the robots with an opinion that hold feasible, NaN where none were: shape (rows, columns)."""


def heat_of(
    scenario: Scenario,
    runs: int = RUNS,
    seed: int = 0,
    *,
    first: int = 0,
    steps: tuple[int, int] | None = None,
    every: int = EVERY,
    progress: Callable[[float], None] | None = None,
) -> Heat:
    """Measure where robots were, and which places they saw.

    Robots of one square stand for each other: their sight is that of one of them. A line of sight is looked
    at in steps of half a cell. Missed sightings aren't counted out.

    Parameters
    ----------
    scenario : Scenario
        The swarm's scenario.
    runs, seed, first : int
        Number of runs, their seed and the number of the first.
    steps : tuple of int, optional
        First and last step; by default all of the run.
    every : int
        Number of steps between two looks.
    progress : callable, optional
        Called with the share of the work done.

    Returns
    -------
    Heat
        Means over all runs and looks.

    Raises
    ------
    FeasibeeError
        If an argument is invalid.
    """
    scenario, which = check_scenario(scenario), Runs(runs, seed, first)
    check_progress(progress)
    last = scenario.run.steps
    start, end = (0, last) if steps is None else check_span("steps", steps, last, "run.steps")
    looks = range(start, end + 1, check_integer("every", every, 1, STEPS_LIMIT))
    return _measured(scenario, which, looks, progress or (lambda _: None))


def _measured(scenario: Scenario, which: Runs, looks: range, progress: Callable[[float], None]) -> Heat:
    """Return the means over runs and looks."""
    longer = max(scenario.arena.size)
    side = longer / BINS
    shape = tuple(max(1, math.ceil(each / side)) for each in reversed(scenario.arena.size))
    sums = np.zeros((len(COUNTED), shape[0] * shape[1]))
    places = np.full((sums.shape[1], 2), np.nan)
    bits = [FLAGS.index(name) for name in COUNTED]
    for number in range(which.count):
        swarm = Swarm(scenario, which.seed, which.first + number)
        for look in looks:
            swarm.advance(look - swarm.step)
            shown = swarm.snapshot()
            at = np.stack([shown.x, shown.y], axis=1) * (longer / 65_536)
            columns, rows = np.minimum((at / side).astype(np.int64), (shape[1] - 1, shape[0] - 1)).T
            squares = rows * shape[1] + columns
            sums += [np.bincount(squares, shown.flags >> bit & 1, len(places)) for bit in bits]
            places[squares] = at
        progress((number + 1) / which.count)
    there, working, feasible, neutral = sums.reshape(-1, *shape) / (which.count * len(looks))
    held = np.divide(feasible, there - neutral, out=np.full(shape, np.nan), where=there > neutral)
    return Heat(side, there / side**2, _seen(scenario, side, working, places.reshape(*shape, 2)), held)


def _seen(
    scenario: Scenario, side: float, robots: NDArray[np.float64], places: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how many robots see each square, from the number in each and the place of one of them."""
    reach, walled = scenario.sensing.range, scenario.arena.boundary == "walls"
    rows, columns = robots.nonzero()
    at, number, size = places[rows, columns], robots[rows, columns], np.array(scenario.arena.size)
    most, found = int(reach / side) + 1, np.zeros_like(robots)
    for dy in range(-most, most + 1):
        for dx in range(-most, most + 1):
            target = (np.stack([columns + dx, rows + dy], axis=1) + 0.5) * side
            near = ((target - at) ** 2).sum(axis=1) < reach**2
            near &= ((target >= 0) & (target < size)).all(axis=1) | (not walled)
            if scenario.plan is not None:
                near[near] = _are_free(scenario.plan, at[near], target[near])
            x, y = (target[near] % size / side).astype(np.int64).T
            np.add.at(found, (y, x), number[near])
    return found


def _are_free(plan: Plan, start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether lines between places, of shape (lines, 2), meet no wall."""
    cell = float(plan.cell)
    far = np.abs(end - start).max(initial=0.0)
    free, most = np.ones(len(start), bool), np.array(plan.walls.shape) - 1
    for part in np.linspace(0, 1, 2 * int(far / cell) + 3):
        columns, rows = ((start + part * (end - start)) / cell).astype(np.int64).T
        free &= ~plan.walls[np.minimum(rows, most[0]), np.minimum(columns, most[1])]
    return free


def plot_heat(scenario: Scenario, heat: Heat) -> Figure:
    """Draw heat maps over the plan of the scenario: robots, sightings, opinions."""
    width, height = scenario.arena.size
    opinions = LinearSegmentedColormap.from_list("", [COLOURS["infeasible"], "#DDDDDD", COLOURS["feasible"]])
    shown: list[tuple[NDArray[np.float64], Any, str, float | None]] = [
        (np.where(heat.robots > 0, heat.robots, np.nan), "Blues", "robots per square unit", None),
        (np.where(heat.sightings > 0, heat.sightings, np.nan), "Oranges", "robots that see the place", None),
        (100 * heat.feasible, opinions, "opinions feasible (%)", 100.0),
    ]
    with figure(9.6, min(6.0, max(1.6, 0.6 + 2.1 * height / width)), columns=3) as (drawn, axes):
        for ax, (values, colours, label, most) in zip(axes, shown, strict=True):
            extent = (0, heat.side * values.shape[1], 0, heat.side * values.shape[0])
            look: dict[str, Any] = {"cmap": colours, "vmin": 0, "vmax": most, "zorder": 0.4}
            image = ax.imshow(values, extent=extent, origin="lower", **look)
            draw_ground(ax, scenario)
            frame_arena(ax, scenario)
            drawn.colorbar(image, ax=ax, label=label)
        return drawn
