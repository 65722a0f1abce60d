"""Census: the swarm counts itself and its tasks, by name.

Each robot keeps the set of the robots and the set of the tasks that it knows of, itself included; it adds
what it sees when it explores, broadcasts both sets for g steps on average, and takes in every set that it
hears. At the end of each dissemination it decides on their sizes: feasible if robots >= tasks, for every
set of skills. Nothing is counted twice, so that the answer is exact once the sets are complete.

A Byzantine robot adds as many robots as there are tasks, or one task more than there are robots.

Message: for each robot known 1 bit and its id, for each task 1 bit and its position in 32 bits, with classes
also theirs, and 1 bit at the end of either list. Memory: the same.

References
----------
Our own; sets that only grow merge in any order (Shapiro et al., "Conflict-free replicated data types", 2011).
"""

BY_NAME = True
NEEDS_IDS = True
NEEDS_NAMES = True
SENDS_POSITIONS = True
POSITION_BITS = 32
SHIFT, LAST = 5, 31
"""Member k of a set is bit ``k & LAST`` of word ``k >> SHIFT``."""
WORD = 2**32 - 1
"""The bits of a word, without its sign."""


def decide(mind, inbox):
    """Return feasible if there are as many robots as tasks, or more."""
    return 1 if mind.feasible_quality >= 0.5 else 0


def words_of(ids):
    """Return the number of words of a set of some of so many ids."""
    return (ids + LAST) >> SHIFT


def words(setting):
    """Return the size of all sets: one of ids for each class of robots, and then of tasks."""
    robots = setting.robot_classes * words_of(setting.robot_ids)
    return robots + setting.task_classes * words_of(setting.task_ids)


def start(known, me):
    """Add the robot itself to what it knows."""
    first = me.kind * words_of(me.setting.robot_ids)
    known[first + (me.id >> SHIFT)] |= 1 << (me.id & LAST)


def observe(known, thing, me):
    """Add a robot or task in sight to what the robot knows."""
    robot_words = words_of(me.setting.robot_ids)
    if thing.is_robot:
        first = thing.kind * robot_words
    else:
        first = me.setting.robot_classes * robot_words
        first += thing.kind * words_of(me.setting.task_ids)
    known[first + (thing.id >> SHIFT)] |= 1 << (thing.id & LAST)


def merge(known, message, sender, me):
    """Unite the sets."""
    for k in range(len(known)):
        known[k] |= message[k]


def members(row, first, number):
    """Return the number of members in so many words of a row."""
    found, start = 0, max(first, 0)  # max: the compiler vectorizes
    for k in range(number):
        found += (row[start + k] & WORD).bit_count()
    return found


def count(known, counts, me):
    """Count the members of each set."""
    first = 0
    for k in range(len(counts)):
        number = words_of(me.setting.robot_ids if k < me.setting.robot_classes else me.setting.task_ids)
        counts[k] = members(known, first, number)
        first += number


def describe(known, me):
    """Return the sizes of the sets in words."""
    robot_words = me.setting.robot_classes * words_of(me.setting.robot_ids)
    robots = members(known, 0, robot_words)
    return f"{robots} robots and {members(known, robot_words, len(known) - robot_words)} tasks, by name"


def bits(message, me):
    """Return the length of all sets."""
    robot_words = me.setting.robot_classes * words_of(me.setting.robot_ids)
    robots = members(message, 0, robot_words)
    tasks = members(message, robot_words, len(message) - robot_words)
    robot_bits = 1 + me.setting.id_bits + (me.setting.robot_classes - 1).bit_length()
    task_bits = 1 + POSITION_BITS + (me.setting.task_classes - 1).bit_length()
    return robots * robot_bits + 1 + tasks * task_bits + 1


def layout(wire, message, sender, setting):
    """Go through the names of all robots, and then of all tasks."""
    first = setting.robot_classes * words_of(setting.robot_ids)
    list_names(wire, message, 0, first, LAST + 1, setting.robot_classes, True, setting)
    list_names(wire, message, first, len(message), LAST + 1, setting.task_classes, False, setting)
    return -1


def list_names(wire, message, first, end, in_word, classes, is_robot, setting):
    """Go through the names in these words of a message, a set for each class, in rising order."""
    ids, last = (end - first) // classes * in_word, -1
    place = next_member(message, first, end, in_word, 0)
    while wire.flag(place < classes * ids):
        kind = place // ids if classes > 1 else 0
        name = place - kind * ids
        if is_robot:
            name = wire.number(name, setting.id_bits, setting.robot_ids)
        else:
            name = wire.task(wire.number(name, POSITION_BITS), name, setting.task_ids)
        if classes > 1:
            kind = wire.number(kind, (classes - 1).bit_length(), classes)
        place = kind * ids + name
        wire.check(place > last, "lists names out of order")
        if place > last:
            message[first + place // in_word] |= 1 << (place % in_word)
            last = place
        place = next_member(message, first, end, in_word, last + 1)


def next_member(row, first, end, in_word, member):
    """Return the first member from this one on of the sets in these words; after the last, their size."""
    while first + member // in_word < end and row[first + member // in_word] >> (member % in_word) & 1 == 0:
        member += 1
    return member
