"""Bodies: robots that go where their way is clear of walls and discs, word by word (model.md 6.1, 6.2).

The robots near those of a word are queued, and all of these pairs tested together. Up to 128 robots need
fewer pairs: see `feasibee.engine.few`.
"""

from __future__ import annotations

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.cells import shortest
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.crowd import queue_near
from feasibee.engine.intrinsics import bit_if, contains, has_bit, lowest_member, place_of, without_lowest
from feasibee.engine.layout import HEARD_ROOM, WORD, Heard, Robot, Set
from feasibee.engine.motion import move_freely, shortened
from feasibee.engine.place import find_blocked_by_place, find_place_beside
from feasibee.engine.team import wait_for_all

SURELY = 1e-14
"""More than the relative error of a product of four numbers, each rounded once."""
TOGETHER = 4
"""Pairs that are tested together; lists are filled up to a multiple."""


@spliced
def move_where_clear(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.2)."""
    if params.arena.wraps and not (params.arena.walls or params.robots.avoid_collisions):
        move_freely(state, part)  # stopped robots have speed 0
        return
    sets = state.sets
    for w in range(part.first, part.last):
        blocked, left, right = find_blocked(params, state, part, w, sets[Set.WORKING, w], True)
        if params.robots.deflects:
            wall_left, wall_right = find_walls_beside(params, state, blocked, w)
            sets[Set.TURNING_LEFT, w] = right | wall_right | ~(left | wall_left)
        sets[Set.BLOCKED, w] = blocked
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
    sets = state.sets
    for _ in range(2):
        for w in range(part.first, part.last):
            turn_away(state.robots, sets[Set.TURNING_LEFT, w], sets[Set.BLOCKED, w], w)
        wait_for_all(part)
        for w in range(part.first, part.last):
            tried = sets[Set.BLOCKED, w]
            still, _, _ = find_blocked(params, state, part, w, tried, False)
            sets[Set.CLEARED, w] = tried & ~still
        wait_for_all(part)
        for w in range(part.first, part.last):
            sets[Set.BLOCKED, w] &= ~sets[Set.CLEARED, w]


@called
def find_blocked(params, state, part, w, tried, at_first):
    """Return which of some robots of a word are blocked, and which of these by robots on the left and right.

    Another robot moves, or may stay: ``at_first`` any, later the blocked ones.
    """
    limit = params.robots.meet_limit
    found, found_left, found_right = find_beyond_walls(params, state, tried, w), uint32(0), uint32(0)
    if not params.robots.avoid_collisions:
        return found, found_left, found_right
    queued, left = int64(0), tried
    if not (at_first and params.robots.deflects):  # the sides don't matter
        left = uint32(tried & ~found)
    while left:
        i = lowest_member(w, left)
        grid = params.robots.grid
        queued = queue_near(params, state, part, state.robot_cells, grid, i, limit, queued, int32(i))
        left = without_lowest(left)
        if queued > HEARD_ROOM or left == 0:
            met, on_left, on_right = find_met(params, state, state.heard[part.thread], queued, at_first)
            found, found_left, found_right = found | met, found_left | on_left, found_right | on_right
            queued = int64(0)
    return found, found_left, found_right


@called
def find_met(params, state, pairs, queued, at_first):
    """Return which robots of a word meet those queued for them, and have these on the left and right.

    Without a branch, so that LLVM vectorizes the loop, unless floats leave a pair in doubt.
    """
    robots, staying = state.robots, state.sets[Set.BLOCKED]
    xs, ys, us, vs = robots[Robot.X], robots[Robot.Y], robots[Robot.STEP_X], robots[Robot.STEP_Y]
    receivers, senders = pairs[Heard.RECEIVER], pairs[Heard.SENDER]
    arena, limit = params.arena, int64(params.robots.apart_limit)
    walls, width, height = arena.walls, arena.width, arena.height
    found, left, right, doubtful = uint32(0), uint32(0), uint32(0), False
    repeat_last(receivers, senders, queued)
    for k in range((queued + TOGETHER - 1) & -TOGETHER):
        i, j = uint64(uint32(receivers[k])), uint64(uint32(senders[k]) >> uint32(1))
        way_x = short_way(xs[i], xs[j], width, walls)
        way_y = short_way(ys[i], ys[j], height, walls)
        ix, iy, jx, jy = int64(us[i]), int64(vs[i]), int64(us[j]), int64(vs[j])
        apart, along, across = way_x * way_x + way_y * way_y, way_x * ix + way_y * iy, way_y * ix - way_x * iy
        length = ix * ix + iy * iy
        along_both = way_x * jx + way_y * jy - along
        across_both = way_x * jy - way_y * jx + across
        length_both = length + jx * jx + jy * jy - 2 * (ix * jx + iy * jy)
        meets_alone, sure_alone = meets(limit, apart, -along, across, length)
        meets_both, sure = meets(limit, apart, along_both, across_both, length_both)
        doubtful |= not (sure & sure_alone)
        met = meets_both | (meets_alone & (at_first | has_bit(staying[j >> uint64(5)], j)))
        found |= bit_if(met, i)
        left |= bit_if(met & (across > 0), i)
        right |= bit_if(met & (across < 0), i)
    if doubtful:
        return find_met_exactly(params, state, pairs, queued, at_first)
    return found, left, right


@called
def find_met_exactly(params, state, pairs, queued, at_first):
    """Return what `find_met` returns, by exact arithmetic."""
    found, left, right = uint32(0), uint32(0), uint32(0)
    for k in range(queued):
        i, j = int64(pairs[Heard.RECEIVER, k]), place_of(pairs[Heard.SENDER, k])
        may_stay = at_first or contains(state.sets[Set.BLOCKED], j)
        met, side = meets_exactly(params, state.robots, i, j, may_stay)
        found |= bit_if(met, i)
        left |= bit_if(met and side > 0, i)
        right |= bit_if(met and side < 0, i)
    return found, left, right


@inlined
def meets_exactly(params, robots, i, j, may_stay):
    """Return whether a robot meets another, which moves or may stay, and how far left of its heading."""
    way_x, way_y = way_between(params, robots, i, j)
    u, v = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    both_x, both_y = int64(robots[Robot.STEP_X, j]) - u, int64(robots[Robot.STEP_Y, j]) - v
    met = meet(params, way_x, way_y, both_x, both_y) or (may_stay and meet(params, way_x, way_y, -u, -v))
    return met, u * way_y - v * way_x


@inlined
def repeat_last(firsts, seconds, listed):
    """Repeat the last pair of a list, which changes no set, so that the last ones can be tested together."""
    last = max(listed - 1, 0)
    for k in range(TOGETHER):
        firsts[listed + k], seconds[listed + k] = firsts[last], seconds[last]


@inlined
def short_way(here, there, side, walls):
    """Return the way along an axis, on the torus the short one. LLVM knows that it fits in 32 bits."""
    way = int64(uint32(there)) - int64(uint32(here))
    return int64(int32(way if walls else shortest(way, side)))


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
def find_beyond_walls(params, state, tried, w):
    """Return which robots of a set in a word have steps that walls block."""
    if params.arena.place.exists:
        return find_blocked_by_place(params, state.tables.ground, state.robots, tried, w)
    return uint32(find_beyond_edges(params, state.robots, w) & tried)


@inlined
def find_walls_beside(params, state, blocked, w):
    """Return which robots of a word have a wall that blocks them on their left, and on their right."""
    if params.arena.place.exists:
        return find_place_beside(params, state.tables.ground, state.robots, blocked, w)
    return find_edges_beside(params, state.robots, w)


@called
def find_beyond_edges(params, robots, w):
    """Return the set of robots of a word whose step leads beyond an edge with a wall."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    found, base = uint32(0), uint64(WORD * w)
    if not params.arena.walls:
        return found
    for k in range(32):
        i = uint64(base + k)
        x, y = int64(uint32(xs[i])) + int64(steps_x[i]), int64(uint32(ys[i])) + int64(steps_y[i])
        found |= bit_if((x < low) | (y < low) | (x > right) | (y > top), k)
    return found


@called
def find_edges_beside(params, robots, w):
    """Return which robots of a word have an edge that blocks them on their left, and on their right."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    found_left, found_right, base = uint32(0), uint32(0), uint64(WORD * w)
    if not params.arena.walls:
        return found_left, found_right
    for k in range(32):
        i = uint64(base + k)
        u, v = int64(steps_x[i]), int64(steps_y[i])
        x, y = int64(uint32(xs[i])) + u, int64(uint32(ys[i])) + v
        west, east, south, north = x < low, x > right, y < low, y > top
        on_left = (east & (v < 0)) | (west & (v > 0)) | (north & (u > 0)) | (south & (u < 0))
        on_right = (east & (v > 0)) | (west & (v < 0)) | (north & (u < 0)) | (south & (u > 0))
        found_left |= bit_if(on_left, k)
        found_right |= bit_if(on_right, k)
    return found_left, found_right


@inlined
def way_between(params, robots, i, j):
    """Return the way from a robot to another, along x and y."""
    way_x = int64(uint32(robots[Robot.X, j])) - int64(uint32(robots[Robot.X, i]))
    way_y = int64(uint32(robots[Robot.Y, j])) - int64(uint32(robots[Robot.Y, i]))
    if params.arena.walls:
        return way_x, way_y
    return shortest(way_x, params.arena.width), shortest(way_y, params.arena.height)


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


@called
def turn_away(robots, turning_left, blocked, w):
    """Turn the steps of the blocked robots of a word by an eighth of a turn, to the left or to the right."""
    steps_x, steps_y, base = robots[Robot.STEP_X], robots[Robot.STEP_Y], uint64(WORD * w)
    for k in range(32):
        i = uint64(base + k)
        u, v = int64(steps_x[i]), int64(steps_y[i])
        side = 2 * int64(has_bit(turning_left, k)) - 1  # without a branch
        turned_u, turned_v = shortened(u - side * v), shortened(v + side * u)
        turns = has_bit(blocked, k)
        steps_x[i], steps_y[i] = int32(turned_u if turns else u), int32(turned_v if turns else v)
