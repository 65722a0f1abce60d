"""Observation and messages (model.md 3.2, 4.2, 4.5, 6.3, 6.5).

On the fast path, up to 32 robots sense together: each robot's neighbours are one word. Otherwise robots are
sorted into cells. Both have the same outcome.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import (
    bit,
    bit_if,
    contains,
    first_bits,
    has_bit,
    is_disseminating,
    lowest_member,
    pack_label,
    sender_of,
    set_member,
    without_lowest,
)
from feasibee.engine.cells import block, block_on_torus, count_within, near, near_on_torus, sort_into_cells
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import choose, draw_now, draw_words, poisson
from feasibee.engine.inbox import empty, receive, receive_together
from feasibee.engine.intrinsics import find_near, lowest, popcount, within
from feasibee.engine.knowledge import defer, sent_opinion
from feasibee.engine.layout import WORD, Clock, Count, Link, Pending, Point, Robot, Set
from feasibee.engine.params import ALWAYS, WHILE_DISSEMINATING, Action
from feasibee.engine.tasklists import count_listed
from feasibee.model.purposes import (
    FALSE_ROBOT,
    FALSE_ROBOT_CLASS,
    FALSE_TASK,
    FALSE_TASK_CLASS,
    LOSS,
    MISS_ROBOT,
    MISS_TASK,
    PAIR,
)


@spliced
def sense_fast(params, state):
    """Let exploring robots observe and listening robots receive, on the fast path."""
    if params.together:
        sense_together(params, state)
    else:
        sense_in_cells(params, state)


@spliced
def sense_together(params, state):
    """Sense in a swarm of at most 32 on the fast path."""
    xs, ys = state.robots[Robot.X], state.robots[Robot.Y]
    sight, seen = state.links[Link.SIGHT], state.counts[Count.ROBOTS_SEEN]
    swarm = first_bits(params.robots.count)
    speaking, disseminating = state.sets[Set.SPEAKING, 0], state.sets[Set.DISSEMINATING, 0]
    state.clock[Clock.BITS] += popcount(speaking) * params.radio.message_bits
    find_neighbours(xs, ys, sight, swarm, params.robots.count, params.sensing)
    looking = uint32(swarm & ~disseminating)
    while looking:
        i = lowest(looking)
        state.counts[Count.TASKS_SEEN, i] += count_listed(params, state, xs[i], ys[i])
        looking = without_lowest(looking)
    for i in range(32):
        explores = int64(has_bit(~disseminating, i))
        seen[i] += -explores & (popcount(sight[i]) + params.sensing.count_self)
    if params.radio.limit != params.sensing.limit:
        find_neighbours(xs, ys, sight, swarm, params.robots.count, params.radio)
    if params.decision.listens_for != ALWAYS:
        for i in range(params.robots.count):
            if not has_bit(disseminating, i):
                sight[i] = uint32(0)
    receive_together(params, state, speaking, state.sets[Set.SAYS_FEASIBLE, 0])


@inlined
def find_neighbours(xs, ys, sight, swarm, robots, reach):
    """Store the set of robots within a range of each robot; ``reach`` has its limit and band."""
    if not find_near(xs, ys, sight, robots, reach.band.low, reach.band.width):
        find_exactly(xs, ys, sight, swarm, robots, reach.limit)


@called
def find_exactly(xs, ys, sight, swarm, robots, limit):
    """Store the same sets where 16 bits leave a distance in doubt: in 1 of 100 steps of 20 robots."""
    for i in range(robots):
        sight[i] = uint32(swarm & ~bit(i)) & within(xs, ys, 0, xs[i], ys[i], limit)


@called
def sense_in_cells(params, state):
    """Sense in a swarm of any size on the fast path."""
    fill_robots(params, state)
    # Read once, not per robot: the compiler must assume that writes to the state change them.
    robot_bits, task_bits, limit = params.robots.grid.bits, params.tasks.grid.bits, params.sensing.limit
    for w in range(state.sets.shape[1]):
        speaking = state.sets[Set.SPEAKING, w]
        state.clock[Clock.BITS] += popcount(speaking) * params.radio.message_bits
        looking = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while speaking:
            broadcast(params, state, lowest_member(w, speaking))
            speaking = without_lowest(speaking)
        while looking:
            observe_fast(params, state, lowest_member(w, looking), robot_bits, task_bits, limit)
            looking = without_lowest(looking)


@spliced
def observe_in_cells(params, state, functions):
    """Observe the robots and tasks in sight of the exploring robots, in a swarm of more than 32."""
    fill_robots(params, state)
    for w in range(state.sets.shape[1]):
        looking = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while looking:
            observe_general(params, state, functions, lowest_member(w, looking))
            looking = without_lowest(looking)


@spliced
def hear_in_cells(params, state, functions):
    """Send the messages of the speaking robots, in a swarm of more than 32."""
    for w in range(state.sets.shape[1]):
        speaking = state.sets[Set.SPEAKING, w]
        while speaking:
            broadcast_with_loss(params, state, functions, lowest_member(w, speaking))
            speaking = without_lowest(speaking)


@inlined
def fill_robots(params, state):
    """Sort the robots into cells."""
    robots = state.robots
    sort_into_cells(
        state.robot_cells,
        params.robots.grid,
        robots[Robot.X],
        robots[Robot.Y],
        robots[Robot.LABEL],
        params.robots.count,
    )


@inlined
def label_of(sets, i):
    """Return a robot's present label; see `feasibee.engine.bits.pack_label`."""
    return pack_label(i, contains(sets[Set.SAYS_FEASIBLE], i), contains(sets[Set.DISSEMINATING], i))


@inlined
def observe_fast(params, state, i, robot_bits, task_bits, limit):
    """Count the robots and tasks in sight of a robot, on the fast path."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    robots = count_within(state.robot_cells, robot_bits, x, y, limit)
    state.counts[Count.ROBOTS_SEEN, i] += robots - 1 + params.sensing.count_self  # it sees itself
    state.counts[Count.TASKS_SEEN, i] += count_within(state.task_cells, task_bits, x, y, limit)


@spliced
def observe_general(params, state, functions, i):
    """Observe each thing in sight of a robot: is it seen, is it new, which class has it (model.md 6.3).

    Counting alone, where nothing of that matters, takes a third off a step.
    """
    robots = observe_robots(params, state, functions, i, state.robots[Robot.X, i], state.robots[Robot.Y, i])
    tasks = observe_tasks(params, state, functions, i, state.robots[Robot.X, i], state.robots[Robot.Y, i])
    if params.sensing.only_counts:
        state.counts[Count.ROBOTS_SEEN, i] += robots
        state.counts[Count.TASKS_SEEN, i] += tasks
    # Tested here, since the call would cost more than the test.
    if params.sensing.false_robots > 0.0 or params.sensing.false_tasks > 0.0:
        count_false_sightings(params, state, functions, i)


@spliced
def observe_robots(params, state, functions, i, x, y):
    """Observe the robots in sight of a robot; return how many count, if counting suffices."""
    points = state.robot_cells.points
    total = params.sensing.count_self - 1 if params.sensing.counts_all else int64(0)  # it sees itself
    first, last = block(state.robot_cells, params.robots.grid, x, y)
    while first < last:
        close = near(params, points, first, last, x, y, params.sensing.limit)
        if params.sensing.counts_all:
            total += popcount(close)
            close = uint32(0)
        while close:
            other = sender_of(points[Point.LABEL, first + lowest(close)])
            if other == i:
                visible = params.sensing.count_self == 1
            else:
                visible = not happens(params, state, i, MISS_ROBOT + PAIR * other, params.sensing.miss)
            new = visible and is_new(params, state, i, other)
            if params.sensing.only_counts:
                total += new
            elif new:
                kind = int64(state.tables.class_of[other])
                count_sighting(params, state, functions, i, other, kind, True)
            close = without_lowest(close)
        first += 32
    return total


@inlined
def observe_tasks(params, state, functions, i, x, y):
    """Observe the tasks in sight of a robot; return how many count, if counting suffices."""
    points = state.task_cells.points
    total = int64(0)
    first, last = block(state.task_cells, params.tasks.grid, x, y)
    while first < last:
        close = near(params, points, first, last, x, y, params.sensing.limit)
        if params.sensing.counts_all:
            total += popcount(close)
            close = uint32(0)
        while close:
            task = int64(points[Point.LABEL, first + lowest(close)])
            seen = not happens(params, state, i, MISS_TASK + PAIR * task, params.sensing.miss)
            new = seen and is_new(params, state, i, WORD * state.sets.shape[1] + task)
            if params.sensing.only_counts:
                total += new
            elif new:
                kind = int64(state.tables.class_of[params.robots.count + task])
                count_sighting(params, state, functions, i, task, kind, False)
            close = without_lowest(close)
        first += 32
    return total


@inlined
def count_sighting(params, state, functions, i, number, kind, is_robot):
    """Count one thing of a class, or add it to what the robot knows."""
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
def count_false_sightings(params, state, functions, i):
    """Count false sightings, each of the class of a robot or task drawn at random, with a hash of its own."""
    run, now = state.clock[Clock.RUN], state.clock[Clock.STEP] + 1
    if params.sensing.false_robots > 0.0:
        for k in range(poisson(draw_now(params, state, i, FALSE_ROBOT), params.sensing.false_robots)):
            words = draw_words(params, run, i, now, FALSE_ROBOT_CLASS + PAIR * k)
            kind = int64(state.tables.class_of[choose(words[0], params.robots.count)])
            mark_next(state, words[1])
            count_sighting(params, state, functions, i, int64(-1), kind, True)
    if params.sensing.false_tasks > 0.0:
        for k in range(poisson(draw_now(params, state, i, FALSE_TASK), params.sensing.false_tasks)):
            words = draw_words(params, run, i, now, FALSE_TASK_CLASS + PAIR * k)
            kind = int64(0)
            if params.tasks.count > 0:
                kind = int64(
                    state.tables.class_of[params.robots.count + choose(words[0], params.tasks.count)]
                )
            mark_next(state, words[1])
            count_sighting(params, state, functions, i, int64(-1), kind, False)


@inlined
def mark_next(state, mark):
    """Give the next pending sighting, if it is a false one, its hash."""
    if state.pending.shape[1] > 0:
        state.pending[Pending.MARK, state.clock[Clock.PENDING]] = int32(mark)


@inlined
def happens(params, state, i, purpose, probability):
    """Return whether an event happens to a robot in this step; ``probability`` is times 2**32."""
    if probability == 0:
        return False
    return uint64(draw_now(params, state, i, purpose)) < probability


@inlined
def is_new(params, state, i, thing):
    """Return whether a thing in sight counts: always, or unless it is remembered; remember it."""
    if not params.sensing.unique:
        return True
    known = contains(state.remembered[i], thing)
    set_member(state.remembered, i, thing, True)
    return not known


@inlined
def broadcast(params, state, i):
    """Send a robot's message to all listening robots in radio range, on the fast path."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    message, value = state.robots[Robot.LABEL, i], state.robots[Robot.SENT_VALUE, i]
    points = state.robot_cells.points
    first, last = block_on_torus(state.robot_cells, params.robots.grid.bits, x, y)
    while first < last:
        close = near_on_torus(points, first, last, x, y, params.radio.limit)
        while close:
            receiver = points[Point.LABEL, first + lowest(close)]
            if receiver != message and (params.decision.listens_for == ALWAYS or is_disseminating(receiver)):
                receive(params, state, sender_of(receiver), message, value)
            close = without_lowest(close)
        first += 32


@spliced
def find_listeners(params, state):
    """Store which robots listen in this step; their phases have been shortened by it already."""
    for w in range(state.sets.shape[1]):
        listening = state.sets[Set.WORKING, w]
        if params.decision.listens_for != ALWAYS:
            listening &= state.sets[Set.DISSEMINATING, w]
        if params.decision.listens_for > WHILE_DISSEMINATING:
            for j in range(32):
                early = state.robots[Robot.PHASE_LEFT, 32 * w + j] >= params.decision.listens_for
                listening &= ~bit_if(early, j)
        state.sets[Set.LISTENING, w] = listening


@inlined
def broadcast_with_loss(params, state, functions, i):
    """Send a robot's message, true or a lie, to listening robots in radio range; some may lose it."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    opinion = sent_opinion(params, state, i)
    message = pack_label(state.robots[Robot.IDENTITY, i], opinion, True)
    value = state.robots[Robot.SENT_VALUE, i]
    if contains(state.sets[Set.BYZANTINE], i):
        value = int32(params.strategy.value_scale) if opinion else int32(0)
    points = state.robot_cells.points
    first, last = block(state.robot_cells, params.robots.grid, x, y)
    while first < last:
        close = near(params, points, first, last, x, y, params.radio.limit)
        while close:
            j = sender_of(points[Point.LABEL, first + lowest(close)])
            can_hear = j != i and contains(state.sets[Set.LISTENING], j)
            if can_hear and not happens(params, state, j, LOSS + PAIR * i, params.radio.loss):
                if params.strategy.knowledge.enabled:
                    defer(params, state, functions, Action.MERGE, j, i, int64(0))
                if params.decision.commit.enabled or not params.strategy.knowledge.enabled:
                    receive(params, state, j, message, value)
            close = without_lowest(close)
        first += 32


@inlined
def forget(params, state, i):
    """Empty a robot's inbox, and its counts unless evidence is kept (model.md 4.6)."""
    empty(params, state, i)
    if params.strategy.forgets:
        clear_counts(params, state, i)
    if params.sensing.unique and not params.sensing.for_life:
        state.remembered[i] = uint32(0)


@inlined
def clear_counts(params, state, i):
    """Set a robot's counts to 0."""
    state.counts[Count.ROBOTS_SEEN, i] = 0
    state.counts[Count.TASKS_SEEN, i] = 0
    if state.seen.shape[0] > 0:
        state.seen[i] = 0
