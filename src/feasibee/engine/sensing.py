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
    is_speaking,
    lowest_member,
    number_of,
    pack_label,
    place_of,
    says_feasible,
    set_member,
    without_lowest,
)
from feasibee.engine.cells import block, near
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.crowd import sense_in_cells
from feasibee.engine.draws import choose, draw_now, draw_words, poisson
from feasibee.engine.inbox import empty, receive, receive_together
from feasibee.engine.intrinsics import find_near, lowest, popcount, within
from feasibee.engine.knowledge import defer, publish, update_pending
from feasibee.engine.layout import WORD, Clock, Count, Heard, Link, Pending, Point, Robot, Set, Share
from feasibee.engine.order import fill_robots
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
def sense_fast(params, state, part):
    """Let exploring robots observe and listening robots receive, on the fast path."""
    if params.together:
        sense_together(params, state, part)
    else:
        sense_in_cells(params, state, part)


@spliced
def sense_together(params, state, part):
    """Sense in a swarm of at most 32 on the fast path."""
    xs, ys = state.robots[Robot.X], state.robots[Robot.Y]
    sight, seen = state.links[Link.SIGHT], state.counts[Count.ROBOTS_SEEN]
    swarm = first_bits(params.robots.count)
    speaking, disseminating = state.sets[Set.SPEAKING, 0], state.sets[Set.DISSEMINATING, 0]
    part.shared[part.thread, Share.BITS] = popcount(speaking) * params.radio.message_bits
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
    receive_together(params, state, speaking)


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


@spliced
def sense_general(params, state, functions, part):
    """Sense in the general engine (model.md 6.3, 6.5, 6.6).

    What a robot observes in a step it knows before it receives messages.
    """
    publish(params, state, functions, part)
    fill_robots(params, state, part)
    for w in range(part.first, part.last):
        looking = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while looking:
            observe_general(params, state, functions, lowest_member(w, looking))
            looking = without_lowest(looking)
    update_pending(params, state, functions, Action.OBSERVE)
    find_listeners(params, state, part)
    for w in range(part.first, part.last):
        listening = state.sets[Set.LISTENING, w]
        while listening:
            listen_general(params, state, functions, part, lowest_member(w, listening))
            listening = without_lowest(listening)
    update_pending(params, state, functions, Action.MERGE)


@inlined
def label_of(state, i):
    """Return a robot's present label; see `feasibee.engine.bits.pack_label`."""
    says, speaks = contains(state.sets[Set.SAYS_FEASIBLE], i), contains(state.sets[Set.SPEAKING], i)
    return pack_label(number_of(state.robots[Robot.LABEL, i]), says, speaks)


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
    first, last, other_first, other_last = block(state.robot_cells, params.robots.grid, x, y)
    for _ in range(2):
        while first < last:
            close = near(params, points, first, last, x, y, params.sensing.limit)
            if params.sensing.counts_all:
                total += popcount(close)
                close = uint32(0)
            while close:
                other = place_of(points[Point.NUMBER, first + lowest(close)])
                total += observe_robot(params, state, functions, i, other)
                close = without_lowest(close)
            first += 32
        first, last = other_first, other_last
    return total


@spliced
def observe_robot(params, state, functions, i, place):
    """Observe a robot in sight, by its place in the arrays; return how many count, if counting suffices."""
    own, other = number_of(state.robots[Robot.LABEL, i]), number_of(state.robots[Robot.LABEL, place])
    if other == own:
        visible = params.sensing.count_self == 1
    else:
        visible = not happens(params, state, own, MISS_ROBOT + PAIR * other, params.sensing.miss)
    new = visible and is_new(params, state, own, other)
    if new and not params.sensing.only_counts:
        count_sighting(params, state, functions, i, other, int64(state.tables.class_of[other]), True)
    return int64(new)


@spliced
def observe_tasks(params, state, functions, i, x, y):
    """Observe the tasks in sight of a robot; return how many count, if counting suffices."""
    points = state.task_cells.points
    total = int64(0)
    first, last, other_first, other_last = block(state.task_cells, params.tasks.grid, x, y)
    for _ in range(2):
        while first < last:
            close = near(params, points, first, last, x, y, params.sensing.limit)
            if params.sensing.counts_all:
                total += popcount(close)
                close = uint32(0)
            while close:
                task = int64(points[Point.NUMBER, first + lowest(close)])
                total += observe_task(params, state, functions, i, task)
                close = without_lowest(close)
            first += 32
        first, last = other_first, other_last
    return total


@spliced
def observe_task(params, state, functions, i, task):
    """Observe a task in sight; return how many count, if counting suffices."""
    own = number_of(state.robots[Robot.LABEL, i])
    seen = not happens(params, state, own, MISS_TASK + PAIR * task, params.sensing.miss)
    new = seen and is_new(params, state, own, WORD * state.sets.shape[1] + task)
    if new and not params.sensing.only_counts:
        kind = int64(state.tables.class_of[params.robots.count + task])
        count_sighting(params, state, functions, i, task, kind, False)
    return int64(new)


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
    run, now, own = (
        state.clock[Clock.RUN],
        state.clock[Clock.STEP] + 1,
        number_of(state.robots[Robot.LABEL, i]),
    )
    if params.sensing.false_robots > 0.0:
        for k in range(poisson(draw_now(params, state, own, FALSE_ROBOT), params.sensing.false_robots)):
            words = draw_words(params, run, own, now, FALSE_ROBOT_CLASS + PAIR * k)
            kind = int64(state.tables.class_of[choose(words[0], params.robots.count)])
            mark_next(state, words[1])
            count_sighting(params, state, functions, i, int64(-1), kind, True)
    if params.sensing.false_tasks > 0.0:
        for k in range(poisson(draw_now(params, state, own, FALSE_TASK), params.sensing.false_tasks)):
            words = draw_words(params, run, own, now, FALSE_TASK_CLASS + PAIR * k)
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
def happens(params, state, number, purpose, probability):
    """Return whether an event happens to a robot in this step; ``probability`` is times 2**32."""
    if probability == 0:
        return False
    return uint64(draw_now(params, state, number, purpose)) < probability


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


@spliced
def listen_general(params, state, functions, part, i):
    """Receive the messages of the robots in radio range of a robot, true or lies; some may be lost."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    points, number = state.robot_cells.points, int64(0)
    first, last, other_first, other_last = block(state.robot_cells, params.robots.grid, x, y)
    for _ in range(2):
        while first < last:
            close = near(params, points, first, last, x, y, params.radio.limit)
            if params.robots.count <= WORD:  # cells hold robots in their order: drop who is silent at once
                close &= state.sets[Set.SPEAKING, 0] & ~bit(i)
            while close:
                numbered = points[Point.NUMBER, first + lowest(close)]
                other = place_of(numbered)
                if is_speaking(numbered) and other != i:
                    if params.in_sender_order:
                        state.heard[part.thread, Heard.SENDER, number] = int32(other)
                        number += 1
                    else:
                        receive_general(params, state, functions, part, i, other)
                close = without_lowest(close)
            first += 32
        first, last = other_first, other_last
    if params.in_sender_order:
        sort_by_number(state, part, number)
        for k in range(number):
            receive_general(
                params, state, functions, part, i, int64(state.heard[part.thread, Heard.SENDER, k])
            )


@called
def sort_by_number(state, part, count):
    """Sort who has been heard by number: a few sorted runs."""
    heard, labels = state.heard[part.thread, Heard.SENDER], state.robots[Robot.LABEL]
    for k in range(1, count):
        other, place = heard[k], k
        while place > 0 and number_of(labels[heard[place - 1]]) > number_of(labels[other]):
            heard[place] = heard[place - 1]
            place -= 1
        heard[place] = other


@inlined
def receive_general(params, state, functions, part, i, other):
    """Receive the message of a robot in radio range unless it is lost."""
    own, label = number_of(state.robots[Robot.LABEL, i]), state.robots[Robot.LABEL, other]
    if happens(params, state, own, LOSS + PAIR * number_of(label), params.radio.loss):
        return
    if params.strategy.knowledge.enabled:
        defer(params, state, functions, Action.MERGE, i, other, int64(0))
    if params.decision.commit.enabled or not params.strategy.knowledge.enabled:
        message = label
        if params.radio.random_ids:
            message = pack_label(state.robots[Robot.IDENTITY, other], says_feasible(label) == 1, True)
        receive(params, state, part, i, message, state.robots[Robot.SENT_VALUE, other])


@inlined
def forget(params, state, part, i):
    """Empty a robot's inbox, and its counts unless evidence is kept (model.md 4.6)."""
    empty(params, state, part, i)
    if params.strategy.forgets:
        clear_counts(params, state, i)
    if params.sensing.unique and not params.sensing.for_life:
        state.remembered[number_of(state.robots[Robot.LABEL, i])] = uint32(0)


@inlined
def clear_counts(params, state, i):
    """Set a robot's counts to 0."""
    state.counts[Count.ROBOTS_SEEN, i] = 0
    state.counts[Count.TASKS_SEEN, i] = 0
    if state.seen.shape[0] > 0:
        state.seen[i] = 0
