"""Cell lists: which of many points lie near a place, at a cost that doesn't grow with their number.

A half cell of the grid is at least the range. So all points in range of a place lie in the nearest block of
two by two cells. Points are sorted by row and then by column, and each row repeats its first column at its
end. So a block is two stretches of consecutive points, one per row, without a wrap.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.compile import inlined, rebound
from feasibee.engine.intrinsics import (
    LANES,
    contains,
    few_within,
    few_within_on,
    first_bits,
    popcount,
    within,
    within_on,
)
from feasibee.engine.layout import Point


@inlined
def shortest(difference, side):
    """Return a difference on a torus the short way round."""
    if 2 * difference >= side:
        difference -= side
    if 2 * difference < -side:
        difference += side
    return difference


@inlined
def cell_of(coordinate, scale):
    """Return the column of an x or the row of a y, by the scale of that axis."""
    return int64((uint64(uint32(coordinate)) * scale) >> uint64(52))


@inlined
def sort_into_cells(cells, grid, points, members, count):
    """Sort those of some points that are members of a set into cells: count, sum up, store."""
    xs, ys, numbers = points
    if is_one_cell(grid):  # it holds all, in their order; sorting took 10 % of a step
        place = int64(0)
        for i in range(count):
            if contains(members, i):
                place_at(cells.points, place, xs[i], ys[i], numbers[i])
                place += 1
        cells.start[1] = cells.start[2] = int32(place)
        return
    clear_cells(cells.start, 0, (grid.columns + 1) * grid.rows)
    for i in range(count):
        if contains(members, i):
            count_point(cells.start, cell_at(grid, xs[i], ys[i]))
    sum_up(cells.start, grid, 0, grid.rows, 0)
    for i in range(count):
        if contains(members, i):
            append(cells, cell_at(grid, xs[i], ys[i]), xs[i], ys[i], numbers[i])
    repeat_columns(cells, grid, 0, grid.rows, 0)


@inlined
def is_one_cell(grid):
    """Return whether one cell holds all points."""
    return grid.columns == 1 and grid.rows == 1


@inlined
def clear_cells(start, first, last):
    """Begin to count the points of the cells from ``first`` to ``last`` (excluded)."""
    for cell in range(first, last):
        start[cell + 1] = 0


@inlined
def cell_at(grid, x, y):
    """Return the cell of a place."""
    return cell_of(y, grid.scale_y) * (grid.columns + 1) + cell_of(x, grid.scale_x)


@inlined
def count_point(start, cell):
    """Count a point in its cell."""
    start[uint64(cell + 1)] += int32(1)


@inlined
def repeated(start, grid, first, last):
    """Return the number of points in the first column of some rows, which each row repeats at its end."""
    points = int64(0)
    if grid.columns > 1:
        for row in range(first, last):
            points += int64(start[row * (grid.columns + 1) + 1])
    return points


@inlined
def sum_up(start, grid, first, last, place):
    """Replace the numbers of points of the cells of some rows by the places where these points begin."""
    for row in range(first, last):
        cell = row * (grid.columns + 1)
        if grid.columns > 1:
            start[cell + grid.columns + 1] = start[cell + 1]
        for k in range(uint64(cell + 1), uint64(cell + grid.columns + 2)):
            place += int64(start[k])
            start[k] = int32(place - int64(start[k]))


@inlined
def repeat_columns(cells, grid, first, last, place):
    """Append the points of the first column of some rows to the cells that repeat it.

    The points of these rows are stored from ``place`` on.
    """
    points, start = cells.points, cells.start
    if grid.columns > 1:
        for row in range(first, last):
            cell = row * (grid.columns + 1)
            for k in range(uint64(place), uint64(uint32(start[cell + 1]))):
                x, y, number = points[Point.X, k], points[Point.Y, k], points[Point.NUMBER, k]
                append(cells, cell + grid.columns, x, y, number)
            place = int64(start[cell + grid.columns + 1])


@inlined
def append(cells, cell, x, y, number):
    """Append a point to a cell; in the end each cell begins where the one before it ends."""
    slot = uint64(uint32(cells.start[uint64(cell + 1)]))
    cells.start[uint64(cell + 1)] = int32(slot + uint64(1))
    place_at(cells.points, slot, x, y, number)


@inlined
def place_at(points, slot, x, y, number):
    """Store a point and its number."""
    points[Point.X, slot] = x
    points[Point.Y, slot] = y
    points[Point.NUMBER, slot] = number


@inlined
def block(cells, grid, x, y):
    """Return first and last place (the last excluded) of both stretches of the nearest block of cells."""
    left = wrapped(int64(uint32(x)) - grid.half_width, grid.width)
    low = wrapped(int64(uint32(y)) - grid.half_height, grid.height)
    column, row = cell_of(left, grid.scale_x), cell_of(low, grid.scale_y)
    next_row = row + 1
    if next_row == grid.rows:
        next_row = 0
    # Unsigned, since numba lets signed numbers count from the end of an array.
    cell = uint64(row * (grid.columns + 1) + column)
    other = uint64(next_row * (grid.columns + 1) + column)
    start, two = cells.start, uint64(2)
    other_last = start[other + two] if grid.rows > 1 else start[other]
    return int64(start[cell]), int64(start[cell + two]), int64(start[other]), int64(other_last)


@inlined
def wrapped(coordinate, side):
    """Return a coordinate that may be negative on the torus, without a branch."""
    return coordinate + (side & (coordinate >> 63))


@inlined
def are_few(first, last, other_first, other_last):
    """Return whether both stretches of a block have up to 8 points."""
    return max(last - first, other_last - other_first) <= LANES


def near(params, points, first, last, x, y, limit):
    """Return which of up to 32 points, ``first`` to ``last`` (excluded), are near.

    ``points`` has the coordinates in its rows `Point.X` and `Point.Y`.
    """
    xs, ys, arena = points[Point.X], points[Point.Y], params.arena
    if arena.wraps:
        close = within(xs, ys, first, x, y, limit, arena.width, arena.height)
    else:
        close = within_on(xs, ys, first, x, y, limit, arena.width, arena.height)
    return close & first_bits(last - first)


def near_both(params, points, first, last, x, y):
    """Return which of up to 32 points are in sight of a place, and which are in radio range."""
    xs, ys, arena, sight, radio = points[Point.X], points[Point.Y], params.arena, params.sensing, params.radio
    if arena.wraps:  # in one branch, so that LLVM computes distances once
        seen = within(xs, ys, first, x, y, sight.limit, arena.width, arena.height)
        heard = within(xs, ys, first, x, y, radio.limit, arena.width, arena.height)
    else:
        seen = within_on(xs, ys, first, x, y, sight.limit, arena.width, arena.height)
        heard = within_on(xs, ys, first, x, y, radio.limit, arena.width, arena.height)
    valid = first_bits(last - first)
    return seen & valid, heard & valid


few_near, few_near_both = (
    inlined(rebound(each, within=few_within, within_on=few_within_on)) for each in (near, near_both)
)
"""Return what `near` and `near_both` return, of up to 8 points."""
near, near_both = inlined(near), inlined(near_both)


@inlined
def count_within(params, cells, grid, x, y, limit):
    """Return the number of points within a range of a place."""
    first, last, other_first, other_last = block(cells, grid, x, y)
    if are_few(first, last, other_first, other_last):
        close = few_near(params, cells.points, first, last, x, y, limit)
        other = few_near(params, cells.points, other_first, other_last, x, y, limit)
        return popcount(close | other << uint32(LANES))
    total = int64(0)
    for _ in range(2):
        while first < last:
            total += popcount(near(params, cells.points, first, last, x, y, limit))
            first += 32
        first, last = other_first, other_last
    return total
