"""Bodies of up to 32 robots: which go, stand or deflect, found at once as sets (model.md 6.1, 6.2).

The pairs that may meet are listed once, and all of them tested together. Larger swarms do so word by word:
see `feasibee.engine.bodies`.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import bit_if, first_bits, has_bit, without_lowest
from feasibee.engine.bodies import (
    TOGETHER,
    around,
    find_beyond_walls,
    find_walls_beside,
    meets,
    meets_exactly,
    repeat_last,
    short_way,
    turn_away,
)
from feasibee.engine.compile import called, spliced
from feasibee.engine.few import find_exactly, keep_only
from feasibee.engine.intrinsics import find_near, lowest
from feasibee.engine.layout import Heard, Link, Robot, Set
from feasibee.engine.motion import move_freely


@spliced
def move_few(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.1, 6.2)."""
    standing = find_standing(params, state, state.heard[part.thread])
    state.sets[Set.BLOCKED, 0] = standing
    if standing == 0 and params.arena.wraps:
        move_freely(state, part)
    else:
        move_unless(params, state.robots, standing)


@spliced
def find_standing(params, state, pairs):
    """Return the set of robots that stand in this step; ``pairs`` is room. The steps of others may turn."""
    robots, listed = state.robots, int64(0)
    if params.robots.avoid_collisions:
        listed = list_pairs(params, robots, state.links[Link.CLOSE], state.sets[Set.THERE, 0], pairs)
    blocked, left, right = find_meeting(params, robots, pairs, listed, first_bits(32))
    blocked = uint32((blocked | find_beyond_walls(params, robots, 0)) & state.sets[Set.WORKING, 0])
    if params.robots.deflects and blocked:
        wall_left, wall_right = find_walls_beside(params, robots, 0)
        turning_left = uint32(right | wall_right | ~(left | wall_left))
        blocked = deflect_few(params, robots, pairs, listed, blocked, turning_left)
    return blocked


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
def list_pairs(params, robots, close_by, there, pairs):
    """List the pairs of robots that are there and may meet within a step; return their number."""
    band, count = params.robots.meet_band, params.robots.count
    if params.arena.wraps and band.low > 0:  # some that are too far do no harm
        high = uint32(band.low + band.width)
        find_near(robots[Robot.X], robots[Robot.Y], close_by, count, high, uint32(0))
    else:
        find_exactly(params, robots, close_by, params.robots.meet_limit)
    if params.changes:
        keep_only(close_by, there)
    rows = uint32(0)
    for i in range(32):
        close_by[i] &= first_bits(i)
        rows |= bit_if(close_by[i] != 0, i)
    rows &= first_bits(count)
    firsts, seconds, listed = pairs[Heard.RECEIVER], pairs[Heard.SENDER], int64(0)
    while rows:  # one loop over pairs: an inner one for each robot would often be mispredicted
        i = lowest(rows)
        close = close_by[i]
        firsts[listed], seconds[listed] = int32(i), int32(lowest(close))
        close_by[i] = without_lowest(close)
        rows &= ~bit_if(without_lowest(close) == 0, i)
        listed += 1
    repeat_last(firsts, seconds, listed)
    return listed


@called
def keep_pairs(pairs, listed, members):
    """Keep those pairs of a list of which one or both are in a set; return their number."""
    firsts, seconds, kept = pairs[Heard.RECEIVER], pairs[Heard.SENDER], int64(0)
    for k in range(listed):
        i, j = firsts[k], seconds[k]
        firsts[kept], seconds[kept] = i, j
        kept += int64(has_bit(members, i) | has_bit(members, j))
    repeat_last(firsts, seconds, kept)
    return kept


@called
def find_meeting(params, robots, pairs, listed, staying):
    """Return which robots of listed pairs meet the other, and which of these have it on the left and right.

    The other one moves, or may stay if it is a member of ``staying``. A stopped robot has step 0. Without a
    branch, so that LLVM vectorizes the loop, unless floats leave a pair in doubt.
    """
    xs, ys, us, vs = robots[Robot.X], robots[Robot.Y], robots[Robot.STEP_X], robots[Robot.STEP_Y]
    firsts, seconds = pairs[Heard.RECEIVER], pairs[Heard.SENDER]
    arena, limit = params.arena, int64(params.robots.apart_limit)
    walls, width, height = arena.walls, arena.width, arena.height
    found, left, right, doubtful = uint32(0), uint32(0), uint32(0), False
    for k in range((listed + TOGETHER - 1) & -TOGETHER):
        i, j = uint64(uint32(firsts[k])), uint64(uint32(seconds[k]))
        way_x = short_way(xs[i], xs[j], width, walls)
        way_y = short_way(ys[i], ys[j], height, walls)
        ix, iy, jx, jy = int64(us[i]), int64(vs[i]), int64(us[j]), int64(vs[j])
        apart = way_x * way_x + way_y * way_y
        along_i, along_j = -(way_x * ix + way_y * iy), way_x * jx + way_y * jy
        across_i, across_j = way_y * ix - way_x * iy, way_x * jy - way_y * jx
        length_i, length_j = ix * ix + iy * iy, jx * jx + jy * jy
        length = length_i + length_j - 2 * (ix * jx + iy * jy)
        meets_i, sure_i = meets(limit, apart, along_i, across_i, length_i)
        meets_j, sure_j = meets(limit, apart, along_j, across_j, length_j)
        meets_both, sure = meets(limit, apart, along_i + along_j, across_i + across_j, length)
        # Opposite to each other on the torus, both take the way round in the same direction.
        doubtful |= (2 * abs(way_x) == width) | (2 * abs(way_y) == height) | (not (sure & sure_i & sure_j))
        meets_i = meets_both | (meets_i & has_bit(staying, j))
        meets_j = meets_both | (meets_j & has_bit(staying, i))
        found |= bit_if(meets_i, i) | bit_if(meets_j, j)
        left |= bit_if(meets_i & (across_i > 0), i) | bit_if(meets_j & (across_j > 0), j)
        right |= bit_if(meets_i & (across_i < 0), i) | bit_if(meets_j & (across_j < 0), j)
    if doubtful:
        return find_meeting_exactly(params, robots, pairs, listed, staying)
    return found, left, right


@called
def find_meeting_exactly(params, robots, pairs, listed, staying):
    """Return what `find_meeting` returns, by exact arithmetic."""
    found, left, right = uint32(0), uint32(0), uint32(0)
    for k in range(2 * listed):
        own, other = (Heard.RECEIVER, Heard.SENDER) if k & 1 else (Heard.SENDER, Heard.RECEIVER)
        i, j = int64(pairs[own, k >> 1]), int64(pairs[other, k >> 1])
        met, side = meets_exactly(params, robots, i, j, has_bit(staying, j))
        found |= bit_if(met, i)
        left |= bit_if(met and side > 0, i)
        right |= bit_if(met and side < 0, i)
    return found, left, right


@called
def deflect_few(params, robots, pairs, listed, blocked, turning_left):
    """Let the blocked robots turn away twice, as long as they are blocked; return those that still are.

    Their steps change, also of those that stay blocked: these draw a new heading (model.md 6.2.2 to 6.2.5).
    """
    for _ in range(2):
        turn_away(robots, turning_left, blocked, 0)
        beyond = find_beyond_walls(params, robots, 0)  # first, since what gathers the steps waits for them
        listed = keep_pairs(pairs, listed, blocked)
        met, _, _ = find_meeting(params, robots, pairs, listed, blocked)
        blocked &= met | beyond
        if blocked == 0:
            break
    return blocked
