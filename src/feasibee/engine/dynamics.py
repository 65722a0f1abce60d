"""How a world changes, and robots charge (model.md 6.17, 6.23).

`change_world` is passed to the step as a pointer, so worlds that stay don't compile it. One thread simulates
a world that changes.
"""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.acting import forget_tasks
from feasibee.engine.compile import called, inlined
from feasibee.engine.crowd import fill_there
from feasibee.engine.draws import choose, draw, draw_headings, draw_phases, draw_words, duration, poisson
from feasibee.engine.inbox import empty
from feasibee.engine.intrinsics import (
    bit,
    contains,
    lowest,
    lowest_member,
    pack_label,
    popcount,
    set_member,
    without_lowest,
)
from feasibee.engine.knowledge import drop_delayed
from feasibee.engine.layout import WORD, Clock, Event, Heard, Robot, Set
from feasibee.engine.motion import head
from feasibee.engine.sensing import label_of
from feasibee.engine.starting import (
    place_robot,
    place_task,
    prepare_robot,
    put,
    put_clear,
    set_inventions,
    set_quorum,
    sort_tasks,
    stand_still,
)
from feasibee.model import purposes

ANYWHERE = int64(-1)
"""In place of a coordinate: it is drawn."""
OF_A_STEP = (Set.BLOCKED, Set.LISTENING, Set.TURNING_LEFT, Set.CLEARED)
OWN_SETS = tuple(int(each) for each in Set if each not in OF_A_STEP)
"""Sets that a robot leaves when it leaves the arena."""


@called
def draw_dynamics(params, state):
    """Draw lifetimes, times of failure and classes at the start of a run."""
    run, class_of = state.clock[Clock.RUN], state.tables.class_of
    state.clock[Clock.APPEARED] = params.tasks.at_start
    for kind in (Clock.EVENTS, Clock.VANISHED, Clock.LEFT):
        state.clock[kind] = 0
    for task in range(params.tasks.at_start):
        begin_lifetime(params, state, task, int64(0))
    for i in range(params.robots.at_start):
        draw_failure(params, state, i, int64(0))
        draw_battery(params, state, i, int64(0))
    for i in range(params.robots.at_start, params.robots.count):
        class_of[i] = class_of[
            choose(draw(params, run, i, 0, purposes.JOINING_CLASS), params.robots.at_start)
        ]
    first = params.robots.count
    for task in range(params.tasks.at_start, params.tasks.count):
        class_of[first + task] = 0
        if params.tasks.at_start > 0:
            drawn = choose(draw(params, run, task, 0, purposes.APPEARING_CLASS), params.tasks.at_start)
            class_of[first + task] = class_of[first + drawn]


def change_world(params, state, now):
    """Change the world at the beginning of step ``now``; before the first step, only events do."""
    state.clock[Clock.CHANGED] = 0
    if now > 0:
        end_lifetimes(params, state, now)
        fail(params, state, now)
        charge(params, state, now)
    while state.clock[Clock.EVENTS] < state.tables.events.shape[0]:
        event = state.tables.events[state.clock[Clock.EVENTS]]
        if event[Event.STEP] != now:
            break
        happen(params, state, event, now)
        state.clock[Clock.EVENTS] += 1
    if now > 0:
        arrive(params, state, now)
    if state.clock[Clock.CHANGED] or now == params.faults.stop_step:
        settle(params, state)


def stay(params, state, now):
    """Stand in for `change_world` in a world that doesn't change."""


@called
def settle(params, state):
    """Store what follows from who is there: the truth, the quorum, and where robots and tasks are."""
    sort_tasks(params, state)
    counted = int64(0)
    for w in range(state.sets.shape[1]):
        counted += popcount(state.sets[Set.COUNTED, w])
    set_quorum(params, state.clock, counted)
    set_inventions(params, state.clock)
    if not params.truth_stays:
        state.clock[Clock.TRUTH] = int64(is_feasible(params, state))
    if params.robots.avoid_collisions and not params.together:
        fill_there(params, state)


@called
def is_feasible(params, state):
    """Return whether the robots that are present can do the tasks that are there (model.md 6.7)."""
    if not params.sensing.by_class:
        return state.clock[Clock.ROBOTS] >= state.clock[Clock.TASKS]
    adds, class_of = state.tables.adds, state.tables.class_of
    for s in range(adds.shape[0]):
        spare = int64(0)
        for i in range(params.robots.count):
            spare += int64(contains(state.sets[Set.PRESENT], i)) * adds[s, class_of[i]]
        for task in range(params.tasks.count):
            kind = params.robots.classes + class_of[params.robots.count + task]
            spare -= int64(contains(state.tasks_there, task)) * adds[s, kind]
        if spare < 0:
            return False
    return True


@called
def happen(params, state, event, now):
    """Let an event happen: tasks, robots, then probabilities."""
    x, y = event[Event.X], event[Event.Y]
    for _ in range(event[Event.TASKS]):
        appear(params, state, now, x, y)
    for _ in range(min(-event[Event.TASKS], state.clock[Clock.TASKS])):
        word = draw(params, state.clock[Clock.RUN], state.clock[Clock.VANISHED], now, purposes.VANISH)
        task = member_of(state.tasks_there, choose(word, state.clock[Clock.TASKS]))
        vanish(state, task)
        state.clock[Clock.VANISHED] += 1
    for _ in range(event[Event.ROBOTS]):
        join(params, state, now, x, y)
    for _ in range(min(-event[Event.ROBOTS], state.clock[Clock.ROBOTS])):
        word = draw(params, state.clock[Clock.RUN], state.clock[Clock.LEFT], now, purposes.LEAVE)
        leave(params, state, member_of(state.sets[Set.PRESENT], choose(word, state.clock[Clock.ROBOTS])))
        state.clock[Clock.LEFT] += 1
    if event[Event.TASK] >= 0 and contains(state.tasks_there, event[Event.TASK]):
        take_or_put_task(state, event[Event.TASK], x, y)
    if event[Event.ROBOT] >= 0:
        take_or_put_robot(params, state, event[Event.ROBOT], x, y)
    if event[Event.MISS] >= 0:
        state.clock[Clock.MISS] = event[Event.MISS]
    if event[Event.LOSS] >= 0:
        state.clock[Clock.LOSS] = event[Event.LOSS]


@called
def take_or_put_task(state, task, x, y):
    """Remove a task that is there, or put it at a point (model.md 6.17.12)."""
    if x < 0:
        vanish(state, task)
        return
    put(state.tasks, task, x, y)
    state.clock[Clock.CHANGED] = 1


@called
def take_or_put_robot(params, state, i, x, y):
    """Remove a robot that is present, or put it at a point if it is in the arena and the point is clear."""
    if x < 0 and contains(state.sets[Set.PRESENT], i):
        leave(params, state, i)
    if x < 0 or not contains(state.sets[Set.THERE], i):
        return
    old_x, old_y = int64(state.robots[Robot.X, i]), int64(state.robots[Robot.Y, i])
    set_member(state.sets, Set.THERE, i, False)  # it isn't in its own way
    if not put_clear(params, state, i, x, y, True):
        put(state.robots, i, old_x, old_y)
    set_member(state.sets, Set.THERE, i, True)
    state.clock[Clock.CHANGED] = 1


@inlined
def member_of(members, k):
    """Return the k-th member of a set, from 0 on."""
    w = int64(0)
    while k >= popcount(members[w]):
        k -= popcount(members[w])
        w += 1
    left = members[w]
    for _ in range(k):
        left = without_lowest(left)
    return lowest_member(w, left)


@called
def arrive(params, state, now):
    """Let tasks appear and robots join by their rates."""
    if params.tasks.arrival_rate == 0.0 and params.robots.arrival_rate == 0.0:
        return
    words = draw_words(params, state.clock[Clock.RUN], 0, now, purposes.ARRIVAL)
    for _ in range(poisson(words[0], params.tasks.arrival_rate)):
        appear(params, state, now, ANYWHERE, ANYWHERE)
    for _ in range(poisson(words[1], params.robots.arrival_rate)):
        join(params, state, now, ANYWHERE, ANYWHERE)


@called
def appear(params, state, now, x, y):
    """Let the next task appear, unless all numbers have been used (model.md 6.17.4)."""
    task = state.clock[Clock.APPEARED]
    if task < params.tasks.count:
        if x < 0:
            place_task(params, state, task)
        else:
            put(state.tasks, task, x, y)
        begin_lifetime(params, state, task, now)
        state.tasks_there[task // WORD] |= bit(task)
        state.clock[Clock.CHANGED] = 1
        state.clock[Clock.APPEARED] += 1
        state.clock[Clock.TASKS] += 1


@inlined
def begin_lifetime(params, state, task, now):
    """Draw the step at which a task vanishes."""
    if params.tasks.lifetime > 0.0:
        word = draw(params, state.clock[Clock.RUN], task, 0, purposes.LIFETIME)
        state.vanish_at[task] = int32(now + duration(word, params.tasks.lifetime))


@inlined
def vanish(state, task):
    """Remove a task from the arena."""
    state.clock[Clock.CHANGED] = 1
    state.tasks_there[task // WORD] &= ~bit(task)
    state.clock[Clock.TASKS] -= 1


@called
def end_lifetimes(params, state, now):
    """Remove the tasks whose lifetime is over."""
    for task in range(state.vanish_at.size):
        if state.vanish_at[task] == now and contains(state.tasks_there, task):
            vanish(state, task)


@called
def fail(params, state, now):
    """Remove the robots that fail at this step; begin to count those that leave by events."""
    state.clock[Clock.VANISHED] = state.clock[Clock.LEFT] = 0
    if params.robots.failure_time == 0.0:
        return
    for i in range(params.robots.count):
        there = contains(state.sets[Set.THERE], i) or contains(state.sets[Set.AWAY], i)
        if state.robots[Robot.LEAVES_AT, i] == now and there:
            leave(params, state, i)


@called
def charge(params, state, now):
    """Let robots go whose battery is empty, then those come back that have charged theirs (model.md 6.23)."""
    if params.robots.work == 0:
        return
    switches_at, sets = state.robots[Robot.SWITCHES_AT], state.sets
    for i in range(params.robots.count):
        if switches_at[i] == now and contains(sets[Set.WORKING], i):
            go_away(params, state, i, now)
    for i in range(params.robots.count):
        stopped = now >= params.faults.stop_step and contains(sets[Set.STOPPING], i)
        if switches_at[i] == now and contains(sets[Set.AWAY], i) and not stopped:
            come_back(params, state, i, now)


@called
def go_away(params, state, i, now):
    """Let a robot charge: it keeps its mind, and its phase waits for the step at which it comes back."""
    set_member(state.sets, Set.SPEAKING_AGAIN, i, contains(state.sets[Set.SPEAKING], i))
    move_between(params, state, i, True)
    phase_left = state.robots[Robot.PHASE_LEFT, i]
    stand_still(state.robots, i)
    drop_delayed(state, i)
    state.robots[Robot.PHASE_LEFT, i] = phase_left + int32(params.robots.charge)  # it ticks meanwhile
    state.robots[Robot.SWITCHES_AT, i] = int32(now + params.robots.charge)


@called
def come_back(params, state, i, now):
    """Let a robot come back as one that joins is placed; without a free place, it waits for a step."""
    state.robots[Robot.JOINED, i] += int32(1)  # each attempt has draws of its own
    if not place_robot(params, state, i, True):
        state.robots[Robot.SWITCHES_AT, i] = int32(now + 1)
        state.robots[Robot.PHASE_LEFT, i] += int32(1)
        return
    move_between(params, state, i, False)
    begin_to_walk(params, state, i)
    state.robots[Robot.SWITCHES_AT, i] = int32(now + params.robots.work)


@inlined
def move_between(params, state, i, away):
    """Let a robot leave the arena to charge, or enter it again."""
    sets = state.sets
    set_member(sets, Set.AWAY, i, away)
    for kind in (Set.THERE, Set.WORKING):
        set_member(sets, kind, i, not away)
    set_member(sets, Set.SPEAKING, i, not away and contains(sets[Set.SPEAKING_AGAIN], i))
    if not params.robots.away_counts:
        set_member(sets, Set.PRESENT, i, not away)
        set_member(sets, Set.COUNTED, i, not away and not contains(sets[Set.BYZANTINE], i))
        state.clock[Clock.ROBOTS] += -1 if away else 1
    state.robots[Robot.LABEL, i] = label_of(state, i)
    state.clock[Clock.CHANGED] = 1


@inlined
def begin_to_walk(params, state, i):
    """Let a robot that enters the arena take a heading."""
    state.heard[0, Heard.RECEIVER, 0] = int32(i)
    draw_headings(params, state, 0, 1)
    head(params, state, 0, i, 0)


@called
def join(params, state, now, x, y):
    """Let a robot join, if a number and a place are free (model.md 6.17.6, 6.17.7)."""
    there, away, w = state.sets[Set.THERE], state.sets[Set.AWAY], int64(0)
    while w < there.size and (there[w] | away[w]) == uint32(0xFFFFFFFF):
        w += 1
    i = WORD * w + (lowest(~(there[w] | away[w])) if w < there.size else int64(0))
    if i >= params.robots.count:
        return
    if not (place_robot(params, state, i, True) if x < 0 else put_clear(params, state, i, x, y, True)):
        return
    for kind in (Set.THERE, Set.WORKING, Set.COUNTED, Set.JOINING, Set.PRESENT):
        set_member(state.sets, kind, i, True)
    state.clock[Clock.CHANGED] = 1
    state.clock[Clock.ROBOTS] += 1
    state.robots[Robot.LABEL, i] = pack_label(i, False, False)
    if params.sensing.unique:
        state.remembered[i] = uint32(0)
    if params.acting.acts:
        forget_tasks(state, i)
    begin_to_walk(params, state, i)
    draw_phases(params, state, 0, 1)
    prepare_robot(params, state, i, 0)
    draw_failure(params, state, i, now)
    draw_battery(params, state, i, now)


@inlined
def draw_battery(params, state, i, now):
    """Draw the step at which a robot goes to charge for the first time; its first step is 1 or later."""
    if params.robots.work > 0:
        word = draw(params, state.clock[Clock.RUN], i, int64(state.robots[Robot.JOINED, i]), purposes.BATTERY)
        lasts = 1 + choose(word, params.robots.work)
        state.robots[Robot.SWITCHES_AT, i] = int32(max(now, 1) + lasts)


@inlined
def draw_failure(params, state, i, now):
    """Draw the step at which a robot fails."""
    if params.robots.failure_time > 0.0:
        word = draw(params, state.clock[Clock.RUN], i, int64(state.robots[Robot.JOINED, i]), purposes.FAILURE)
        state.robots[Robot.LEAVES_AT, i] = int32(now + duration(word, params.robots.failure_time))


@called
def leave(params, state, i):
    """Remove a robot from the arena for good; the next one of its number goes on with its draws."""
    state.clock[Clock.ROBOTS] -= int64(contains(state.sets[Set.PRESENT], i))
    for kind in OWN_SETS:
        set_member(state.sets, kind, i, False)
    state.clock[Clock.CHANGED] = 1
    empty(params, state, int64(0), i)
    stand_still(state.robots, i)
    drop_delayed(state, i)
    state.robots[Robot.LABEL, i] = pack_label(i, False, False)
    state.robots[Robot.JOINED, i] += int32(1)
