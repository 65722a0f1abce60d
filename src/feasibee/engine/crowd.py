"""What the robots of a swarm of more than 32 see and hear (model.md 3.2, 4.2, 4.5).

Each robot looks through the cells around it. What it hears, or sees if that has to be looked at closely, is
queued, and worked off for many robots at once. So the loops over robots have little to keep in registers.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import has_bit, lowest_member, place_of, without_lowest
from feasibee.engine.cells import are_few, block, count_within, few_near, few_near_both, near, near_both
from feasibee.engine.compile import called, inlined
from feasibee.engine.inbox import keep_label, keeps_labels_only, receive
from feasibee.engine.intrinsics import LANES, popcount
from feasibee.engine.layout import HEARD_ROOM, WORD, Count, Heard, Point, Robot, Set, Share
from feasibee.engine.order import fill_robots
from feasibee.engine.params import ALWAYS
from feasibee.engine.queues import few_odd, many_odd, store_few, store_many


@called
def sense_crowd(params, state, part):
    """Let exploring robots observe and listening robots receive, on the fast path."""
    fill_robots(params, state, part)
    speaking = queued = int64(0)
    for w in range(part.first, part.last):
        speaking += popcount(state.sets[Set.SPEAKING, w])
        disseminating, working = state.sets[Set.DISSEMINATING, w], state.sets[Set.WORKING, w]
        listening = working if params.decision.listens_for == ALWAYS else disseminating
        exploring = uint32(working & ~disseminating)
        left = uint32(listening | exploring)
        while left:
            i = uint64(lowest_member(w, left))
            queued = look_and_listen(params, state, part, i, exploring, listening, queued)
            if queued > HEARD_ROOM:
                queued = receive_queued(params, state, part, queued)
            left = without_lowest(left)
    receive_queued(params, state, part, queued)
    part.shared[part.thread, Share.BITS] = speaking * params.radio.message_bits
    count_tasks(params, state, part)


@inlined
def look_and_listen(params, state, part, i, exploring, listening, queued):
    """Count the robots in sight of a robot and queue the messages that it hears, by its bits in two words."""
    seen, queued = scan(params, state, part, i, has_bit(listening, i), queued)
    explores = -int64(has_bit(exploring, i))
    state.counts[Count.ROBOTS_SEEN, i] += explores & (seen - 1 + params.sensing.count_self)
    return queued


@inlined
def scan(params, state, part, i, listens, queued):
    """Return how many robots are in sight of a robot, itself included; queue the messages that it hears."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    first, last, other_first, other_last = block(state.robot_cells, params.robots.grid, x, y)
    if not are_few(first, last, other_first, other_last):
        return scan_many(params, state, part, i, listens, queued, (first, last, other_first, other_last))
    heard, numbers, own = state.heard[part.thread], points[Point.NUMBER], own_number(i)
    seen, close = few_near_both(params, points, first, last, x, y)
    other_seen, other_close = few_near_both(params, points, other_first, other_last, x, y)
    if listens:
        queued = queue_few(heard, numbers, first, close & few_odd(numbers, first, own), i, queued)
        other_close &= few_odd(numbers, other_first, own)
        queued = queue_few(heard, numbers, other_first, other_close, i, queued)
    return popcount(uint32(seen | other_seen << uint32(LANES))), queued


@inlined
def scan_many(params, state, part, i, listens, queued, stretches):
    """Do what `scan` does where more robots are around."""
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], state.robot_cells.points
    first, last, other_first, other_last = stretches
    total = int64(0)
    for _ in range(2):
        while first < last:
            seen, close = near_both(params, points, first, last, x, y)
            total += popcount(seen)
            if listens:
                close &= many_odd(points[Point.NUMBER], first, own_number(i))
                queued = queue_many(state.heard[part.thread], points[Point.NUMBER], first, close, i, queued)
            first += WORD
        first, last = other_first, other_last
    return total, queued


@inlined
def own_number(i):
    """Return what stands for a robot in the cells while it broadcasts."""
    return int32(int32(i) << int32(1)) | int32(1)


@inlined
def queue_few(heard, numbers, first, chosen, i, queued):
    """Queue the chosen ones of 8 numbers for a robot; return how many are queued."""
    return queued + store_few(numbers, first, chosen, heard[Heard.SENDER], queued, i, heard[Heard.RECEIVER])


@inlined
def queue_many(heard, numbers, first, chosen, i, queued):
    """Queue the chosen ones of 32 numbers for a robot; return how many are queued.

    Even if none is chosen: a branch would often be mispredicted, which took a tenth of a step.
    """
    return queued + store_many(numbers, first, chosen, heard[Heard.SENDER], queued, i, heard[Heard.RECEIVER])


@called
def receive_queued(params, state, part, queued):
    """Let robots receive the queued messages; return 0."""
    receivers, senders = state.heard[part.thread, Heard.RECEIVER], state.heard[part.thread, Heard.SENDER]
    labels, values = state.robots[Robot.LABEL], state.robots[Robot.SENT_VALUE]
    if keeps_labels_only(params):  # so the loop need not ask
        for k in range(queued):
            i, other = uint64(receivers[k]), uint64(place_of(senders[k]))
            keep_label(params, state, part, i, labels[other])
    else:
        for k in range(queued):
            i, other = uint64(receivers[k]), uint64(place_of(senders[k]))
            receive(params, state, part, i, labels[other], values[other])
    return int64(0)


@inlined
def count_tasks(params, state, part):
    """Count the tasks in sight of exploring robots."""
    grid, xs, ys = params.tasks.grid, state.robots[Robot.X], state.robots[Robot.Y]
    limit, cells = params.sensing.limit, state.task_cells
    for w in range(part.first, part.last):
        left = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        while left:
            i = uint64(lowest_member(w, left))
            state.counts[Count.TASKS_SEEN, i] += count_within(params, cells, grid, xs[i], ys[i], limit)
            left = without_lowest(left)


@inlined
def queue_near(params, state, part, cells, grid, i, limit, queued):
    """Queue what is near a robot, robots or tasks; return how many are queued.

    ``limit`` is above their squared distances. A robot is near itself.
    """
    x, y, points = state.robots[Robot.X, i], state.robots[Robot.Y, i], cells.points
    first, last, other_first, other_last = block(cells, grid, x, y)
    heard, numbers = state.heard[part.thread], points[Point.NUMBER]
    if are_few(first, last, other_first, other_last):
        close = few_near(params, points, first, last, x, y, limit)
        queued = queue_few(heard, numbers, first, close, i, queued)
        close = few_near(params, points, other_first, other_last, x, y, limit)
        return queue_few(heard, numbers, other_first, close, i, queued)
    for _ in range(2):
        while first < last:
            close = near(params, points, first, last, x, y, limit)
            queued = queue_many(heard, numbers, first, close, i, queued)
            first += WORD
        first, last = other_first, other_last
    return queued
