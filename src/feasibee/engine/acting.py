"""Robots that act: ways to tasks, arrivals, what they know of tasks, and what they choose (model.md 6.25).

`act` is passed to the step as a pointer, so that worlds in which nobody acts don't compile it. One thread
simulates robots that act. A version in `State.news` and `State.told` is one more than the model's; 0 stands
for nothing.
"""

from __future__ import annotations

import math

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.cells import shortest
from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import contains, lowest_member, set_member, without_lowest
from feasibee.engine.layout import Clock, Robot, Set
from feasibee.engine.params import Moment
from feasibee.engine.place import passable_ends, position
from feasibee.engine.way import NO_WAY, cell_at, clear_ways, step_around, way_around
from feasibee.model.outcomes import (
    ALL_DONE_STEP,
    ALL_TAKEN_STEP,
    BITS_SENT,
    DISTANCE_WALKED,
    FIRST_TAKEN_STEP,
    STARTS_IN_VAIN,
    TASKS_TAKEN,
    VAIN_ARRIVALS,
)

GONE = 2**30 + 1
"""Version of a task that has vanished."""
FREE, DONE = -1, -2
"""What `State.holders` has for tasks that nobody has."""
QUARTERS = 4
PATIENCE = 20
"""Steps after which a robot that has no task by its rank goes to the nearest."""
DETOUR = 3
"""Most steps that a blocked robot walks another way before it heads for its target again."""
NOWHERE = 2**64 - 1
RUN = (int(Robot.STEP_X), int(Robot.HEADING_X)), (int(Robot.STEP_Y), int(Robot.HEADING_Y))
"""Where a robot's step is, and where that of its run is kept while the run waits."""


def act(params, state, moment, i, w, members):
    """Do what belongs to a moment; robot ``i`` sees or hears the members of word ``w``."""
    if moment == Moment.SEE:
        see_all(params, state, i, w, members)
    elif moment == Moment.HEAR:
        hear_all(params, state, i, w, members)
    elif moment == Moment.BEGIN:
        begin(params, state)
        set_out(params, state)
    elif moment == Moment.MOVED:
        count_moves(params, state)
    elif moment == Moment.SPEAK:
        tell_all(params, state)
        arrive_all(params, state)
    else:
        choose_all(params, state)


def rest(params, state, moment, i, w, members):
    """Stand in for `act` where nobody acts."""


@called
def start_acting(state):
    """Let no task be taken, and no robot know of any."""
    state.holders[:] = FREE
    state.news[:] = 0
    state.told[:] = 0
    clear_ways(state)


@called
def forget_tasks(state, i):
    """Let a robot that joins know of no task."""
    state.news[i] = 0


# --- Motion ---


@called
def begin(params, state):
    """Free tasks whose robots left, and robots whose tasks are done or vanished."""
    sets, now = state.sets, state.clock[Clock.STEP] + 1
    if now in (1, params.faults.stop_step):
        state.clock[Clock.MOST] = most_at_once(params, state)
    taken = done = int64(0)
    for task in range(state.holders.size):
        i, is_there = int64(state.holders[task]), contains(state.tasks_there, task)
        if i >= 0 and not (is_there and has_task(sets, i)):
            let_go(state, task, int64(FREE))
        elif i >= 0 and contains(sets[Set.STANDING], i) and state.robots[Robot.DONE_AT, i] == now:
            let_go(state, task, int64(DONE))
        i = int64(state.holders[task])
        is_done = int64(is_there and i == DONE)
        done += is_done
        taken += is_done + int64(i >= 0 and contains(sets[Set.STANDING], i))
    state.account[TASKS_TAKEN] = taken
    if params.tasks.work > 0 and state.account[ALL_DONE_STEP] < 0 and done >= most_of(params, state):
        state.account[ALL_DONE_STEP] = now


@inlined
def has_task(sets, i):
    """Return whether a robot works, and stands at a task or has marked one."""
    has = contains(sets[Set.STANDING], i) or contains(sets[Set.MARKED], i)
    return has and contains(sets[Set.WORKING], i)


@inlined
def let_go(state, task, becomes):
    """Let the robot that has a task go on, and the task be free or done."""
    for kind in (Set.STANDING, Set.MARKED):
        set_member(state.sets, kind, int64(state.holders[task]), False)
    state.holders[task] = int32(becomes)


@called
def most_of(params, state):
    """Return how many tasks the counted robots can take, or have done and can do (model.md 6.25.14)."""
    if params.changes and not params.truth_stays:
        robots, tasks = state.clock[Clock.COUNTED], state.clock[Clock.TASKS]
        return tasks if params.tasks.work > 0 else min(robots, tasks)
    if params.tasks.work == 0:
        return state.clock[Clock.MOST]
    most = int64(0)
    for task in range(state.holders.size):
        can, i = state.holders[task] == DONE, int64(0)
        while not can and i < params.robots.count:
            can = contains(state.sets[Set.COUNTED], i) and can_do(params, state, i, task)
            i += 1
        most += int64(can)
    return most


@called
def most_at_once(params, state):
    """Return how many tasks of the start the counted robots can take at once, by Hall's condition."""
    tasks, most = int64(params.tasks.at_start), int64(params.tasks.at_start)
    if not params.sensing.by_class:
        return min(state.clock[Clock.COUNTED], tasks)
    adds, class_of = state.tables.adds, state.tables.class_of
    for s in range(adds.shape[0]):
        others = tasks
        for task in range(tasks):
            others -= adds[s, params.robots.classes + class_of[params.robots.count + task]]
        for i in range(params.robots.count):
            others += int64(contains(state.sets[Set.COUNTED], i)) * adds[s, class_of[i]]
        most = min(most, others)
    return most


@called
def set_out(params, state):
    """Let each robot with a target make a step towards it, unless it is on a detour, and others stand."""
    robots, sets = state.robots, state.sets
    for w in range(sets.shape[1]):
        left = uint32((sets[Set.BOUND, w] | sets[Set.STANDING, w]) & sets[Set.WORKING, w])
        sets[Set.COURSED, w] = uint32(0)
        while left:
            i = lowest_member(w, left)
            left = without_lowest(left)
            if robots[Robot.DETOUR, i] > 0:
                robots[Robot.DETOUR, i] -= 1
                continue
            task, u, v = int64(robots[Robot.TARGET, i]), int32(0), int32(0)
            if not contains(sets[Set.STANDING], i):
                u, v = course(params, state, i, task)
            elif params.robots.avoid_collisions and may_shift(params, state, i, task):
                continue
            set_member(sets, Set.COURSED, i, True)
            for step, heading in RUN:
                robots[heading, i] = robots[step, i]
            robots[Robot.STEP_X, i], robots[Robot.STEP_Y, i] = u, v


@called
def may_shift(params, state, i, task):
    """Return whether the step of a standing robot's run ends where it would have arrived at its task."""
    robots, place = state.robots, params.arena.place
    u, v = robots[Robot.STEP_X, i], robots[Robot.STEP_Y, i]
    if not place.exists:
        x, y = way_to(params, state, i, task)
        return squared(x - u, y - v) < params.acting.reach
    x, y = position(robots, i)
    if passable_ends(place, state.tables.ground, x, y, u, v) < QUARTERS:
        return False
    return int64(state.ways[task, cell_at(place, x + u, y + v)]) <= place.arrived


@inlined
def way_to(params, state, i, task):
    """Return the way from a robot to a task along x and y."""
    ax, ay = position(state.robots, i)
    bx, by = position(state.tasks, task)
    if params.arena.walls:
        return bx - ax, by - ay
    return shortest(bx - ax, params.arena.width), shortest(by - ay, params.arena.height)


@inlined
def squared(x, y):
    """Return the squared length of a way."""
    return uint64(x * x) + uint64(y * y)


@called
def away(params, state, i, task):
    """Return how far a robot is from a task: squared, or in a place around walls; or `NOWHERE`."""
    if params.arena.place.exists:
        way = way_around(params, state, i, task)
        return uint64(way) if way < NO_WAY else uint64(NOWHERE)
    x, y = way_to(params, state, i, task)
    return squared(x, y)


@called
def course(params, state, i, task):
    """Return a robot's step towards a task (model.md 6.25.2, 6.25.17)."""
    if params.arena.place.exists:
        return step_around(params, state, i, task)
    x, y = way_to(params, state, i, task)
    if x == 0 and y == 0:
        return int32(0), int32(0)
    length, reach = math.sqrt(float64(squared(x, y))), params.robots.reach
    u = math.floor(reach * (float64(x) / length) + 0.5)
    v = math.floor(reach * (float64(y) / length) + 0.5)
    return int32(u), int32(v)


@called
def count_moves(params, state):
    """Count the steps of robots that don't stand; let runs wait, but not those of standing bodies."""
    robots, sets, moved = state.robots, state.sets, int64(0)
    for w in range(sets.shape[1]):
        left = sets[Set.WORKING, w]
        while left:
            i = lowest_member(w, left)
            stands = contains(sets[Set.STANDING], i)
            if contains(sets[Set.COURSED], i) and not (stands and params.robots.avoid_collisions):
                robots[Robot.WALK_LEFT, i] += 1
            steps = robots[Robot.STEP_X, i] != 0 or robots[Robot.STEP_Y, i] != 0
            moved += int64(steps and not stands and not contains(sets[Set.BLOCKED], i))
            left = without_lowest(left)
    if state.account[ALL_TAKEN_STEP] < 0:
        state.account[DISTANCE_WALKED] += moved


# --- Arrival ---


@inlined
def rank_of(state, i):
    """Return the rank of a robot: 1 for the most skilled."""
    return state.tables.ranks[state.tables.class_of[i]]


@inlined
def status_of(state, task):
    """Return 0 if a task is free, else the rank of who has it."""
    holder = int64(state.holders[task])
    return int64(0) if holder < 0 else rank_of(state, holder)


@called
def arrive_all(params, state):
    """Let each robot that has reached its target take the task, or learn how it is (model.md 6.25.3)."""
    now, place, reach = state.clock[Clock.STEP] + 1, params.arena.place, params.acting.reach
    if place.exists:
        reach = uint64(place.arrived + 1)
    for w in range(state.sets.shape[1]):
        left = uint32(state.sets[Set.BOUND, w] & state.sets[Set.WORKING, w])
        while left:
            i = lowest_member(w, left)
            task = int64(state.robots[Robot.TARGET, i])
            if away(params, state, i, task) < reach:
                arrive(params, state, i, task, now)
            left = without_lowest(left)
    if state.account[ALL_TAKEN_STEP] < 0 and state.account[TASKS_TAKEN] >= most_of(params, state):
        state.account[ALL_TAKEN_STEP] = now


@called
def arrive(params, state, i, task, now):
    """Let a robot take a task, if it may have it, and know how the task is."""
    if not contains(state.tasks_there, task) or state.holders[task] == DONE:
        state.news[i, task] = GONE
        state.account[VAIN_ARRIVALS] += 1
        return
    holder, status = int64(state.holders[task]), status_of(state, task)
    if status > 0 and holder != i:
        state.account[VAIN_ARRIVALS] += 1
        see(params, state, i, task)
        return
    set_member(state.sets, Set.BOUND, i, False)
    state.holders[task] = int32(i)
    if contains(state.sets[Set.ACTING], i):
        stand(state, i, now)
        state.robots[Robot.DONE_AT, i] = int32(now + params.tasks.work if params.tasks.work > 0 else -1)
    else:
        set_member(state.sets, Set.MARKED, i, True)
    see(params, state, i, task)


@inlined
def stand(state, i, now):
    """Let a robot stand at the task that it has reached."""
    set_member(state.sets, Set.STANDING, i, True)
    set_member(state.sets, Set.MARKED, i, False)
    state.account[TASKS_TAKEN] += 1
    state.account[STARTS_IN_VAIN] += 1 - state.clock[Clock.TRUTH]
    if state.account[FIRST_TAKEN_STEP] < 0:
        state.account[FIRST_TAKEN_STEP] = now


# --- Knowledge ---


@called
def next_version(params, version, status):
    """Return the least version with a status from a version on; 0 as the version stands for nothing."""
    period = params.acting.ranks + 1
    if not params.acting.come_free or version == 0:
        return 1 + status
    ahead = (status - (version - 1)) % period
    return version + ahead


@called
def see(params, state, i, task):
    """Let a robot know how a task is."""
    version = int64(GONE)
    if state.holders[task] != DONE:
        version = next_version(params, int64(state.news[i, task]), status_of(state, task))
    state.news[i, task] = int32(version)


@called
def see_all(params, state, i, w, members):
    """Let a robot know how the tasks in sight are."""
    while members:
        see(params, state, i, lowest_member(w, members))
        members = without_lowest(members)


@inlined
def slot_of(state, step):
    """Return where `State.told` has the messages of a step."""
    return step % state.told.shape[0]


@called
def tell_all(params, state):
    """Fix what each robot says of tasks, and count the bits of those that broadcast."""
    now = state.clock[Clock.STEP] + 1
    due, bits = slot_of(state, now + 1), int64(0)
    for i in range(params.robots.count):
        told = state.told[slot_of(state, now), i]
        for task in range(told.size):
            told[task] = state.news[i, task]
        if contains(state.sets[Set.BYZANTINE], i):
            lie(params, told)
        if contains(state.sets[Set.SPEAKING], i):
            known = int64(0)
            for task in range(told.size):
                known += int64(state.told[due, i, task] != 0)
            bits += params.acting.list_bits + params.acting.task_bits * known
    state.account[BITS_SENT] += bits


@called
def lie(params, told):
    """Change a message, so that robots of the last rank have all tasks that it names."""
    for task in range(told.size):
        if 0 < told[task] < GONE:
            told[task] = int32(next_version(params, int64(told[task]), params.acting.ranks))


@called
def hear_all(params, state, i, w, members):
    """Let a robot keep the larger of its versions and those that it hears."""
    known, due = state.news[i], slot_of(state, state.clock[Clock.STEP] + 2)
    while members:
        sender = lowest_member(w, members)
        told = state.told[due, sender]
        for task in range(known.size):
            known[task] = max(known[task], told[task])
        members = without_lowest(members)


# --- Choice ---


@called
def choose_all(params, state):
    """End the detours that are over, give robots their runs back, and let them choose targets."""
    robots, sets, now = state.robots, state.sets, state.clock[Clock.STEP] + 1
    for w in range(sets.shape[1]):
        left = sets[Set.COURSED, w]
        while left:
            i = lowest_member(w, left)
            for step, heading in RUN:
                robots[step, i] = robots[heading, i]
            left = without_lowest(left)
        left = sets[Set.WORKING, w]
        while left:
            i = lowest_member(w, left)
            if contains(sets[Set.BLOCKED], i) and contains(sets[Set.BOUND], i):
                robots[Robot.DETOUR, i] = DETOUR
            elif contains(sets[Set.TURNING], i) or not contains(sets[Set.BOUND], i):
                robots[Robot.DETOUR, i] = 0
            if not contains(sets[Set.STANDING], i):
                target = target_of(params, state, i, now)
                if target >= 0 and away(params, state, i, target) == NOWHERE:
                    target = int64(-1)
                set_member(sets, Set.BOUND, i, target >= 0)
                robots[Robot.TARGET, i] = int32(target)
            left = without_lowest(left)


@called
def target_of(params, state, i, now):
    """Return the task that a robot goes to, or -1."""
    sets = state.sets
    declared, feasible = contains(sets[Set.DECLARED], i), contains(sets[Set.DECLARED_FEASIBLE], i)
    if contains(sets[Set.BYZANTINE], i) or (declared and not feasible) or knows_too_many(params, state, i):
        return int64(-1)
    if now >= params.acting.start or (params.acting.by_word and declared):
        if not contains(sets[Set.ACTING], i):
            set_member(sets, Set.ACTING, i, True)
            state.robots[Robot.BEGAN, i] = int32(now)
    elif not params.acting.tags or contains(sets[Set.MARKED], i):
        return int64(-1)
    if contains(sets[Set.MARKED], i):
        return marked_by(state, i)
    if params.acting.by_rank and now < state.robots[Robot.BEGAN, i] + PATIENCE:
        return task_of_rank(params, state, i)
    return nearest(params, state, i)


@called
def knows_too_many(params, state, i):
    """Return whether a robot knows that there are more tasks than robots."""
    if not params.robots.knows_count or params.tasks.work > 0:
        return False
    known = int64(0)
    for task in range(state.holders.size):
        known += int64(0 < state.news[i, task] < GONE)
    return known > max(params.robots.at_start, state.clock[Clock.ROBOTS])


@called
def marked_by(state, i):
    """Return the task that a robot has marked."""
    for task in range(state.holders.size):
        if state.holders[task] == i:
            return int64(task)
    return int64(-1)


@inlined
def known_status(params, state, i, task):
    """Return the status of a task as a robot knows it, or -1."""
    version = int64(state.news[i, task])
    return (version - 1) % (params.acting.ranks + 1) if 0 < version < GONE else int64(-1)


@inlined
def can_do(params, state, i, task):
    """Return whether a robot can do a task."""
    kinds = state.tables.class_of
    return state.tables.able[kinds[i], kinds[params.robots.count + task]] == 1


@called
def task_of_rank(params, state, i):
    """Return the task that comes after ``i`` known ones, if it is free and the robot can do it; else -1."""
    before = int64(0)
    for task in range(state.holders.size):
        status = known_status(params, state, i, task)
        if status >= 0 and before == i:
            return int64(task) if status == 0 and can_do(params, state, i, task) else int64(-1)
        before += int64(status >= 0)
    return int64(-1)


@called
def nearest(params, state, i):
    """Return the nearest free task, or -1."""
    found, least = int64(-1), uint64(NOWHERE)
    for task in range(state.holders.size):
        if known_status(params, state, i, task) == 0 and can_do(params, state, i, task):
            far = away(params, state, i, task)
            if far < least:
                found, least = int64(task), far
    return found
