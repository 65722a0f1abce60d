"""Map: robots that share a frame map the tasks cell by cell, and declare what the map proves.

The arena is divided evenly into cells of at most ``cell`` units a side, and each cell into sub-cells of at
most a quarter of the range of sight. A robot has searched a sub-cell once it explored in a step in which all
of the sub-cell was within range. It knows a cell once it has searched all sub-cells; the cell's value is the
number of tasks that it saw there. Robots broadcast the cells that they know for g steps on average, and
adopt the values of cells that they don't know. At least as many tasks exist as the values of all known
cells and the tasks seen in other cells together. Robots know n. A robot is sure of infeasible once these are
more than n, and sure of feasible once it knows all cells and their values are at most n. Then it declares,
and broadcasts its verdict, which other robots adopt, instead of the map. Without missed sightings and without
Byzantine robots this is a proof: no robot is wrong. In a place with walls, robots know the plan: they leave
out sub-cells in which no task can be, and search only what no wall hides.

With ``tolerates`` = f a robot adopts a value or a verdict only when f + 1 neighbours have sent the same one.
At least one of any f + 1 is honest, so that up to f Byzantine robots make no robot wrong. Robots keep the
latest verdict, and the latest value of each cell, of each neighbour. They broadcast verdict and map.

A Byzantine robot sends a false verdict and a false map: n + 1 tasks in the first cell in addition to what it
knows, or all cells without tasks.

With ``rows`` = k a message has k consecutive rows of cells, taken in turn; by default all.

Message: the id; 1 bit whether the robot is sure, and if so, 1 bit for the verdict. Then the map: with
``rows``, the number of the first row; 1 bit whether all cells of the message are known, and if not, 1 bit per
cell; for each known cell its value in unary, which is as many bits and 1. Memory: the values, the tasks seen
in each cell, the sub-cells searched, and the names of the tasks seen.

References
----------
Our own; f + 1 neighbours are the rule of certified propagation (Koo, "Broadcast in radio networks tolerating
Byzantine adversarial behavior", 2004).
"""

import math

from feasibee.strategies.quiet_census import decide, say
from feasibee.strategies.sight import holds_tasks, sees

BY_NAME = True
STARTS_NEUTRAL = True
NEEDS_COUNT = True
NEEDS_IDS = "tolerates"
NEEDS_NAMES = True
ONE_CLASS = True
ALL_ROUND = True
READS_PLAN = True
PARAMETERS = {"cell": 1.0, "rows": 0.0, "tolerates": 0.0}
POSITIVE = ("cell",)
MEMBERS = 31
"""Number of a set's members in a word; also most sub-cells of a cell per axis."""
MOST_CELLS = 1000
"""Most cells of the arena per axis."""
MOST_TASKS = 2**20
"""Bound of a cell's value in a message that is read."""
MARGIN = 1e-8
"""Of the arena's size, taken off the range of sight: over 7 times the error of positions and distances."""
VERDICT, ROW, CELLS_KNOWN, SUM, CELLS = 0, 1, 2, 3, 4
"""First words of a message, and of what a robot knows.

The verdict, 1 infeasible, 2 feasible, or 0 if the robot isn't sure; the first row of the message, or of the
next one; the number of known cells, and the sum of their values. In a message the cells follow, each with its
value + 1, or 0 if it isn't known. In a message without a map only the verdict means anything.
"""
LEAST, COLUMNS, ROWS, ACROSS, DOWN, VALUES = 4, 5, 6, 7, 8, 9
"""Further words of what a robot knows.

The least number of tasks: in each cell its value or the tasks seen there, whichever is more; the numbers of
cells per axis, and of sub-cells per axis of a cell. Then, for each cell, its value + 1, or 0 if it isn't
known; for each cell the tasks seen there + 1; for each row of sub-cells of each cell the set of those
searched; the set of tasks seen; and for each robot the latest value + 1 that it sent of each cell, and its
latest verdict.
"""


def divided(side, longest, most):
    """Return into how many equal parts of at most some length to divide a side: 1 to ``most``."""
    if longest * most < side:
        return most
    return max(1, math.ceil(side / longest))


def columns_of(setting):
    """Return the number of columns of cells."""
    return divided(setting.width, setting.parameters[0], MOST_CELLS)


def rows_of(setting):
    """Return the number of rows of cells."""
    return divided(setting.height, setting.parameters[0], MOST_CELLS)


def rows_sent(setting):
    """Return the number of rows in a message."""
    rows = rows_of(setting)
    return int(setting.parameters[1]) if 1.0 <= setting.parameters[1] < rows else rows


def across_of(setting):
    """Return the number of sub-cells of a cell along the x-axis."""
    return divided(setting.width / columns_of(setting), setting.sight / 4.0, MEMBERS)


def down_of(setting):
    """Return the number of sub-cells of a cell along the y-axis."""
    return divided(setting.height / rows_of(setting), setting.sight / 4.0, MEMBERS)


def words(setting):
    """Return the size of the map and of all that is kept for it; see `VALUES`."""
    cells = columns_of(setting) * rows_of(setting)
    told = setting.robots * (cells + 1) if setting.parameters[2] >= 1.0 else 0
    return VALUES + cells * (2 + down_of(setting)) + (setting.task_ids + MEMBERS - 1) // MEMBERS + told


def message_words(setting):
    """Return the size of a message: some or all rows of the map."""
    return CELLS + rows_sent(setting) * columns_of(setting)


def start(known, me):
    """Store how the arena is divided."""
    known[COLUMNS], known[ROWS] = columns_of(me.setting), rows_of(me.setting)
    known[ACROSS], known[DOWN] = across_of(me.setting), down_of(me.setting)
    cells = known[COLUMNS] * known[ROWS]
    for k in range(VALUES + cells, VALUES + 2 * cells):
        known[k] = 1
    for cell in range(cells if me.setting.columns > 0 else 0):
        if leave_out(known, cell, me.setting):
            learn(known, cell, 1)


def leave_out(known, cell, setting):
    """Mark the sub-cells of a cell in which no task may be, by the plan; return whether these are all."""
    across, down = known[ACROSS], known[DOWN]
    width, height = setting.width / (known[COLUMNS] * across), setting.height / (known[ROWS] * down)
    left, low = cell % known[COLUMNS] * across * width, cell // known[COLUMNS] * down * height
    sets, missing = VALUES + 2 * known[COLUMNS] * known[ROWS] + cell * down, 0
    for j in range(down):
        for i in range(across):
            x, y = left + i * width, low + j * height
            if holds_tasks(x, y, x + width, y + height, setting):
                missing += 1
            else:
                known[sets + j] |= 1 << i
    return missing == 0


def observe(known, thing, me):
    """Add a task in sight to those seen in its cell."""
    if thing.is_robot or known[VERDICT] != 0:
        return
    cells = known[COLUMNS] * known[ROWS]
    word = VALUES + cells * (2 + known[DOWN]) + thing.id // MEMBERS
    bit = 1 << (thing.id % MEMBERS)
    if known[word] & bit == 0:
        known[word] |= bit
        column = min(int(thing.x / me.setting.width * known[COLUMNS]), known[COLUMNS] - 1)
        row = min(int(thing.y / me.setting.height * known[ROWS]), known[ROWS] - 1)
        cell = VALUES + row * known[COLUMNS] + column
        known[cells + cell] += 1
        if known[cells + cell] > known[cell]:
            known[LEAST] += 1


def encode(message, known, me):
    """Write the verdict, or the rows whose turn it is."""
    message[VERDICT] = known[VERDICT]
    if not has_map(known[VERDICT], me.setting):
        return
    sent = len(message) - CELLS
    first = max(VALUES + known[ROW] * known[COLUMNS], 0)  # max: the compiler vectorizes, four times as fast
    for k in range(sent):
        message[CELLS + k] = known[first + k]
    message[ROW], message[CELLS_KNOWN], message[SUM] = known[ROW], known[CELLS_KNOWN], known[SUM]
    if me.setting.parameters[1] >= 1.0:
        summarize(message)
    last = known[ROWS] - sent // known[COLUMNS]
    known[ROW] = 0 if known[ROW] == last else min(known[ROW] + sent // known[COLUMNS], last)


def has_map(verdict, setting):
    """Whether a message has cells: not if a verdict is adopted from one neighbour."""
    return verdict == 0 or setting.parameters[2] >= 1.0


def summarize(message):
    """Write the number of cells of a message that are known, and the sum of their values."""
    number, total = 0, 0
    for k in range(CELLS, len(message)):
        number += min(message[k], 1)
        total += message[k]
    message[CELLS_KNOWN], message[SUM] = number, total - number


def lie(message, feasible, me):
    """Write a false verdict, and a false map: n + 1 tasks in the first cell, or no task in any."""
    message[VERDICT] = 1 + feasible
    if has_map(message[VERDICT], me.setting):
        if feasible == 1 or message[ROW] != 0:
            for k in range(CELLS, len(message)):
                message[k] = feasible
        if feasible == 0:
            message[ROW] = 0  # so that each message has the first cell
            message[CELLS] = me.setting.robots + 2
        summarize(message)
    else:
        for k in range(VERDICT + 1, len(message)):
            message[k] = 0


def merge(known, message, sender, me):
    """Adopt a verdict, or the values of cells that aren't known."""
    if known[VERDICT] != 0:
        return
    if me.setting.parameters[2] >= 1.0:
        certify(known, message, sender, me)
    elif message[VERDICT] != 0:
        known[VERDICT] = message[VERDICT]
    else:
        adopt(known, message)


def adopt(known, message):
    """Adopt the values of cells that aren't known."""
    first = max(VALUES + message[ROW] * known[COLUMNS], 0)
    for k in range(len(message) - CELLS):
        word = known[first + k]
        known[first + k] = word if word != 0 else message[CELLS + k]
    cells = max(known[COLUMNS] * known[ROWS], 0)
    number, total, least = 0, 0, 0
    for k in range(cells):  # apart from the loop above: together they take twice the time
        number += min(known[VALUES + k], 1)
        total += known[VALUES + k]
        least += max(known[VALUES + k], known[VALUES + cells + k])
    known[CELLS_KNOWN], known[SUM], known[LEAST] = number, total - number, least - cells


def certify(known, message, sender, me):
    """Keep what a neighbour sends; adopt what enough neighbours have sent."""
    cells = known[COLUMNS] * known[ROWS]
    if message[VERDICT] != 0 and enough(known, cells, message[VERDICT], sender, me):
        known[VERDICT] = message[VERDICT]
        return
    first = message[ROW] * known[COLUMNS]
    for k in range(len(message) - CELLS):
        told = message[CELLS + k]
        if told != 0 and known[VALUES + first + k] == 0 and enough(known, first + k, told, sender, me):
            learn(known, first + k, told)


def enough(known, cell, told, sender, me):
    """Keep a value or verdict of a neighbour; return whether more than f sent the same.

    Verdicts are kept as those of a further cell.
    """
    kept = known[COLUMNS] * known[ROWS] + 1
    first = len(known) - me.setting.robots * kept + cell
    if known[first + sender * kept] == told:
        return False
    known[first + sender * kept] = told
    same = 0
    for other in range(me.setting.robots):
        same += known[first + other * kept] == told
    return same > me.setting.parameters[2]


def learn(known, cell, word):
    """Store the value + 1 of a cell that wasn't known."""
    known[VALUES + cell] = word
    known[CELLS_KNOWN] += 1
    known[SUM] += word - 1
    known[LEAST] += max(word - known[VALUES + known[COLUMNS] * known[ROWS] + cell], 0)


def count(known, counts, me):
    """Count the robots, which are known, and the tasks that exist at least."""
    counts[0], counts[1] = me.setting.robots, known[LEAST]


def describe(known, me):
    """Return how much of the map is known, in words."""
    cells = known[COLUMNS] * known[ROWS]
    return f"{known[CELLS_KNOWN]} of {cells} cells, with at least {known[LEAST]} tasks"


def bits(message, me):
    """Return the length of a message."""
    length = me.setting.id_bits + (1 if message[VERDICT] == 0 else 2)
    if has_map(message[VERDICT], me.setting):
        sent, rows = len(message) - CELLS, rows_of(me.setting)
        if sent < rows * columns_of(me.setting):
            length += (rows - 1).bit_length()
        length += 1 if message[CELLS_KNOWN] == sent else 1 + sent
        length += message[CELLS_KNOWN] + message[SUM]
    return length


def declare(known, me):
    """Return the verdict, if any, or what the map proves.

    What a robot sees in a step it has observed before: it knows all tasks in the sub-cells that it searches.
    """
    if known[VERDICT] == 0:
        if me.explores:
            search(known, me)
        if known[LEAST] > me.setting.robots:
            known[VERDICT] = 1
        elif known[CELLS_KNOWN] == known[COLUMNS] * known[ROWS]:
            known[VERDICT] = 2
    return known[VERDICT] - 1


def search(known, me):
    """Mark the sub-cells that are wholly within range of sight; learn the cells that are complete."""
    columns, rows = known[COLUMNS], known[ROWS]
    across, down = known[ACROSS], known[DOWN]
    width, height = me.setting.width / columns, me.setting.height / rows
    sight = me.setting.sight - MARGIN * (me.setting.width + me.setting.height)
    left, right = math.floor((me.x - sight) / width), math.floor((me.x + sight) / width)
    low, high = math.floor((me.y - sight) / height), math.floor((me.y + sight) / height)
    if me.setting.walled:
        left, right = max(left, 0), min(right, columns - 1)
        low, high = max(low, 0), min(high, rows - 1)
    for row in range(low, high + 1):
        first, column_there = row % rows * columns, left % columns
        for column in range(left, right + 1):
            cell = first + column_there
            column_there = column_there + 1 if column_there + 1 < columns else 0
            if known[VALUES + cell] == 0:
                x, y = column * width - me.x, row * height - me.y
                sets = VALUES + 2 * columns * rows + cell * down
                if mark(known, sets, across, down, x, y, width / across, height / down, sight * sight, me):
                    learn(known, cell, known[VALUES + columns * rows + cell])


def mark(known, sets, across, down, left, low, width, height, limit, me):
    """Mark the sub-cells of a cell that are within range and not hidden; return whether all are marked.

    The cell's corner is given from the robot, the sizes are those of a sub-cell.
    """
    missing = 0
    for j in range(down):
        dy = max(-(low + j * height), low + (j + 1) * height)  # to the farther side
        marked = known[sets + j]
        for i in range(across):
            dx = max(-(left + i * width), left + (i + 1) * width)
            marked |= (dx * dx + dy * dy <= limit) << i
        if me.setting.columns > 0:
            new = marked & ~known[sets + j]
            marked ^= hidden_ones(new, across, left, low + j * height, width, height, me)
        known[sets + j] = marked
        missing |= marked ^ ((1 << across) - 1)
    return missing == 0


def hidden_ones(new, across, left, low, width, height, me):
    """Return which sub-cells of a row, of those given, walls may hide."""
    found = 0
    for i in range(across):
        x, y = me.x + left + i * width, me.y + low
        if new >> i & 1 == 1 and not sees(x, y, x + width, y + height, me):
            found |= 1 << i
    return found


def layout(wire, message, sender, setting):
    """Go through the id, the verdict, and the map, if it has one."""
    sender = wire.number(sender, setting.id_bits, setting.robots)
    is_sure = wire.flag(message[VERDICT] != 0)
    message[VERDICT] = 1 + wire.number(message[VERDICT] - 1, 1) if is_sure else 0
    if not has_map(message[VERDICT], setting):
        return sender
    rows, sent = rows_of(setting), rows_sent(setting)
    if sent < rows:
        message[ROW] = wire.number(message[ROW], (rows - 1).bit_length(), rows - sent + 1)
    cells = len(message) - CELLS
    is_whole = wire.flag(cells_known(message) == cells)
    for cell in range(CELLS, len(message)):  # when reading, 1 until its value is read
        message[cell] = max(message[cell], 1) if is_whole or wire.flag(message[cell] != 0) else 0
    wire.check(is_whole or cells_known(message) < cells, "lists all cells as known, one by one")
    for cell in range(CELLS, len(message)):
        if message[cell] != 0:
            message[cell] = 1 + wire.rice(message[cell] - 1, 0, MOST_TASKS)
    summarize(message)
    return sender


def cells_known(message):
    """Return the number of cells in a message that are known."""
    number = 0
    for cell in range(CELLS, len(message)):
        number += message[cell] != 0
    return number
