"""Fading: counts of what was seen lately, for worlds that change.

Each robot counts the robots and the tasks in sight. In each step both counts lose 1 / ``tau`` of their
weight. It broadcasts them with its id, and keeps the latest counts of each neighbour, which fade, too. A
robot sees the n - 1 others as often as each task, so that the number of tasks is about (n - 1) times that
of all tasks seen per robot seen. It holds *feasible* as long as this is at most n + 1/2, halfway to the
first that isn't.
"""

import math

NEEDS_COUNT = True
NEEDS_IDS = True
ONE_CLASS = True
MEMORY = 2
PARAMETERS = {"tau": 150.0}
COUNT_BITS = 10
UNIT = 8.0
"""Counts of a message are in 1/8."""
ENTRY = 3
"""Words for each robot: both of its counts, and the step when they came."""


def words(setting):
    """Return the length of what is known: an entry for each robot."""
    return ENTRY * setting.robots


def message_words(setting):
    """Return the length of a message: both counts."""
    return 2


def observe(known, thing, me):
    """Count a robot or task in sight."""
    me.memory[0 if thing.is_robot else 1] += 1.0


def encode(message, known, me):
    """Write the robot's own counts."""
    for k in range(2):
        message[k] = min(int(me.memory[k] * UNIT), 2**COUNT_BITS - 1)


def merge(known, message, sender, me):
    """Keep the latest counts of each neighbour."""
    known[ENTRY * sender] = message[0]
    known[ENTRY * sender + 1] = message[1]
    known[ENTRY * sender + 2] = me.step


def total(known, me, which):
    """Return what all robots have seen lately: 0 of robots, 1 of tasks."""
    seen = me.memory[which]
    for entry in range(0, len(known), ENTRY):
        age = me.step - known[entry + 2]
        seen += known[entry + which] / UNIT * math.exp(-age / me.setting.parameters[0])
    return seen


def judge(known, me):
    """Return the opinion that the counts support, and let the robot's own fade."""
    robots, tasks = total(known, me, 0), total(known, me, 1)
    for k in range(2):
        me.memory[k] *= math.exp(-1.0 / me.setting.parameters[0])
    if robots == 0.0:
        return -1
    return 1 if (me.setting.robots - 1) * tasks <= (me.setting.robots + 0.5) * robots else 0


def count(known, counts, me):
    """Write both sides of the comparison, as whole numbers."""
    counts[0] = int((me.setting.robots + 0.5) * total(known, me, 0))
    counts[1] = int((me.setting.robots - 1) * total(known, me, 1))


def bits(message, me):
    """Return the length of the id and both counts."""
    return me.setting.id_bits + 2 * COUNT_BITS


def decide(mind, inbox):
    """Return the opinion that the robot has: ``judge`` changes it."""
    return mind.opinion
