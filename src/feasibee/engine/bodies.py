"""Bodies: robots that go where their way is clear of walls and discs, robot by robot (model.md 6.1, 6.2).

Up to 32 robots do so at once: see `feasibee.engine.few_bodies`.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import bit, contains, has_bit, lowest_member, place_of, set_member, without_lowest
from feasibee.engine.cells import block, near, shortest
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.intrinsics import lowest
from feasibee.engine.layout import Point, Robot, Set
from feasibee.engine.motion import move_freely
from feasibee.engine.team import wait_for_all
from feasibee.model.codes import COS_EIGHTH


@spliced
def move_where_clear(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.2)."""
    if params.arena.wraps and not (params.arena.walls or params.robots.avoid_collisions):
        move_freely(state, part)  # stopped robots have speed 0
        return
    for w in range(part.first, part.last):
        blocked = uint32(0)
        left = state.sets[Set.WORKING, w]
        while left:
            i = lowest_member(w, left)
            if not is_clear(params, state, i):
                blocked |= bit(i)
                if params.robots.deflects:
                    set_member(state.sets, Set.TURNING_LEFT, i, turns_left(params, state, i))
            left = without_lowest(left)
        state.sets[Set.BLOCKED, w] = blocked
    wait_for_all(part)
    if params.robots.deflects:
        deflect(params, state, part)
    for w in range(part.first, part.last):
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
    if is_beyond_walls(params, state.robots, i):
        return False
    if not params.robots.avoid_collisions:
        return True
    first, last, other_first, other_last = block(
        state.robot_cells, params.robots.grid, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    )
    return is_clear_of(params, state, i, first, last) and is_clear_of(
        params, state, i, other_first, other_last
    )


@inlined
def is_beyond_walls(params, robots, i):
    """Return whether a robot's step leads beyond a wall."""
    x = int64(uint32(robots[Robot.X, i])) + int64(robots[Robot.STEP_X, i])
    y = int64(uint32(robots[Robot.Y, i])) + int64(robots[Robot.STEP_Y, i])
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    return params.arena.walls & ((x < low) | (y < low) | (x > right) | (y > top))


@called
def is_clear_of(params, state, i, first, last):
    """Return whether a robot's step keeps clear of the robots in a stretch of the cells."""
    points, x, y = state.robot_cells.points, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    while first < last:
        close = near(params, points, first, last, x, y, params.robots.meet_limit)
        while close:
            other = place_of(points[Point.NUMBER, first + lowest(close)])
            if other != i and collide(params, state, i, other):
                return False
            close = without_lowest(close)
        first += 32
    return True


@inlined
def collide(params, state, i, other):
    """Return whether a moving robot meets another, which may move too or stay."""
    way_x, way_y = way_between(params, state.robots, i, other)
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


@inlined
def way_between(params, robots, i, j):
    """Return the way from a robot to another, along x and y."""
    way_x = int64(uint32(robots[Robot.X, j])) - int64(uint32(robots[Robot.X, i]))
    way_y = int64(uint32(robots[Robot.Y, j])) - int64(uint32(robots[Robot.Y, i]))
    if params.arena.walls:
        return way_x, way_y
    return shortest(way_x, params.arena.width), shortest(way_y, params.arena.height)


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


@spliced
def deflect(params, state, part):
    """Let the blocked robots turn away twice, as long as they are blocked (model.md 6.2.2 to 6.2.5)."""
    sets = state.sets
    for _ in range(2):
        for w in range(part.first, part.last):
            left = sets[Set.BLOCKED, w]
            while left:
                turn_away(state.robots, sets[Set.TURNING_LEFT, w], lowest_member(w, left))
                left = without_lowest(left)
        wait_for_all(part)
        for w in range(part.first, part.last):
            cleared = uint32(0)
            left = sets[Set.BLOCKED, w]
            while left:
                i = lowest_member(w, left)
                if is_way_clear(params, state, i):
                    cleared |= bit(i)
                left = without_lowest(left)
            sets[Set.CLEARED, w] = cleared
        wait_for_all(part)
        for w in range(part.first, part.last):
            sets[Set.BLOCKED, w] &= ~sets[Set.CLEARED, w]


@inlined
def turn_away(robots, turning_left, i):
    """Turn a robot's step by an eighth of a turn; ``turning_left`` is its word of the set."""
    u, v = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    side = 2 * int64(has_bit(turning_left, i)) - 1  # without a branch
    robots[Robot.STEP_X, i] = int32(shortened(u - side * v))
    robots[Robot.STEP_Y, i] = int32(shortened(v + side * u))


@inlined
def shortened(length):
    """Return a length times the cosine of an eighth of a turn, rounded towards 0."""
    return (length * int64(COS_EIGHTH) + ((length >> 63) & 0xFFFFFFFF)) >> 32


@called
def turns_left(params, state, i):
    """Return whether a blocked robot turns left: unless all that blocks it lies left of its heading."""
    on_left, on_right = walls_beside(params, state.robots, i)
    stretches = block(
        state.robot_cells, params.robots.grid, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    )
    first, last, other_first, other_last = stretches
    some_left, some_right = robots_beside(params, state, i, first, last)
    others_left, others_right = robots_beside(params, state, i, other_first, other_last)
    return on_right or some_right or others_right or not (on_left or some_left or others_left)


@called
def walls_beside(params, robots, i):
    """Return whether a robot's step leads beyond a wall left of its heading, and right of it."""
    if not params.arena.walls:
        return False, False
    u, v = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    x, y = int64(uint32(robots[Robot.X, i])) + u, int64(uint32(robots[Robot.Y, i])) + v
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    west, east, south, north = x < low, x > right, y < low, y > top
    on_left = (east & (v < 0)) | (west & (v > 0)) | (north & (u > 0)) | (south & (u < 0))
    on_right = (east & (v > 0)) | (west & (v < 0)) | (north & (u < 0)) | (south & (u > 0))
    return on_left, on_right


@called
def robots_beside(params, state, i, first, last):
    """Return whether robots of a stretch block a robot left of its heading, and right of it."""
    points, x, y = state.robot_cells.points, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    u, v = int64(state.robots[Robot.STEP_X, i]), int64(state.robots[Robot.STEP_Y, i])
    on_left = on_right = False
    while first < last:
        close = near(params, points, first, last, x, y, params.robots.meet_limit)
        while close:
            other = place_of(points[Point.NUMBER, first + lowest(close)])
            if other != i and collide(params, state, i, other):
                way_x, way_y = way_between(params, state.robots, i, other)
                side = u * way_y - v * way_x
                on_left |= side > 0
                on_right |= side < 0
            close = without_lowest(close)
        first += 32
    return on_left, on_right


@inlined
def is_way_clear(params, state, i):
    """Return whether a blocked robot's new step is clear, whatever the other blocked robots do."""
    if is_beyond_walls(params, state.robots, i):
        return False
    first, last, other_first, other_last = block(
        state.robot_cells, params.robots.grid, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    )
    return is_way_clear_of(params, state, i, first, last) and is_way_clear_of(
        params, state, i, other_first, other_last
    )


@called
def is_way_clear_of(params, state, i, first, last):
    """Return whether a blocked robot's new step is clear of the robots in a stretch of the cells."""
    points, x, y = state.robot_cells.points, state.robots[Robot.X, i], state.robots[Robot.Y, i]
    dx, dy = -int64(state.robots[Robot.STEP_X, i]), -int64(state.robots[Robot.STEP_Y, i])
    while first < last:
        close = near(params, points, first, last, x, y, params.robots.meet_limit)
        while close:
            other = place_of(points[Point.NUMBER, first + lowest(close)])
            close = without_lowest(close)
            if other == i:
                continue
            way_x, way_y = way_between(params, state.robots, i, other)
            if contains(state.sets[Set.BLOCKED], other) and meet(params, way_x, way_y, dx, dy):
                return False
            both_x = dx + int64(state.robots[Robot.STEP_X, other])
            both_y = dy + int64(state.robots[Robot.STEP_Y, other])
            if meet(params, way_x, way_y, both_x, both_y):
                return False
        first += 32
    return True
