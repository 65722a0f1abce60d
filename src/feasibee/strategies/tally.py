"""Tally: totals of each robot's sightings over its life, which all robots pass on.

Each robot keeps a table of every robot's totals, n_j sightings of robots and m_j of tasks, by id. It adds to
its own row when it explores, broadcasts the table for g steps on average, and keeps the newest of each row
that it hears: as totals only grow, that is the larger. At the end of each dissemination it decides on the
sums: feasible if sum n_j > sum m_j, infeasible if less, for the scarcest set of skills; a tie keeps the
opinion. No sighting is counted twice. A robot never takes its own row from others. It stops counting once a
total fills its word: 2**31 - 1 sightings.

A Byzantine robot calls all that it saw robots, or tasks. A colluding one forges the rows of all robots, with
a million sightings of robots, or of tasks, each: others keep the larger of each total, and pass it on.

Message: for each row that isn't zero 1 bit, the id and the totals at the width of the largest, 5 bits for
this width and 1 bit at the end. Memory: the same.

References
----------
Our own; a table whose rows only grow is the grow-only counter of Shapiro et al., "Conflict-free replicated
data types", 2011.
"""

FORGED = 2**20 - 1
"""Total in a forged row; an honest robot with 20 things in sight reaches it after 50,000 steps."""
FULL = 2**31 - 1
"""Largest number of a word."""
WIDTH_BITS = 5
"""Bits for the width of a total."""


def decide(mind, inbox):
    """Return what the sums say; a tie keeps the opinion."""
    if mind.feasible_quality == 0.5:
        return mind.opinion
    return 1 if mind.feasible_quality > 0.5 else 0


def words(setting):
    """Return the size of the table: a row for each robot, a total for each class."""
    return setting.robots * (setting.robot_classes + setting.task_classes)


def observe(known, thing, me):
    """Count a robot or task in sight in the robot's own row."""
    column = thing.kind if thing.is_robot else me.setting.robot_classes + thing.kind
    classes = me.setting.robot_classes + me.setting.task_classes
    first = me.id * classes
    for k in range(first, first + classes):
        if known[k] == FULL:  # to go on with the other totals would change their ratio
            return
    known[first + column] += 1


def lie(message, feasible, me):
    """Call all that was seen robots, or tasks, of the first class; a colluding robot forges all rows."""
    classes = me.setting.robot_classes + me.setting.task_classes
    if me.setting.colluding:
        for k in range(len(message)):
            is_robots = k % classes < me.setting.robot_classes
            message[k] = FORGED if is_robots == (feasible == 1) else 0
        return
    first = me.id * classes
    total = 0
    for k in range(first, first + classes):
        total += message[k]
        message[k] = 0
    message[first if feasible == 1 else first + me.setting.robot_classes] = min(total, FULL)


def merge(known, message, sender, me):
    """Keep the larger of each total, except in the robot's own row."""
    classes = me.setting.robot_classes + me.setting.task_classes
    for k in range(me.id * classes):
        known[k] = max(known[k], message[k])
    first = max((me.id + 1) * classes, 0)  # max: the compiler vectorizes
    for k in range(len(known) - first):
        known[first + k] = max(known[first + k], message[first + k])


def count(known, counts, me):
    """Add each column of the table to its total."""
    classes = len(counts)
    if classes == 2:  # the compiler vectorizes steps of a length that it knows
        robots, tasks = 0, 0
        for row in range(len(known) // 2):
            robots += known[2 * row]
            tasks += known[2 * row + 1]
        counts[0] += robots
        counts[1] += tasks
        return
    for first in range(0, len(known), classes):
        for k in range(classes):
            counts[k] += known[first + k]


def rows_of(table, classes):
    """Return the number of rows that aren't zero, and the largest total."""
    rows, largest = 0, 0
    if classes == 2:  # as in `count`
        for row in range(len(table) // 2):
            total = max(table[2 * row], table[2 * row + 1])
            rows += 1 if total > 0 else 0
            largest = max(largest, total)
        return rows, largest
    for first in range(0, len(table), classes):
        total = 0
        for k in range(first, first + classes):
            total = max(total, table[k])
        rows += 1 if total > 0 else 0
        largest = max(largest, total)
    return rows, largest


def describe(known, me):
    """Return the sums of all rows in words."""
    counts = [0] * (me.setting.robot_classes + me.setting.task_classes)
    count(known, counts, me)
    rows, _ = rows_of(known, len(counts))
    robots = sum(counts[: me.setting.robot_classes])
    return f"totals of {rows} robots: {robots} sightings of robots and {sum(counts) - robots} of tasks"


def bits(message, me):
    """Return the length of a table."""
    classes = me.setting.robot_classes + me.setting.task_classes
    rows, largest = rows_of(message, classes)
    return WIDTH_BITS + rows * (1 + me.setting.id_bits + classes * largest.bit_length()) + 1


def layout(wire, message, sender, setting):
    """Go through the rows that aren't zero, in rising order, all totals at the width of the largest."""
    classes, last = setting.robot_classes + setting.task_classes, -1
    width = wire.number(rows_of(message, classes)[1].bit_length(), WIDTH_BITS)
    robot = next_row(message, 0, classes)
    while wire.flag(robot < setting.robots):
        robot = wire.number(robot, setting.id_bits, setting.robots)
        for place in range(robot * classes, (robot + 1) * classes):
            message[place] = wire.number(message[place], width)
        rises = robot > last and next_row(message, robot, classes) == robot
        wire.check(rises, "lists rows out of order, or without sightings")
        last = robot
        robot = next_row(message, last + 1, classes)
    wire.check(rows_of(message, classes)[1].bit_length() == width, "has totals of another width")
    return -1


def next_row(table, row, classes):
    """Return the first row from this one on that isn't zero; after the last, the number of rows."""
    k = row * classes
    while k < len(table) and table[k] == 0:
        k += 1
    return k // classes
