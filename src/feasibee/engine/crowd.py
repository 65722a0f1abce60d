"""Observation and messages in a swarm of more than 32 robots, on the fast path (model.md 3.2, 4.2, 4.5).

Each robot looks through the cells around it once, for the robots in sight and for messages. What it hears is
queued, and received for many robots at once: so the loop over the robots has little to keep in registers.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import first_bits, has_bit, lowest_member, place_of, without_lowest
from feasibee.engine.cells import are_few, block, count_within, few_in_block, near_on_square
from feasibee.engine.compile import called, inlined
from feasibee.engine.inbox import receive
from feasibee.engine.intrinsics import LANES, few_odd, lowest, popcount
from feasibee.engine.layout import HEARD_ROOM, WORD, Count, Heard, Point, Robot, Set, Share
from feasibee.engine.order import fill_robots
from feasibee.engine.params import ALWAYS


@called
def sense_in_cells(params, state, part):
    """Let exploring robots observe and listening robots receive."""
    fill_robots(params, state, part)
    speaking = int64(0)
    for w in range(part.first, part.last):
        speaking += popcount(state.sets[Set.SPEAKING, w])
    part.shared[part.thread, Share.BITS] = speaking * params.radio.message_bits
    look_around(params, state, part)
    if params.radio.limit != params.sensing.limit:
        listen_around(params, state, part)
    count_tasks(params, state, part)


@inlined
def look_around(params, state, part):
    """Count the robots in sight; if the ranges for sight and radio are equal, listen to them."""
    listens = params.radio.limit == params.sensing.limit
    queued = int64(0)
    for w in range(part.first, part.last):
        exploring = uint32(~state.sets[Set.DISSEMINATING, w])
        listening = listeners(params, state, w) if listens else uint32(0)
        left = uint32((exploring | listening) & first_bits(params.robots.count - WORD * w))
        while left:
            i = uint64(lowest_member(w, left))
            seen, queued = scan(params, state, part, i, params.sensing.limit, has_bit(listening, i), queued)
            explores = -int64(has_bit(exploring, i))
            state.counts[Count.ROBOTS_SEEN, i] += explores & (seen - 1 + params.sensing.count_self)
            left = without_lowest(left)
    receive_queued(params, state, part, queued)


@inlined
def listen_around(params, state, part):
    """Receive the messages of the robots in radio range."""
    queued = int64(0)
    for w in range(part.first, part.last):
        left = uint32(listeners(params, state, w) & first_bits(params.robots.count - WORD * w))
        while left:
            i = uint64(lowest_member(w, left))
            _, queued = scan(params, state, part, i, params.radio.limit, True, queued)
            left = without_lowest(left)
    receive_queued(params, state, part, queued)


@inlined
def listeners(params, state, w):
    """Return which robots of a word listen."""
    return uint32(0xFFFFFFFF) if params.decision.listens_for == ALWAYS else state.sets[Set.DISSEMINATING, w]


@inlined
def count_tasks(params, state, part):
    """Count the tasks in sight of exploring robots."""
    grid, xs, ys = params.tasks.grid, state.robots[Robot.X], state.robots[Robot.Y]
    limit = params.sensing.limit
    for w in range(part.first, part.last):
        left = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while left:
            i = uint64(lowest_member(w, left))
            state.counts[Count.TASKS_SEEN, i] += count_within(state.task_cells, grid, xs[i], ys[i], limit)
            left = without_lowest(left)


@inlined
def scan(params, state, part, i, limit, listens, queued):
    """Return how many robots are near a robot, itself included; queue the messages that it hears."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    stretches = block(state.robot_cells, params.robots.grid, x, y)
    if not are_few(stretches):
        return scan_many(params, state, part, i, stretches, limit, listens, queued)
    close = few_in_block(points, stretches, x, y, limit)
    if listens:
        first, _, other_first, _ = stretches
        numbers = points[Point.NUMBER]
        heard = close & (few_odd(numbers, first) | few_odd(numbers, other_first) << uint32(LANES))
        while heard:
            k = lowest(heard)
            place = first + k if k < LANES else other_first + k - LANES
            queued = queue(state, part, i, place_of(numbers[uint64(place)]), queued)
            heard = without_lowest(heard)
        if queued > HEARD_ROOM - WORD:
            queued = receive_queued(params, state, part, queued)
    return popcount(close), queued


@called
def scan_many(params, state, part, i, stretches, limit, listens, queued):
    """Do what `scan` does where more robots are in the cells."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    first, last, other_first, other_last = stretches
    seen = int64(0)
    for _ in range(2):
        while first < last:
            close = near_on_square(points, first, last, x, y, limit)
            seen += popcount(close)
            while close and listens:
                numbered = points[Point.NUMBER, uint64(first + lowest(close))]
                if numbered & int32(1):
                    queued = queue(state, part, i, place_of(numbered), queued)
                close = without_lowest(close)
            if queued > HEARD_ROOM - WORD:
                queued = receive_queued(params, state, part, queued)
            first += WORD
        first, last = other_first, other_last
    return seen, queued


@inlined
def queue(state, part, i, other, queued):
    """Queue a message for a robot, unless it is its own; return how many are queued."""
    state.heard[part.thread, Heard.RECEIVER, uint64(queued)] = int32(i)
    state.heard[part.thread, Heard.SENDER, uint64(queued)] = int32(other)
    return queued + int64(int64(i) != other)


@called
def receive_queued(params, state, part, queued):
    """Let robots receive the queued messages; return 0."""
    heard, labels, values = state.heard[part.thread], state.robots[Robot.LABEL], state.robots[Robot.SENT_VALUE]
    for k in range(queued):
        i, other = uint64(heard[Heard.RECEIVER, k]), uint64(heard[Heard.SENDER, k])
        receive(params, state, part, i, labels[other], values[other])
    return int64(0)
