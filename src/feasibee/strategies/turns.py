"""Turns: a census in a few bits, a few names of tasks in turn and an alarm.

Each robot keeps the names of the tasks that it knows, sorted, and knows n, the number of robots. It adds
what it sees when it explores. For g steps on average it broadcasts the next ``names`` of its names in turn,
and takes in all names that it hears. A name is the first ``name_bits`` bits of a task's hash: two tasks with
equal names are one. A robot that knows more than n names, or hears the alarm, raises the alarm and declares
infeasible. Until then its opinion is feasible. It declares feasible after a quiet time without a new name,
as in `quiet_census`; the fewer names a message holds, the longer it is.

``names`` = 0: only the alarm is sent, and each robot counts what it sees by itself. It declares feasible
when some robot would have seen n + 1 tasks. ``names`` = -1: all names are sent, n + 1 at most. ``quiet``
sets the time, in steps; 0: computed. With ``tolerates`` = f, a name or alarm of others counts once f + 1
different neighbours have sent it. Robots broadcast only what counts. With ``looks`` = 2, a name that a robot
sees counts at the second look, if the first was among its last 16 new names. A false sighting has no second.

A Byzantine robot raises the alarm and invents n + 1 names, or denies the alarm. A colluding one invents the
n + 1 - m names that the lie needs; to speak for feasible it sends neither alarm nor names.

Message: the id, 1 bit for the alarm, and each name in ``name_bits`` bits, 0 where there is none. All names
are sent as their number, in as many bits as n + 1 has, and the gaps between them in Rice's code. Memory: the
names, the end of the quiet time, and for each name or alarm that does not count yet the neighbours that sent
it, at most f.

References
----------
Our own. The gaps: Rice and Plaunt, "Adaptive variable-length coding for efficient compression of spacecraft
television data", 1971. Names by f + 1 neighbours: see `quiet_census`.
"""

import math

from feasibee.strategies.census import decide
from feasibee.strategies.certified import (
    invented,
    steps_for,
    steps_given,
    tasks_to_invent,
    told_enough,
    tolerated,
)
from feasibee.strategies.clock import has_come
from feasibee.strategies.quiet_census import patience

NEEDS_COUNT = True
NEEDS_IDS = "tolerates"
NEEDS_NAMES = True
ONE_CLASS = True
PARAMETERS = {"names": 1.0, "name_bits": 20.0, "quiet": 0.0, "tolerates": 0.0, "looks": 1.0}
NAMES, NAME_BITS, QUIET, TOLERATES, LOOKS = 0, 1, 2, 3, 4
GLIMPSES = 16
"""Number of names seen once that a robot keeps for a second look."""
HASH_BITS = 32
LARGEST = 2**31 - 1
"""Largest name: in C, a word with a sign is enough, which takes less flash."""
ALARM, KNOWN, UNTIL, TURN, PENDING, TOLD = 0, 1, 2, 3, 4, 5
"""Words of what is known: alarm, number of names, end of the quiet time, the next name's turn, waiting names.

Then come the senders of the alarm, at most f; the sorted names; each name that waits, with its senders; and
the names seen once, after their number.
"""


def name_bits(setting):
    """Return the length of a name, in bits."""
    return int(min(max(setting.parameters[NAME_BITS], 1.0), 31.0))


def looks_twice(setting):
    """Return whether a name that a robot sees counts at the second look only."""
    return setting.parameters[LOOKS] >= 2


def sends_all(setting):
    """Return whether a message holds all names."""
    return setting.parameters[NAMES] < 0


def places(setting):
    """Return the number of places for names in a message."""
    most = setting.robots + 1
    return most if sends_all(setting) else int(min(setting.parameters[NAMES], float(most)))


def message_words(setting):
    """Return the size of a message: the alarm, and its places for names; a name is at least 1."""
    return 1 + places(setting)


def words(setting):
    """Return the size of what is known: at most n + 1 names count, and each other waits with its tellers."""
    tolerates = tolerated(setting, TOLERATES)
    waiting = setting.task_ids * (1 + tolerates) if tolerates > 0 else 0
    glimpses = 1 + GLIMPSES if looks_twice(setting) else 0
    return TOLD + tolerates + setting.robots + 1 + waiting + glimpses


def start(known, me):
    """Begin the quiet time."""
    known[UNTIL] = me.step + quiet_steps(me.setting)


def place_of(row, first, last, name):
    """Return the place of the first name that is not below this one, among sorted names."""
    number = last - first
    while number > 0:
        half = (number + 1) // 2
        first += half if row[first + half - 1] < name else 0
        number -= half
    return first


def insert(row, place, last, name):
    """Put a name at its place, and move those up to the last one place on."""
    for k in range(last, place, -1):
        row[k] = row[k - 1]
    row[place] = name


def accept(known, name, me):
    """Add a name to those that count, and raise the alarm if there are more than robots."""
    first = TOLD + tolerated(me.setting, TOLERATES)
    last = first + known[KNOWN]
    place = place_of(known, first, last, name)
    if known[KNOWN] > me.setting.robots or (place < last and known[place] == name):
        return
    insert(known, place, last, name)
    known[KNOWN] += 1
    if place - first < known[TURN]:
        known[TURN] += 1
    if places(me.setting) > 0:
        known[UNTIL] = me.step + quiet_steps(me.setting)
    if known[KNOWN] > me.setting.robots:
        known[ALARM] = 1


def counts_already(known, name, me):
    """Return whether a name is among those that count."""
    first = TOLD + tolerated(me.setting, TOLERATES)
    place = place_of(known, first, first + known[KNOWN], name)
    return place < first + known[KNOWN] and known[place] == name


def was_glimpsed(known, name):
    """Return whether a name is among the last ones that were seen once; if not, keep it there."""
    number = len(known) - 1 - GLIMPSES
    for k in range(number + 1, len(known)):
        if known[k] == name:
            return True
    known[number + 1 + known[number] % GLIMPSES] = name
    known[number] += 1
    return False


def observe(known, thing, me):
    """Add the name of a task in sight, at the second look if there must be one."""
    if thing.is_robot:
        return
    name = max((thing.hash >> (HASH_BITS - name_bits(me.setting))) & LARGEST, 1)
    if looks_twice(me.setting) and not (counts_already(known, name, me) or was_glimpsed(known, name)):
        return
    accept(known, name, me)


def encode(message, known, me):
    """Write the alarm, and the names whose turn it is."""
    message[0] = known[ALARM]
    first, number = TOLD + tolerated(me.setting, TOLERATES), known[KNOWN]
    turn = 0 if sends_all(me.setting) else known[TURN]
    for k in range(1, len(message)):
        message[k] = 0
        if k <= number:
            turn = turn if turn < number else 0
            message[k] = known[first + turn]
            turn += 1
    known[TURN] = turn


def lie(message, feasible, me):
    """Forge the alarm and invent names, or deny both (model.md 6.16)."""
    setting = me.setting
    message[0] = 1 - feasible
    number = tasks_to_invent(setting)
    if feasible == 1:
        for k in range(1, len(message)):
            message[k] = 0 if setting.colluding else message[k]
    elif sends_all(setting):
        used = 1
        while used < len(message) and message[used] != 0:
            used += 1
        for k in range(min(number, len(message) - used)):
            name = invented(k, name_bits(setting))
            insert(message, place_of(message, 1, used + k, name), used + k, name)
    elif number > 0:
        for k in range(1, len(message)):
            message[k] = invented((me.step * places(setting) + k) % number, name_bits(setting))


def consider(known, name, sender, me):
    """Accept a name once enough neighbours have sent it; until then it waits."""
    setting = me.setting
    tolerates = tolerated(setting, TOLERATES)
    if tolerates == 0:
        accept(known, name, me)
        return
    if counts_already(known, name, me):
        return
    entry = TOLD + tolerates + setting.robots + 1
    room = entry + setting.task_ids * (1 + tolerates)
    end = entry + known[PENDING] * (1 + tolerates)
    while entry < end and known[entry] != name:
        entry += 1 + tolerates
    if entry == end and entry < room:
        known[entry] = name
        known[PENDING] += 1
    if entry < room and told_enough(known, entry + 1, tolerates, sender):
        accept(known, name, me)


def merge(known, message, sender, me):
    """Add the alarm and the names of a message to what is known."""
    alarmed = message[0] == 1 and known[ALARM] == 0
    if alarmed and told_enough(known, TOLD, tolerated(me.setting, TOLERATES), sender):
        known[ALARM] = 1
    for k in range(1, len(message)):
        if message[k] != 0:
            consider(known, message[k], sender, me)


def count(known, counts, me):
    """Count the robots, and the names; more than robots after an alarm."""
    counts[0] = me.setting.robots
    counts[1] = me.setting.robots + 1 if known[ALARM] == 1 else known[KNOWN]


def describe(known, me):
    """Return the number of names in words."""
    alarm = "; the alarm was raised" if known[ALARM] else ""
    return f"{known[KNOWN]} tasks, by name; quiet until step {known[UNTIL]}{alarm}"


def bits(message, me):
    """Return the length of the id, the alarm and the names."""
    length = name_bits(me.setting)
    if sends_all(me.setting):
        return me.setting.id_bits + 1 + (len(message) - 1).bit_length() + rice_bits(message, length)
    return me.setting.id_bits + 1 + (len(message) - 1) * length


def rice_bits(message, length):
    """Return the length of sorted names: the gaps between them in Rice's code for their number."""
    number = 0
    while number + 1 < len(message) and message[number + 1] != 0:
        number += 1
    low = low_bits(number, length)
    total, last = 0, 0
    for k in range(1, number + 1):
        total += 1 + low + ((message[k] - last - 1) >> low)
        last = message[k]
    return total


def patience_in_turn(setting):
    """Return how often the swarm would find a task in the quiet time: the longer, the fewer names are sent.

    Fitted as `quiet_census.patience` is, for 20 and 50 robots and messages of 1 name to all.
    """
    tolerates = tolerated(setting, TOLERATES)
    rounds = 0.0 if sends_all(setting) else (1 + tolerates) * setting.robots / places(setting)
    return patience(setting.robots, tolerates) * (1.0 + rounds / 50.0)


def patience_alone(setting):
    """Return how often a robot must find a task by itself until f + 1 robots have seen all of n + 1.

    Of n - f honest robots in f + 1 groups, one in each must have, in all but 1 run of 1,000: a robot has with
    probability ``each``. Then the alarm must reach all robots.
    """
    robots, tolerates = setting.robots, tolerated(setting, TOLERATES)
    flooding = patience(robots, tolerates) / robots
    if flooding == math.inf:
        return flooding
    groups = tolerates + 1.0
    each = 1.0 - (0.001 / groups) ** (groups / (robots - tolerates))
    return flooding - math.log(1.0 - each ** (1.0 / (robots + 1)))


def quiet_steps(setting):
    """Return the quiet time, in steps; the time from the start if no names are sent."""
    if setting.parameters[QUIET] > 0:
        return steps_given(setting.parameters[QUIET])
    if places(setting) == 0:
        return steps_for(patience_alone(setting), 1, setting)
    return steps_for(patience_in_turn(setting), setting.robots, setting)


def declare(known, me):
    """Return infeasible after an alarm, feasible after the quiet time."""
    if known[ALARM] == 1:
        return 0
    return 1 if has_come(known[UNTIL], me.step) else -1


def low_bits(number, length):
    """Return how many low bits of a gap Rice's code writes as they are, for so many names."""
    return max(length - number.bit_length(), 0)  # a lie may hold more names than there are


def layout(wire, message, sender, setting):
    """Go through the id, the alarm and the names; all names as their number and the gaps between them."""
    length, last = name_bits(setting), 0
    sender = wire.number(sender, setting.id_bits, setting.robots)
    message[0] = int(wire.flag(message[0] == 1))
    if not sends_all(setting):
        for k in range(1, len(message)):
            message[k] = wire.number(message[k], length)
        return sender
    number = 0  # of different names: a lie may hold one twice
    for k in range(1, len(message)):
        if message[k] > last:
            last = message[k]
            number += 1
    number = wire.number(number, places(setting).bit_length(), len(message))
    last, at = 0, 1
    for k in range(number):
        while at < len(message) - 1 and message[at] <= last:
            at += 1
        gap = max(message[at] - last - 1, 0)
        last += 1 + wire.rice(gap, low_bits(number, length), 2**length - 1 - last)
        message[1 + k] = last
    return sender
