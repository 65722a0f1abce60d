"""Comparing places in 16 bits first: near and far are sure, and the rest is compared exactly."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from feasibee import Scenario
from feasibee.engine import intrinsics, sensing, tasklists
from feasibee.engine.cells import sort_into_cells
from feasibee.engine.layout import Link, Point, Robot, empty_state
from feasibee.engine.params import packed
from feasibee.simulation.lowering import lower

SIDE = 2**32


def swarm(changes):
    """Return parameters and an empty state."""
    lowered = lower(Scenario().replace(changes), 1)
    return packed(lowered.params), empty_state(lowered.params, lowered.tables, 64)


def scatter(params, state, generator):
    """Place robots and tasks: one other robot, and a task per robot, at the edge of the range of a robot.

    Only one, since a single distance in doubt makes the engine compare all of them exactly.
    """
    count, total = int(params.robots.count), int(params.tasks.count)
    robots, tasks = generator.integers(0, SIDE, (2, count)), generator.integers(0, SIDE, (2, total))
    reach, angle = int(params.sensing.limit) ** 0.5, generator.uniform(0, 2 * np.pi, count)
    edge = (reach * np.array([np.cos(angle), np.sin(angle)])).astype(np.int64)
    edge += generator.integers(-2, 3, edge.shape)
    robots[:, 1] = robots[:, 0] + edge[:, 0]
    tasks[:, :count] = robots + edge
    state.robots[[Robot.X, Robot.Y], :count] = as_int32(robots)
    state.tasks[[Point.X, Point.Y]] = as_int32(tasks)


def as_int32(numbers):
    return (numbers % SIDE).astype(np.uint32).view(np.int32)


def are_near(points, others, limit):
    """Return which points are within the limit of which others, exactly."""
    ways = (points[:, :, None] - others[:, None, :]).astype(np.int64)  # int32, so they wrap
    return (ways**2).sum(axis=0) < int(limit)


@njit(_nrt=False)
def find(xs, ys, sight, swarm, robots, reach):
    sensing.find_neighbours(xs, ys, sight, swarm, robots, reach)


@njit(_nrt=False)
def find_near(xs, ys, sight, count, low, width):
    return intrinsics.find_near(xs, ys, sight, count, low, width)


WORLDS = [
    {"tasks.count": 100},
    {"tasks.count": 300, "robots.count": 32},
    {"tasks.count": 100, "robots.count": 32, "sensing.range": 4.9},
    {"tasks.count": 100, "robots.count": 31, "sensing.range": 5.1},  # fewer than four cells a side: no lists
    {"tasks.count": 40, "robots.count": 6, "sensing.range": 10.0},
    {"tasks.count": 2000, "sensing.range": 0.01, "arena.side": 1000.0},  # about one unit of 16 bits
]


@pytest.mark.parametrize("changes", WORLDS)
def test_neighbours_are_exactly_those_in_range(changes):
    params, state = swarm(changes)
    count, generator = int(params.robots.count), np.random.default_rng(3)
    xs, ys, sight = state.robots[Robot.X], state.robots[Robot.Y], state.links[Link.SIGHT]
    for _ in range(100):
        scatter(params, state, generator)
        find(xs, ys, sight, np.uint32(2**count - 1), count, params.sensing)
        points = state.robots[[Robot.X, Robot.Y], :count]
        expected = are_near(points, points, params.sensing.limit) & ~np.eye(count, dtype=bool)
        assert sight[:count].tolist() == (expected << np.arange(count)).sum(axis=1).tolist()


@pytest.mark.parametrize("changes", WORLDS)
def test_counts_of_tasks_are_exact(changes):
    params, state = swarm(changes)
    generator = np.random.default_rng(3)
    for _ in range(10):
        scatter(params, state, generator)
        prepare(params, state)
        robots = state.robots[[Robot.X, Robot.Y], : params.robots.count]
        expected = are_near(robots, state.tasks[[Point.X, Point.Y]], params.sensing.limit).sum(axis=1)
        assert [tasklists.count_listed(params, state, x, y) for x, y in robots.T] == expected.tolist()


def prepare(params, state):
    """Sort the tasks into cells, and fill their lists."""
    xs, ys, count = state.tasks[Point.X], state.tasks[Point.Y], params.tasks.count
    grid, lists = params.tasks.grid, params.tasks.lists
    sort(state.task_cells, grid, xs, ys, state.tasks[Point.LABEL], count)
    if lists.bits > 0:
        tasklists.fill_lists(state.task_lists, lists.bits, lists.shift, params.sensing.limit, xs, ys, count)


@njit(_nrt=False)
def sort(cells, grid, xs, ys, labels, count):
    sort_into_cells(cells, grid, xs, ys, labels, count)


def test_most_steps_of_twenty_robots_need_no_exact_comparison():
    params, state = swarm({"tasks.count": 100})
    generator, band = np.random.default_rng(5), params.sensing.band
    xs, ys, sight = state.robots[Robot.X], state.robots[Robot.Y], state.links[Link.SIGHT]
    sure = 0
    for _ in range(1000):
        xs[:20], ys[:20] = as_int32(generator.integers(0, SIDE, (2, 20)))
        sure += find_near(xs, ys, sight, 20, band.low, band.width)
    assert sure > 970
