"""Cell lists: which of many points lie near a place, at a cost that doesn't grow with their number.

The grid is as wide as the arena, 2**bits cells a side. A half cell is at least the range. So all points in
range of a place lie in the nearest block of two by two cells. Strip r holds the points of rows r and r + 1,
sorted by column, and repeats the first column at its end. So each block is one stretch of consecutive
points without a wrap, and every point is stored twice.
"""

from __future__ import annotations

from numba import int64, uint32, uint64

from feasibee.engine.bits import first_bits
from feasibee.engine.compile import inlined
from feasibee.engine.intrinsics import popcount, within, within_on
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
def near(params, points, first, last, x, y, limit):
    """Return which of up to 32 points, ``first`` to ``last`` (excluded), are near a place, on any arena.

    ``points`` has the coordinates in its rows `Point.X` and `Point.Y`.
    """
    xs, ys, arena = points[Point.X], points[Point.Y], params.arena
    if arena.wraps:
        close = within(xs, ys, first, x, y, limit)
    else:
        close = within_on(xs, ys, first, x, y, limit, (arena.width, arena.height))
    return close & first_bits(last - first)


@inlined
def near_on_torus(points, first, last, x, y, limit):
    """Return which of up to 32 points, ``first`` to ``last`` (excluded), are near, on a square torus."""
    return within(points[Point.X], points[Point.Y], first, x, y, limit) & first_bits(last - first)


@inlined
def cell_of(coordinate, scale):
    """Return the column of an x or the row of a y, by the scale of that axis."""
    return int64((uint64(uint32(coordinate)) * scale) >> uint64(52))


@inlined
def sort_into_cells(cells, grid, xs, ys, labels, count):
    """Sort points and their labels into the cells of all strips: count, sum up, store."""
    # Read once: the compiler must assume that writing to the cells changes the grid.
    side, scale_x, scale_y = 1 << grid.bits, grid.scale_x, grid.scale_y
    start = cells.start
    if side == 1:  # one cell holds all, in their order; sorting took 10 % of a step
        start[0], start[1] = 0, count
        points = cells.points
        for i in range(count):
            points[Point.X, i], points[Point.Y, i], points[Point.LABEL, i] = xs[i], ys[i], labels[i]
        return
    for cell in range(side * (side + 1) + 2):
        start[cell] = 0
    for i in range(count):
        column = cell_of(xs[i], scale_x)
        row = cell_of(ys[i], scale_y)
        upper = row * (side + 1) + column
        lower = ((row - 1) & (side - 1)) * (side + 1) + column
        start[upper + 2] += 1
        if column == 0:
            start[upper + side + 2] += 1
        start[lower + 2] += 1
        if column == 0:
            start[lower + side + 2] += 1
    for cell in range(side * (side + 1)):
        start[cell + 2] += start[cell + 1]
    for i in range(count):
        column = cell_of(xs[i], scale_x)
        row = cell_of(ys[i], scale_y)
        upper = row * (side + 1) + column
        lower = ((row - 1) & (side - 1)) * (side + 1) + column
        place(cells, upper, xs[i], ys[i], labels[i])
        if column == 0:
            place(cells, upper + side, xs[i], ys[i], labels[i])
        place(cells, lower, xs[i], ys[i], labels[i])
        if column == 0:
            place(cells, lower + side, xs[i], ys[i], labels[i])


@inlined
def place(cells, cell, x, y, label):
    """Append a point to its cell."""
    slot = cells.start[cell + 1]
    cells.start[cell + 1] = slot + 1
    cells.points[Point.X, slot] = x
    cells.points[Point.Y, slot] = y
    cells.points[Point.LABEL, slot] = label


@inlined
def block(cells, grid, x, y):
    """Return first and last place (the last excluded) of the points in the nearest block of cells."""
    if grid.bits == 0:
        return int64(0), cells.start[1]
    side = 1 << grid.bits
    left = int64(uint32(x)) - (grid.width >> (grid.bits + 1))
    low = int64(uint32(y)) - (grid.height >> (grid.bits + 1))
    if left < 0:
        left += grid.width
    if low < 0:
        low += grid.height
    cell = cell_of(low, grid.scale_y) * (side + 1) + cell_of(left, grid.scale_x)
    return cells.start[cell], cells.start[cell + 2]


@inlined
def block_on_torus(cells, bits, x, y):
    """Return what `block` returns, on a square torus, where the side is 2**32: by shifts."""
    side = 1 << bits
    shift = uint64(32 - bits)
    half = int64(1) << int64(31 - bits)
    column = int64(uint64(uint32(x - half)) >> shift)
    row = int64(uint64(uint32(y - half)) >> shift)
    cell = row * (side + 1) + column
    return cells.start[cell], cells.start[cell + min(2, side)]


@inlined
def count_within(cells, bits, x, y, limit):
    """Return the number of points within a range of a place on a square torus."""
    first, last = block_on_torus(cells, bits, x, y)
    total = 0
    while first < last:
        total += popcount(near_on_torus(cells.points, first, last, x, y, limit))
        first += 32
    return total
