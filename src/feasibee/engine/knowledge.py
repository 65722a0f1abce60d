"""What robots know and pass on in strategies whose messages hold more than opinions.

A robot's knowledge is a row of 32-bit words: for a tally, the totals of each robot by class of robots and of
tasks; for a census, sets of robots, of tasks and of what liars invented, one bit each; for a sketch, the
registers of each class. It only grows: what two robots know together is the larger of each word, or the
union. Things are numbered: robots, tasks, invented robots (as many as tasks), invented tasks (one more than
robots).
"""

from __future__ import annotations

import math

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.bits import bit, contains, lowest_member, without_lowest
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import coin, draw_now, philox
from feasibee.engine.intrinsics import lowest, popcount
from feasibee.engine.layout import REGISTERS, Clock, Copy, Robot, Set
from feasibee.engine.params import Knowledge, Lie
from feasibee.model.purposes import IDENTITY, LIE

POSITION_BITS = 32
TOP = 15  # rank in a sketch
SCALE = 65536.0  # of the estimates of sketches


@inlined
def sent_opinion(params, state, i):
    """Return the opinion in a robot's message, true or a lie (model.md 6.6)."""
    said = int64(contains(state.sets[Set.SAYS_FEASIBLE], i))
    if not contains(state.sets[Set.BYZANTINE], i):
        return said
    if params.faults.byzantine_says == Lie.OPPOSITE:
        return 1 - said
    if params.faults.byzantine_says == Lie.RANDOM:
        return coin(draw_now(params, state, i, LIE))
    return int64(params.faults.byzantine_says == Lie.FEASIBLE)


@called
def assign_identities(params, state):
    """Give robots their ids, things their hashes, and each robot the knowledge of itself."""
    for i in range(params.robots.count):
        state.robots[Robot.IDENTITY, i] = int32(i)
    if params.radio.random_ids:
        find_equal_ids(params, state)
    for thing in range(state.hashes.size):
        holder = int64(state.robots[Robot.IDENTITY, thing]) if thing < params.robots.count else int64(thing)
        words = philox(
            int64(0), holder, state.clock[Clock.RUN], int64(IDENTITY), params.seed.low, params.seed.high
        )
        state.hashes[thing] = words[1]
    if params.strategy.knowledge:
        state.knowledge[:] = uint32(0)
        if params.strategy.knowledge != Knowledge.TALLY:
            for i in range(params.robots.count):
                me = int64(state.robots[Robot.IDENTITY, i])
                learn(params, state, int64(Copy.KNOWN), i, me, int64(state.tables.class_of[i]))


@called
def find_equal_ids(params, state):
    """Find for each robot the first that has the same id, by a hash table in the room of the counts."""
    ids, table = state.robots[Robot.ORDER], state.counts
    size = 4 * table.shape[1]
    table[:] = 0
    for i in range(params.robots.count):
        words = philox(
            int64(0), i, state.clock[Clock.RUN], int64(IDENTITY), params.seed.low, params.seed.high
        )
        ids[i] = int32(words[0] >> uint32(32 - params.radio.id_bits))
        place = int64(uint32(uint32(ids[i]) * uint32(0x9E3779B1))) % size
        holder = table[place & 3, place >> 2]
        while holder > 0 and ids[holder - 1] != ids[i]:
            place = (place + 1) % size
            holder = table[place & 3, place >> 2]
        if holder == 0:
            table[place & 3, place >> 2] = i + 1
        else:
            state.robots[Robot.IDENTITY, i] = int32(holder - 1)


@called
def learn(params, state, row, i, thing, column):
    """Add a thing to what a robot knows, or tells; ``column`` is its class, robots' first."""
    words = state.knowledge[row, i]
    if params.strategy.knowledge == Knowledge.TALLY:
        words[state.robots[Robot.IDENTITY, i] * state.tables.adds.shape[1] + column] += uint32(1)
    elif params.strategy.knowledge == Knowledge.CENSUS:
        first, number = side_of(params, thing)
        words[first + (number >> 5)] |= bit(number)
    else:
        mark = state.hashes[thing]
        rest = uint32(mark >> uint32(7))
        rank = uint32(TOP)
        if rest:
            rank = uint32(min(TOP, lowest(rest) + 1))
        register = column * REGISTERS + int64(mark & uint32(REGISTERS - 1))
        words[register] = max(words[register], rank)


@inlined
def side_of(params, thing):
    """Return the first word of a thing's side of a census, and its number there."""
    number = int64(thing)
    first = int64(0)
    if number < params.robots.count:
        return first, number
    number -= params.robots.count
    first += (params.robots.count + 31) >> 5
    if number < params.tasks.count:
        return first, number
    number -= params.tasks.count
    first += (params.tasks.count + 31) >> 5
    if number < params.tasks.count:
        return first, number
    return first + ((params.tasks.count + 31) >> 5), number - params.tasks.count


@spliced
def publish(params, state):
    """Fix what each robot tells in this step, and count its bits."""
    for w in range(state.sets.shape[1]):
        speaking = state.sets[Set.SPEAKING, w]
        state.clock[Clock.BITS] += popcount(speaking) * params.radio.message_bits
        if params.strategy.knowledge:
            while speaking:
                i = lowest_member(w, speaking)
                for k in range(state.knowledge.shape[2]):
                    state.knowledge[Copy.SENT, i, k] = state.knowledge[Copy.KNOWN, i, k]
                if contains(state.sets[Set.BYZANTINE], i):
                    lie(params, state, i)
                state.clock[Clock.BITS] += length(params, state, i)
                speaking = without_lowest(speaking)


@called
def lie(params, state, i):
    """Let a liar tell of robots, or tasks, that there aren't; or, in a tally, call one what is the other."""
    feasible = sent_opinion(params, state, i)
    column = int64(0) if feasible else params.robots.classes
    if params.strategy.knowledge == Knowledge.TALLY:
        classes = state.tables.adds.shape[1]
        first = int64(state.robots[Robot.IDENTITY, i]) * classes
        own = uint32(0)
        for k in range(classes):
            own += state.knowledge[Copy.SENT, i, first + k]
            state.knowledge[Copy.SENT, i, first + k] = uint32(0)
        state.knowledge[Copy.SENT, i, first + column] = own
        return
    thing = params.robots.count + params.tasks.count
    number = params.tasks.count
    if not feasible:
        thing += params.tasks.count
        number = params.robots.count + 1
    for k in range(number):
        learn(params, state, int64(Copy.SENT), i, int64(thing + k), column)


@called
def merge(params, state, i, sender):
    """Let a robot take in what it hears."""
    if params.strategy.knowledge == Knowledge.CENSUS:
        for k in range(state.knowledge.shape[2]):
            state.knowledge[Copy.KNOWN, i, k] |= state.knowledge[Copy.SENT, sender, k]
    else:
        own, end = int64(0), int64(0)
        if params.strategy.knowledge == Knowledge.TALLY:  # nobody knows its own row better
            own = int64(state.robots[Robot.IDENTITY, i]) * state.tables.adds.shape[1]
            end = own + state.tables.adds.shape[1]
        for k in range(state.knowledge.shape[2]):
            heard = state.knowledge[Copy.SENT, sender, k]
            if not own <= k < end:
                state.knowledge[Copy.KNOWN, i, k] = max(heard, state.knowledge[Copy.KNOWN, i, k])


@called
def count_known(params, state, row, i):
    """Count what a robot knows, or tells, by class: sightings, things, or their estimates times 2**16."""
    classes = state.tables.adds.shape[1]
    words = state.knowledge[row, i]
    state.seen[i] = 0
    if params.strategy.knowledge == Knowledge.TALLY:
        for k in range(words.size):
            state.seen[i, k % classes] += int64(words[k])
        if params.strategy.estimates:
            known, _ = rows_of(words, classes)
            for k in range(classes):
                state.seen[i, k] *= 2 * known + 1 if k < params.robots.classes else 2 * known - 2
    elif params.strategy.knowledge == Knowledge.SKETCH:
        for column in range(classes):
            state.seen[i, column] = int64(estimate(words, column * REGISTERS) * SCALE)
    else:
        count_census(params, state, row, i)


@called
def count_census(params, state, row, i):
    """Count the bits of a census, by side and class; what liars invented is of the first class."""
    words = state.knowledge[row, i]
    tasks = (params.robots.count + 31) >> 5
    inventions = tasks + ((params.tasks.count + 31) >> 5)
    invented_tasks = inventions + ((params.tasks.count + 31) >> 5)
    for k in range(words.size):
        left = words[k]
        is_task = k >= invented_tasks or tasks <= k < inventions
        if k >= inventions or not params.sensing.by_class:
            state.seen[i, params.robots.classes if is_task else 0] += popcount(left)
            continue
        while left:
            number = 32 * k + lowest(left)
            if is_task:
                kind = int64(state.tables.class_of[params.robots.count + number - 32 * tasks])
                state.seen[i, params.robots.classes + kind] += 1
            else:
                state.seen[i, state.tables.class_of[number]] += 1
            left = without_lowest(left)


@called
def length(params, state, i):
    """Return the length of what a robot tells, in bits."""
    classes = state.tables.adds.shape[1]
    words = state.knowledge[Copy.SENT, i]
    if params.strategy.knowledge == Knowledge.SKETCH:
        return classes * REGISTERS * 4
    if params.strategy.knowledge == Knowledge.TALLY:
        rows, largest = rows_of(words, classes)
        return 5 + rows * (1 + params.radio.id_bits + classes * bit_length(int64(largest))) + 1
    count_known(params, state, int64(Copy.SENT), i)
    robot = 1 + params.radio.id_bits + bit_length(params.robots.classes - 1)
    task = 1 + POSITION_BITS + bit_length(classes - params.robots.classes - 1)
    bits = int64(2)
    for kind in range(classes):
        bits += state.seen[i, kind] * (robot if kind < params.robots.classes else task)
    return bits


@called
def rows_of(words, classes):
    """Return how many rows of a tally aren't zero, and the largest number in it."""
    rows, largest = int64(0), uint32(0)
    for first in range(0, words.size, classes):
        row = uint32(0)
        for k in range(classes):
            row = max(row, words[first + k])
        rows += row > 0
        largest = max(largest, row)
    return rows, largest


@inlined
def bit_length(number):
    """Return how many binary digits a number has; none for 0."""
    digits = int64(0)
    while number > 0:
        digits += 1
        number >>= 1
    return digits


@called
def estimate(words, first):
    """Return the estimated size of a sketch (Ertl 2017, algorithm 6)."""
    # How many registers have each rank, in bytes: none has more than 128.
    low, high = uint64(0), uint64(0)
    for k in range(REGISTERS):
        rank = uint64(words[first + k])
        one = uint64(uint64(1) << uint64(uint64(8) * (rank & uint64(7))))
        if rank < uint64(8):
            low += one
        else:
            high += one
    unused = int64(low & uint64(255))
    if unused == REGISTERS:
        return 0.0
    if int64(high >> uint64(56)) == REGISTERS:  # it can't tell more things from this
        return float64(REGISTERS * 2**TOP)
    z = REGISTERS * tau(1.0 - float64(high >> uint64(56)) / REGISTERS)
    for rank in range(TOP - 1, 0, -1):
        byte = (high if rank >= 8 else low) >> uint64(8 * (rank & 7))
        z = 0.5 * (z + float64(byte & uint64(255)))
    z += REGISTERS * sigma(float64(unused) / REGISTERS)
    return 0.7213475204444817 * REGISTERS * REGISTERS / z


@inlined
def sigma(x):
    """Return x + the sum of 2**(k - 1) x**(2**k) over k >= 1."""
    power, weight, total, last = x, 1.0, x, -1.0
    while total != last:
        last = total
        power = power * power
        total += power * weight
        weight += weight
    return total


@inlined
def tau(x):
    """Return (1 - x - the sum of 2**-k (1 - x**(2**-k))**2 over k >= 1) / 3."""
    if x in (0.0, 1.0):
        return 0.0
    root, weight, total, last = x, 1.0, 1.0 - x, -1.0
    while total != last:
        last = total
        root = math.sqrt(root)
        weight *= 0.5
        total -= (1.0 - root) * (1.0 - root) * weight
    return total / 3.0
