"""Heat maps of an arena: where robots were, and which places they saw, over the steps of some runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.figures.arena import draw_ground, frame_arena
from feasibee.figures.style import figure
from feasibee.scenario.plan import Plan
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import STEPS_LIMIT, check_progress, check_scenario, check_span
from feasibee.simulation.snapshot import FLAGS
from feasibee.simulation.swarm import Swarm

BINS: Final = 50
"""Number of squares of a heat map along the longer side of the arena."""
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
    start, end = (0, last) if steps is None else check_span("steps", steps)
    if end > last:
        rule = f"must end by step {last}, the run's last"
        raise FeasibeeError(f"steps = {start}:{end}: {rule}; lower it, or raise run.steps")
    looks = range(start, end + 1, check_integer("every", every, 1, STEPS_LIMIT))
    return _measured(scenario, which, looks, progress or (lambda _: None))


def _measured(scenario: Scenario, which: Runs, looks: range, progress: Callable[[float], None]) -> Heat:
    """Return the means over runs and looks."""
    longer = max(scenario.arena.size)
    side = longer / BINS
    shape = tuple(max(1, math.ceil(each / side)) for each in reversed(scenario.arena.size))
    counts, seeing = (np.zeros(shape[0] * shape[1]) for _ in range(2))
    places = np.full((counts.size, 2), np.nan)
    for number in range(which.count):
        swarm = Swarm(scenario, which.seed, which.first + number)
        for look in looks:
            swarm.advance(look - swarm.step)
            shown = swarm.snapshot()
            there, working = (shown.flags >> FLAGS.index(name) & 1 for name in ("there", "working"))
            at = np.stack([shown.x, shown.y], axis=1) * (longer / 65_536)
            columns, rows = np.minimum((at / side).astype(np.int64), (shape[1] - 1, shape[0] - 1)).T
            squares = rows * shape[1] + columns
            counts += np.bincount(squares, there, counts.size)
            seeing += np.bincount(squares, working, counts.size)
            places[squares] = at
        progress((number + 1) / which.count)
    total = which.count * len(looks)
    seen = _seen(scenario, side, seeing.reshape(shape) / total, places.reshape(*shape, 2))
    return Heat(side, counts.reshape(shape) / total / side**2, seen)


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
    """Draw heat maps over the plan of the scenario: robots on the left, sightings on the right."""
    width, height = scenario.arena.size
    with figure(7.2, min(6.0, max(1.6, 0.6 + 2.4 * height / width)), columns=2) as (drawn, axes):
        _panel(axes[0], scenario, heat.robots, heat.side, ("Blues", "robots per square unit"))
        _panel(axes[1], scenario, heat.sightings, heat.side, ("Oranges", "robots that see the place"))
        axes[1].set_ylabel("")
        return drawn


def _panel(
    ax: Axes, scenario: Scenario, values: NDArray[np.float64], side: float, look: tuple[str, str]
) -> None:
    """Draw one heat map with its scale; places without any are white."""
    rows, columns = values.shape
    shown: dict[str, Any] = {"extent": (0, side * columns, 0, side * rows), "origin": "lower", "zorder": 0.4}
    image = ax.imshow(np.where(values > 0, values, np.nan), cmap=look[0], vmin=0, **shown)
    draw_ground(ax, scenario)
    frame_arena(ax, scenario)
    assert ax.figure is not None
    ax.figure.colorbar(image, ax=ax, label=look[1])
