"""What robots see and hear (model.md 3.2, 4.2, 4.5): two ways, with the same outcome.

Up to 32 robots, each robot's neighbours and inbox are one word, and all robots are looked at together.
Beyond, robots stand in cells, and an inbox is a small hash table.
"""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.cells import block, count_within, fill, first_bits, lowest, popcount, within
from feasibee.engine.compile import kernel
from feasibee.engine.layout import FULL


@kernel
def sense(params, state):
    """Let every robot observe, if it explores, and hear."""
    if state.opinions.size == 1:
        sense_few(params, state)
    else:
        sense_many(params, state)


@kernel
def sense_few(params, state):
    """Sense in a swarm of at most 32."""
    swarm = first_bits(params.robots)
    speaking = state.disseminating[0]
    for i in range(params.robots):
        others = uint32(swarm & ~uint32(uint32(1) << uint32(i)))
        state.sight[i] = others & within(state.x, state.y, 0, state.x[i], state.y[i], params.sight_limit)
    looking = uint32(swarm & ~speaking)
    while looking:
        i = lowest(looking)
        state.tasks_seen[i] += count_within(
            state.task_cells, params.task_bits, state.x[i], state.y[i], params.sight_limit
        )
        looking = uint32(looking & uint32(looking - uint32(1)))
    for i in range(32):
        explores = int64(uint32(~speaking >> uint32(i)) & uint32(1))
        state.robots_seen[i] += -explores & (popcount(state.sight[i]) + params.count_self)
    if params.radio_limit != params.sight_limit:
        for i in range(params.robots):
            others = uint32(swarm & ~uint32(uint32(1) << uint32(i)))
            state.sight[i] = others & within(state.x, state.y, 0, state.x[i], state.y[i], params.radio_limit)
    if not params.listen_always:
        for i in range(params.robots):
            if uint32(speaking >> uint32(i)) & uint32(1) == 0:
                state.sight[i] = uint32(0)
    hear_few(params, state, speaking)


@kernel
def hear_few(params, state, speaking):
    """Put what each robot hears from those in ``state.sight`` into its inbox."""
    opinions = state.opinions[0]
    if params.every_message:
        for i in range(32):
            heard = uint32(state.sight[i] & speaking)
            state.votes[i] += popcount(heard)
            state.feasible_votes[i] += popcount(uint32(heard & opinions))
    else:
        for i in range(32):
            heard = uint32(state.sight[i] & speaking)
            state.heard[i] |= heard
            state.heard_feasible[i] = uint32(
                uint32(state.heard_feasible[i] & ~heard) | uint32(heard & opinions)
            )


@kernel
def sense_many(params, state):
    """Sense in a swarm of any size."""
    fill(state.robot_cells, params.robot_bits, state.x, state.y, state.labels, params.robots)
    for w in range(state.disseminating.size):
        speaking = state.disseminating[w]
        looking = uint32(~speaking & first_bits(params.robots - 32 * w))
        while speaking:
            speak(params, state, 32 * w + lowest(speaking))
            speaking = uint32(speaking & uint32(speaking - uint32(1)))
        while looking:
            look(params, state, 32 * w + lowest(looking))
            looking = uint32(looking & uint32(looking - uint32(1)))


@kernel
def label(state, i):
    """Return who a robot is, its opinion (bit 1), and whether it speaks (bit 0)."""
    return int32(i << 2) | int32(has(state.opinions, i)) << int32(1) | int32(has(state.disseminating, i))


@kernel
def look(params, state, i):
    """Let a robot count the robots and tasks in sight."""
    x, y = state.x[i], state.y[i]
    robots = count_within(state.robot_cells, params.robot_bits, x, y, params.sight_limit)
    state.robots_seen[i] += robots - 1 + params.count_self  # it is in its own sight
    state.tasks_seen[i] += count_within(state.task_cells, params.task_bits, x, y, params.sight_limit)


@kernel
def speak(params, state, i):
    """Send a robot's message to all that listen in radio range."""
    x, y = state.x[i], state.y[i]
    cells = state.robot_cells
    message = state.labels[i]
    first, last = block(cells, params.robot_bits, x, y)
    while first < last:
        near = uint32(within(cells.x, cells.y, first, x, y, params.radio_limit) & first_bits(last - first))
        while near:
            receiver = cells.label[first + lowest(near)]
            if receiver != message and (params.listen_always or receiver & int32(1)):
                hear(params, state, int64(receiver >> int32(2)), message)
            near = uint32(near & uint32(near - uint32(1)))
        first += 32


@kernel
def hear(params, state, i, message):
    """Put a message, the sender's label, into a robot's inbox."""
    opinion = int64(message >> int32(1)) & 1
    if params.every_message:
        state.votes[i] += 1
        state.feasible_votes[i] += opinion
        return
    inbox = state.inbox[i]
    slots = inbox.size
    sender = message >> int32(2)
    place = int64(uint32(uint32(sender) * uint32(0x9E3779B1)) >> uint32(8)) & (slots - 1)
    while inbox[place] >= 0 and inbox[place] >> int32(2) != sender:
        place = (place + 1) & (slots - 1)
    known = inbox[place]
    if known >= 0:
        state.feasible_votes[i] += opinion - (int64(known >> int32(1)) & 1)
    elif 4 * state.votes[i] >= 3 * slots:  # nearly full; the caller plays this run again with more room
        state.clock[FULL] = 1
        return
    else:
        state.votes[i] += 1
        state.feasible_votes[i] += opinion
    inbox[place] = message


@kernel
def has(words, i):
    """Tell whether a set has robot i."""
    return uint32(words[i >> 5] >> uint32(i & 31)) & uint32(1) == uint32(1)


@kernel
def count_votes(params, state, i):
    """Return how many votes in a robot's inbox say feasible, and how many infeasible."""
    if state.opinions.size == 1 and not params.every_message:
        votes = popcount(state.heard[i])
        feasible = popcount(state.heard_feasible[i])
    else:
        votes = state.votes[i]
        feasible = state.feasible_votes[i]
    return feasible, votes - feasible


@kernel
def forget(params, state, i):
    """Empty a robot's inbox and both its counts (model.md 4.6)."""
    state.robots_seen[i] = 0
    state.tasks_seen[i] = 0
    if state.opinions.size == 1:
        state.heard[i] = uint32(0)
        state.heard_feasible[i] = uint32(0)
    elif state.votes[i] > 0 and not params.every_message:
        state.inbox[i] = int32(-1)
    state.votes[i] = 0
    state.feasible_votes[i] = 0
