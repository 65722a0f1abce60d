"""Gossip: robots broadcast all names of tasks that they know, and declare once they know all of their piece.

`feasibee.simulation.flooding` runs it, to find out how soon names flood a place. In place of a plan, robots
are given how many names there are for each of them to know. A Byzantine robot's messages are empty.

Message: a bit for each task. Memory: the same.
"""

BY_NAME = True
READS_PLAN = True
MEMBERS = 31
"""Number of a set's members in a word."""
WANTED_BYTES = 3
"""Bytes of a number of names in the table that robots are given."""


def decide(mind, inbox):
    """Return any opinion: nobody reads it."""
    return 1


def words(setting):
    """Return the number of words of the set of tasks."""
    return setting.tasks // MEMBERS + 1


def observe(known, thing, me):
    """Add the name of a task in sight."""
    if not thing.is_robot:
        known[thing.id // MEMBERS] |= 1 << (thing.id % MEMBERS)


def lie(message, feasible, me):
    """Empty a Byzantine robot's message."""
    for k in range(len(message)):
        message[k] = 0


def merge(known, message, sender, me):
    """Unite the sets."""
    for k in range(len(message)):
        known[k] |= message[k]


def count(known, counts, me):
    """Count nothing: robots don't decide."""


def bits(message, me):
    """Return a bit for each task."""
    return me.setting.tasks


def declare(known, me):
    """Declare once the robot knows as many names as there are for it to know; without a table, all."""
    wanted, found, first = me.setting.tasks, 0, me.id * WANTED_BYTES
    if len(me.setting.plan) > 0:
        wanted = 0
        for k in range(WANTED_BYTES):
            wanted = wanted * 256 + me.setting.plan[first + k]
    for k in range(len(known)):
        found += known[k].bit_count()
    return 1 if found >= wanted else -1
