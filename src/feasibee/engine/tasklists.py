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
from feasibee.engine.layout import Bound

PIECE = 16
"""Places that are compared at once; each list is padded to a multiple of it."""


@called
def fill_lists(lists, bits, shift, limit, xs, ys, count):
    """Fill the lists of 2**bits cells a side: make room for the tasks of nine cells each, fill, pad."""
    places, first, last = lists.places, lists.bounds[Bound.FIRST], lists.bounds[Bound.LAST]
    cells = int64(1) << (2 * bits)
    for cell in range(cells):
        last[cell] = 0
    for task in range(count):
        for k in range(9):
            last[neighbour(xs[task], ys[task], k, bits)] += 1
    room = int64(0)
    for cell in range(cells):
        first[cell], room = room, room + whole_pieces(last[cell])
        last[cell] = first[cell]
    for task in range(count):
        place = pack_place(xs[task], ys[task], shift)
        for k in range(9):
            cell = neighbour(xs[task], ys[task], k, bits)
            places[last[cell]] = place  # no branch: another task overwrites one that is out of range
            last[cell] += int64(is_near_cell(xs[task], ys[task], k, bits, limit))
    for cell in range(cells):
        for slot in range(last[cell], whole_pieces(last[cell])):
            places[slot] = opposite(cell, bits, shift)


@inlined
def neighbour(x, y, k, bits):
    """Return the k-th of the nine cells round a task."""
    side, back = int64(1) << bits, uint32(32 - bits)
    column = (int64(uint32(x) >> back) + k % 3 - 1) & (side - 1)
    row = (int64(uint32(y) >> back) + k // 3 - 1) & (side - 1)
    return (row << bits) + column


@inlined
def is_near_cell(x, y, k, bits, limit):
    """Return whether a task is in range of a place in the k-th of the nine cells round it."""
    width = int64(1) << (32 - bits)
    way_x = way_to(int64(uint32(x)) & (width - 1), k % 3, width)
    way_y = way_to(int64(uint32(y)) & (width - 1), k // 3, width)
    return uint64(way_x * way_x + way_y * way_y) < limit


@inlined
def way_to(inside, column, width):
    """Return the least distance along an axis from within a cell to the cell before, itself or the next."""
    return int64(0) if column == 1 else (inside if column == 0 else width - inside)


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
        bounds = state.task_lists.bounds
        first, last = bounds[Bound.FIRST, cell], bounds[Bound.LAST, cell]
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
