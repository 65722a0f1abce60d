"""Bodies: robots that go where their way is clear of walls and discs, robot by robot (model.md 6.1, 6.2).

Up to 32 robots do so at once: see `feasibee.engine.few_bodies`.
"""

from __future__ import annotations

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.bits import bit_if, contains, has_bit, lowest_member, place_of, without_lowest
from feasibee.engine.cells import are_few, block, few_near, near, shortest
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.intrinsics import LANES, lowest
from feasibee.engine.layout import WORD, Point, Robot, Set
from feasibee.engine.motion import move_freely
from feasibee.engine.team import wait_for_all
from feasibee.model.codes import COS_EIGHTH

SURELY = 1e-14
"""More than the relative error of a product of four numbers, each rounded once."""


@spliced
def move_where_clear(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.2)."""
    if params.arena.wraps and not (params.arena.walls or params.robots.avoid_collisions):
        move_freely(state, part)  # stopped robots have speed 0
        return
    sets = state.sets
    for w in range(part.first, part.last):
        blocked, turning_left, left = uint32(0), uint32(0), sets[Set.WORKING, w]
        while left:
            i = lowest_member(w, left)
            is_blocked, on_left, on_right = find_obstacles(params, state, i, True)
            blocked |= bit_if(is_blocked, i)
            turning_left |= bit_if(on_right | (not on_left), i)
            left = without_lowest(left)
        sets[Set.BLOCKED, w], sets[Set.TURNING_LEFT, w] = blocked, turning_left
    wait_for_all(part)
    if params.robots.deflects:
        deflect(params, state, part)
    for w in range(part.first, part.last):
        left = uint32(sets[Set.WORKING, w] & ~sets[Set.BLOCKED, w])
        while left:
            i = lowest_member(w, left)
            x, y = destination(params, state, i)
            state.robots[Robot.X, i], state.robots[Robot.Y, i] = int32(uint32(x)), int32(uint32(y))
            left = without_lowest(left)


@spliced
def deflect(params, state, part):
    """Let the blocked robots turn away twice, as long as they are blocked (model.md 6.2.2 to 6.2.5)."""
    sets, steps_x, steps_y = state.sets, state.robots[Robot.STEP_X], state.robots[Robot.STEP_Y]
    for _ in range(2):
        for w in range(part.first, part.last):
            left = sets[Set.BLOCKED, w]
            while left:
                i = lowest_member(w, left)
                steps_x[i], steps_y[i] = turned(steps_x[i], steps_y[i], has_bit(sets[Set.TURNING_LEFT, w], i))
                left = without_lowest(left)
        wait_for_all(part)
        for w in range(part.first, part.last):
            cleared, left = uint32(0), sets[Set.BLOCKED, w]
            while left:
                i = lowest_member(w, left)
                is_blocked, _, _ = find_obstacles(params, state, i, False)
                cleared |= bit_if(not is_blocked, i)
                left = without_lowest(left)
            sets[Set.CLEARED, w] = cleared
        wait_for_all(part)
        for w in range(part.first, part.last):
            sets[Set.BLOCKED, w] &= ~sets[Set.CLEARED, w]


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


@called
def find_obstacles(params, state, i, at_first):
    """Return whether walls or robots block a robot's step, and whether some do on its left and right.

    Another robot moves, or may stay: ``at_first`` any, later the blocked ones. Sides are found at first, and
    only if robots deflect; otherwise the search ends with the first obstacle.
    """
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    u, v = int64(state.robots[Robot.STEP_X, i]), int64(state.robots[Robot.STEP_Y, i])
    left, right = walls_beside(params, int64(uint32(x)), int64(uint32(y)), u, v)
    found = is_beyond_walls(params, state.robots, i), left, right
    needs_all = at_first and params.robots.deflects
    if not params.robots.avoid_collisions or (found[0] and not needs_all):
        return found
    points, limit = state.robot_cells.points, params.robots.meet_limit
    first, last, other_first, other_last = block(state.robot_cells, params.robots.grid, x, y)
    if are_few(first, last, other_first, other_last):
        close = few_near(params, points, first, last, x, y, limit)
        close |= few_near(params, points, other_first, other_last, x, y, limit) << uint32(LANES)
        return find_robots(params, state, i, at_first, close, first, other_first - LANES, found)
    for _ in range(2):
        while first < last and (needs_all or not found[0]):
            close = near(params, points, first, last, x, y, limit)
            found = find_robots(params, state, i, at_first, close, first, first, found)
            first += WORD
        first, last = other_first, other_last
    return found


@inlined
def find_robots(params, state, i, at_first, close, first, second, found):
    """Return what `find_obstacles` returns, of robots of its cells.

    These are the members of ``close``: the first 8 counted from ``first`` on, the others from ``second``.
    """
    blocked, left, right = found
    u, v = int64(state.robots[Robot.STEP_X, i]), int64(state.robots[Robot.STEP_Y, i])
    while close:
        place = lowest(close)
        close = without_lowest(close)
        other = place_of(state.robot_cells.points[Point.NUMBER, place + (first if place < LANES else second)])
        if other == i:
            continue
        way_x, way_y = way_between(params, state.robots, i, other)
        both_x = int64(state.robots[Robot.STEP_X, other]) - u
        both_y = int64(state.robots[Robot.STEP_Y, other]) - v
        met = meets_within(params, way_x, way_y, both_x, both_y)
        if at_first or contains(state.sets[Set.BLOCKED], other):
            met |= meets_within(params, way_x, way_y, -u, -v)
        blocked |= met
        if not (at_first and params.robots.deflects):
            if blocked:
                break
            continue
        left |= met & (u * way_y - v * way_x > 0)
        right |= met & (u * way_y - v * way_x < 0)
    return blocked, left, right


@inlined
def is_beyond_walls(params, robots, i):
    """Return whether a robot's step leads beyond a wall."""
    x = int64(uint32(robots[Robot.X, i])) + int64(robots[Robot.STEP_X, i])
    y = int64(uint32(robots[Robot.Y, i])) + int64(robots[Robot.STEP_Y, i])
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    return params.arena.walls & ((x < low) | (y < low) | (x > right) | (y > top))


@inlined
def walls_beside(params, x, y, u, v):
    """Return whether a step leads beyond a wall left of its heading, and right of it."""
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    west, east, south, north = x + u < low, x + u > right, y + v < low, y + v > top
    on_left = (east & (v < 0)) | (west & (v > 0)) | (north & (u > 0)) | (south & (u < 0))
    on_right = (east & (v > 0)) | (west & (v < 0)) | (north & (u < 0)) | (south & (u > 0))
    return params.arena.walls & on_left, params.arena.walls & on_right


@inlined
def way_between(params, robots, i, j):
    """Return the way from a robot to another, along x and y."""
    way_x = int64(uint32(robots[Robot.X, j])) - int64(uint32(robots[Robot.X, i]))
    way_y = int64(uint32(robots[Robot.Y, j])) - int64(uint32(robots[Robot.Y, i]))
    if params.arena.walls:
        return way_x, way_y
    return shortest(way_x, params.arena.width), shortest(way_y, params.arena.height)


@inlined
def meets_within(params, way_x, way_y, dx, dy):
    """Return what `meet` returns, without a branch unless floats leave it in doubt."""
    limit, apart, length = int64(params.robots.apart_limit), way_x * way_x + way_y * way_y, dx * dx + dy * dy
    met, sure = meets(limit, apart, way_x * dx + way_y * dy, way_x * dy - way_y * dx, length)
    return met if sure else meet(params, way_x, way_y, dx, dy)


@inlined
def meets(limit, apart, along, across, length):
    """Return whether two discs overlap at some moment of a step, as `meet` does, and whether that is sure.

    The squared distance is ``apart`` at the start and ``apart + 2 along + length`` at the end.
    """
    passes = (along < 0) & (-along < length)
    at_ends = apart + (int64(0) if along >= 0 else 2 * along + length) < limit
    squared, least = float64(across) * float64(across), float64(limit) * float64(length)
    sure = (abs(squared - least) > SURELY * least) | (not passes)
    return (passes & (squared < least)) | ((not passes) & at_ends), sure


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
def turned(u, v, left):
    """Return a step turned by an eighth of a turn."""
    u, v, side = int64(u), int64(v), 2 * int64(left) - 1  # without a branch
    return int32(shortened(u - side * v)), int32(shortened(v + side * u))


@inlined
def shortened(length):
    """Return a length times the cosine of an eighth of a turn, rounded towards 0."""
    return (length * int64(COS_EIGHTH) + ((length >> 63) & 0xFFFFFFFF)) >> 32
