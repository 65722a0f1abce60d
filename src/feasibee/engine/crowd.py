"""Swarms of more than 128 robots: sorted in space, sight and radio through cells.

Robots that meet should lie close together in memory. So the state is sorted by tiles of cells, in rows.
Between two sorts robots move only a few cells. Place i of the arrays then holds another robot than number i:
its label has its number. Draws are coordinates of that number, so the order changes no result.

Robots are sorted into cells in each step. Each thread does that for some rows of cells. It gets its own
robots that are in these rows, and those that others have listed as leaving.

In the paper's world threads wait for each other four times a step, and seven times more where they sort.

Each robot looks through the cells around it. What it hears, or sees if that has to be looked at closely, is
queued, and worked off for many robots at once. So the loops over robots have little to keep in registers.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.cells import (
    append,
    are_few,
    block,
    cell_at,
    cell_of,
    clear_cells,
    count_point,
    count_within,
    few_near,
    few_near_both,
    is_one_cell,
    near,
    near_both,
    place_at,
    repeat_columns,
    repeated,
    sort_into_cells,
    sum_up,
)
from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import (
    LANES,
    bit_if,
    bits_of,
    contains,
    float_of,
    has_bit,
    lowest_member,
    popcount,
    without_lowest,
)
from feasibee.engine.layout import LINE, TILE, WORD, Clock, Count, Heard, Point, Robot, Set, Share
from feasibee.engine.queues import few_odd, few_others, many_odd, many_others, store_few, store_many
from feasibee.engine.team import comes_last, first_word, let_go, wait_for_all

INTERVAL = 8
"""Steps between two sorts."""
ROOM = int(Robot.ORDER), int(Robot.SPARE)
"""Rows of `State.robots` that are only room to work in."""
ONLY_CHANGING = int(Robot.LEAVES_AT), int(Robot.JOINED), int(Robot.SWITCHES_AT)
"""Rows of `State.robots` for worlds that change, in which robots aren't sorted."""
OPINION_SETS = tuple(
    map(int, (Set.FEASIBLE, Set.NEUTRAL, Set.DISSEMINATING, Set.SPEAKING, Set.SAYS_FEASIBLE))
)
DECLARED_SETS = int(Set.DECLARED), int(Set.DECLARED_FEASIBLE)
FAULT_SETS = tuple(map(int, (Set.WORKING, Set.COUNTED, Set.BYZANTINE, Set.STUBBORN, Set.STOPPING)))


@inlined
def keep_order(params, state, part):
    """Sort the robots by tiles, if it is time."""
    if params.in_space_order and state.clock[Clock.STEP] % INTERVAL == 0:
        sort_robots(params, state, part)


@called
def sort_robots(params, state, part):
    """Sort the robots by tiles."""
    tiles, tile_of, order = state.tiles[part.thread], state.robots[Robot.SPARE], state.robots[Robot.ORDER]
    first, last = WORD * part.first, end_of(params, part)
    find_tiles(params, state, first, last)
    tiles[:] = 0
    for i in range(first, last):
        tiles[uint64(uint32(tile_of[i]))] += int32(1)
    if comes_last(part):
        sum_up_tiles(params, state, part)
        let_go(part)
    for i in range(first, last):
        tile = uint64(uint32(tile_of[i]))
        order[uint64(uint32(tiles[tile]))] = int32(i)
        tiles[tile] += int32(1)
    wait_for_all(part)
    share_rows(params, state, part)
    move_state(params, state, part, order)


@inlined
def find_tiles(params, state, first, last):
    """Store the tile of each robot; tiles are numbered by rows."""
    grid, xs, ys = params.robots.grid, state.robots[Robot.X], state.robots[Robot.Y]
    scale_x, scale_y, columns = grid.scale_x, grid.scale_y, (grid.columns + TILE - 1) // TILE
    tiles = state.robots[Robot.SPARE]
    for i in range(first, last):
        tiles[i] = int32(cell_of(ys[i], scale_y) // TILE * columns + cell_of(xs[i], scale_x) // TILE)


@inlined
def end_of(params, part):
    """Return the place after a thread's last robot."""
    return min(WORD * part.last, params.robots.count)


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
    first = state.robots[Robot.ORDER, WORD * part.first]
    row = cell_of(state.robots[Robot.Y, first], grid.scale_y) // TILE * TILE
    part.shared[part.thread, Share.ROW] = 0 if part.thread == 0 else row


@called
def move_state(params, state, part, order):
    """Put what is stored of each robot in the new order: gather it, wait for all, and store it.

    The room of the inboxes serves for eight rows of numbers at a time, so that threads seldom wait.
    """
    gather_numbers(params, state, part, order, 0)
    gather_sets(params, state, part, order)
    wait_for_all(part)
    store_numbers(params, state, part, 0)
    store_sets(params, state, part)
    gather_numbers(params, state, part, order, LINE)
    wait_for_all(part)
    store_numbers(params, state, part, LINE)
    gather_counts(params, state, part, order)
    wait_for_all(part)
    store_counts(params, state, part)
    move_columns(params, state, part, order)
    move_inboxes(params, state, part, order)


@inlined
def spare_row(state):
    """Return the row of `State.inbox` to sort in.

    A thread uses the lines of its own robots there, for eight rows of numbers of 32 bits.
    """
    return state.inbox.shape[0] - 1


@inlined
def room_of(part, row):
    """Return where the spare room for a row of a thread's robots begins."""
    return WORD * (LINE * part.first + row * (part.last - part.first))


@called
def gather_numbers(params, state, part, order, begin):
    """Gather up to eight rows of `State.robots`, from ``begin`` on."""
    spare, first = state.inbox[spare_row(state)], WORD * part.first
    for kind in range(begin, begin + LINE):
        if is_used(params, kind):
            row, room = state.robots[kind], room_of(part, kind - begin) - first
            for i in range(first, end_of(params, part)):
                spare[uint64(room + i)] = row[uint64(uint32(order[i]))]


@called
def store_numbers(params, state, part, begin):
    """Store what `gather_numbers` has gathered."""
    spare, first = state.inbox[spare_row(state)], WORD * part.first
    for kind in range(begin, begin + LINE):
        if is_used(params, kind):
            row, room = state.robots[kind], room_of(part, kind - begin) - first
            for i in range(first, end_of(params, part)):
                row[i] = spare[uint64(room + i)]


@inlined
def is_used(params, kind):
    """Return whether a scenario uses a row of `State.robots` that is sorted."""
    if kind == Robot.AGREED:
        return params.decision.declare.enabled
    if kind == Robot.SENT_VALUE:
        return params.strategy.value_scale > 0.0
    if kind == Robot.IDENTITY:
        return params.radio.random_ids
    if kind == Robot.MESSAGES:
        return params.decision.inbox_size > 0
    return kind not in ROOM and kind not in ONLY_CHANGING


@inlined
def gather_counts(params, state, part, order):
    """Gather the counts, each as two numbers of 32 bits."""
    spare, first = state.inbox[spare_row(state)], WORD * part.first
    for kind in range(int64(Count.SENT_BITS)):
        row = state.counts[kind]
        low, high = room_of(part, 2 * kind) - first, room_of(part, 2 * kind + 1) - first
        for i in range(first, end_of(params, part)):
            number = row[uint64(uint32(order[i]))]
            spare[uint64(low + i)] = int32(uint32(number))
            spare[uint64(high + i)] = int32(number >> 32)


@inlined
def store_counts(params, state, part):
    """Store what `gather_counts` has gathered."""
    spare, first = state.inbox[spare_row(state)], WORD * part.first
    for kind in range(int64(Count.SENT_BITS)):
        row = state.counts[kind]
        low, high = room_of(part, 2 * kind) - first, room_of(part, 2 * kind + 1) - first
        for i in range(first, end_of(params, part)):
            row[i] = int64(spare[uint64(high + i)]) << 32 | int64(uint32(spare[uint64(low + i)]))


@inlined
def move_columns(params, state, part, order):
    """Put memory and what was seen of each class in the new order, column by column."""
    spare, first, last = state.counts[Count.SPARE], WORD * part.first, end_of(params, part)
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
def gather_sets(params, state, part, order):
    """Gather the sets, as words; a row of numbers has room for 32 of them."""
    spare, words = state.robots[Robot.SPARE], state.sets.shape[1]
    for kind in range(state.sets.shape[0]):
        if is_kept(params, kind):
            members = state.sets[kind]
            for w in range(part.first, part.last):
                word = uint32(0)
                for j in range(min(WORD, params.robots.count - WORD * w)):
                    word |= bit_if(contains(members, uint64(uint32(order[WORD * w + j]))), j)
                spare[uint64(words * kind + w)] = int32(word)


@inlined
def store_sets(params, state, part):
    """Store what `gather_sets` has gathered."""
    spare, words = state.robots[Robot.SPARE], state.sets.shape[1]
    for kind in range(state.sets.shape[0]):
        if is_kept(params, kind):
            for w in range(part.first, part.last):
                state.sets[kind, w] = uint32(spare[uint64(words * kind + w)])


@inlined
def is_kept(params, kind):
    """Return whether a set lasts from step to step, and has some of the robots."""
    if kind == Set.JOINING:
        return params.decision.first_sight
    if kind in DECLARED_SETS:
        return params.decision.declare.enabled
    if kind == Set.BLOCKED:
        return params.arena.walls or params.robots.avoid_collisions
    if kind in FAULT_SETS:
        return params.faults.stopped + params.faults.byzantine + params.faults.stubborn > 0
    return kind in OPINION_SETS


@inlined
def move_inboxes(params, state, part, order):
    """Put the lines of the inboxes in the new order; tables stay where they are."""
    if params.decision.every_message:
        return
    first, last, spare = WORD * part.first, end_of(params, part), state.inbox[spare_row(state)]
    for kind in range(spare_row(state)):
        slots = state.inbox[kind]
        for i in range(first, last):
            old = LINE * int64(uint32(order[i]))
            for k in range(LINE):
                spare[uint64(LINE * i + k)] = slots[uint64(old + k)]
        wait_for_all(part)
        for place in range(LINE * first, LINE * last):
            slots[uint64(place)] = spare[uint64(place)]


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
    first, last = low * (grid.columns + 1), high * (grid.columns + 1)
    clear_cells(cells.start, first, last)
    count_own(params, state, part, first, last)
    part.shared[part.thread, Share.POINTS] += repeated(cells.start, grid, low, high)
    wait_for_all(part)
    begin = count_arriving(params, state, part, first, last)
    for thread in range(part.thread):
        begin += part.shared[thread, Share.POINTS]
    sum_up(cells.start, grid, low, high, begin)
    place_own(params, state, part, first, last)
    place_arriving(params, state, part, first, last)
    repeat_columns(cells, grid, low, high, begin)
    wait_for_all(part)


@called
def fill_there(params, state):
    """Sort the robots that are there into cells, in a world that changes: one thread does it all."""
    numbers = state.robots[Robot.SPARE]
    for i in range(params.robots.count):
        numbers[i] = numbered(state, i)
    points = (state.robots[Robot.X], state.robots[Robot.Y], numbers)
    sort_into_cells(state.robot_cells, params.robots.grid, points, state.sets[Set.THERE], params.robots.count)


@inlined
def numbered(state, i):
    """Return what stands for a robot in the cells: its place, and as the lowest bit whether it broadcasts."""
    return int32(i << 1) | (state.robots[Robot.LABEL, i] & int32(1))


@inlined
def count_own(params, state, part, first_cell, last_cell):
    """Find the cell of each of a thread's robots; count those in its own cells, and list the others."""
    grid, start, cells = params.robots.grid, state.robot_cells.start, state.robots[Robot.SPARE]
    leaving, first, last = state.robots[Robot.ORDER], WORD * part.first, end_of(params, part)
    find_cells(grid, state, first, last)
    listed = first
    for i in range(first, last):
        cell = int64(cells[i])
        if first_cell <= cell < last_cell:
            count_point(start, cell)
        else:
            leaving[listed] = int32(i)
            listed += 1
    part.shared[part.thread, Share.LEAVING] = listed - first
    part.shared[part.thread, Share.POINTS] = last - listed


@inlined
def find_cells(grid, state, first, last):
    """Store the cell of each robot: a loop of its own, which LLVM vectorizes."""
    cells, xs, ys = state.robots[Robot.SPARE], state.robots[Robot.X], state.robots[Robot.Y]
    for i in range(first, last):
        cells[i] = int32(cell_at(grid, xs[i], ys[i]))


@inlined
def place_own(params, state, part, first_cell, last_cell):
    """Store a thread's robots in its cells."""
    cells, xs, ys = state.robots[Robot.SPARE], state.robots[Robot.X], state.robots[Robot.Y]
    for i in range(WORD * part.first, end_of(params, part)):
        if first_cell <= cells[i] < last_cell:
            append(state.robot_cells, int64(cells[i]), xs[i], ys[i], numbered(state, i))


@inlined
def count_arriving(params, state, part, first_cell, last_cell):
    """Count the robots in a thread's cells that other threads have listed as leaving.

    Return how many places robots so listed take in the cells of the threads before.
    """
    grid, cells, before = params.robots.grid, state.robots[Robot.SPARE], int64(0)
    leaving = state.robots[Robot.ORDER]
    for thread in range(part.threads):
        first = WORD * first_word(state.sets.shape[1], thread, part.threads)
        for k in range(first, first + part.shared[thread, Share.LEAVING]):
            cell = int64(cells[leaving[k]])
            if first_cell <= cell < last_cell:
                count_point(state.robot_cells.start, cell)
            elif cell < first_cell:
                before += 2 if grid.columns > 1 and cell % (grid.columns + 1) == 0 else 1
    return before


@inlined
def place_arriving(params, state, part, first_cell, last_cell):
    """Store the robots that have been listed as leaving in the thread's cells."""
    cells, xs, ys = state.robots[Robot.SPARE], state.robots[Robot.X], state.robots[Robot.Y]
    leaving = state.robots[Robot.ORDER]
    for thread in range(part.threads):
        first = WORD * first_word(state.sets.shape[1], thread, part.threads)
        for k in range(first, first + part.shared[thread, Share.LEAVING]):
            i = int64(leaving[k])
            if first_cell <= cells[i] < last_cell:
                append(state.robot_cells, int64(cells[i]), xs[i], ys[i], numbered(state, i))


@inlined
def look_and_listen(params, state, part, i, exploring, listening, queued):
    """Count the robots in sight of a robot and queue the messages that it hears, by its bits in two words."""
    seen, queued = scan(params, state, part, i, has_bit(listening, i), queued)
    explores = -int64(has_bit(exploring, i))
    state.counts[Count.ROBOTS_SEEN, i] += explores & (seen - 1 + params.sensing.count_self)
    return queued


@inlined
def scan(params, state, part, i, listens, queued):
    """Return how many robots are in sight of a robot, itself included; queue the messages that it hears."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    first, last, other_first, other_last = block(state.robot_cells, params.robots.grid, x, y)
    if not are_few(first, last, other_first, other_last):
        return scan_many(params, state, part, i, listens, queued, (first, last, other_first, other_last))
    heard, numbers, own = state.heard[part.thread], points[Point.NUMBER], own_number(i)
    seen, close = few_near_both(params, points, first, last, x, y)
    other_seen, other_close = few_near_both(params, points, other_first, other_last, x, y)
    if listens:
        queued = queue_few(heard, numbers, first, close & few_odd(numbers, first, own), i, queued)
        other_close &= few_odd(numbers, other_first, own)
        queued = queue_few(heard, numbers, other_first, other_close, i, queued)
    return popcount(uint32(seen | other_seen << uint32(LANES))), queued


@inlined
def scan_many(params, state, part, i, listens, queued, stretches):
    """Do what `scan` does where more robots are around."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    first, last, other_first, other_last = stretches
    total = int64(0)
    for _ in range(2):
        while first < last:
            seen, close = near_both(params, points, first, last, x, y)
            total += popcount(seen)
            if listens:
                close &= many_odd(points[Point.NUMBER], first, own_number(i))
                queued = queue_many(state.heard[part.thread], points[Point.NUMBER], first, close, i, queued)
            first += WORD
        first, last = other_first, other_last
    return total, queued


@inlined
def own_number(i):
    """Return what stands for a robot in the cells while it broadcasts."""
    return int32(int32(i) << int32(1)) | int32(1)


@inlined
def queue_few(heard, numbers, first, chosen, i, queued):
    """Queue the chosen ones of 8 numbers for a robot; return how many are queued."""
    return queued + store_few(numbers, first, chosen, heard[Heard.SENDER], queued, i, heard[Heard.RECEIVER])


@inlined
def queue_many(heard, numbers, first, chosen, i, queued):
    """Queue the chosen ones of 32 numbers for a robot; return how many are queued.

    Even if none is chosen: a branch would often be mispredicted, which took a tenth of a step.
    """
    return queued + store_many(numbers, first, chosen, heard[Heard.SENDER], queued, i, heard[Heard.RECEIVER])


@inlined
def count_tasks(params, state, part):
    """Count the tasks in sight of exploring robots."""
    grid, xs, ys = params.tasks.grid, state.robots[Robot.X], state.robots[Robot.Y]
    limit, cells = params.sensing.limit, state.task_cells
    for w in range(part.first, part.last):
        left = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while left:
            i = uint64(lowest_member(w, left))
            state.counts[Count.TASKS_SEEN, i] += count_within(params, cells, grid, xs[i], ys[i], limit)
            left = without_lowest(left)


@inlined
def queue_near(params, state, part, cells, grid, i, limit, queued, but):
    """Queue what is near a robot, robots or tasks; return how many are queued.

    ``limit`` is above their squared distances. A robot is near itself: it is left out as ``but``, or -1 is.
    """
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], cells.points
    first, last, other_first, other_last = block(cells, grid, x, y)
    heard, numbers = state.heard[part.thread], points[Point.NUMBER]
    if are_few(first, last, other_first, other_last):
        close = few_near(params, points, first, last, x, y, limit) & few_others(numbers, first, but)
        queued = queue_few(heard, numbers, first, close, i, queued)
        close = few_near(params, points, other_first, other_last, x, y, limit)
        close &= few_others(numbers, other_first, but)
        return queue_few(heard, numbers, other_first, close, i, queued)
    for _ in range(2):
        while first < last:
            close = near(params, points, first, last, x, y, limit) & many_others(numbers, first, but)
            queued = queue_many(heard, numbers, first, close, i, queued)
            first += WORD
        first, last = other_first, other_last
    return queued
