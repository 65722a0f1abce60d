"""How a swarm or a joining robot begins: ids, places, faults, first phases (model.md 1, 4.1, 6.4, 6.6)."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.cells import block, near, sort_into_cells
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import (
    choose,
    coin,
    draw,
    draw_headings,
    draw_phases,
    draw_words,
    list_members,
    normal,
    phase_duration,
    present_phase,
    shuffle,
)
from feasibee.engine.inbox import clear_inbox, free_all_tables
from feasibee.engine.intrinsics import first_bits, lowest_member, pack_label, set_member, without_lowest
from feasibee.engine.knowledge import drop_delayed
from feasibee.engine.layout import WORD, Clock, Heard, Point, Robot, Set
from feasibee.engine.motion import head
from feasibee.engine.opinions import set_opinion
from feasibee.engine.params import Placement
from feasibee.engine.sensing import clear_counts, label_of, pack_place
from feasibee.model import purposes
from feasibee.model.codes import ATTEMPTS, NO_OPINION
from feasibee.model.outcomes import FILLS


@called
def assign_identities(params, state):
    """Give robots their ids, and robots and tasks their hashes."""
    for i in range(params.robots.count):
        state.robots[Robot.IDENTITY, i] = int32(i)
    if params.radio.random_ids:
        find_equal_ids(params, state)
    for thing in range(state.hashes.size):
        holder = int64(state.robots[Robot.IDENTITY, thing]) if thing < params.robots.count else int64(thing)
        words = draw_words(params, state.clock[Clock.RUN], holder, 0, purposes.IDENTITY)
        state.hashes[thing] = words[1]


@called
def find_equal_ids(params, state):
    """Find for each robot the first that has the same id, by a hash table in the room of the counts."""
    ids, table = state.robots[Robot.ORDER], state.counts
    size = 4 * table.shape[1]
    table[:] = 0
    for i in range(params.robots.count):
        word = draw(params, state.clock[Clock.RUN], i, 0, purposes.IDENTITY)
        ids[i] = int32(word >> uint32(32 - params.radio.id_bits))
        place = int64(uint32(uint32(ids[i]) * uint32(0x9E3779B1))) % size
        holder = table[place & 3, place >> 2]
        while holder > 0 and ids[holder - 1] != ids[i]:
            place = (place + 1) % size
            holder = table[place & 3, place >> 2]
        if holder == 0:
            table[place & 3, place >> 2] = i + 1
        else:
            state.robots[Robot.IDENTITY, i] = int32(holder - 1)


ROBOT = purposes.PLACE_ROBOT, purposes.CENTRE_ROBOT, purposes.CLUSTER_ROBOT, purposes.SCATTER_ROBOT
TASK = purposes.PLACE_TASK, purposes.CENTRE_TASK, purposes.CLUSTER_TASK, purposes.SCATTER_TASK
"""Purposes of the draws of a place: uniform, centre, cluster, offset from the centre."""


@inlined
def put(points, i, x, y):
    """Store the place of a robot or task; `Robot` and `Point` have their coordinates in the same rows."""
    points[Point.X, i], points[Point.Y, i] = int32(uint32(x)), int32(uint32(y))


@called
def place_tasks(params, state):
    """Place the tasks of the start, in the general engine."""
    for i in range(params.tasks.at_start):
        place_task(params, state, i)


@called
def place_task(params, state, i):
    """Place a task; one that appears later (model.md 6.17.4), at any of the given points."""
    placing, run = params.tasks.placement, state.clock[Clock.RUN]
    if placing.how == Placement.POINTS:
        given = i
        if i >= params.tasks.at_start:
            given = choose(draw(params, run, i, 0, purposes.PLACE_TASK), params.tasks.at_start)
        point = state.tables.points[params.robots.at_start + given]
        put(state.tasks, i, point[0], point[1])
        return
    if params.arena.place.exists:
        x, y = on_ground(params, state, i, params.robots.count + i, int64(0), int64(purposes.PLACE_TASK))
    else:
        x, y = candidate(params, placing, run, i, int64(0), int64(0), TASK)
    put(state.tasks, i, x, y)


@called
def place_robots(params, state):
    """Place the robots, in the general engine: apart if they avoid collisions, if need be on a lattice."""
    for i in range(params.robots.at_start):
        if params.robots.placement.how == Placement.POINTS:
            put(state.robots, i, state.tables.points[i, 0], state.tables.points[i, 1])
        elif not place_robot(params, state, i, False):
            place_on_lattice(params, state)
            return


@called
def place_robot(params, state, i, joins):
    """Draw places for a robot of the start, or one that joins, until one is clear; return whether one was.

    One that joins (model.md 6.17.7) may take any of the given points.
    """
    placing, run = params.robots.placement, state.clock[Clock.RUN]
    joined = int64(state.robots[Robot.JOINED, i]) if joins else int64(0)
    for attempt in range(ATTEMPTS):
        if placing.how == Placement.POINTS:
            word = draw(params, run, i, ATTEMPTS * joined + attempt, purposes.PLACE_ROBOT)
            point = state.tables.points[choose(word, params.robots.at_start)]
            x, y = int64(point[0]), int64(point[1])
        elif params.arena.place.exists:
            x, y = on_ground(params, state, i, i, ATTEMPTS * joined + attempt, int64(purposes.PLACE_ROBOT))
        else:
            x, y = candidate(params, placing, run, i, joined, int64(attempt), ROBOT)
        if put_clear(params, state, i, x, y, joins):
            return True
    return False


@called
def put_clear(params, state, i, x, y, joins):
    """Put a robot at a point; return whether it is clear of those there, or need not be."""
    put(state.robots, i, x, y)
    return not params.robots.avoid_collisions or is_clear(params, state, i, joins)


@called
def on_ground(params, state, i, thing, attempt, purpose):
    """Return a position drawn in a cell of a robot's or task's piece and zone (model.md 6.20.7)."""
    place, ground = params.arena.place, state.tables.ground
    words = draw_words(params, state.clock[Clock.RUN], i, attempt, purpose)
    first, number = int64(ground.stand_of[thing, 0]), int64(ground.stand_of[thing, 1])
    cell = int64(ground.stands[first + choose(words[0], number)])
    width = int64(1) << place.bits
    x = (cell % place.columns << place.bits) + choose(words[1], width)
    return x, (cell // place.columns << place.bits) + choose(words[2], width)


@inlined
def is_clear(params, state, i, joins):
    """Return whether a robot's disc overlaps none of those there; at the start, of the robots before it."""
    x, y, w = state.robots[Robot.X, i], state.robots[Robot.Y, i], int64(0)
    while w < state.sets.shape[1] and (joins or WORD * w < i):
        close = near(params, state.robots, WORD * w, WORD * (w + 1), x, y, params.robots.apart_limit)
        if close & (state.sets[Set.THERE, w] if joins else first_bits(max(i - WORD * w, 0))):
            return False
        w += 1
    return True


@called
def candidate(params, placing, run, i, joined, attempt, purposes):
    """Return the place drawn for a robot or task at an attempt; within walls, clipped to the arena.

    ``joined`` is the number of robots that had its number before it.
    """
    uniform, centre, cluster, scatter = purposes
    counter = ATTEMPTS * joined + attempt
    if placing.how == Placement.UNIFORM:
        return anywhere(params, placing, run, i, counter, uniform)
    chosen = choose(draw(params, run, i, joined, cluster), placing.clusters)
    x, y = anywhere(params, placing, run, chosen, int64(0), centre)
    spread = placing.spread * (1 + attempt // 32)  # wider after each 32 failed attempts
    dx = normal(params, run, i, 6 * counter, scatter, spread)
    dy = normal(params, run, i, 6 * counter + 3, scatter, spread)
    if params.arena.walls:
        low = placing.margin
        x = min(max(x + dx, low), params.arena.width - low)
        y = min(max(y + dy, low), params.arena.height - low)
    else:
        x, y = (x + dx) % params.arena.width, (y + dy) % params.arena.height
    return x, y


@called
def anywhere(params, placing, run, i, attempt, purpose):
    """Return a uniform place."""
    words = draw_words(params, run, i, attempt, purpose)
    low = placing.margin if params.arena.walls else 0
    return low + choose(words[0], params.arena.width - 2 * low), low + choose(
        words[1], params.arena.height - 2 * low
    )


@called
def place_on_lattice(params, state):
    """Place the robots on a square lattice over the whole arena, in random order, or as a place has it."""
    if params.arena.place.exists:
        for i in range(params.robots.at_start):
            put(state.robots, i, state.tables.ground.lattice[i, 0], state.tables.ground.lattice[i, 1])
        return
    step = 2 * params.robots.radius
    columns, rows = params.arena.width // step, params.arena.height // step
    shuffle(params, state.clock[Clock.RUN], state.robots[Robot.ORDER], params.robots.at_start, purposes.SITE)
    for i in range(params.robots.at_start):
        site = int64(state.robots[Robot.ORDER, i]) * (columns * rows) // params.robots.at_start
        x, y = params.robots.radius + site % columns * step, params.robots.radius + site // columns * step
        put(state.robots, i, x, y)


NEVER = 2**31 - 1
"""Steps left until a stopped robot turns or ends its phase."""


@called
def draw_faults(params, state):
    """Draw the faulty robots: the first of a shuffle stop, the next lie, the next are stubborn."""
    if params.faults.stopped + params.faults.byzantine + params.faults.stubborn == 0:
        return
    shuffle(params, state.clock[Clock.RUN], state.robots[Robot.ORDER], params.robots.at_start, purposes.FAULT)
    for k in range(params.faults.stopped):
        set_member(state.sets, Set.STOPPING, int64(state.robots[Robot.ORDER, k]), True)
    for k in range(params.faults.byzantine):
        i = int64(state.robots[Robot.ORDER, params.faults.stopped + k])
        set_member(state.sets, Set.BYZANTINE, i, True)
        set_member(state.sets, Set.COUNTED, i, False)
    for k in range(params.faults.stubborn):
        i = int64(state.robots[Robot.ORDER, params.faults.stopped + params.faults.byzantine + k])
        set_member(state.sets, Set.STUBBORN, i, True)


@inlined
def stand_still(robots, i):
    """Let a robot neither move nor end a phase again."""
    robots[Robot.WALK_LEFT, i] = robots[Robot.PHASE_LEFT, i] = NEVER
    robots[Robot.STEP_X, i] = robots[Robot.STEP_Y, i] = 0


@called
def stop(params, state, w):
    """Stop the robots of a word with that fault for the rest of the run (model.md 6.6)."""
    stopping = state.sets[Set.STOPPING, w]
    left = stopping
    while left:
        stand_still(state.robots, lowest_member(w, left))
        left = without_lowest(left)
    for kind in (Set.WORKING, Set.COUNTED, Set.DISSEMINATING, Set.SPEAKING, Set.BLOCKED):
        state.sets[kind, w] &= ~stopping
    while stopping:
        i = lowest_member(w, stopping)
        state.robots[Robot.LABEL, i] = label_of(state, i)
        drop_delayed(state, i)
        stopping = without_lowest(stopping)


@called
def clear(params, state, run):
    """Clear what the previous run left in the state."""
    state.clock[Clock.RUN] = run
    state.clock[Clock.STEP] = 0
    state.clock[Clock.FULL] = 0
    state.clock[Clock.PENDING] = 0
    for column in range(state.account.size):
        state.account[column] = FILLS[column]
    for w in range(state.sets.shape[1]):
        for kind in range(state.sets.shape[0]):
            state.sets[kind, w] = uint32(0)
        state.sets[Set.THERE, w] = first_bits(max(params.robots.at_start - 32 * w, 0))
        for kind in (Set.WORKING, Set.COUNTED, Set.JOINING, Set.PRESENT):
            state.sets[kind, w] = state.sets[Set.THERE, w]
    for w in range(state.tasks_there.size):
        state.tasks_there[w] = first_bits(max(params.tasks.at_start - 32 * w, 0))
    state.clock[Clock.ROBOTS], state.clock[Clock.TASKS] = params.robots.at_start, params.tasks.at_start
    state.clock[Clock.MISS], state.clock[Clock.LOSS] = params.sensing.miss, params.radio.loss
    state.clock[Clock.TRUTH] = int64(params.truth)
    for i in range(state.delayed.shape[1]):
        drop_delayed(state, i)
    set_inventions(params, state.clock)
    set_quorum(params, state.clock, params.robots.at_start - params.faults.byzantine)


@inlined
def set_quorum(params, clock, counted):
    """Store over how many robots the decision is taken, and how many of them it needs (model.md 4.7)."""
    clock[Clock.COUNTED] = counted
    clock[Clock.QUORUM] = counted * params.decision.quorum.share // params.decision.quorum.whole + 1


@inlined
def set_inventions(params, clock):
    """Store how many robots or tasks Byzantine robots invent (model.md 6.12, 6.16)."""
    robots, tasks, exactly = clock[Clock.ROBOTS], clock[Clock.TASKS], int64(params.faults.exactly)
    clock[Clock.INVENTED_ROBOTS] = tasks - exactly * robots
    clock[Clock.INVENTED_TASKS] = robots + 1 - exactly * tasks


@spliced
def prepare_robots(params, state):
    """Give robots in their places a first opinion, heading and phase (model.md 2.1, 4.1)."""
    sort_tasks(params, state)
    w, working = int64(0), state.sets[Set.WORKING]
    while w < working.size:
        w, count = list_members(state, 0, working, w, working.size)
        for k in range(count):
            i = int64(state.heard[0, Heard.RECEIVER, k])
            state.robots[Robot.LABEL, i] = pack_label(i, False, False)
            state.robots[Robot.WALKS, i] = state.robots[Robot.PHASES, i] = state.robots[Robot.JOINED, i] = 0
        draw_headings(params, state, 0, count)
        for k in range(count):
            head(params, state, 0, int64(state.heard[0, Heard.RECEIVER, k]), k)
        draw_phases(params, state, 0, count)
        for k in range(count):
            prepare_robot(params, state, int64(state.heard[0, Heard.RECEIVER, k]), k)
    for i in range(params.robots.at_start, state.robots.shape[1]):
        stand_still(state.robots, i)
        state.robots[Robot.WALKS, i] = state.robots[Robot.PHASES, i] = state.robots[Robot.JOINED, i] = 0
        state.robots[Robot.LABEL, i] = pack_label(i, False, False)
    free_all_tables(state)


@called
def sort_tasks(params, state):
    """Sort the tasks in their places so that robots find those in sight."""
    xs, ys = state.tasks[Point.X], state.tasks[Point.Y]
    for task in range(params.tasks.count):
        state.tasks[Point.NUMBER, task] = task
    points = (xs, ys, state.tasks[Point.NUMBER])
    sort_into_cells(state.task_cells, params.tasks.grid, points, state.tasks_there, params.tasks.count)
    if params.sensing.merges:
        name_tasks(params, state)
    if params.tasks.numbered:
        for task in range(params.tasks.count):
            state.task_places[task] = pack_place(xs[task], ys[task], uint32(16))


@called
def name_tasks(params, state):
    """Give each task the name of the lowest in its chain of tasks under one name (model.md 6.24)."""
    names, chain, cells = state.names, state.heard[0, Heard.RECEIVER], state.task_cells
    names[:] = -1
    for lowest in range(names.size):
        if names[lowest] >= 0:
            continue
        names[lowest] = chain[0] = lowest
        waiting = int64(1)
        while waiting > 0:
            waiting -= 1
            x, y = state.tasks[Point.X, chain[waiting]], state.tasks[Point.Y, chain[waiting]]
            first, last, other_first, other_last = block(cells, params.tasks.grid, x, y)
            for _ in range(2):
                for begin in range(first, last, WORD):
                    close = near(params, cells.points, begin, last, x, y, params.sensing.merge_limit)
                    while close:
                        task = cells.points[Point.NUMBER, lowest_member(0, close) + begin]
                        if names[task] < 0:
                            names[task], chain[waiting] = lowest, task
                            waiting += 1
                        close = without_lowest(close)
                first, last = other_first, other_last


@spliced
def prepare_robot(params, state, i, k):
    """Give a robot, entry ``k`` of those that draw, its first opinion and phase."""
    word = draw(
        params, state.clock[Clock.RUN], i, int64(state.robots[Robot.JOINED, i]), purposes.FIRST_OPINION
    )
    set_opinion(state.sets, i, coin(word))
    if params.strategy.starts_neutral:
        set_opinion(state.sets, i, int64(NO_OPINION))
    length, _, _ = present_phase(params, state, 0, i, k)
    enter_phase(state, i, phase_duration(params, state, i, length, params.decision.exploration))
    clear_inbox(params, state, i)
    clear_counts(params, state, i)
    state.robots[Robot.AGREED, i] = 0
    state.memory[i] = 0.0
    state.memory[i, 0] = 0.5  # until it has rated


@inlined
def enter_phase(state, i, lasts):
    """Begin a robot's next phase, of a given duration in steps."""
    state.robots[Robot.PHASES, i] += int32(1)
    state.robots[Robot.PHASE_LEFT, i] = lasts
    state.robots[Robot.LABEL, i] = label_of(state, i)
