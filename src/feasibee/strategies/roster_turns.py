"""Roster in turns: a roster in 22 bits, one name per message, each with a version.

A task's name is its position in ``name_bits`` bits: two tasks with equal names are one. With each name a
robot keeps a version, which counts how often the task appeared or vanished: odd if it is there, even if not.
A robot that sees a task whose version is even, or looks at the place of one in vain ``looks`` times in a row,
adds 1. Of two versions robots take the newer. Every other message holds one of the 2 latest changes that the
robot made or heard of, as long as they are news: 2 quiet times of `quiet_census`. The others hold the names
in turn, those that vanished for 4 quiet times. A robot that hears an outdated version tells its own again. In
each step the opinion is feasible if there are as many robots as tasks, or more. Observation must not be
unique, as in `roster`.

Versions count modulo 4. Of two that differ by 1, the one that follows is the newer, so that 0 follows 3. Two
that differ by 2 say the same of the task; robots take 2 or 3, and so agree. This is right as long as no robot
misses two changes of a task in a row. If one does, the next look at the place corrects the error.

Unless robots know n, a message is either about a task or about a robot: which one, and how many steps ago it
was seen or heard at the latest. n counts the robot itself and those at most ``robot_timeout`` steps ago. A
timeout of 0 is computed: 6 quiet times.

With ``tolerates`` = f, a version that a robot did not see itself counts once f + 1 different neighbours have
sent it, and a robot's age likewise, as in `roster`. Robots send only what counts.

A Byzantine robot sends each task with the version that would make it vanish, and invents robots; or with the
version that would bring it back, and invents n + 1 tasks. Every other message holds an invention.

Message: 2 bits of version and the name. Unless n is known, the sender's id, 1 bit for robot or task, and for
a robot its id and 12 bits of age; with f > 0, the sender's id. Memory: names and versions, when they were
news, looks in vain; for each robot its age; for each of them the reports of f + 1 neighbours.

References
----------
Our own. Sets whose members have a version, odd if present: Yu and Rostad, "A low-cost set CRDT based on
causal lengths", 2020. Numbers that wrap: Elz and Bush, "Serial number arithmetic", RFC 1982, 1996.
"""

from feasibee.strategies.certified import invented, steps_for, steps_given, told_enough, tolerated
from feasibee.strategies.clock import steps_since
from feasibee.strategies.quiet_census import decide, patience
from feasibee.strategies.roster import CERTAIN, distance, entry_of, expired, oldest_of, state_at, younger
from feasibee.strategies.sight import sees

BY_NAME = True
NEEDS_IDS = True
NEEDS_NAMES = True
ONE_CLASS = True
ALL_ROUND = True
READS_PLAN = True
PARAMETERS = {"name_bits": 20.0, "robot_timeout": 0.0, "looks": 2.0, "tolerates": 0.0}
NAME_BITS, ROBOT_TIMEOUT, LOOKS, TOLERATES = 0, 1, 2, 3
ROBOT_QUIETS, NEWS_QUIETS, VANISHED_QUIETS = 6, 2, 4
"""Timeout of robots, and for how long changes are news and vanished tasks are sent, in quiet times."""
LONGEST = 2**26
"""Largest quiet time, in steps: 6 of them must fit a word."""
VERSIONS = 4
VERSION_BITS = 2
AGE_BITS = 12
OLDEST = 2**AGE_BITS - 1
NUMBER, TICK, TURNS, TURN, ROBOT_TURN, QUIET, TIMEOUT, ENTRIES = 0, 1, 2, 3, 4, 5, 6, 7
"""Words of what is known: number of names; messages sent, and turns of kinds, names and robots.

Then the quiet time and the timeout of robots in steps; the entries of names, and of robots, if listed.
"""
NAME, VERSION, NEWS, VAIN, SENDERS = 0, 1, 2, 3, 4
"""Words of a name's entry: its name, its version, the step when it was news, and its looks in vain.

The version is one more than that sent, or 0 as long as it doesn't count.
Then come one more than the ids of at most f neighbours that sent the next version, and f the one after it.
"""
KIND, WHAT, VALUE = 0, 1, 2
"""Words of a message: 1 if it is about a robot, a name or one more than an id, and a version or age.

The second is 0 in an empty message.
"""


def name_bits(setting):
    """Return the length of a name, in bits."""
    return int(min(max(setting.parameters[NAME_BITS], 2.0), 30.0))


def name_of(thing, setting):
    """Return the name of a task: the number of its cell in a grid of the arena, and never 0."""
    columns, rows = columns_of(setting), rows_of(setting)
    column = min(int(thing.x / setting.width * columns), columns - 1)
    row = min(int(thing.y / setting.height * rows), rows - 1)
    return max(column * rows + row, 1)


def columns_of(setting):
    """Return the number of columns of the grid of names."""
    return 1 << ((name_bits(setting) + 1) // 2)


def rows_of(setting):
    """Return the number of rows of the grid of names."""
    return 1 << (name_bits(setting) // 2)


def is_near(name, me):
    """Return whether a cell is so near that a task anywhere in it must be seen."""
    setting, row_bits = me.setting, name_bits(me.setting) // 2
    across, along = setting.width / columns_of(setting), setting.height / rows_of(setting)
    x = ((name >> row_bits) + 0.5) * across
    y = ((name & ((1 << row_bits) - 1)) + 0.5) * along
    across, along = 0.5 * across, 0.5 * along
    dx = distance(x, me.x, setting.width, setting.walled) + across
    dy = distance(y, me.y, setting.height, setting.walled) + along
    reach = CERTAIN * setting.sight
    return dx * dx + dy * dy < reach * reach and sees(x - across, y - along, x + across, y + along, me)


def entry_words(setting):
    """Return the size of an entry of a name."""
    return SENDERS + 2 * tolerated(setting, TOLERATES)


def robot_words(setting):
    """Return the size of an entry of a robot: when it was there, and reports of neighbours on that."""
    tolerates = tolerated(setting, TOLERATES)
    return 1 + 2 * (tolerates + 1) if tolerates > 0 else 1


def first_robot(setting):
    """Return the place of the first robot's entry."""
    return ENTRIES + setting.task_ids * entry_words(setting)


def words(setting):
    """Return the size of what is known."""
    robots = 0 if setting.knows_count else setting.robot_ids * robot_words(setting)
    return first_robot(setting) + robots


def message_words(setting):
    """Return the size of a message."""
    return 3


def set_timeout(known, robots, setting):
    """Store the timeout for so many robots."""
    visits = patience(robots, tolerated(setting, TOLERATES))
    known[QUIET] = min(steps_for(visits, robots, setting), LONGEST)
    known[TIMEOUT] = ROBOT_QUIETS * known[QUIET]
    if setting.parameters[ROBOT_TIMEOUT] > 0:
        known[TIMEOUT] = steps_given(setting.parameters[ROBOT_TIMEOUT])


def start(known, me):
    """Begin with the robot itself."""
    set_timeout(known, me.setting.count if me.setting.knows_count else 1, me.setting)
    meet(known, me.id, me)


def meet(known, robot, me):
    """Store that a robot is there, if robots are listed."""
    if not me.setting.knows_count:
        known[first_robot(me.setting) + robot * robot_words(me.setting)] = state_at(me.step, 1)


def find(known, name, setting):
    """Return the place of a name's entry, a new one if it has none; -1 if there is no room.

    Names are sorted, so that the order of the things in sight doesn't matter.
    """
    size = entry_words(setting)
    low, high = 0, known[NUMBER]
    while low < high:
        middle = (low + high) // 2
        if known[ENTRIES + middle * size + NAME] < name:
            low = middle + 1
        else:
            high = middle
    entry, end = ENTRIES + low * size, ENTRIES + known[NUMBER] * size
    if entry < end and known[entry + NAME] == name:
        return entry
    if known[NUMBER] >= setting.task_ids:
        return -1
    for k in range(end - 1, entry - 1, -1):
        known[k + size] = known[k]
    for k in range(entry, entry + size):
        known[k] = 0
    known[entry + NAME] = name
    known[NUMBER] += 1
    known[TURN] += low <= known[TURN]
    return entry


def change(known, entry, version, me):
    """Give an entry a version."""
    known[entry + VERSION] = version % VERSIONS + 1
    known[entry + NEWS] = me.step
    known[entry + VAIN] = 0
    for k in range(entry + SENDERS, entry + entry_words(me.setting)):
        known[k] = 0


def is_there(known, entry):
    """Return whether the task of an entry is there."""
    return known[entry + VERSION] > 0 and known[entry + VERSION] % 2 == 0


def observe(known, thing, me):
    """Store that a robot or task is in sight."""
    if thing.is_robot:
        meet(known, thing.id, me)
        return
    entry = find(known, name_of(thing, me.setting), me.setting)
    if entry >= 0:
        if not is_there(known, entry):
            change(known, entry, max(known[entry + VERSION], 1), me)
        known[entry + VAIN] = -1  # `look` then counts no look in vain


def look(known, me):
    """Count the looks in vain at the places of tasks; a task that was looked for in vain has vanished."""
    entry = ENTRIES
    for _ in range(known[NUMBER]):
        if known[entry + VAIN] < 0:
            known[entry + VAIN] = 0
        elif is_there(known, entry) and is_near(known[entry + NAME], me):
            known[entry + VAIN] += 1
            if known[entry + VAIN] >= me.setting.parameters[LOOKS]:
                change(known, entry, known[entry + VERSION], me)
        entry += entry_words(me.setting)


def encode(message, known, me):
    """Write a task that changed lately, or one in turn; unless n is known, also a robot in turn."""
    message[KIND], message[WHAT], message[VALUE] = 0, 0, 0
    known[TICK] = (known[TICK] + 1) % 4
    entry = latest_news(known, known[TICK] == 0, me) if known[TICK] % 2 == 0 else -1
    if entry < 0:
        known[TURNS] = 1 - known[TURNS]
        if known[TURNS] == 0 and not me.setting.knows_count:
            write_robot(message, known, me)
            return
        entry = next_in_turn(known, me)
    if entry >= 0:
        message[WHAT], message[VALUE] = known[entry + NAME], known[entry + VERSION] - 1


def latest_news(known, second, me):
    """Return the entry with the latest news, or with the second latest if any; -1 if nothing is news."""
    latest, before = -1, -1
    youngest = second_youngest = NEWS_QUIETS * known[QUIET]
    for k in range(known[NUMBER]):
        entry = ENTRIES + k * entry_words(me.setting)
        age = steps_since(known[entry + NEWS], me.step)
        if known[entry + VERSION] > 0 and age <= second_youngest:
            if age <= youngest:
                latest, before = entry, latest
                youngest, second_youngest = age, youngest
            else:
                before, second_youngest = entry, age
    return before if second and before >= 0 else latest


def next_in_turn(known, me):
    """Return the next entry that counts, -1 if none does; tasks that vanished long ago have no turn."""
    for _ in range(known[NUMBER]):
        known[TURN] = known[TURN] + 1 if known[TURN] + 1 < known[NUMBER] else 0
        entry = ENTRIES + known[TURN] * entry_words(me.setting)
        if is_there(known, entry):
            return entry
        age = steps_since(known[entry + NEWS], me.step)
        if known[entry + VERSION] > 0 and age <= VANISHED_QUIETS * known[QUIET]:
            return entry
    return -1


def write_robot(message, known, me):
    """Write the next robot that was there lately, and its age when the message arrives."""
    robots, first = me.setting.robot_ids, first_robot(me.setting)
    message[KIND] = 1
    for _ in range(robots):
        known[ROBOT_TURN] = known[ROBOT_TURN] + 1 if known[ROBOT_TURN] + 1 < robots else 0
        state = known[first + known[ROBOT_TURN] * robot_words(me.setting)]
        age = entry_of(state, me) // 2 + int(me.setting.delay)
        if known[ROBOT_TURN] != me.id and state % 2 == 1 and age <= OLDEST:
            message[WHAT], message[VALUE] = known[ROBOT_TURN] + 1, age
            return


def lie(message, feasible, me):
    """Send a version that makes a task vanish, or brings it back; every other message is invented."""
    setting = me.setting
    turn, more_robots = me.step // 2, setting.robot_ids - setting.robots
    if feasible == 1 and not setting.knows_count and me.step % 2 == 0 and more_robots > 0:
        message[KIND], message[WHAT], message[VALUE] = 1, setting.robots + turn % more_robots + 1, 0
    elif feasible == 0 and me.step % 2 == 0:
        message[KIND], message[VALUE] = 0, 1
        message[WHAT] = invented(turn % (setting.count + 1), name_bits(setting))
    elif message[KIND] == 0 and message[WHAT] != 0 and message[VALUE] % 2 == feasible:
        message[VALUE] = (message[VALUE] + 1) % VERSIONS


def hear_task(known, message, sender, me):
    """Adopt the newer version of a task; send its own soon if the one heard is outdated."""
    entry = find(known, message[WHAT], me.setting)
    if entry < 0:
        return
    version, own = message[VALUE], known[entry + VERSION] - 1
    ahead = (version - own) % VERSIONS if own >= 0 else 1 + version % 2
    if ahead == 1 or (ahead == 2 and version > own):
        tolerates = tolerated(me.setting, TOLERATES)
        if told_enough(known, entry + SENDERS + (ahead - 1) * tolerates, tolerates, sender):
            change(known, entry, version, me)
    elif ahead != 0:
        known[entry + NEWS] = me.step


def hear_robot(known, message, sender, me):
    """Adopt the younger age of a robot."""
    tolerates = tolerated(me.setting, TOLERATES)
    entry = 2 * message[VALUE] + 1
    place = first_robot(me.setting) + (message[WHAT] - 1) * robot_words(me.setting)
    if entry < entry_of(known[place], me) and tolerates > 0:
        entry = oldest_of(known, place + 1, tolerates + 1, entry, sender, me)
    known[place] = younger(known[place], entry, me)


def merge(known, message, sender, me):
    """Store that the sender is there, and take what is newer in its message."""
    meet(known, sender, me)
    if message[WHAT] != 0 and message[KIND] == 0:
        hear_task(known, message, sender, me)
    elif message[WHAT] != 0:
        hear_robot(known, message, sender, me)


def robots_of(known, me):
    """Return the number of robots: n if the robot knows it, or those that were seen or heard lately."""
    if me.setting.knows_count:
        return me.setting.count
    number = 0
    for k in range(me.setting.robot_ids):
        number += known[first_robot(me.setting) + k * robot_words(me.setting)] % 2
    return max(number, 1)


def expire(known, me):
    """Give up robots that were not there for too long, as in `roster`, until there is younger news."""
    for place in range(first_robot(me.setting), len(known), robot_words(me.setting)):
        known[place] = expired(known[place], known[TIMEOUT], me)


def tasks_of(known, me):
    """Return the number of tasks that are there."""
    number = 0
    for k in range(known[NUMBER]):
        number += is_there(known, ENTRIES + k * entry_words(me.setting))
    return number


def judge(known, me):
    """Return whether there are enough robots for the tasks, after a look around."""
    if me.explores:
        look(known, me)
    expire(known, me)
    meet(known, me.id, me)
    robots = robots_of(known, me)
    set_timeout(known, robots, me.setting)
    return 1 if robots >= tasks_of(known, me) else 0


def count(known, counts, me):
    """Count the robots and the tasks."""
    counts[0], counts[1] = robots_of(known, me), tasks_of(known, me)


def gap(known, me):
    """Return by how many the tasks outnumber the robots."""
    return tasks_of(known, me) - robots_of(known, me)


def describe(known, me):
    """Return the numbers of robots and tasks in words."""
    return f"{robots_of(known, me)} robots and {tasks_of(known, me)} tasks, by name and version"


def bits(message, me):
    """Return the length of a message, which is the same for all."""
    return bits_of(me.setting)


def bits_of(setting):
    """Return the length of a message in bits."""
    length = VERSION_BITS + name_bits(setting)
    if not setting.knows_count:
        return setting.id_bits + 1 + max(length, setting.id_bits + AGE_BITS)
    return length + (setting.id_bits if tolerated(setting, TOLERATES) > 0 else 0)


def layout(wire, message, sender, setting):
    """Go through the sender's id if it is sent, and a task or a robot; the sender itself stands for none."""
    counts_robots, left = not setting.knows_count, bits_of(setting)
    sends_id = counts_robots or tolerated(setting, TOLERATES) > 0
    left -= setting.id_bits * sends_id + counts_robots
    sender = wire.number(sender, setting.id_bits, setting.robots) if sends_id else -1
    message[KIND] = int(counts_robots and wire.flag(message[KIND] == 1))
    if message[KIND] == 1:
        robot = message[WHAT] - 1 if message[WHAT] != 0 else sender
        robot = wire.number(robot, setting.id_bits, setting.robot_ids)
        message[WHAT] = robot + 1 if robot != sender else 0
        message[VALUE] = wire.number(message[VALUE], AGE_BITS)
        left -= setting.id_bits + AGE_BITS
    else:
        message[WHAT] = wire.number(message[WHAT], name_bits(setting))
        message[VALUE] = wire.number(message[VALUE], VERSION_BITS)
        left -= name_bits(setting) + VERSION_BITS
    wire.check(message[WHAT] != 0 or message[VALUE] == 0, "says something about nothing")
    wire.check(wire.number(0, left) == 0, "is filled with bits other than 0")
    return sender
