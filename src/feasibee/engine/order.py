"""The robots of a large swarm, sorted in space every few steps.

Robots that meet should lie close together in memory. So the state is sorted by tiles of cells, in rows.
Between two sorts robots move only a few cells. Place i of the arrays then holds another robot than number i:
its label has its number. Draws are coordinates of that number, so the order changes no result.

Robots are sorted into cells in each step. Each thread does that for some rows of cells. It gets its own
robots that are in these rows, and those that others have listed as leaving.
"""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.bits import bit_if, contains
from feasibee.engine.cells import (
    cell_of,
    clear_cells,
    count_point,
    is_one_cell,
    place,
    place_at,
    sum_up,
)
from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import bits_of, float_of
from feasibee.engine.layout import LINE, TILE, WORD, Clock, Count, Robot, Set, Share
from feasibee.engine.team import first_word, wait_for_all

INTERVAL = 8
"""Steps between two sorts."""
NUMBERS = tuple(int(each) for each in Robot if each not in (Robot.ORDER, Robot.SPARE))
"""Rows of `State.robots` that are sorted."""
OPINION_SETS = tuple(
    map(int, (Set.FEASIBLE, Set.NEUTRAL, Set.DISSEMINATING, Set.SPEAKING, Set.SAYS_FEASIBLE))
)
FAULT_SETS = tuple(map(int, (Set.WORKING, Set.COUNTED, Set.BYZANTINE, Set.STUBBORN, Set.STOPPING)))


@inlined
def keep_order(params, state, part):
    """Sort the robots by tiles, if it is time."""
    if params.in_space_order and state.clock[Clock.STEP] % INTERVAL == 0:
        sort_robots(params, state, part)


@called
def sort_robots(params, state, part):
    """Sort the robots by tiles."""
    tiles = state.tiles[part.thread]
    tiles[:] = 0
    for i in range(WORD * part.first, end_of(params, part)):
        tiles[tile_of(params.robots.grid, state, i)] += int32(1)
    wait_for_all(part)
    if part.thread == 0:
        sum_up_tiles(params, state, part)
    wait_for_all(part)
    order = state.robots[Robot.ORDER]
    for i in range(WORD * part.first, end_of(params, part)):
        tile = tile_of(params.robots.grid, state, i)
        order[tiles[tile]] = int32(i)
        tiles[tile] += int32(1)
    wait_for_all(part)
    share_rows(params, state, part)
    move_numbers(params, state, part, order)
    move_counts(params, state, part, order)
    move_sets(params, state, part, order)
    move_inboxes(params, state, part, order)


@inlined
def end_of(params, part):
    """Return the place after a thread's last robot."""
    return min(WORD * part.last, params.robots.count)


@inlined
def tile_of(grid, state, i):
    """Return the tile of a robot; tiles are numbered by rows."""
    column = cell_of(state.robots[Robot.X, i], grid.scale_x)
    row = cell_of(state.robots[Robot.Y, i], grid.scale_y)
    return row // TILE * tile_columns(grid) + column // TILE


@inlined
def tile_columns(grid):
    """Return the number of tiles of a row."""
    return (grid.columns + TILE - 1) // TILE


@inlined
def sum_up_tiles(params, state, part):
    """Replace numbers of robots by the places where each thread's robots of a tile begin."""
    begin = int32(0)
    for tile in range(state.tiles.shape[1]):
        for thread in range(part.threads):
            number = state.tiles[thread, tile]
            state.tiles[thread, tile] = begin
            begin += number


@inlined
def share_rows(params, state, part):
    """Let each thread have the rows of cells from that of its first robot on."""
    grid = params.robots.grid
    first = int64(state.robots[Robot.ORDER, WORD * part.first])
    row = tile_of(grid, state, first) // tile_columns(grid) * TILE
    part.shared[part.thread, Share.ROW] = 0 if part.thread == 0 else row


@inlined
def move_numbers(params, state, part, order):
    """Put the rows of `State.robots` in the new order."""
    for kind in NUMBERS:
        if is_used(params, kind):
            move_row(params, part, state.robots[kind], state.robots[Robot.SPARE], order)


@called
def move_row(params, part, row, spare, order):
    """Put a row of numbers in the new order, by way of a spare row."""
    first, last = WORD * part.first, end_of(params, part)
    for i in range(first, last):
        spare[i] = row[order[i]]
    wait_for_all(part)
    for i in range(first, last):
        row[i] = spare[i]


@inlined
def is_used(params, kind):
    """Return whether a scenario uses a row of `State.robots`."""
    if kind == Robot.AGREED:
        return params.decision.commit.enabled
    if kind == Robot.SENT_VALUE:
        return params.strategy.value_scale > 0.0
    if kind == Robot.IDENTITY:
        return params.radio.random_ids
    return kind != Robot.MESSAGES or params.decision.inbox_size > 0


@inlined
def move_counts(params, state, part, order):
    """Put counts, memory and what was seen of each class in the new order."""
    spare, first, last = state.counts[Count.SPARE], WORD * part.first, end_of(params, part)
    for kind in range(int64(Count.SENT_BITS)):
        move_row(params, part, state.counts[kind], spare, order)
    for k in range(state.memory.shape[1]):
        for i in range(first, last):
            spare[i] = bits_of(state.memory[order[i], k])
        wait_for_all(part)
        for i in range(first, last):
            state.memory[i, k] = float_of(spare[i])
    if state.seen.shape[0] > 0:
        for k in range(state.seen.shape[1]):
            for i in range(first, last):
                spare[i] = state.seen[order[i], k]
            wait_for_all(part)
            for i in range(first, last):
                state.seen[i, k] = spare[i]


@inlined
def move_sets(params, state, part, order):
    """Put the sets that last from step to step in the new order."""
    faults = params.faults.stopped + params.faults.byzantine + params.faults.stubborn > 0
    for kind in OPINION_SETS:
        move_set(params, state, part, order, kind)
    if params.decision.commit.enabled:
        move_set(params, state, part, order, int64(Set.COMMITTED))
    if params.arena.walls or params.robots.avoid_collisions:
        move_set(params, state, part, order, int64(Set.BLOCKED))
    if faults:
        for kind in FAULT_SETS:
            move_set(params, state, part, order, kind)


@called
def move_set(params, state, part, order, kind):
    """Put a set in the new order."""
    spare, words = state.sets[Set.SPARE], state.sets[kind]
    for w in range(part.first, part.last):
        word = uint32(0)
        for j in range(min(WORD, params.robots.count - WORD * w)):
            word |= bit_if(contains(words, order[WORD * w + j]), j)
        spare[w] = word
    wait_for_all(part)
    for w in range(part.first, part.last):
        words[w] = spare[w]


@inlined
def move_inboxes(params, state, part, order):
    """Put the lines of the inboxes in the new order; tables stay where they are."""
    if params.decision.every_message:
        return
    first, last, rows = WORD * part.first, end_of(params, part), state.inbox.shape[0]
    spare = state.inbox[rows - 1]
    for kind in range(rows - 1):
        slots = state.inbox[kind]
        for i in range(first, last):
            old = LINE * int64(order[i])
            for k in range(LINE):
                spare[LINE * i + k] = slots[old + k]
        wait_for_all(part)
        for place_ in range(LINE * first, LINE * last):
            slots[place_] = spare[place_]


@called
def fill_robots(params, state, part):
    """Sort the robots into cells, each thread those in its rows."""
    grid, cells, robots = params.robots.grid, state.robot_cells, state.robots
    if is_one_cell(grid):
        cells.start[1] = cells.start[2] = int32(params.robots.count)
        for i in range(WORD * part.first, end_of(params, part)):
            place_at(cells.points, i, robots[Robot.X, i], robots[Robot.Y, i], numbered(state, i))
        wait_for_all(part)
        return
    low, high = part.shared[part.thread, Share.ROW], grid.rows
    if part.thread + 1 < part.threads:
        high = part.shared[part.thread + 1, Share.ROW]
    first_cell, last_cell = low * (grid.columns + 1), high * (grid.columns + 1)
    clear_cells(cells.start, first_cell, last_cell)
    points = count_own(params, state, part, low, high)
    wait_for_all(part)
    points += count_arriving(params, state, part, low, high)
    part.shared[part.thread, Share.POINTS] = points
    wait_for_all(part)
    begin = int64(0)
    for thread in range(part.thread):
        begin += part.shared[thread, Share.POINTS]
    sum_up(cells.start, first_cell, last_cell, begin)
    place_own(params, state, part, low, high)
    place_arriving(params, state, part, low, high)
    wait_for_all(part)


@inlined
def numbered(state, i):
    """Return what stands for a robot in the cells: its place, and as the lowest bit whether it broadcasts."""
    return int32(i << 1) | (state.robots[Robot.LABEL, i] & int32(1))


@inlined
def count_own(params, state, part, low, high):
    """Count a thread's robots in its rows of cells, and list the others; return the places that they take."""
    grid, start, points = params.robots.grid, state.robot_cells.start, int64(0)
    xs, ys, leaving = state.robots[Robot.X], state.robots[Robot.Y], state.robots[Robot.ORDER]
    first = listed = WORD * part.first
    for i in range(first, end_of(params, part)):
        row = cell_of(ys[i], grid.scale_y)
        if low <= row < high:
            points += count_point(start, grid, cell_of(xs[i], grid.scale_x), row)
        else:
            leaving[listed] = int32(i)
            listed += 1
    part.shared[part.thread, Share.LEAVING] = listed - first
    return points


@inlined
def place_own(params, state, part, low, high):
    """Store a thread's robots in its rows of cells."""
    grid, cells, xs, ys = params.robots.grid, state.robot_cells, state.robots[Robot.X], state.robots[Robot.Y]
    for i in range(WORD * part.first, end_of(params, part)):
        row = cell_of(ys[i], grid.scale_y)
        if low <= row < high:
            place(cells, grid, cell_of(xs[i], grid.scale_x), row, xs[i], ys[i], numbered(state, i))


@inlined
def count_arriving(params, state, part, low, high):
    """Count the robots in a thread's rows of cells that other threads have listed as leaving."""
    grid, start, points = params.robots.grid, state.robot_cells.start, int64(0)
    xs, ys, leaving = state.robots[Robot.X], state.robots[Robot.Y], state.robots[Robot.ORDER]
    for thread in range(part.threads):
        first = WORD * first_word(state.sets.shape[1], thread, part.threads)
        for k in range(first, first + part.shared[thread, Share.LEAVING]):
            i = leaving[k]
            row = cell_of(ys[i], grid.scale_y)
            if low <= row < high:
                points += count_point(start, grid, cell_of(xs[i], grid.scale_x), row)
    return points


@inlined
def place_arriving(params, state, part, low, high):
    """Store the robots that have been listed as leaving in the thread's rows of cells."""
    grid, cells, xs, ys = params.robots.grid, state.robot_cells, state.robots[Robot.X], state.robots[Robot.Y]
    leaving = state.robots[Robot.ORDER]
    for thread in range(part.threads):
        first = WORD * first_word(state.sets.shape[1], thread, part.threads)
        for k in range(first, first + part.shared[thread, Share.LEAVING]):
            i = int64(leaving[k])
            row = cell_of(ys[i], grid.scale_y)
            if low <= row < high:
                place(cells, grid, cell_of(xs[i], grid.scale_x), row, xs[i], ys[i], numbered(state, i))
