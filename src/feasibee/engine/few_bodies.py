"""Bodies of up to 32 robots: which go, stand or deflect, found at once as sets (model.md 6.1, 6.2).

Larger swarms do so robot by robot: see `feasibee.engine.bodies`.
"""

from __future__ import annotations

from numba import float64, int32, int64, uint32

from feasibee.engine.bits import bit_if, first_bits, has_bit, without_lowest
from feasibee.engine.bodies import around, is_beyond_walls, meet, turn_away, walls_beside, way_between
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.few import find_exactly, keep_only
from feasibee.engine.intrinsics import find_near, lowest
from feasibee.engine.layout import Link, Robot, Set
from feasibee.engine.motion import move_freely

SURELY = 1e-14
"""More than the relative error of a product of four numbers, each rounded once."""


@spliced
def move_few(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.1, 6.2)."""
    robots, blocked, beyond, turning_left = state.robots, uint32(0), uint32(0), uint32(0)
    if params.arena.walls:
        beyond = find_beyond_walls(params, robots)
    if params.robots.avoid_collisions:
        blocked, turning_left = find_colliding(params, robots, state.links, state.sets[Set.THERE, 0], beyond)
    blocked = uint32((blocked | beyond) & state.sets[Set.WORKING, 0])
    if params.robots.deflects and blocked:
        blocked = deflect_few(params, robots, state.links[Link.CLOSE], blocked, turning_left)
    state.sets[Set.BLOCKED, 0] = blocked
    if blocked == 0 and params.arena.wraps:
        move_freely(state, part)
    else:
        move_unless(params, robots, blocked)


@called
def find_beyond_walls(params, robots):
    """Return the set of robots whose step leads beyond a wall."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    found = uint32(0)
    for i in range(32):
        x, y = int64(uint32(xs[i])) + int64(steps_x[i]), int64(uint32(ys[i])) + int64(steps_y[i])
        found |= bit_if((x < low) | (y < low) | (x > right) | (y > top), i)
    return found


@called
def move_unless(params, robots, blocked):
    """Move all robots but those of a set; a torus whose sides differ doesn't wrap by itself."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    wraps, width, height = params.arena.wraps, params.arena.width, params.arena.height
    for i in range(32):
        moves = -int32(has_bit(~blocked, i))
        step_x, step_y = steps_x[i] & moves, steps_y[i] & moves
        x, y = int64(uint32(xs[i])) + int64(step_x), int64(uint32(ys[i])) + int64(step_y)
        xs[i] = int32(uint32(x if wraps else around(x, width)))
        ys[i] = int32(uint32(y if wraps else around(y, height)))


@called
def find_colliding(params, robots, links, there, beyond):
    """Return the set of those robots that are there whose step meets another, which may move too or stay.

    If robots deflect, return also which would turn left; ``beyond`` has those whose step passes a wall.
    """
    band, close_by = params.robots.meet_band, links[Link.CLOSE]
    if params.arena.wraps and band.low > 0:  # some that are too far do no harm
        high = uint32(band.low + band.width)
        find_near(robots[Robot.X], robots[Robot.Y], close_by, params.robots.count, high, uint32(0))
    else:
        find_exactly(params, robots, close_by, params.robots.meet_limit)
    if params.changes:
        keep_only(close_by, there)
    found, on_left, on_right = uint32(0), uint32(0), uint32(0)
    if params.robots.deflects and params.arena.walls:
        on_left, on_right = find_walls_beside(params, robots, beyond)
    for i in range(1, params.robots.count):
        close = close_by[i] & first_bits(i)
        while close:
            j = lowest(close)
            colliding = who_collides(params, robots, i, j)
            found |= colliding
            if params.robots.deflects and colliding:
                on_left |= colliding & on_side(params, robots, i, j, 1)
                on_right |= colliding & on_side(params, robots, i, j, -1)
            close = without_lowest(close)
    return found, uint32(on_right | ~on_left)


@inlined
def who_collides(params, robots, i, j):
    """Return the set of those of two robots whose step meets the other, which may move too or stay.

    Without a branch, unless floats leave it in doubt. A stopped robot has step 0.
    """
    way_x, way_y = way_between(params, robots, i, j)
    ix, iy = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    jx, jy = int64(robots[Robot.STEP_X, j]), int64(robots[Robot.STEP_Y, j])
    apart = way_x * way_x + way_y * way_y
    along_i, along_j = -(way_x * ix + way_y * iy), way_x * jx + way_y * jy
    across_i, across_j = way_y * ix - way_x * iy, way_x * jy - way_y * jx
    length_i, length_j = ix * ix + iy * iy, jx * jx + jy * jy
    length_both = length_i + length_j - 2 * (ix * jx + iy * jy)
    meets_i, sure_i = meets(params, apart, along_i, across_i, length_i)
    meets_j, sure_j = meets(params, apart, along_j, across_j, length_j)
    meets_both, sure_both = meets(params, apart, along_i + along_j, across_i + across_j, length_both)
    # Opposite to each other on the torus, both take the way round in the same direction.
    is_opposite = (2 * abs(way_x) == params.arena.width) | (2 * abs(way_y) == params.arena.height)
    if sure_i & sure_j & sure_both & ~is_opposite:
        return bit_if(meets_i | meets_both, i) | bit_if(meets_j | meets_both, j)
    return bit_if(collides(params, robots, i, j), i) | bit_if(collides(params, robots, j, i), j)


@inlined
def on_side(params, robots, i, j, side):
    """Return the set of those of two robots that have the other on their left (side 1) or right (-1)."""
    return bit_if(side * leftness(params, robots, i, j) > 0, i) | bit_if(
        side * leftness(params, robots, j, i) > 0, j
    )


@inlined
def leftness(params, robots, i, j):
    """Return how far left of a robot's heading another is, times the length of its step."""
    way_x, way_y = way_between(params, robots, i, j)
    return int64(robots[Robot.STEP_X, i]) * way_y - int64(robots[Robot.STEP_Y, i]) * way_x


@inlined
def meets(params, apart, along, across, length):
    """Return whether two discs overlap at some moment of a step, as `meet` does, and whether that is sure.

    The squared distance is ``apart`` at the start and ``apart + 2 along + length`` at the end.
    """
    limit = int64(params.robots.apart_limit)
    passes = (along < 0) & (-along < length)
    at_ends = apart + (int64(0) if along >= 0 else 2 * along + length) < limit
    squared, least = float64(across) * float64(across), float64(limit) * float64(length)
    sure = (abs(squared - least) > SURELY * least) | ~passes
    return (passes & (squared < least)) | (~passes & at_ends), sure


@called
def collides(params, robots, i, other):
    """Return whether a robot's step meets another, by exact arithmetic."""
    way_x, way_y = way_between(params, robots, i, other)
    dx, dy = -int64(robots[Robot.STEP_X, i]), -int64(robots[Robot.STEP_Y, i])
    both_x, both_y = dx + int64(robots[Robot.STEP_X, other]), dy + int64(robots[Robot.STEP_Y, other])
    return meet(params, way_x, way_y, dx, dy) or meet(params, way_x, way_y, both_x, both_y)


@called
def deflect_few(params, robots, close_by, blocked, turning_left):
    """Let the blocked robots turn away twice, as long as they are blocked; return those that still are.

    Their steps change, also of those that stay blocked: these draw a new heading (model.md 6.2.2 to 6.2.5).
    """
    for _ in range(2):
        barred, left = uint32(0), blocked
        while left:
            i = lowest(left)
            turn_away(robots, turning_left, i)
            barred |= bit_if(is_beyond_walls(params, robots, i), i)
            left = without_lowest(left)
        left = uint32(blocked & ~barred)
        while left:
            i = lowest(left)
            barred |= bit_if(is_barred(params, robots, i, close_by[i], blocked), i)
            left = without_lowest(left)
        blocked &= barred
    return blocked


@inlined
def is_barred(params, robots, i, close, blocked):
    """Return whether a blocked robot's new step meets another, whatever the other blocked robots do."""
    u, v = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    barred = False
    while close:
        j = lowest(close)
        way_x, way_y = way_between(params, robots, i, j)
        both_x, both_y = int64(robots[Robot.STEP_X, j]) - u, int64(robots[Robot.STEP_Y, j]) - v
        barred |= meets_within(params, way_x, way_y, both_x, both_y)
        barred |= has_bit(blocked, j) & meets_within(params, way_x, way_y, -u, -v)
        close = without_lowest(close)
    return barred


@inlined
def meets_within(params, way_x, way_y, dx, dy):
    """Return what `meet` returns, without a branch unless floats leave it in doubt."""
    apart, length = way_x * way_x + way_y * way_y, dx * dx + dy * dy
    met, sure = meets(params, apart, way_x * dx + way_y * dy, way_x * dy - way_y * dx, length)
    return met if sure else meet(params, way_x, way_y, dx, dy)


@called
def find_walls_beside(params, robots, beyond):
    """Return which of the robots beyond walls have such a wall on their left, and on their right."""
    found_left, found_right = uint32(0), uint32(0)
    while beyond:
        i = lowest(beyond)
        on_left, on_right = walls_beside(params, robots, i)
        found_left |= bit_if(on_left, i)
        found_right |= bit_if(on_right, i)
        beyond = without_lowest(beyond)
    return found_left, found_right
