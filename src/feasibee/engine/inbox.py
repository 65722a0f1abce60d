"""Inboxes (model.md 4.5): sets for up to 128 robots with ids of their own, else a small hash table per robot.

Each robot has a line of 8 slots, in the order of the robots. An inbox that outgrows it takes one of the
tables that lie behind all lines. Most never do: so a large swarm needs little memory. Eight slots are
compared at once.
"""

from __future__ import annotations

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import choose
from feasibee.engine.intrinsics import (
    has_bit,
    lowest,
    lowest_member,
    popcount,
    says_feasible,
    sender_of,
    without_lowest,
)
from feasibee.engine.layout import LINE, WORD, Clock, Count, Lack, Link, Robot, Slot
from feasibee.engine.queues import same_or_free
from feasibee.model.codes import NO_OPINION


@spliced
def receive_together(params, state, part, other, speaking, said):
    """Add the messages of the speaking robots of a word in each robot's sight.

    Those of ``said`` are for *feasible*.
    """
    sight, last = state.links[Link.SIGHT, other], WORD * part.last
    if params.decision.every_message:
        votes, feasible_votes = state.counts[Count.VOTES], state.counts[Count.FEASIBLE_VOTES]
        for i in range(last):
            spoken = uint32(sight[i] & speaking)
            votes[i] += popcount(spoken)
            feasible_votes[i] += popcount(uint32(spoken & said))
        return
    heard, feasible = state.links[Link.HEARD, other], state.links[Link.HEARD_FEASIBLE, other]
    for i in range(last):
        spoken = uint32(sight[i] & speaking)
        heard[i] |= spoken
        feasible[i] = uint32(uint32(feasible[i] & ~spoken) | uint32(spoken & said))
    if params.strategy.value_scale > 0.0:
        for i in range(params.robots.count):
            spoken = uint32(sight[i] & speaking)
            while spoken:
                j = lowest_member(other, spoken)
                state.inbox[Slot.VALUE, last * i + j] = state.robots[Robot.SENT_VALUE, j]
                spoken = without_lowest(spoken)


@inlined
def receive(params, state, part, i, message, value):
    """Add a message, the sender's label and value, to a robot's inbox."""
    if params.decision.every_message:
        state.counts[Count.VOTES, i] += 1
        state.counts[Count.FEASIBLE_VOTES, i] += says_feasible(message)
        return
    place = keep_label(params, state, part, i, message)
    if place >= 0 and params.strategy.value_scale > 0.0:
        state.inbox[Slot.VALUE, place] = value
    if place >= 0 and params.decision.inbox_size > 0:
        state.inbox[Slot.WHEN, place] = state.robots[Robot.MESSAGES, i]
        state.robots[Robot.MESSAGES, i] += int32(1)


@inlined
def keep_label(params, state, part, i, message):
    """Keep a sender's label in a robot's inbox; return its slot, or -1 if there is no room for it."""
    senders = state.inbox[Slot.SENDER]
    first, slots = slots_of(state, i)
    place = find(senders, first, slots, sender_of(message))
    known = senders[place]
    if known < 0:
        if 4 * state.counts[Count.VOTES, i] >= 3 * slots:  # nearly full
            if not take_table(params, state, part, i):
                return int64(-1)
            first, slots = slots_of(state, i)
            place = find(senders, first, slots, sender_of(message))
        state.counts[Count.VOTES, i] += 1
        state.counts[Count.FEASIBLE_VOTES, i] += says_feasible(message)
        senders[place] = message
    elif known != message:  # most say the same again
        state.counts[Count.FEASIBLE_VOTES, i] += says_feasible(message) - says_feasible(known)
        senders[place] = message
    return int64(place)


@inlined
def slots_of(state, i):
    """Return the first slot of a robot's inbox and the number of its slots."""
    table = int64(state.robots[Robot.TABLE, i])
    slots, behind = state.clock[Clock.TABLE_SLOTS], LINE * state.robots.shape[1]
    in_line = -int64(table == 0)  # a mask: to mispredict a branch takes longer
    first = (LINE * i & in_line) | (behind + (table - 1) * slots & ~in_line)
    return first, (LINE & in_line) | (slots & ~in_line)


@inlined
def find(senders, first, slots, sender):
    """Return the slot of a sender, or the free one that it would take.

    A sender is looked for in eight slots at once: in those that its hash chooses, and then in the next eight.
    """
    hashed = int64(uint32(uint32(sender) * uint32(0x9E3779B1)) >> uint32(8))  # Knuth's multiplicative hash
    place = hashed & (slots - LINE)
    found = same_or_free(senders, first + place, sender)
    while found == 0:  # all are taken by others
        place = (place + LINE) & (slots - 1)
        found = same_or_free(senders, first + place, sender)
    return uint64(first + place + (lowest(found) & (LINE - 1)))


@called
def take_table(params, state, part, i):
    """Move an inbox from its line to a table; return whether there was one.

    If not, or if the inbox has a table already, the runner plays this run again with more room.
    """
    free = state.free_tables[part.thread]
    if state.robots[Robot.TABLE, i] > 0 or free[0] == 0:
        state.clock[Clock.FULL] = Lack.SLOTS if state.robots[Robot.TABLE, i] > 0 else Lack.TABLES
        return False
    state.robots[Robot.TABLE, i] = free[free[0]]
    free[0] -= int32(1)
    inbox, (first, slots) = state.inbox, slots_of(state, i)
    for old in range(LINE * i, LINE * i + LINE):
        message = inbox[Slot.SENDER, old]
        if message >= 0:
            new = find(inbox[Slot.SENDER], first, slots, sender_of(message))
            inbox[Slot.SENDER, new] = message
            if params.strategy.value_scale > 0.0:
                inbox[Slot.VALUE, new] = inbox[Slot.VALUE, old]
            if params.decision.inbox_size > 0:
                inbox[Slot.WHEN, new] = inbox[Slot.WHEN, old]
            inbox[Slot.SENDER, old] = int32(-1)
    return True


@inlined
def empty(params, state, thread, i):
    """Empty a robot's inbox (model.md 4.6); its table is free again for a thread."""
    table = state.robots[Robot.TABLE, i]
    if state.counts[Count.VOTES, i] > 0 or params.decision.inbox_is_set:
        clear_inbox(params, state, i)
    if table > 0:
        free = state.free_tables[thread]
        free[0] += int32(1)
        free[free[0]] = table


@inlined
def clear_inbox(params, state, i):
    """Clear a robot's inbox, which then has no table."""
    if params.decision.inbox_is_set:
        for other in range(state.links.shape[1]):
            state.links[Link.HEARD, other, i] = uint32(0)
            state.links[Link.HEARD_FEASIBLE, other, i] = uint32(0)
    elif not params.decision.every_message:
        first, slots = slots_of(state, i)
        for place in range(first, first + slots):
            state.inbox[Slot.SENDER, place] = int32(-1)
        state.robots[Robot.TABLE, i] = int32(0)
        state.robots[Robot.MESSAGES, i] = int32(0)
    state.counts[Count.VOTES, i] = 0
    state.counts[Count.FEASIBLE_VOTES, i] = 0


@called
def free_all_tables(state):
    """Give each thread its share of the tables, none of which is in use."""
    threads = state.free_tables.shape[0]
    for thread in range(threads):
        free = state.free_tables[thread]
        free[0] = 0
        for table in range(thread + 1, free.size, threads):
            free[0] += int32(1)
            free[free[0]] = int32(table)


@inlined
def read(params, state, i, word):
    """Return what `decide` needs of an inbox.

    These are the votes for *feasible*, all votes, the opinion and value of a message drawn at random, and the
    sum of all values. The messages for *feasible* come first in the draw, each group by its senders.
    """
    if params.decision.inbox_is_set and not params.decision.every_message:
        return read_together(params, state, i, word)
    if params.decision.inbox_size > 0 or params.strategy.value_scale > 0.0:
        return read_slots(params, state, i, word)
    votes, feasible_votes = state.counts[Count.VOTES, i], state.counts[Count.FEASIBLE_VOTES, i]
    opinion, _ = draw_message(word, feasible_votes, votes)
    return feasible_votes, votes, opinion, int64(0), int64(0)


@inlined
def read_together(params, state, i, word):
    """Read an inbox that is a set."""
    votes = feasible_votes = int64(0)
    for other in range(state.links.shape[1]):
        votes += popcount(state.links[Link.HEARD, other, i])
        feasible_votes += popcount(state.links[Link.HEARD_FEASIBLE, other, i])
    opinion, drawn = draw_message(word, feasible_votes, votes)
    value = total = int64(0)
    if params.strategy.value_scale > 0.0:
        for other in range(state.links.shape[1]):
            heard = state.links[Link.HEARD, other, i]
            while heard:
                j = lowest_member(other, heard)
                held = int64(state.inbox[Slot.VALUE, state.links.shape[2] * i + j])
                total += held
                if has_bit(state.links[Link.HEARD_FEASIBLE, other, i], j) == (opinion == 1):
                    value = held if drawn == 0 else value
                    drawn -= 1
                heard = without_lowest(heard)
    return feasible_votes, votes, opinion, value, total


@called
def read_slots(params, state, i, word):
    """Read an inbox whose running counts do not suffice: it keeps the newest only, or has values."""
    votes, feasible_votes = state.counts[Count.VOTES, i], state.counts[Count.FEASIBLE_VOTES, i]
    first, slots = slots_of(state, i)
    kept = first, slots, int64(0)
    if 0 < params.decision.inbox_size < votes:
        kept = first, slots, oldest_kept(params, state, i, first, slots)
        votes = params.decision.inbox_size
        feasible_votes = count(params, state, kept, int64(1), params.robots.count)
    opinion, drawn = draw_message(word, feasible_votes, votes)
    value = total = int64(0)
    if params.strategy.value_scale > 0.0 and votes > 0:
        # Find the least sender up to which more than `drawn` messages have this opinion.
        low, high = int64(0), params.robots.count - 1
        while low < high:
            middle = (low + high) // 2
            if count(params, state, kept, opinion, middle + 1) > drawn:
                high = middle
            else:
                low = middle + 1
        for place in range(first, first + slots):
            if keeps(params, state, kept, place):
                total += state.inbox[Slot.VALUE, place]
                if sender_of(state.inbox[Slot.SENDER, place]) == low:
                    value = int64(state.inbox[Slot.VALUE, place])
    return feasible_votes, votes, opinion, value, total


@inlined
def draw_message(word, feasible_votes, votes):
    """Return the opinion of a message drawn at random, and its place among those of this opinion."""
    if votes == 0:
        return int64(NO_OPINION), int64(0)
    drawn = choose(word, votes)
    if drawn < feasible_votes:
        return int64(1), drawn
    return int64(0), drawn - feasible_votes


@called
def oldest_kept(params, state, i, first, slots):
    """Return the number of the oldest message that an inbox of limited size keeps."""
    low, high = int64(0), int64(state.robots[Robot.MESSAGES, i])
    while high - low > 1:
        middle = (low + high) // 2
        since = 0
        for place in range(first, first + slots):
            if state.inbox[Slot.SENDER, place] >= 0 and state.inbox[Slot.WHEN, place] >= middle:
                since += 1
        if since >= params.decision.inbox_size:
            low = middle
        else:
            high = middle
    return low


@called
def count(params, state, kept, opinion, senders):
    """Return the number of kept messages with this opinion and a sender below ``senders``."""
    number = int64(0)
    first, slots, _ = kept
    for place in range(first, first + slots):
        message = state.inbox[Slot.SENDER, place]
        counts = keeps(params, state, kept, place)
        if counts and says_feasible(message) == opinion and sender_of(message) < senders:
            number += 1
    return number


@inlined
def keeps(params, state, kept, place):
    """Return whether a slot holds a message that counts."""
    if state.inbox[Slot.SENDER, place] < 0:
        return False
    _, _, oldest = kept
    return params.decision.inbox_size == 0 or state.inbox[Slot.WHEN, place] >= oldest


@inlined
def as_share(params, value):
    """Return a message's integer value, or a sum of such values, as a share of the largest value."""
    return float64(value) / params.strategy.value_scale if params.strategy.value_scale > 0.0 else 0.0
