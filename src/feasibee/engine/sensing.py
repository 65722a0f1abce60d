"""What robots see and hear (model.md 3.2, 4.2, 4.5, 6.3, 6.5): two ways, with the same outcome.

Up to 32 robots as in the paper, each robot's neighbours and inbox are one word, and all robots are looked at
together. Otherwise robots stand in cells, and an inbox is a small hash table.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.cells import (
    block,
    block_on_torus,
    count_within,
    fill,
    first_bits,
    lowest,
    near,
    popcount,
    within,
)
from feasibee.engine.compile import kernel, subroutine
from feasibee.engine.draws import choose, draw, poisson
from feasibee.engine.layout import (
    DISSEMINATING,
    FEASIBLE_VOTES,
    FULL,
    HEARD,
    HEARD_FEASIBLE,
    LABEL,
    LABELS,
    LIARS,
    OPINIONS,
    OPPOSITE,
    RANDOM,
    ROBOTS_SEEN,
    RUN,
    SAYS_FEASIBLE,
    SIGHT,
    STEP,
    TASKS_SEEN,
    VOTES,
    WORKING,
    X,
    Y,
)
from feasibee.vocabulary import (
    FALSE_ROBOT,
    FALSE_ROBOT_CLASS,
    FALSE_TASK,
    FALSE_TASK_CLASS,
    LIE,
    LOSS,
    MISS_ROBOT,
    MISS_TASK,
    PAIR,
)


@kernel
def sense_paper(params, state):
    """Let every robot observe, if it explores, and hear."""
    if params.together:
        sense_few(params, state)
    else:
        sense_many(params, state)


@kernel
def sense_few(params, state):
    """Sense in a swarm of at most 32."""
    xs, ys = state.robots[X], state.robots[Y]
    sight, seen = state.few[SIGHT], state.counts[ROBOTS_SEEN]
    swarm = first_bits(params.robots)
    speaking = state.sets[DISSEMINATING, 0]
    look_about(xs, ys, sight, swarm, params.robots, params.sight_limit)
    looking = uint32(swarm & ~speaking)
    while looking:
        i = lowest(looking)
        tasks = count_within(state.task_cells, params.task_grid, xs[i], ys[i], params.sight_limit)
        state.counts[TASKS_SEEN, i] += tasks
        looking = uint32(looking & uint32(looking - uint32(1)))
    for i in range(32):
        explores = int64(uint32(~speaking >> uint32(i)) & uint32(1))
        seen[i] += -explores & (popcount(sight[i]) + params.count_self)
    if params.radio_limit != params.sight_limit:
        look_about(xs, ys, sight, swarm, params.robots, params.radio_limit)
    if not params.listen_always:
        for i in range(params.robots):
            if uint32(speaking >> uint32(i)) & uint32(1) == 0:
                sight[i] = uint32(0)
    hear_few(params, state, speaking)


@kernel
def look_about(xs, ys, sight, swarm, robots, limit):
    """Note who is near each robot."""
    for i in range(robots):
        others = uint32(swarm & ~uint32(uint32(1) << uint32(i)))
        sight[i] = others & within(xs, ys, 0, xs[i], ys[i], limit)


@kernel
def hear_few(params, state, speaking):
    """Put what each robot hears from those noted beside it into its inbox."""
    sight = state.few[SIGHT]
    opinions = state.sets[OPINIONS, 0]
    if params.every_message:
        votes, feasible_votes = state.counts[VOTES], state.counts[FEASIBLE_VOTES]
        for i in range(32):
            spoken = uint32(sight[i] & speaking)
            votes[i] += popcount(spoken)
            feasible_votes[i] += popcount(uint32(spoken & opinions))
    else:
        heard, feasible = state.few[HEARD], state.few[HEARD_FEASIBLE]
        for i in range(32):
            spoken = uint32(sight[i] & speaking)
            heard[i] |= spoken
            feasible[i] = uint32(uint32(feasible[i] & ~spoken) | uint32(spoken & opinions))


@subroutine
def sense_many(params, state):
    """Sense in a swarm of any size, with nothing beyond the paper."""
    fill_robots(params, state)
    for w in range(state.sets.shape[1]):
        speaking = state.sets[DISSEMINATING, w]
        looking = uint32(~speaking & state.sets[WORKING, w])
        while speaking:
            speak(params, state, int64(32 * w + lowest(speaking)))
            speaking = uint32(speaking & uint32(speaking - uint32(1)))
        while looking:
            look(params, state, int64(32 * w + lowest(looking)))
            looking = uint32(looking & uint32(looking - uint32(1)))


@subroutine
def sense_beyond(params, state):
    """Sense in any swarm (model.md 6.3, 6.5, 6.6)."""
    fill_robots(params, state)
    for w in range(state.sets.shape[1]):
        speaking = state.sets[DISSEMINATING, w]
        looking = uint32(~speaking & state.sets[WORKING, w])
        while speaking:
            speak_maybe(params, state, int64(32 * w + lowest(speaking)))
            speaking = uint32(speaking & uint32(speaking - uint32(1)))
        while looking:
            look_closely(params, state, int64(32 * w + lowest(looking)))
            looking = uint32(looking & uint32(looking - uint32(1)))


@subroutine
def fill_robots(params, state):
    """Sort the robots into cells."""
    robots = state.robots
    fill(state.robot_cells, params.robot_grid, robots[X], robots[Y], robots[LABELS], params.robots)


@kernel
def label(params, state, i):
    """Return who a robot is, the opinion that it tells (bit 1), and whether it speaks (bit 0)."""
    told = int32(has(state.sets[OPINIONS], i))
    if has(state.sets[LIARS], i):
        if params.byzantine_says == OPPOSITE:
            told = int32(1) - told
        else:
            told = int32(params.byzantine_says == SAYS_FEASIBLE)
    return int32(i << 2) | told << int32(1) | int32(has(state.sets[DISSEMINATING], i))


@kernel
def look(params, state, i):
    """Let a robot count the robots and tasks in sight."""
    x, y = state.robots[X, i], state.robots[Y, i]
    robots = count_within(state.robot_cells, params.robot_grid, x, y, params.sight_limit)
    state.counts[ROBOTS_SEEN, i] += robots - 1 + params.count_self  # it is in its own sight
    state.counts[TASKS_SEEN, i] += count_within(state.task_cells, params.task_grid, x, y, params.sight_limit)


@subroutine
def look_closely(params, state, i):
    """Let a robot look at each thing in sight: is it seen, is it new, of which class is it (model.md 6.3)."""
    x, y = state.robots[X, i], state.robots[Y, i]
    cells = state.robot_cells
    first, last = block(cells, params.robot_grid, x, y)
    while first < last:
        close = near(params, cells.points[X], cells.points[Y], first, x, y, params.sight_limit) & first_bits(
            last - first
        )
        while close:
            other = int64(cells.points[LABEL, first + lowest(close)] >> int32(2))
            if other == i:
                visible = params.count_self == 1
            else:
                visible = not happens(params, state, i, MISS_ROBOT + PAIR * other, params.miss)
            if visible and is_new(params, state, i, other):
                see(state, i, int64(state.kinds.of[other]), 0, 1)
            close = uint32(close & uint32(close - uint32(1)))
        first += 32
    cells = state.task_cells
    first, last = block(cells, params.task_grid, x, y)
    while first < last:
        close = near(params, cells.points[X], cells.points[Y], first, x, y, params.sight_limit) & first_bits(
            last - first
        )
        while close:
            task = int64(cells.points[LABEL, first + lowest(close)])
            seen = not happens(params, state, i, MISS_TASK + PAIR * task, params.miss)
            if seen and is_new(params, state, i, 32 * state.sets.shape[1] + task):
                see(state, i, int64(state.kinds.of[params.robots + task]), params.robot_classes, 0)
            close = uint32(close & uint32(close - uint32(1)))
        first += 32
    see_falsely(params, state, i)


@kernel
def see(state, i, kind, offset, is_robot):
    """Count one thing of a class."""
    if state.seen.shape[0] > 0:
        state.seen[i, offset + kind] += 1
    elif is_robot:
        state.counts[ROBOTS_SEEN, i] += 1
    else:
        state.counts[TASKS_SEEN, i] += 1


@subroutine
def see_falsely(params, state, i):
    """Count what isn't there, each of the class of some thing of the swarm's."""
    if params.false_robots > 0.0:
        word = draw(params, state.clock[RUN], i, state.clock[STEP] + 1, FALSE_ROBOT)
        for k in range(poisson(word, params.false_robots)):
            word = draw(params, state.clock[RUN], i, state.clock[STEP] + 1, FALSE_ROBOT_CLASS + PAIR * k)
            see(state, i, int64(state.kinds.of[choose(word, params.robots)]), 0, 1)
    if params.false_tasks > 0.0:
        word = draw(params, state.clock[RUN], i, state.clock[STEP] + 1, FALSE_TASK)
        for k in range(poisson(word, params.false_tasks)):
            kind = int64(0)
            if params.tasks > 0:
                word = draw(params, state.clock[RUN], i, state.clock[STEP] + 1, FALSE_TASK_CLASS + PAIR * k)
                kind = int64(state.kinds.of[params.robots + choose(word, params.tasks)])
            see(state, i, kind, params.robot_classes, 0)


@kernel
def happens(params, state, i, purpose, probability):
    """Tell whether something happens to a robot in this step; its probability is times 2**32."""
    if probability == 0:
        return False
    return uint64(draw(params, state.clock[RUN], i, state.clock[STEP] + 1, purpose)) < probability


@kernel
def is_new(params, state, i, thing):
    """Tell whether a thing in view counts: always, or if it isn't remembered, which it is from now on."""
    if not params.unique:
        return True
    bit = uint32(uint32(1) << uint32(thing & 31))
    known = state.known[i, thing >> 5]
    state.known[i, thing >> 5] = known | bit
    return known & bit == 0


@kernel
def speak(params, state, i):
    """Send a robot's message to all that listen in radio range."""
    x, y = state.robots[X, i], state.robots[Y, i]
    message = state.robots[LABELS, i]
    points = state.robot_cells.points
    first, last = block_on_torus(state.robot_cells, params.robot_grid, x, y)
    while first < last:
        close = within(points[X], points[Y], first, x, y, params.radio_limit) & first_bits(last - first)
        while close:
            receiver = points[LABEL, first + lowest(close)]
            if receiver != message and (params.listen_always or receiver & int32(1)):
                hear(params, state, int64(receiver >> int32(2)), message)
            close = uint32(close & uint32(close - uint32(1)))
        first += 32


@kernel
def speak_maybe(params, state, i):
    """Send a robot's message, true or false, to those in radio range that work and don't lose it."""
    x, y = state.robots[X, i], state.robots[Y, i]
    message = state.robots[LABELS, i]
    if params.byzantine_says == RANDOM and has(state.sets[LIARS], i):
        told = draw(params, state.clock[RUN], i, state.clock[STEP] + 1, LIE) >> uint32(31)
        message = message & ~int32(2) | int32(told) << int32(1)
    points = state.robot_cells.points
    first, last = block(state.robot_cells, params.robot_grid, x, y)
    while first < last:
        close = near(params, points[X], points[Y], first, x, y, params.radio_limit) & first_bits(last - first)
        while close:
            receiver = points[LABEL, first + lowest(close)]
            j = int64(receiver >> int32(2))
            listens = params.listen_always or receiver & int32(1) == int32(1)
            can_hear = j != i and listens and has(state.sets[WORKING], j)
            if can_hear and not happens(params, state, j, LOSS + PAIR * i, params.loss):
                hear(params, state, j, message)
            close = uint32(close & uint32(close - uint32(1)))
        first += 32


@kernel
def hear(params, state, i, message):
    """Put a message, the sender's label, into a robot's inbox."""
    opinion = int64(message >> int32(1)) & 1
    if params.every_message:
        state.counts[VOTES, i] += 1
        state.counts[FEASIBLE_VOTES, i] += opinion
        return
    inbox = state.inbox[i]
    slots = inbox.size
    sender = message >> int32(2)
    place = int64(uint32(uint32(sender) * uint32(0x9E3779B1)) >> uint32(8)) & (slots - 1)
    while inbox[place] >= 0 and inbox[place] >> int32(2) != sender:
        place = (place + 1) & (slots - 1)
    known = inbox[place]
    if known >= 0:
        state.counts[FEASIBLE_VOTES, i] += opinion - (int64(known >> int32(1)) & 1)
    elif (
        4 * state.counts[VOTES, i] >= 3 * slots
    ):  # nearly full; the caller plays this run again with more room
        state.clock[FULL] = 1
        return
    else:
        state.counts[VOTES, i] += 1
        state.counts[FEASIBLE_VOTES, i] += opinion
    inbox[place] = message


@kernel
def has(words, i):
    """Tell whether a set has robot i."""
    return uint32(words[i >> 5] >> uint32(i & 31)) & uint32(1) == uint32(1)


@kernel
def count_votes(params, state, i):
    """Return how many votes in a robot's inbox say feasible, and how many infeasible."""
    if params.together and not params.every_message:
        votes = popcount(state.few[HEARD, i])
        feasible = popcount(state.few[HEARD_FEASIBLE, i])
    else:
        votes = state.counts[VOTES, i]
        feasible = state.counts[FEASIBLE_VOTES, i]
    return feasible, votes - feasible


@kernel
def forget(params, state, i):
    """Empty a robot's inbox and all its counts (model.md 4.6)."""
    state.counts[ROBOTS_SEEN, i] = 0
    state.counts[TASKS_SEEN, i] = 0
    if state.seen.shape[0] > 0:
        state.seen[i] = 0
    if params.unique and not params.for_life:
        state.known[i] = uint32(0)
    if params.together:
        state.few[HEARD, i] = uint32(0)
        state.few[HEARD_FEASIBLE, i] = uint32(0)
    elif state.counts[VOTES, i] > 0 and not params.every_message:
        state.inbox[i] = int32(-1)
    state.counts[VOTES, i] = 0
    state.counts[FEASIBLE_VOTES, i] = 0
