"""Observation and messages, and lists of the tasks in sight (model.md 3.2, 4.2, 4.5, 6.3, 6.5).

A cell is longer than the range, so a task is in at most nine lists. A robot looks through the list of its
cell: about 10 of 100 tasks, against 25 in a block of `feasibee.engine.cells`. A list holds places only, in 16
bits an axis. They span four cells, so that the difference between a place and a listed one doesn't wrap.

Up to 128 robots sense together: each robot's neighbours are a word or a few. Otherwise robots are sorted into
cells. Both have the same outcome.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.crowd import count_tasks, fill_robots, fill_there, look_and_listen, queue_near
from feasibee.engine.draws import choose, draw_now, draw_words, poisson
from feasibee.engine.inbox import empty, receive
from feasibee.engine.intrinsics import (
    bit,
    bit_if,
    contains,
    has_bit,
    lowest_member,
    number_of,
    pack_label,
    place_of,
    says_feasible,
    set_member,
    without_lowest,
)
from feasibee.engine.knowledge import defer, publish, update_pending
from feasibee.engine.layout import (
    HEARD_ROOM,
    WORD,
    Clock,
    Count,
    Heard,
    Pending,
    Robot,
    Sense,
    Set,
)
from feasibee.engine.params import ALWAYS, WHILE_DISSEMINATING, Action, Moment
from feasibee.engine.view import keep_reached
from feasibee.model import purposes

PIECE = 16
"""Places that are compared at once; each list is padded to a multiple of it."""


@inlined
def pack_place(x, y, shift):
    """Return 16 bits of each coordinate from bit ``shift`` on, those of x below."""
    low, high = (uint32(x) >> shift) & uint32(0xFFFF), uint32(uint32(y) >> shift) << uint32(16)
    return uint32(uint32(low) | uint32(high))


@spliced
def sense_general_crowd(params, state, functions, part):
    """Do what `feasibee.engine.few.sense_general_few` does, in a swarm of more than 64."""
    publish(params, state, functions, part)
    fill_general(params, state, part)
    observe_crowd(params, state, functions, part)
    count_all_false_sightings(params, state, functions, part)
    update_pending(params, state, functions, Action.OBSERVE)
    find_listeners(params, state, part)
    hear_crowd(params, state, functions, part)
    update_pending(params, state, functions, Action.MERGE)


@called
def fill_general(params, state, part):
    """Sort the robots that are there into cells."""
    if params.changes:
        fill_there(params, state)
    else:
        fill_robots(params, state, part)


@spliced
def observe_crowd(params, state, functions, part):
    """Observe the robots and tasks in sight of exploring robots.

    Where all in sight count, robots are counted while listening.
    """
    if not counts_while_hearing(params):
        observe_all(params, state, functions, part, state.robot_cells, params.robots.grid, True)
    observe_tasks(params, state, functions, part)


@inlined
def counts_while_hearing(params):
    """Return whether robots are counted while listening: all in sight count, and who is seen is heard."""
    return params.sensing.counts_all and (params.radio.as_sight or not params.sensing.hides)


@spliced
def observe_tasks(params, state, functions, part):
    """Observe the tasks in sight of exploring robots."""
    if params.sensing.counts_all and not params.sensing.hides:
        count_tasks(params, state, part)
    else:
        observe_all(params, state, functions, part, state.task_cells, params.tasks.grid, False)


@called
def observe_all(params, state, functions, part, cells, grid, are_robots):
    """Observe each robot or each task in sight of exploring robots."""
    queued, limit = int64(0), params.sensing.limit
    for w in range(part.first, part.last):
        left = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while left:
            i = uint64(lowest_member(w, left))
            queued = queue_near(params, state, part, cells, grid, i, limit, queued, int32(-1))
            if queued > HEARD_ROOM:
                queued = observe_queued(params, state, functions, part, queued, are_robots)
            left = without_lowest(left)
    observe_queued(params, state, functions, part, queued, are_robots)


@called
def observe_queued(params, state, functions, part, queued, are_robots):
    """Observe the queued sights: is it seen, is it new, which class has it (model.md 6.3); return 0."""
    heard = state.heard[part.thread]
    if params.sensing.hides:
        points = state.robots if are_robots else state.tasks
        queued = keep_reached(params, state, points, part, int64(Sense.SIGHT), queued, are_robots)
    if params.sensing.counts_all and not are_robots:
        for k in range(queued):
            state.counts[Count.TASKS_SEEN, heard[Heard.RECEIVER, k]] += 1
        return int64(0)
    for k in range(queued):
        i, number = int64(heard[Heard.RECEIVER, k]), int64(heard[Heard.SENDER, k])
        if are_robots:
            observe_robot(params, state, functions, i, number >> 1)
        else:
            observe_task(params, state, functions, i, number)
    return int64(0)


@spliced
def hear_crowd(params, state, functions, part):
    """Let listening robots receive messages."""
    queued, counts = int64(0), counts_while_hearing(params)
    for w in range(part.first, part.last):
        exploring, listening = uint32(0), state.sets[Set.LISTENING, w]
        if counts:
            exploring = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        left = uint32(listening | exploring)
        while left:
            i = uint64(lowest_member(w, left))
            before = queued
            if counts and params.sensing.hides:
                cells, grid, limit = state.robot_cells, params.robots.grid, params.radio.limit
                queued = queue_near(params, state, part, cells, grid, i, limit, queued, int32(i))
                itself = params.sensing.count_self * int64(has_bit(exploring, i))
                state.counts[Count.ROBOTS_SEEN, i] += itself
            else:
                queued = look_and_listen(params, state, part, i, exploring, listening, queued)
            if params.in_sender_order:
                sort_by_number(state, part, before, queued)
            if queued > HEARD_ROOM:
                queued = receive_queued_general(params, state, functions, part, queued)
            left = without_lowest(left)
    receive_queued_general(params, state, functions, part, queued)


@inlined
def count_queued(params, state, part, queued):
    """Count the queued robots that robots see; keep those that they hear, and return their number."""
    queue, sets, kept = state.heard[part.thread], state.sets, int64(0)
    receivers, others, seen = queue[Heard.RECEIVER], queue[Heard.SENDER], state.counts[Count.ROBOTS_SEEN]
    for k in range(queued):
        i, other = receivers[k], others[k]
        seen[i] += int64(contains(sets[Set.WORKING], i) & (not contains(sets[Set.DISSEMINATING], i)))
        receivers[kept], others[kept] = i, other
        kept += int64(contains(sets[Set.LISTENING], i)) & int64(other & 1)
    return kept


@inlined
def label_of(state, i):
    """Return a robot's present label; see `feasibee.engine.intrinsics.pack_label`."""
    says, speaks = contains(state.sets[Set.SAYS_FEASIBLE], i), contains(state.sets[Set.SPEAKING], i)
    return pack_label(number_of(state.robots[Robot.LABEL, i]), says, speaks)


@spliced
def observe_robot(params, state, functions, i, place):
    """Observe a robot in sight, by its place in the arrays."""
    own, other = number_of(state.robots[Robot.LABEL, i]), number_of(state.robots[Robot.LABEL, place])
    if other == own:
        visible = params.sensing.count_self == 1
    else:
        visible = not happens(
            params, state, own, purposes.MISS_ROBOT + purposes.PAIR * other, state.clock[Clock.MISS]
        )
    if visible and is_new(params, state, own, other):
        count_sighting(params, state, functions, i, other, int64(state.tables.class_of[other]), True)


@spliced
def observe_task(params, state, functions, i, task):
    """Observe a task in sight."""
    own = number_of(state.robots[Robot.LABEL, i])
    seen = not happens(params, state, own, purposes.MISS_TASK + purposes.PAIR * task, state.clock[Clock.MISS])
    if seen and params.acting.acts:
        functions.act(params, state, int64(Moment.SEE), int64(i), int64(task >> 5), uint32(bit(task)))
    if seen and is_new(params, state, own, WORD * state.sets.shape[1] + task):
        number = params.robots.count + (int64(state.names[task]) if params.sensing.merges else task)
        kind = int64(state.tables.class_of[number])
        if happens(params, state, own, purposes.MISNAME + purposes.PAIR * task, params.sensing.misname):
            mark_next(state, draw_words(params, state.clock[Clock.RUN], number, 0, purposes.IDENTITY)[2])
            number += params.tasks.count
        count_sighting(params, state, functions, i, number, kind, False)


@inlined
def count_sighting(params, state, functions, i, number, kind, is_robot):
    """Count one thing of a class, or add it to what the robot knows; ``number`` as in `Pending`."""
    column = kind if is_robot else params.robots.classes + kind
    if params.strategy.knowledge.enabled:
        defer(params, state, functions, Action.OBSERVE, i, number, column)
    elif state.seen.shape[0] > 0:
        state.seen[i, column] += 1
    elif is_robot:
        state.counts[Count.ROBOTS_SEEN, i] += 1
    else:
        state.counts[Count.TASKS_SEEN, i] += 1


@called
def count_all_false_sightings(params, state, functions, part):
    """Count the false sightings of all exploring robots."""
    if params.sensing.false_robots == 0.0 and params.sensing.false_tasks == 0.0:
        return
    for w in range(part.first, part.last):
        left = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while left:
            i = lowest_member(w, left)
            mean, robots = params.sensing.false_robots, params.robots.at_start
            count_false(params, state, functions, i, mean, int64(purposes.FALSE_ROBOT), 0, robots)
            mean, first, tasks = params.sensing.false_tasks, params.robots.count, params.tasks.at_start
            count_false(params, state, functions, i, mean, int64(purposes.FALSE_TASK), first, tasks)
            left = without_lowest(left)


@called
def count_false(params, state, functions, i, mean, purpose, first, count):
    """Count false sightings, each with a hash of its own and the class of one drawn of ``count`` things.

    These are the robots or tasks of the start, numbered from ``first`` on.
    """
    if mean == 0.0:
        return
    run, now, own = (
        state.clock[Clock.RUN],
        state.clock[Clock.STEP] + 1,
        number_of(state.robots[Robot.LABEL, i]),
    )
    # Purposes of classes follow those of numbers in the same order.
    of_class = purpose + purposes.FALSE_ROBOT_CLASS - purposes.FALSE_ROBOT
    for k in range(poisson(draw_now(params, state, own, purpose), mean)):
        words = draw_words(params, run, own, now, of_class + purposes.PAIR * k)
        kind = int64(state.tables.class_of[first + choose(words[0], count)]) if count > 0 else int64(0)
        mark_next(state, words[1])
        count_sighting(params, state, functions, i, int64(-1), kind, purpose == purposes.FALSE_ROBOT)


@inlined
def mark_next(state, mark):
    """Give the next pending sighting, if it is a false one or has a wrong name, its hash."""
    if state.pending.shape[1] > 0:
        state.pending[Pending.MARK, state.clock[Clock.PENDING]] = int32(mark)


@inlined
def happens(params, state, number, purpose, probability):
    """Return whether an event happens to a robot in this step; ``probability`` is times 2**32."""
    if probability == 0:
        return False
    return uint64(draw_now(params, state, number, purpose)) < uint64(probability)


@inlined
def is_new(params, state, number, thing):
    """Return whether a thing in sight counts: always, or unless it is remembered; remember it."""
    if not params.sensing.unique:
        return True
    known = contains(state.remembered[number], thing)
    set_member(state.remembered, number, thing, True)
    return not known


@spliced
def find_listeners(params, state, part):
    """Store which robots listen in this step; their phases have been shortened by it already."""
    for w in range(part.first, part.last):
        listening = state.sets[Set.WORKING, w]
        if params.decision.listens_for != ALWAYS:
            listening &= state.sets[Set.DISSEMINATING, w]
        if params.decision.listens_for > WHILE_DISSEMINATING:
            for j in range(32):
                early = state.robots[Robot.PHASE_LEFT, 32 * w + j] >= params.decision.listens_for
                listening &= ~bit_if(early, j)
        state.sets[Set.LISTENING, w] = listening


@called
def sort_by_number(state, part, first, last):
    """Sort who has been heard by one robot by number: a few sorted runs."""
    heard, labels = state.heard[part.thread, Heard.SENDER], state.robots[Robot.LABEL]
    for k in range(first + 1, last):
        other, place = heard[k], k
        while place > first and labels[heard[place - 1] >> 1] >> 2 > labels[other >> 1] >> 2:
            heard[place] = heard[place - 1]
            place -= 1
        heard[place] = other


@called
def receive_queued_general(params, state, functions, part, queued):
    """Let robots receive the queued messages, of which some are lost; return 0."""
    heard = state.heard[part.thread]
    if params.arena.place.exists:
        queued = keep_reached(params, state, state.robots, part, int64(Sense.RADIO), queued, True)
    if params.sensing.hides and counts_while_hearing(params):
        queued = count_queued(params, state, part, queued)
    for k in range(queued):
        i, other = int64(heard[Heard.RECEIVER, k]), place_of(heard[Heard.SENDER, k])
        receive_general(params, state, functions, part, i, other)
    return int64(0)


@inlined
def receive_general(params, state, functions, part, i, other):
    """Receive the message of a robot in radio range unless it is lost."""
    own, label = number_of(state.robots[Robot.LABEL, i]), state.robots[Robot.LABEL, other]
    if happens(params, state, own, purposes.LOSS + purposes.PAIR * number_of(label), state.clock[Clock.LOSS]):
        return
    if params.acting.acts:
        functions.act(params, state, int64(Moment.HEAR), int64(i), int64(other >> 5), uint32(bit(other)))
    if params.strategy.knowledge.enabled:
        defer(params, state, functions, Action.MERGE, i, other, int64(0))
    if params.decision.declare.enabled or not params.strategy.knowledge.enabled:
        message = label
        if params.radio.random_ids:
            message = pack_label(state.robots[Robot.IDENTITY, other], says_feasible(label) == 1, True)
        receive(params, state, part, i, message, state.robots[Robot.SENT_VALUE, other])


@inlined
def forget(params, state, part, i):
    """Empty a robot's inbox, and its counts unless evidence is kept (model.md 4.6)."""
    empty(params, state, part.thread, i)
    if params.strategy.forgets:
        clear_counts(params, state, i)
    if params.sensing.unique:
        state.remembered[number_of(state.robots[Robot.LABEL, i])] = uint32(0)


@inlined
def clear_counts(params, state, i):
    """Set a robot's counts to 0."""
    state.counts[Count.ROBOTS_SEEN, i] = 0
    state.counts[Count.TASKS_SEEN, i] = 0
    if state.seen.shape[0] > 0:
        state.seen[i] = 0
