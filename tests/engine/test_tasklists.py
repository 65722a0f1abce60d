"""Comparing places in 16 bits first: near and far are sure, and the rest is compared exactly."""

from __future__ import annotations

import numpy as np
import pytest
from numba import types

from feasibee import Scenario
from feasibee.engine import few, sensing, starting
from feasibee.engine.compile import entry
from feasibee.engine.intrinsics import find_near
from feasibee.engine.layout import Link, Point, Robot, empty_state, first_room
from feasibee.engine.params import packed
from feasibee.engine.signatures import PARAMS, PART, STATE
from feasibee.engine.team import parts_of
from feasibee.simulation.lowering import lower
from feasibee.simulation.snapshot import members

SIDE = 2**32


def swarm(changes):
    """Return parameters, an empty state, and the part of its one thread."""
    lowered = lower(Scenario().replace(changes), 1)
    state = empty_state(lowered.params, lowered.tables, first_room(lowered.params))
    return packed(lowered.params), state, *parts_of(lowered.params)


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
    state.tasks_there[:] = 2**32 - 1


def as_int32(numbers):
    return (numbers % SIDE).astype(np.uint32).view(np.int32)


def are_near(points, others, limit):
    """Return which points are within the limit of which others, exactly."""
    ways = (points[:, :, None] - others[:, None, :]).astype(np.int64)  # int32, so they wrap
    return (ways**2).sum(axis=0) < int(limit)


@entry(types.void(PARAMS, STATE, PART))
def find(params, state, part):
    few.find_sight(params, state, params.sensing, part)


@entry(types.boolean(PARAMS, STATE))
def is_sure(params, state):
    xs, ys, sight, band = (
        state.robots[Robot.X],
        state.robots[Robot.Y],
        state.links[Link.SIGHT, 0],
        params.sensing.band,
    )
    return find_near(xs, ys, sight, 0, 0, params.robots.count, band.low, band.width)


@entry(types.void(PARAMS, STATE))
def prepare(params, state):
    starting.sort_tasks(params, state)


@entry(types.int64(PARAMS, STATE, types.int32, types.int32))
def count_listed(params, state, x, y):
    return sensing.count_listed(params, state, x, y)


WORLDS = [
    {"tasks.count": 100},
    {"tasks.count": 300, "robots.count": 32},
    {"tasks.count": 100, "robots.count": 32, "sensing.range": 4.9},
    {"tasks.count": 100, "robots.count": 33},
    {"tasks.count": 200, "robots.count": 128, "sensing.range": 4.9},
    {"tasks.count": 100, "robots.count": 31, "sensing.range": 5.1},  # fewer than four cells a side: no lists
    {"tasks.count": 40, "robots.count": 6, "sensing.range": 10.0},
    {"tasks.count": 2000, "sensing.range": 0.01, "arena.side": 1000.0},  # about one unit of 16 bits
]


@pytest.mark.parametrize("changes", WORLDS)
def test_neighbours_are_exactly_those_in_range(changes):
    params, state, part = swarm(changes)
    count, generator = int(params.robots.count), np.random.default_rng(3)
    sight = state.links[Link.SIGHT]
    for _ in range(100):
        scatter(params, state, generator)
        find(params, state, part)
        points = state.robots[[Robot.X, Robot.Y], :count]
        expected = are_near(points, points, params.sensing.limit) & ~np.eye(count, dtype=bool)
        assert [members(words.copy())[:count].tolist() for words in sight.T[:count]] == expected.tolist()


@pytest.mark.parametrize("changes", WORLDS)
def test_counts_of_tasks_are_exact(changes):
    params, state, _ = swarm(changes)
    generator = np.random.default_rng(3)
    for _ in range(10):
        scatter(params, state, generator)
        prepare(params, state)
        robots = state.robots[[Robot.X, Robot.Y], : params.robots.count]
        expected = are_near(robots, state.tasks[[Point.X, Point.Y]], params.sensing.limit).sum(axis=1)
        assert [count_listed(params, state, x, y) for x, y in robots.T] == expected.tolist()


def test_most_steps_of_twenty_robots_need_no_exact_comparison():
    params, state, _ = swarm({"tasks.count": 100})
    generator, sure = np.random.default_rng(5), 0
    xs, ys = state.robots[Robot.X], state.robots[Robot.Y]
    for _ in range(1000):
        xs[:20], ys[:20] = as_int32(generator.integers(0, SIDE, (2, 20)))
        sure += is_sure(params, state)
    assert sure > 970
