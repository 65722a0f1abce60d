"""The ways around walls to tasks, in a place (model.md 6.25.15 to 6.25.17).

The ways to a task are found when they are first asked for: a cell takes about 25 ns. Cells wait in two
queues, those reached over a side and over a corner. In each of them ways never decrease: no heap is needed.
"""

from __future__ import annotations

import math

from numba import float64, int32, int64, uint32

from feasibee.engine.compile import called, inlined
from feasibee.engine.place import has_cell, passable_ends, position

SIDE, CORNER = 5, 7
"""Fifths of a cell's side from a cell to one at its side, and to one at its corner."""
NO_WAY, CLOSED = 2**30, -1
"""What stands in place of a way from a passable cell without one, and from a cell that isn't passable."""


@called
def clear_ways(state):
    """Let no ways be found: of each task in the first cell, which is never passable."""
    for task in range(state.ways.shape[0]):
        state.ways[task, 0] = 0


@called
def need_ways(params, state, task):
    """Find the ways to a task, unless they are found."""
    if state.ways[task, 0] == 0:
        x, y = position(state.tasks, task)
        find_ways(params.arena.place, state.tables.ground, state.ways, task, x, y)


@called
def way_around(params, state, i, task):
    """Return the way from a robot's cell to a task, in fifths of a cell's side, or `NO_WAY`."""
    need_ways(params, state, task)
    x, y = position(state.robots, i)
    return int64(state.ways[task, cell_at(params.arena.place, x, y)])


@called
def find_ways(place, ground, ways, task, x, y):
    """Find the ways from all cells to a task at a position."""
    way, last, columns = ways[task], ways.shape[0] - 1, place.columns
    by_side, by_corner = ways[last - 1], ways[last]
    for row in range(place.rows):
        for column in range(columns):
            way[row * columns + column] = NO_WAY if is_open(place, ground, column, row) else CLOSED
    first = reached_from(place, ground, x >> place.bits, y >> place.bits)
    if first < 0:
        return
    way[first], by_side[0] = 0, first
    side, corner, sides, corners = int64(0), int64(0), int64(1), int64(0)
    while side < sides or corner < corners:
        if corner == corners or (side < sides and way[by_side[side]] <= way[by_corner[corner]]):
            here, side = int64(by_side[side]), side + 1
        else:
            here, corner = int64(by_corner[corner]), corner + 1
        sides = reach(way, by_side, sides, here, here - columns, SIDE)
        sides = reach(way, by_side, sides, here, here - 1, SIDE)
        sides = reach(way, by_side, sides, here, here + 1, SIDE)
        sides = reach(way, by_side, sides, here, here + columns, SIDE)
        for dy in (-columns, columns):
            for dx in (-1, 1):
                if min(way[here + dy], way[here + dx]) > CLOSED:
                    corners = reach(way, by_corner, corners, here, here + dy + dx, CORNER)


@inlined
def reach(way, queue, queued, here, there, length):
    """Shorten the way from a cell, if it is shorter by another one, and queue it; return the queue's end."""
    if way[here] + length < way[there]:
        way[there] = way[here] + length
        queue[queued] = there
        return queued + 1
    return queued


@inlined
def is_open(place, ground, column, row):
    """Return whether a cell is passable."""
    return has_cell(ground.passable, place.row_words, uint32(column), uint32(row)) == 1


@called
def reached_from(place, ground, column, row):
    """Return the passable cell from which robots reach a task in a cell, or -1 (model.md 6.20.9)."""
    if is_open(place, ground, column, row):
        return row * place.columns + column
    best, least = int64(-1), place.near + 1
    around = int64(math.sqrt(float64(place.near))) + 2
    for y in range(max(row - around, 0), min(row + around + 1, place.rows)):
        for x in range(max(column - around, 0), min(column + around + 1, place.columns)):
            across, along = max(abs(x - column) - 1, 0), max(abs(y - row) - 1, 0)
            gap = across * across + along * along
            if gap < least and is_open(place, ground, x, y):
                best, least = y * place.columns + x, gap
    return best


@called
def step_around(params, state, i, task):
    """Return a robot's step on its way to a task."""
    need_ways(params, state, task)
    place, ground, way = params.arena.place, state.tables.ground, state.ways[task]
    x, y = position(state.robots, i)
    here = cell_at(place, x, y)
    number = cells_ahead(params, way, here, x, y)
    while True:
        cell = here
        for _ in range(number):
            cell = next_cell(place, way, cell)
        right, up = centre_of(place, cell)
        u, v = step_to(params, right - x, up - y)
        if number <= 1 or (
            passable_ends(place, ground, x, y, u, v) == 4 and way[cell_at(place, x + u, y + v)] < way[here]
        ):
            return int32(u), int32(v)
        number >>= 1


@inlined
def cells_ahead(params, way, here, x, y):
    """Return the number of the first cell on a way that is farther than a step, or of the task's cell."""
    cell, number = here, int64(0)
    while 0 < way[cell] < NO_WAY:
        cell, number = next_cell(params.arena.place, way, cell), number + 1
        right, up = centre_of(params.arena.place, cell)
        if off(right - x, up - y) > params.robots.reach:
            break
    return number


@inlined
def next_cell(place, way, cell):
    """Return which of the cells around a cell is next on the way: the lowest, and the first of equals."""
    best, columns = cell, place.columns
    for dy in range(-1, 2):
        for dx in range(-1, 2):
            there = cell + dy * columns + dx
            least = min(way[there], way[cell + dx], way[cell + dy * columns])
            if way[there] < way[best] and least > CLOSED:
                best = there
    return best


@inlined
def cell_at(place, x, y):
    """Return the number of the cell of a position, row by row."""
    return (y >> place.bits) * place.columns + (x >> place.bits)


@inlined
def centre_of(place, cell):
    """Return the middle of a cell."""
    half = int64(1) << (place.bits - 1)
    return ((cell % place.columns) << place.bits) + half, ((cell // place.columns) << place.bits) + half


@inlined
def off(x, y):
    """Return the length of a way along x and y."""
    return math.sqrt(float64(x * x + y * y))


@inlined
def step_to(params, right, up):
    """Return the step along a way that is so far to the right and up, as long as other steps at most."""
    length, reach = off(right, up), params.robots.reach
    if length <= reach:
        return right, up
    return (
        int64(math.floor(reach * (float64(right) / length) + 0.5)),
        int64(math.floor(reach * (float64(up) / length) + 0.5)),
    )
