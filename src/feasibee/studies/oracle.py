"""Oracle: robots that look, broadcast all that they saw and hear in every step, and record when they knew it.

`feasibee.studies.flooding` runs it in swarms with the phases of a scenario. Each robot keeps the
names of the tasks and the set of the parts of the area, the cells, that it knows. A cell is at most as wide
and high as the range of sight divided by ``cells_per_range``. It is seen when its centre is in range. No
robot of any strategy can know more, however many bits its messages have. The oracle never decides anything.

A Byzantine robot's messages are empty, since nobody can rely on them.

Message: a bit for each task and each cell. Memory: the same, with the step at which the robot knew all cells,
that at which it first saw each task and each cell, and that at which it first knew each task. Step 0 means
never.
"""

import math

BY_NAME = True
PARAMETERS = {"cells_per_range": 4.0, "range": 2.0}
MEMBERS = 31
"""Number of a set's members in a word."""
MAP_STEP = 0
FIRST_STEPS = 1
"""Word of the step at which the first task was first seen; the other tasks and the cells follow."""


def decide(mind, inbox):
    """Return any opinion: nobody reads it."""
    return 1


def columns(setting):
    """Return the number of cells side by side."""
    return math.ceil(setting.width * setting.parameters[0] / setting.parameters[1])


def rows(setting):
    """Return the number of cells one above the other."""
    return math.ceil(setting.height * setting.parameters[0] / setting.parameters[1])


def cells(setting):
    """Return the number of cells."""
    return columns(setting) * rows(setting)


def known_start(setting):
    """Return the word of the step at which the robot first knew the first task; the other tasks follow."""
    return FIRST_STEPS + setting.tasks + cells(setting)


def names_start(setting):
    """Return the first word of the set of tasks."""
    return known_start(setting) + setting.tasks


def name_words(setting):
    """Return the number of words of the set of tasks."""
    return (setting.tasks + MEMBERS - 1) // MEMBERS


def message_words(setting):
    """Return the number of words of both sets."""
    return name_words(setting) + (cells(setting) + MEMBERS - 1) // MEMBERS


def words(setting):
    """Return the number of words of the steps and of both sets."""
    return names_start(setting) + message_words(setting)


def observe(known, thing, me):
    """Record the name of a task in sight, and when it was first seen."""
    if not thing.is_robot:
        known[names_start(me.setting) + thing.id // MEMBERS] |= 1 << (thing.id % MEMBERS)
        if known[FIRST_STEPS + thing.id] == 0:
            known[FIRST_STEPS + thing.id] = me.step + 1


def encode(message, known, me):
    """Write both sets."""
    start = names_start(me.setting)
    for k in range(len(message)):
        message[k] = known[start + k]


def lie(message, feasible, me):
    """Empty a Byzantine robot's message."""
    for k in range(len(message)):
        message[k] = 0


def merge(known, message, sender, me):
    """Unite the sets."""
    start = names_start(me.setting)
    for k in range(len(message)):
        known[start + k] |= message[k]


def count(known, counts, me):
    """Count nothing: the oracle doesn't decide."""


def bits(message, me):
    """Return a bit for each task and each cell."""
    return me.setting.tasks + cells(me.setting)


def declare(known, me):
    """Record the cells in sight, and when the robot knows each task and all cells; then declare."""
    setting = me.setting
    look(known, me)
    first, start, names = known_start(setting), names_start(setting), name_words(setting)
    missing = 0
    for task in range(setting.tasks):
        if known[first + task] == 0 and known[start + task // MEMBERS] & (1 << (task % MEMBERS)) != 0:
            known[first + task] = me.step + 1
        missing += known[first + task] == 0
    if known[MAP_STEP] == 0 and members(known, start + names, len(known)) == cells(setting):
        known[MAP_STEP] = me.step + 1
    return 1 if missing == 0 and known[MAP_STEP] != 0 else -1


def members(known, start, stop):
    """Return the number of members of the set in some words."""
    found = 0
    for k in range(start, stop):
        found += known[k].bit_count()
    return found


def look(known, me):
    """Record the cells whose centres are in sight, and when they first were."""
    setting = me.setting
    wide, high = columns(setting), rows(setting)
    width, height = setting.width / wide, setting.height / high
    first_row = math.floor((me.y - setting.parameters[1]) / height)
    last_row = math.floor((me.y + setting.parameters[1]) / height)
    first_column = math.floor((me.x - setting.parameters[1]) / width)
    last_column = math.floor((me.x + setting.parameters[1]) / width)
    for row in range(first_row, last_row + 1):
        way_y = (row + 0.5) * height - me.y
        left = setting.parameters[1] * setting.parameters[1] - way_y * way_y
        if left >= 0.0 and (not setting.walled or 0 <= row < high):
            for column in range(first_column, last_column + 1):
                way_x = (column + 0.5) * width - me.x
                if way_x * way_x <= left and (not setting.walled or 0 <= column < wide):
                    record_cell(known, (row % high) * wide + column % wide, me)


def record_cell(known, cell, me):
    """Record a cell in sight, and when it first was."""
    first = FIRST_STEPS + me.setting.tasks + cell
    if known[first] == 0:
        known[first] = me.step + 1
        start = names_start(me.setting) + name_words(me.setting)
        known[start + cell // MEMBERS] |= 1 << (cell % MEMBERS)
