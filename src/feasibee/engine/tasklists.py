"""Task lists: for each cell of a square torus, the tasks in sight of any place in it.

A cell is longer than the range, so a task is in at most nine lists. A robot looks through the list of its
cell: about 10 of 100 tasks, against 25 in a block of `feasibee.engine.cells`. A list holds places only, in 16
bits an axis. They span four cells, so that the difference between a place and a listed one doesn't wrap.
"""

from __future__ import annotations

from numba import int64, uint32, uint64

from feasibee.engine.cells import count_within
from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import popcount, within_roughly

PIECE = 16
"""Places that are compared at once; each list is padded to a multiple of it."""


@called
def fill_lists(lists, bits, shift, limit, xs, ys, count):
    """Fill the lists of 2**bits cells a side: count, sum up, store, pad."""
    start, places = lists.start, lists.places
    cells, unlisted = int64(1) << (2 * bits), places.size - 1
    for cell in range(cells + 2):
        start[cell] = 0
    for task in range(count):
        for k in range(9):
            cell, listed = neighbour(xs[task], ys[task], k, bits, limit)
            start[cell + 2] += int64(listed)
    for cell in range(cells):
        start[cell + 2] = start[cell + 1] + whole_pieces(start[cell + 2])
    for task in range(count):
        place = pack_place(xs[task], ys[task], shift)
        for k in range(9):
            cell, listed = neighbour(xs[task], ys[task], k, bits, limit)
            slot = start[cell + 1] if listed else unlisted
            places[slot] = place
            start[cell + 1] += int64(listed)
    for cell in range(cells):
        last = start[cell + 1]
        start[cell + 1] = whole_pieces(last)
        for slot in range(last, start[cell + 1]):
            places[slot] = opposite(cell, bits, shift)


@inlined
def neighbour(x, y, k, bits, limit):
    """Return the k-th of nine cells round a task, and whether the task is in range of a place in it."""
    side, width = int64(1) << bits, int64(1) << (32 - bits)
    right, up = k % 3 - 1, k // 3 - 1
    way_x, way_y = way_to(int64(uint32(x)), right, width), way_to(int64(uint32(y)), up, width)
    column = ((int64(uint32(x)) >> (32 - bits)) + right) & (side - 1)
    row = ((int64(uint32(y)) >> (32 - bits)) + up) & (side - 1)
    return (row << bits) + column, uint64(way_x * way_x + way_y * way_y) < limit


@inlined
def way_to(coordinate, offset, width):
    """Return the least distance along an axis from a task to its own cell, or to the one before or after."""
    inside = coordinate & (width - 1)
    return int64(0) if offset == 0 else (inside if offset < 0 else width - inside)


@inlined
def whole_pieces(count):
    """Return a number of places rounded up to whole pieces."""
    return (count + PIECE - 1) & -PIECE


@inlined
def opposite(cell, bits, shift):
    """Return a place out of range of all places in a cell."""
    width = int64(1) << (32 - bits)
    column, row = cell & ((int64(1) << bits) - 1), cell >> bits
    return pack_place(column * width + 5 * (width >> 1), row * width + 5 * (width >> 1), shift)


@inlined
def pack_place(x, y, shift):
    """Return 16 bits of each coordinate from bit ``shift`` on, those of x below."""
    low, high = (uint32(x) >> shift) & uint32(0xFFFF), uint32(uint32(y) >> shift) << uint32(16)
    return uint32(uint32(low) | uint32(high))


@inlined
def count_listed(params, state, x, y):
    """Return the number of tasks in sight of a place: exactly, where 16 bits leave one in doubt."""
    bits, band = params.tasks.lists.bits, params.tasks.lists.band
    if bits > 0:
        back = uint32(32 - bits)
        cell = uint64((uint32(uint32(y) >> back) << uint32(bits)) | uint32(uint32(x) >> back))
        place = pack_place(x, y, params.tasks.lists.shift)
        first, last = state.task_lists.start[cell], state.task_lists.start[cell + uint64(1)]
        total = 0
        while first < last:
            close, doubtful = within_roughly(state.task_lists.places, first, place, band.low, band.width)
            if doubtful:
                return count_exactly(params, state.task_cells, x, y)
            total += popcount(close)
            first += PIECE
        return total
    return count_exactly(params, state.task_cells, x, y)


@called
def count_exactly(params, cells, x, y):
    """Return the number of tasks in range of a place, by the block of cells round it."""
    return count_within(params, cells, params.tasks.grid, x, y, params.sensing.limit)
