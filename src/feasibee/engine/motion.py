"""Motion: straight runs of exponential duration, uniform headings, bodies (model.md 2, 6.1, 6.2)."""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import (
    bit,
    bit_if,
    contains,
    lowest_member,
    sender_of,
    without_lowest,
)
from feasibee.engine.cells import block, near, shortest
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.intrinsics import lowest
from feasibee.engine.layout import Point, Robot, Set
from feasibee.engine.pools import draw_heading


@inlined
def move_freely(state):
    """Move all robots one step on a square torus, through each other (model.md 3.1)."""
    xs, ys = state.robots[Robot.X], state.robots[Robot.Y]
    steps_x, steps_y = state.robots[Robot.STEP_X], state.robots[Robot.STEP_Y]
    for w in range(state.sets.shape[1]):
        base = uint64(32 * w)
        for j in range(32):
            i = uint64(base + j)
            xs[i] += steps_x[i]
            ys[i] += steps_y[i]


@inlined
def tick(state):
    """Advance the timers; store whose heading and whose phase end with this step (model.md 3.3)."""
    walks_left, phases_left = state.robots[Robot.WALK_LEFT], state.robots[Robot.PHASE_LEFT]
    for w in range(state.sets.shape[1]):
        turning = uint32(0)
        ending = uint32(0)
        base = uint64(32 * w)
        for j in range(32):
            i = uint64(base + j)
            walk_left = int32(walks_left[i] - int32(1))
            phase_left = int32(phases_left[i] - int32(1))
            walks_left[i] = walk_left
            phases_left[i] = phase_left
            turning |= bit_if(walk_left == int32(0), j)
            ending |= bit_if(phase_left == int32(0), j)
        state.sets[Set.TURNING, w] = turning | state.sets[Set.BLOCKED, w]
        state.sets[Set.ENDING, w] = ending


@spliced
def move_where_clear(params, state):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.2)."""
    if params.arena.wraps and not (params.arena.walls or params.robots.avoid_collisions):
        move_freely(state)  # stopped robots have speed 0
        return
    for w in range(state.sets.shape[1]):
        blocked = uint32(0)
        left = state.sets[Set.WORKING, w]
        while left:
            i = lowest_member(w, left)
            if not is_clear(params, state, i):
                blocked |= bit(i)
            left = without_lowest(left)
        state.sets[Set.BLOCKED, w] = blocked
    for w in range(state.sets.shape[1]):
        left = uint32(state.sets[Set.WORKING, w] & ~state.sets[Set.BLOCKED, w])
        while left:
            i = lowest_member(w, left)
            x, y = destination(params, state, i)
            state.robots[Robot.X, i], state.robots[Robot.Y, i] = int32(uint32(x)), int32(uint32(y))
            left = without_lowest(left)


@inlined
def destination(params, state, i):
    """Return where a robot's step leads: on the torus, or possibly beyond a wall."""
    x = int64(uint32(state.robots[Robot.X, i])) + int64(state.robots[Robot.STEP_X, i])
    y = int64(uint32(state.robots[Robot.Y, i])) + int64(state.robots[Robot.STEP_Y, i])
    if not params.arena.walls:
        x, y = around(x, params.arena.width), around(y, params.arena.height)
    return x, y


@inlined
def around(coordinate, side):
    """Return a coordinate less than a side off the torus, wrapped onto it."""
    if coordinate < 0:
        coordinate += side
    if coordinate >= side:
        coordinate -= side
    return coordinate


@inlined
def is_clear(params, state, i):
    """Return whether a robot's step keeps its disc clear of walls and of all other robots."""
    if params.arena.walls:
        x, y = destination(params, state, i)
        margin = params.robots.radius
        if x < margin or y < margin or x > params.arena.width - margin or y > params.arena.height - margin:
            return False
    if not params.robots.avoid_collisions:
        return True
    first, last = block(
        state.robot_cells, params.robots.grid, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    )
    return is_clear_of(params, state, i, first, last)


@called
def is_clear_of(params, state, i, first, last):
    """Return whether a robot's step keeps clear of the robots in a stretch of the cells."""
    points, x, y = state.robot_cells.points, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    while first < last:
        close = near(params, points, first, last, x, y, params.robots.meet_limit)
        while close:
            other = sender_of(points[Point.LABEL, first + lowest(close)])
            if other != i and collide(params, state, i, other):
                return False
            close = without_lowest(close)
        first += 32
    return True


@inlined
def collide(params, state, i, other):
    """Return whether a moving robot meets another, which may move too or stay."""
    way_x = int64(uint32(state.robots[Robot.X, other])) - int64(uint32(state.robots[Robot.X, i]))
    way_y = int64(uint32(state.robots[Robot.Y, other])) - int64(uint32(state.robots[Robot.Y, i]))
    if not params.arena.walls:
        way_x, way_y = shortest(way_x, params.arena.width), shortest(way_y, params.arena.height)
    dx, dy = -int64(state.robots[Robot.STEP_X, i]), -int64(state.robots[Robot.STEP_Y, i])
    if meet(params, way_x, way_y, dx, dy):
        return True
    return contains(state.sets[Set.WORKING], other) and meet(
        params,
        way_x,
        way_y,
        dx + int64(state.robots[Robot.STEP_X, other]),
        dy + int64(state.robots[Robot.STEP_Y, other]),
    )


@called
def meet(params, way_x, way_y, dx, dy):
    """Return whether two discs overlap at some moment of a step, exactly.

    ``way`` is the difference of their places at the start, ``d`` that of their steps.
    """
    along = way_x * dx + way_y * dy
    length = dx * dx + dy * dy
    if along >= 0:  # the distance grows
        return uint64(way_x * way_x + way_y * way_y) < params.robots.apart_limit
    if -along >= length:  # the distance shrinks until the end
        end_x, end_y = way_x + dx, way_y + dy
        return uint64(end_x * end_x + end_y * end_y) < params.robots.apart_limit
    across = uint64(abs(way_x * dy - way_y * dx))  # the least distance is within the step
    high, low = product(across, across)
    least_high, least_low = product(params.robots.apart_limit, uint64(length))
    return high < least_high or (high == least_high and low < least_low)


@called
def product(a, b):
    """Return the high and low 64 bits of the product of two 64-bit words."""
    mask = uint64(0xFFFFFFFF)
    a0, a1, b0, b1 = a & mask, a >> uint64(32), b & mask, b >> uint64(32)
    low = a0 * b0
    middle = a1 * b0 + (low >> uint64(32))
    other = a0 * b1 + (middle & mask)
    return a1 * b1 + (middle >> uint64(32)) + (other >> uint64(32)), (other << uint64(32)) | (low & mask)


@inlined
def turn(params, state):
    """Draw a new heading for each robot whose straight run has ended."""
    for w in range(state.sets.shape[1]):
        left = state.sets[Set.TURNING, w]
        while left:
            head(params, state, lowest_member(w, left))
            left = without_lowest(left)


@inlined
def head(params, state, i):
    """Draw a robot's next heading and its duration (model.md 2.1)."""
    step_x, step_y, lasts = draw_heading(params, state, i, int64(state.robots[Robot.WALKS, i]))
    state.robots[Robot.WALKS, i] += int32(1)
    state.robots[Robot.STEP_X, i] = step_x
    state.robots[Robot.STEP_Y, i] = step_y
    state.robots[Robot.WALK_LEFT, i] = lasts
