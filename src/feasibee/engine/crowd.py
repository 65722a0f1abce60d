"""Observation and messages in a swarm of more than 32 robots, on the fast path (model.md 3.2, 4.2, 4.5).

Each robot looks through the cells around it once, for the robots in sight and for messages. What it hears is
queued, and received for many robots at once: so the loop over the robots has little to keep in registers.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import first_bits, has_bit, lowest_member, place_of, without_lowest
from feasibee.engine.cells import block_on_square, count_within, few_near
from feasibee.engine.compile import called, inlined
from feasibee.engine.inbox import receive
from feasibee.engine.intrinsics import LANES, popcount, store_all_speakers, store_speakers, within
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
    look_and_listen(params, state, part)
    count_tasks(params, state, part)


@inlined
def look_and_listen(params, state, part):
    """Count the robots in sight of those that explore, and receive the messages in radio range."""
    queued = int64(0)
    for w in range(part.first, part.last):
        exploring, listening = uint32(~state.sets[Set.DISSEMINATING, w]), listeners(params, state, w)
        left = uint32((exploring | listening) & first_bits(params.robots.count - WORD * w))
        while left:
            i = uint64(lowest_member(w, left))
            seen, queued = scan(params, state, part, i, has_bit(listening, i), queued)
            explores = -int64(has_bit(exploring, i))
            state.counts[Count.ROBOTS_SEEN, i] += explores & (seen - 1 + params.sensing.count_self)
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
def scan(params, state, part, i, listens, queued):
    """Return how many robots are in sight of a robot, itself included; queue the messages that it hears."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    sight, radio = params.sensing.limit, params.radio.limit
    first, last, other_first, other_last = block_on_square(state.robot_cells, params.robots.grid, x, y)
    if max(last - first, other_last - other_first) <= LANES:
        seen = few_near(points, first, last, x, y, sight)
        seen |= few_near(points, other_first, other_last, x, y, sight) << uint32(LANES)
        # LLVM computes distances once for both ranges.
        close = few_near(points, first, last, x, y, radio) if listens else uint32(0)
        queued = queue(state, part, first, close, i, queued)
        close = few_near(points, other_first, other_last, x, y, radio) if listens else uint32(0)
        queued = queue(state, part, other_first, close, i, queued)
        return popcount(seen), make_room(params, state, part, queued)
    return scan_many(params, state, part, i, listens, queued, (first, last, other_first, other_last))


@inlined
def scan_many(params, state, part, i, listens, queued, stretches):
    """Do what `scan` does where more robots are around."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    first, last, other_first, other_last = stretches
    heard, total = state.heard[part.thread], int64(0)
    for _ in range(2):
        while first < last:
            there = first_bits(last - first)
            seen = there & within(points[Point.X], points[Point.Y], first, x, y, params.sensing.limit)
            close = there & within(points[Point.X], points[Point.Y], first, x, y, params.radio.limit)
            total += popcount(seen)
            if listens and close:
                for k in range(WORD):
                    heard[Heard.RECEIVER, uint64(queued + k)] = int32(i)
                own, senders = own_number(i), heard[Heard.SENDER]
                queued += store_all_speakers(points[Point.NUMBER], first, close, own, senders, queued)
                queued = make_room(params, state, part, queued)
            first += WORD
        first, last = other_first, other_last
    return total, queued


@inlined
def queue(state, part, first, close, i, queued):
    """Queue messages for a robot of those who are close, of 8; return how many are queued."""
    heard, numbers = state.heard[part.thread], state.robot_cells.points[Point.NUMBER]
    for k in range(LANES):
        heard[Heard.RECEIVER, uint64(queued + k)] = int32(i)
    return queued + store_speakers(numbers, first, close, own_number(i), heard[Heard.SENDER], queued)


@inlined
def own_number(i):
    """Return what stands for a robot in the cells while it broadcasts."""
    return int32(int32(i) << int32(1)) | int32(1)


@inlined
def make_room(params, state, part, queued):
    """Make sure that a word of messages has room in the queue; return how many are queued."""
    return queued if queued <= HEARD_ROOM - 2 * WORD else receive_queued(params, state, part, queued)


@called
def receive_queued(params, state, part, queued):
    """Let robots receive the queued messages; return 0."""
    heard, labels, values = (
        state.heard[part.thread],
        state.robots[Robot.LABEL],
        state.robots[Robot.SENT_VALUE],
    )
    for k in range(queued):
        i, other = uint64(heard[Heard.RECEIVER, k]), uint64(place_of(heard[Heard.SENDER, k]))
        receive(params, state, part, i, labels[other], values[other])
    return int64(0)
