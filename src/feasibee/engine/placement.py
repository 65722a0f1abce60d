"""Placement of robots and tasks at the start (model.md 1.2, 1.3, 6.4)."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.cells import near
from feasibee.engine.compile import called, inlined
from feasibee.engine.draws import choose, draw, draw_words, shuffle
from feasibee.engine.layout import WORD, Clock, Point, Robot, Set
from feasibee.engine.params import Placement
from feasibee.model.codes import ATTEMPTS
from feasibee.model.purposes import (
    CENTRE_ROBOT,
    CENTRE_TASK,
    CLUSTER_ROBOT,
    CLUSTER_TASK,
    PLACE_ROBOT,
    PLACE_TASK,
    SCATTER_ROBOT,
    SCATTER_TASK,
    SITE,
)


@called
def scatter(params, state):
    """Place robots and tasks uniformly, on the fast path."""
    for i in range(params.tasks.count):
        x, y = anywhere(params, params.tasks.placement, state.clock[Clock.RUN], i, 0, PLACE_TASK)
        state.tasks[Point.X, i], state.tasks[Point.Y, i] = int32(uint32(x)), int32(uint32(y))
    for i in range(params.robots.count):
        x, y = anywhere(params, params.robots.placement, state.clock[Clock.RUN], i, 0, PLACE_ROBOT)
        state.robots[Robot.X, i], state.robots[Robot.Y, i] = int32(uint32(x)), int32(uint32(y))


@called
def place_tasks(params, state):
    """Place the tasks of the start, in the general engine."""
    for i in range(params.tasks.at_start):
        place_task(params, state, i)


@called
def place_task(params, state, i):
    """Place a task; one that appears later (model.md 6.17.4), at any of the given points."""
    if params.tasks.placement.how == Placement.POINTS:
        given = i
        if i >= params.tasks.at_start:
            given = choose(draw(params, state.clock[Clock.RUN], i, 0, PLACE_TASK), params.tasks.at_start)
        state.tasks[Point.X, i], state.tasks[Point.Y, i] = (
            state.tables.points[params.robots.at_start + given, 0],
            state.tables.points[params.robots.at_start + given, 1],
        )
    else:
        purposes = (int64(PLACE_TASK), int64(CENTRE_TASK), int64(CLUSTER_TASK), int64(SCATTER_TASK))
        x, y = candidate(
            params, params.tasks.placement, state.clock[Clock.RUN], i, int64(0), int64(0), purposes
        )
        state.tasks[Point.X, i], state.tasks[Point.Y, i] = int32(uint32(x)), int32(uint32(y))


@called
def place_robots(params, state):
    """Place the robots, in the general engine: apart if they avoid collisions, if need be on a lattice."""
    for i in range(params.robots.at_start):
        if params.robots.placement.how == Placement.POINTS:
            state.robots[Robot.X, i], state.robots[Robot.Y, i] = (
                state.tables.points[i, 0],
                state.tables.points[i, 1],
            )
        elif not place_robot(params, state, i):
            place_on_lattice(params, state)
            return


@called
def place_robot(params, state, i):
    """Draw a place for a robot until it is apart from those before it; return whether one was found."""
    purposes = (int64(PLACE_ROBOT), int64(CENTRE_ROBOT), int64(CLUSTER_ROBOT), int64(SCATTER_ROBOT))
    attempt, run = int64(0), state.clock[Clock.RUN]
    while attempt < ATTEMPTS:
        x, y = candidate(params, params.robots.placement, run, i, int64(0), attempt, purposes)
        state.robots[Robot.X, i], state.robots[Robot.Y, i] = int32(uint32(x)), int32(uint32(y))
        if not params.robots.avoid_collisions or is_apart(params, state, i):
            return True
        attempt += 1
    return False


@called
def place_joining(params, state, i):
    """Place a robot that joins clear of others; return whether a place was free (model.md 6.17.7)."""
    purposes = (int64(PLACE_ROBOT), int64(CENTRE_ROBOT), int64(CLUSTER_ROBOT), int64(SCATTER_ROBOT))
    run, joined = state.clock[Clock.RUN], int64(state.robots[Robot.JOINED, i])
    for attempt in range(ATTEMPTS):
        if params.robots.placement.how == Placement.POINTS:
            word = draw(params, run, i, ATTEMPTS * joined + attempt, PLACE_ROBOT)
            given = choose(word, params.robots.at_start)
            x, y = int64(state.tables.points[given, 0]), int64(state.tables.points[given, 1])
        else:
            x, y = candidate(params, params.robots.placement, run, i, joined, int64(attempt), purposes)
        state.robots[Robot.X, i], state.robots[Robot.Y, i] = int32(uint32(x)), int32(uint32(y))
        if not params.robots.avoid_collisions or is_free(params, state, i):
            return True
    return False


@inlined
def is_free(params, state, i):
    """Return whether a robot's disc overlaps none of the robots that are there."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    for w in range(state.sets.shape[1]):
        close = near(params, state.robots, WORD * w, WORD * (w + 1), x, y, params.robots.apart_limit)
        if close & state.sets[Set.THERE, w]:
            return False
    return True


@inlined
def is_apart(params, state, i):
    """Return whether a robot's disc overlaps none of the robots before it."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    first = 0
    while first < i:
        if near(params, state.robots, first, i, x, y, params.robots.apart_limit):
            return False
        first += 32
    return True


@called
def candidate(params, placing, run, i, joined, attempt, purposes):
    """Return the place drawn for a robot or task at an attempt; within walls, clipped to the arena.

    ``joined`` is the number of robots that had its number before it.
    """
    uniform, centre, cluster, scatter = purposes
    counter = ATTEMPTS * joined + attempt
    if placing.how == Placement.UNIFORM:
        return anywhere(params, placing, run, i, counter, uniform)
    chosen = choose(draw(params, run, i, joined, cluster), placing.clusters)
    x, y = anywhere(params, placing, run, chosen, int64(0), centre)
    spread = placing.spread * (1 + attempt // 32)  # wider after each 32 failed attempts
    dx = normal(params, run, i, 6 * counter, scatter, spread)
    dy = normal(params, run, i, 6 * counter + 3, scatter, spread)
    if params.arena.walls:
        low = placing.margin
        x = min(max(x + dx, low), params.arena.width - low)
        y = min(max(y + dy, low), params.arena.height - low)
    else:
        x, y = (x + dx) % params.arena.width, (y + dy) % params.arena.height
    return x, y


@called
def anywhere(params, placing, run, i, attempt, purpose):
    """Return a uniform place."""
    words = draw_words(params, run, i, attempt, purpose)
    low = placing.margin if params.arena.walls else 0
    return low + choose(words[0], params.arena.width - 2 * low), low + choose(
        words[1], params.arena.height - 2 * low
    )


@called
def normal(params, run, i, counter, purpose, scale):
    """Return a nearly normal deviate with standard deviation ``scale``.

    It is the sum of the twelve words of three draws, less its mean.
    """
    total = int64(0)
    for part in range(3):
        words = draw_words(params, run, i, counter + part, purpose)
        total += int64(words[0]) + int64(words[1]) + int64(words[2]) + int64(words[3])
    return (((total - 6 * 4294967296) >> 8) * scale) >> 24


@called
def place_on_lattice(params, state):
    """Place the robots on a square lattice over the whole arena, in random order."""
    step = 2 * params.robots.radius
    columns, rows = params.arena.width // step, params.arena.height // step
    shuffle(params, state.clock[Clock.RUN], state.robots[Robot.ORDER], params.robots.at_start, SITE)
    for i in range(params.robots.at_start):
        site = int64(state.robots[Robot.ORDER, i]) * (columns * rows) // params.robots.at_start
        state.robots[Robot.X, i] = int32(uint32(params.robots.radius + site % columns * step))
        state.robots[Robot.Y, i] = int32(uint32(params.robots.radius + site // columns * step))
