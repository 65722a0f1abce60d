"""Places: which steps avoid walls, and how many walls are between two things (model.md 6.20, 6.21).

A byte says how many cells around a cell, or around 4 x 4 cells, are free of walls. If such squares around
both ends and the middle cover a line, no wall is on it. Otherwise the line is walked from cell to cell: one
in ten, among obstacles.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import (
    bit,
    bit_if,
    first_bits,
    lowest_member,
    without_lowest,
)
from feasibee.engine.layout import HEARD_ROOM, WORD, Heard, Link, Point, Robot, Sense
from feasibee.engine.motion import shortened
from feasibee.engine.queues import store_members
from feasibee.model.codes import MOST_WALLS


@inlined
def is_passable(place, ground, x, y):
    """Return 1 if a position is in a passable cell, else 0.

    Cells at the edges never are, so they stand for all beyond: a negative coordinate is a large unsigned one.
    """
    bits = uint32(place.bits)
    column, row = uint32(uint32(x) >> bits), uint32(uint32(y) >> bits)
    last_column, last_row = uint32(place.columns - 1), uint32(place.rows - 1)
    column, row = min(column, last_column), min(row, last_row)
    return has_cell(ground.passable, place.row_words, column, row)


@inlined
def has_cell(words, row_words, column, row):
    """Return 1 if a cell is in a set of them, else 0; see `feasibee.engine.layout.Ground`."""
    word = words[uint64(uint32(row * uint32(row_words) + uint32(column >> uint32(6))))]
    return uint32(uint64(word >> uint64(column & uint32(63))) & uint64(1))


@inlined
def passable_ends(place, ground, x, y, u, v):
    """Return how many of the four quarters of a step end in passable cells (model.md 6.20.4)."""
    x, y, u, v = int32(x), int32(y), int32(u), int32(v)
    quarter_u, quarter_v, half_u, half_v = u >> int32(2), v >> int32(2), u >> int32(1), v >> int32(1)
    first = is_passable(place, ground, int32(x + quarter_u), int32(y + quarter_v))
    second = is_passable(place, ground, int32(x + half_u), int32(y + half_v))
    third = is_passable(place, ground, int32(x + half_u + quarter_u), int32(y + half_v + quarter_v))
    return int64(first + second + third + is_passable(place, ground, int32(x + u), int32(y + v)))


@called
def find_blocked_by_place(params, ground, robots, tried, w):
    """Return which robots of a set in a word have steps that the place blocks."""
    found = uint32(0)
    while tried:
        i = lowest_member(w, tried)
        x, y, u, v = robots[Robot.X, i], robots[Robot.Y, i], robots[Robot.STEP_X, i], robots[Robot.STEP_Y, i]
        found |= bit_if(passable_ends(params.arena.place, ground, x, y, u, v) < 4, i)
        tried = without_lowest(tried)
    return found


@called
def find_place_beside(params, ground, robots, blocked, w):
    """Return which robots of a word have the place that blocks them on their left, and on their right."""
    place, found_left, found_right = params.arena.place, uint32(0), uint32(0)
    while blocked:
        i = lowest_member(w, blocked)
        x, y = robots[Robot.X, i], robots[Robot.Y, i]
        u, v = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
        if passable_ends(place, ground, x, y, u, v) < 4:
            left = passable_ends(place, ground, x, y, shortened(u - v), shortened(u + v))
            right = passable_ends(place, ground, x, y, shortened(u + v), shortened(v - u))
            found_left |= bit_if(right > left, i)
            found_right |= bit_if(left > right, i)
        blocked = without_lowest(blocked)
    return found_left, found_right


@inlined
def open_around(place, ground, column, row):
    """Return how many cells from a cell on, in each direction, are surely free of walls."""
    block = (row >> place.blur) * place.blurred_columns + (column >> place.blur)
    return int64(ground.open_around[uint64(block)])


@inlined
def open_at(place, ground, x, y):
    """Return what `open_around` returns of a position's cell."""
    return open_around(place, ground, x >> place.bits, y >> place.bits)


@inlined
def is_cut(params, ground, sense, ax, ay, bx, by):
    """Return whether walls between two positions in range cut them off (model.md 6.20.11, 6.21)."""
    place = params.arena.place
    if is_surely_free(place, ground, ax, ay, bx, by):
        return False
    return is_behind_walls(place, ground, sense, ax, ay, bx, by)


@inlined
def is_surely_free(place, ground, ax, ay, bx, by):
    """Return whether open squares around both ends and the middle of a line cover it: so no wall is on it."""
    ax, ay, bx, by = ax >> place.bits, ay >> place.bits, bx >> place.bits, by >> place.bits
    length = max(abs(bx - ax), abs(by - ay))
    start, end = open_around(place, ground, ax, ay), open_around(place, ground, bx, by)
    if start + end > length + 1:
        return True
    middle = open_around(place, ground, (ax + bx) >> 1, (ay + by) >> 1)  # up to half a cell from the line's
    return 2 * (min(start, end) + middle) > length + 3


@called
def is_behind_walls(place, ground, sense, ax, ay, bx, by):
    """Return whether as many walls as are between two positions make them too far apart."""
    first = int64(sense) * (MOST_WALLS + 1)
    passes = ground.limits[first + 1] > 0
    walls = walls_between(place, ground, ax, ay, bx, by, MOST_WALLS if passes else 1)
    if walls == 0:
        return False
    way_x, way_y = bx - ax, by - ay
    return uint64(way_x * way_x + way_y * way_y) >= ground.limits[first + walls]


@inlined
def walls_between(place, ground, ax, ay, bx, by, most):
    """Return in how many stretches the line between two positions' cells touches walls, at most ``most``.

    The line joins the cells' centres. ``ahead`` says which border it meets first: at 0 both, at a corner.
    """
    column, row = ax >> place.bits, ay >> place.bits
    across, along = (bx >> place.bits) - column, (by >> place.bits) - row
    step_x, step_y = int64(1) if across >= 0 else int64(-1), int64(1) if along >= 0 else int64(-1)
    across, along = abs(across), abs(along)
    ahead, left = along - across, across + along
    inside = is_wall(place, ground, column, row)
    found = int64(inside)
    while left > 0 and found < most:
        corner = False
        if ahead < 0:
            column, ahead, left = column + step_x, ahead + 2 * along, left - 1
        elif ahead > 0:
            row, ahead, left = row + step_y, ahead - 2 * across, left - 1
        else:
            beside = is_wall(place, ground, column + step_x, row)
            corner = beside or is_wall(place, ground, column, row + step_y)
            column, row, ahead, left = column + step_x, row + step_y, ahead + 2 * (along - across), left - 2
        now = is_wall(place, ground, column, row)
        found += int64((not inside) and (now or corner))
        inside = now
    return found


@inlined
def is_wall(place, ground, column, row):
    """Return whether a cell is a wall."""
    return has_cell(ground.walls, place.row_words, uint32(column), uint32(row)) == 1


@inlined
def position(points, i):
    """Return the position of a robot or task; `Robot` and `Point` have the coordinates in the same rows."""
    return int64(uint32(points[Point.X, uint64(i)])), int64(uint32(points[Point.Y, uint64(i)]))


@called
def drop_cut(params, state, part, sense, reach):
    """Leave those robots out of each other's sets in `Link.SIGHT` between which walls are.

    A robot without walls within ``reach`` cells lists nobody. Pairs are listed and then tested in one loop.
    """
    links, pairs, listed, ground = (
        state.links[Link.SIGHT],
        state.heard[part.thread],
        int64(0),
        state.tables.ground,
    )
    receivers, senders, place = pairs[Heard.RECEIVER], pairs[Heard.SENDER], params.arena.place
    for i in range(params.robots.count):
        x, y = position(state.robots, i)
        if open_at(place, ground, x, y) > reach:
            continue
        for other in range(part.first, part.last):
            members = links[other, i] & first_bits(i - WORD * other)
            if members:
                listed += store_members(receivers, senders, listed, int32(i), members, int32(WORD * other))
        if listed > HEARD_ROOM:
            drop_listed_cut(params, state, links, pairs, listed, sense)
            listed = int64(0)
    drop_listed_cut(params, state, links, pairs, listed, sense)


@called
def drop_listed_cut(params, state, links, pairs, listed, sense):
    """Leave the robots of listed pairs out of each other's sets if walls are between them."""
    ground = state.tables.ground
    for k in range(listed):
        i, j = int64(pairs[Heard.RECEIVER, k]), int64(pairs[Heard.SENDER, k])
        ax, ay = position(state.robots, i)
        bx, by = position(state.robots, j)
        if is_cut(params, ground, sense, ax, ay, bx, by):
            links[j >> 5, i] &= ~bit(j)
            links[i >> 5, j] &= ~bit(i)


@called
def visible_tasks(params, state, tasks, w, x, y):
    """Return which tasks of a word, all in range of a position, aren't hidden by walls."""
    ground, left = state.tables.ground, tasks
    x, y = int64(uint32(x)), int64(uint32(y))
    while left:
        task = lowest_member(w, left)
        bx, by = position(state.tasks, task)
        if is_cut(params, ground, int64(Sense.SIGHT), x, y, bx, by):
            tasks &= ~bit(task)
        left = without_lowest(left)
    return tasks
