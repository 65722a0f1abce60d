"""Roster: a census of what was seen lately, with tombstones, for worlds that change.

Each robot keeps, for each task that it knows of, whether it was there or not when it was last looked for, and
when that was. It does so for robots, too, unless it knows n. It broadcasts all of this with ages in steps, so
that robots need no common clock. Of two reports on a task the younger counts; at the same age, that it is
there. A robot that looks at the place of a task and does not see it, ``looks`` times in a row, reports it
absent: its tombstone. It never repeats that as a new report, so that tombstones grow old as well.

In each step the opinion is feasible if there are as many robots as tasks, or more: m counts the tasks that
were there at most ``task_timeout`` steps ago, n the robot itself and the robots seen or heard at most
``robot_timeout`` steps ago. Robots that leave have no tombstone, since nobody knows where to look.

A timeout of 0 is computed: 2 quiet times of `quiet_census` for tasks, and 1.5 for robots. That is 200 and 150
steps for 20 robots in the paper's arena. If sightings are missed with probability p, a swarm whose tasks
exceed its robots by one is wrong for about 45 p**looks of the time: 2 looks suffice up to p = 0.01, 3 up to
0.05, 4 up to 0.1. Robots must observe a thing as often as they see it: with unique observation it would seem
to vanish.

With ``tolerates`` = f, what a robot did not see itself counts once f + 1 different neighbours have reported
it; the oldest of their latest reports counts. So no false report is younger than a true one.

A Byzantine robot that speaks for feasible reports all tasks absent, and invents robots. One that speaks for
infeasible reports all tasks that it ever knew as there, and invents tasks. Colluding robots invent as many
as the lie needs.

Message: the length of an age, in 5 bits; for each task 1 bit, its position in 32 bits, 1 bit whether it is
there, and its age; without n, for each robot 1 bit, its id and its age; 1 bit at the end of either list; with
f > 0, the sender's id. Memory: the same, for each task the number of looks in vain, and for each task and
robot the latest reports of f + 1 neighbours.

References
----------
Our own. Sets with the latest write of each member: Shapiro et al., "A comprehensive study of convergent and
commutative replicated data types", 2011. What f + 1 neighbours report: see `certified`.
"""

from feasibee.strategies.certified import invented, steps_for, steps_given, tolerated
from feasibee.strategies.clock import LAST, steps_since
from feasibee.strategies.quiet_census import decide, patience
from feasibee.strategies.sight import sees

BY_NAME = True
NEEDS_IDS = True
NEEDS_NAMES = True
ONE_CLASS = True
ALL_ROUND = True
READS_PLAN = True
PARAMETERS = {"task_timeout": 0.0, "robot_timeout": 0.0, "looks": 2.0, "tolerates": 0.0}
TASK_TIMEOUT, ROBOT_TIMEOUT, LOOKS, TOLERATES = 0, 1, 2, 3
TASK_QUIETS, ROBOT_QUIETS = 2.0, 1.5
"""Timeouts in quiet times of `quiet_census`."""
WIDTH_BITS = 5
"""Bits for the length of an age."""
POSITION_BITS = 32
SIDE = 2**16
"""Number of positions along a side of the arena."""
CERTAIN = 0.95
"""Share of the range of sight within which a task that isn't seen is taken for absent."""
PAST = 2**20
"""Largest timeout, in steps. So many may have passed before the robot's own first one."""
FORGOTTEN = 2**30
"""Age at which a state is given up, in steps: the words of states count steps modulo 2**31."""
STATES = 2
"""Place of the first state of a robot, and then of a task, in what is known.

Before stand both timeouts in steps, behind places of tasks, looks in vain, and reports of neighbours.
"""
ENTRIES = 1
"""Place of the first robot, and then task, in a message; before stands the length of an age."""


def robot_entries(setting):
    """Return the number of robots that are listed: none if n is known."""
    return 0 if setting.knows_count else setting.robot_ids


def message_words(setting):
    """Return the size of a message: the length of an age, an entry for each name, and places of tasks."""
    return ENTRIES + robot_entries(setting) + 2 * setting.task_ids


def words(setting):
    """Return the size of what is known, with the reports of neighbours that a robot must weigh.

    Those on a name are f + 1 senders and states that it is absent, and present.
    """
    names, tolerates = robot_entries(setting) + setting.task_ids, tolerated(setting, TOLERATES)
    reports = 4 * (tolerates + 1) if tolerates > 0 else 0
    return STATES + names + 2 * setting.task_ids + names * reports


def state_at(step, present):
    """Return the state of a name that was seen (1) or found absent (0) at a step."""
    return (2 * (step + PAST) + present) & LAST


def entry_of(state, me):
    """Return a state as in a message: twice its age in steps, and 1 if there, 2 if absent."""
    return steps_since(state, state_at(me.step + 1, 0)) if state != 0 else LAST


def younger(state, entry, me):
    """Return a state, or that of an entry of a message if this is younger."""
    now = state_at(me.step + 1, 0)
    return steps_since(entry, now) if 0 < entry < entry_of(state, me) else state & LAST


def expired(state, timeout, me):
    """Return a state, absent if it is older than a timeout, and 0 if it is forgotten."""
    entry = entry_of(state, me)
    found = state + ((entry > 2 * timeout + 2) & (state & 1))
    return 0 if entry > 2 * FORGOTTEN else found


def own_timeout(setting, place, quiets, robots):
    """Return a timeout in steps: as given, or computed for so many robots."""
    if setting.parameters[place] > 0:
        return min(steps_given(setting.parameters[place]), PAST - 1)
    visits = quiets * patience(robots, tolerated(setting, TOLERATES))
    return min(steps_for(visits, robots, setting), PAST - 1)


def set_timeouts(known, robots, setting):
    """Store both timeouts for so many robots."""
    known[TASK_TIMEOUT] = own_timeout(setting, TASK_TIMEOUT, TASK_QUIETS, robots)
    known[ROBOT_TIMEOUT] = own_timeout(setting, ROBOT_TIMEOUT, ROBOT_QUIETS, robots)


def start(known, me):
    """Add the robot itself to what it knows."""
    set_timeouts(known, me.setting.count if me.setting.knows_count else 1, me.setting)
    if not me.setting.knows_count:
        known[STATES + me.id] = state_at(me.step, 1)


def place_of(thing, setting):
    """Return the position of a task in 32 bits."""
    across = min(int(thing.x / setting.width * SIDE), SIDE - 1)
    along = min(int(thing.y / setting.height * SIDE), SIDE - 1)
    return across * SIDE + along


def observe(known, thing, me):
    """Store that a robot or task is in sight."""
    robots = robot_entries(me.setting)
    if thing.is_robot:
        if robots > 0:
            known[STATES + thing.id] = state_at(me.step, 1)
        return
    task = STATES + robots + thing.id
    known[task] = state_at(me.step, 1)
    known[task + me.setting.task_ids] = place_of(thing, me.setting)
    known[task + 2 * me.setting.task_ids] = -1  # `look` then counts no look in vain


def distance(first, second, side, walled):
    """Return the distance of two coordinates, the shorter way round on a torus."""
    apart = abs(first - second)
    return apart if walled else min(apart, side - apart)


def is_near(place, me):
    """Return whether a position is so near that a task there must be seen."""
    setting = me.setting
    x = ((place >> 16) % SIDE + 0.5) * setting.width / SIDE
    y = (place % SIDE + 0.5) * setting.height / SIDE
    dx, dy = (
        distance(x, me.x, setting.width, setting.walled),
        distance(y, me.y, setting.height, setting.walled),
    )
    reach = max(CERTAIN * setting.sight - (setting.width + setting.height) / SIDE, 0.0)
    if dx * dx + dy * dy >= reach * reach:
        return False
    across, along = 0.5 * setting.width / SIDE, 0.5 * setting.height / SIDE
    return sees(x - across, y - along, x + across, y + along, me)


def look(known, me):
    """Count the looks in vain at the places of tasks; report those absent that were looked for in vain."""
    tasks = me.setting.task_ids
    first = STATES + robot_entries(me.setting)
    for task in range(first, first + tasks):
        vain = task + 2 * tasks
        if known[vain] < 0:
            known[vain] = 0
        elif known[task] % 2 == 1 and is_near(known[task + tasks], me):
            known[vain] += 1
            if known[vain] >= me.setting.parameters[LOOKS]:
                known[task] = state_at(me.step, 0)
                known[vain] = 0


def encode(message, known, me):
    """Write the ages that all states have when the message arrives, and the positions of the tasks."""
    robots, tasks = robot_entries(me.setting), me.setting.task_ids
    task_timeout, robot_timeout = known[TASK_TIMEOUT], known[ROBOT_TIMEOUT]
    longest = task_timeout if robots == 0 else max(task_timeout, robot_timeout)
    late = 2 * int(me.setting.delay)
    message[0] = longest.bit_length()
    if robots > 0:
        known[STATES + me.id] = state_at(me.step, 1)
    for k in range(robots):
        entry = entry_of(known[STATES + k], me)
        is_news = (entry & 1 == 1) & (entry <= 2 * robot_timeout + 2 - late)
        message[ENTRIES + k] = entry + late if is_news else 0
    for k in range(robots, robots + tasks):
        entry = entry_of(known[STATES + k], me)
        message[ENTRIES + k] = 0 if entry > 2 * task_timeout + 2 - late else entry + late
    for k in range(robots, robots + tasks):
        message[ENTRIES + tasks + k] = known[STATES + tasks + k] if message[ENTRIES + k] != 0 else 0


def lie(message, feasible, me):
    """Report all tasks absent and invent robots, or all tasks there and invent tasks; each just seen."""
    setting = me.setting
    robots, tasks = robot_entries(setting), setting.task_ids
    there = 0
    for task in range(ENTRIES + robots, ENTRIES + robots + tasks):
        if message[task] != 0:
            message[task] = 1 + feasible
            there += 1
    if feasible == 0:
        lacking = setting.count + 1 - there if setting.colluding else setting.count + 1
        for task in range(setting.tasks, min(setting.tasks + max(lacking, 0), tasks)):
            message[ENTRIES + robots + task] = 1
            message[ENTRIES + robots + tasks + task] = invented(task, POSITION_BITS)
    else:
        lacking = there - setting.count if setting.colluding else there
        for robot in range(setting.robots, min(setting.robots + max(lacking, 0), robots)):
            message[ENTRIES + robot] = 1


def oldest_of(known, first, reports, entry, sender, me):
    """Store a neighbour's report; return the oldest of the latest reports, `LAST` if there are too few.

    The words from ``first`` on list the latest states, as many as needed, of different senders; then one
    more than their ids.
    """
    place = first
    for k in range(first, first + reports):
        if known[k + reports] == sender + 1:
            place = k
            break
        if entry_of(known[k], me) > entry_of(known[place], me):
            place = k
    if entry < entry_of(known[place], me):
        known[place], known[place + reports] = younger(known[place], entry, me), sender + 1
    oldest = 0
    for k in range(first, first + reports):
        oldest = max(oldest, entry_of(known[k], me))
    return oldest


def weigh(known, message, sender, me):
    """Store the reports of a neighbour; accept what enough neighbours have reported."""
    robots, tasks = robot_entries(me.setting), me.setting.task_ids
    reports = tolerated(me.setting, TOLERATES) + 1
    first = STATES + robots + 3 * tasks
    for k in range(robots + tasks):
        entry = message[ENTRIES + k]
        if 0 < entry < entry_of(known[STATES + k], me):
            place = first + 2 * reports * (2 * k + entry % 2)
            oldest = oldest_of(known, place, reports, entry, sender, me)
            known[STATES + k] = younger(known[STATES + k], oldest, me)
    if robots > 0:
        known[STATES + sender] = state_at(me.step, 1)


def merge(known, message, sender, me):
    """Adopt the younger state of each name."""
    robots, tasks = robot_entries(me.setting), me.setting.task_ids
    if tolerated(me.setting, TOLERATES) > 0:
        weigh(known, message, sender, me)
    else:
        for k in range(robots + tasks):
            known[STATES + k] = younger(known[STATES + k], message[ENTRIES + k], me)
    for k in range(robots + tasks, robots + 2 * tasks):
        known[STATES + k] |= message[ENTRIES + k]


def expire(known, me):
    """Give up what is too old, until there is younger news.

    Else it would count again when the timeouts grow, since robots that leave make them longer.
    """
    robots, task_timeout, robot_timeout = robot_entries(me.setting), known[TASK_TIMEOUT], known[ROBOT_TIMEOUT]
    for k in range(STATES, STATES + robots):
        known[k] = expired(known[k], robot_timeout, me)
    for k in range(STATES + robots, STATES + robots + me.setting.task_ids):
        known[k] = expired(known[k], task_timeout, me)


def present(known, first, number):
    """Return how many of so many names are there."""
    there = 0
    for k in range(first, first + number):
        there += known[k] & 1
    return there


def robots_of(known, me):
    """Return the number of robots: n if the robot knows it, or those that were seen or heard lately."""
    if me.setting.knows_count:
        return me.setting.count
    return max(present(known, STATES, me.setting.robot_ids), 1)


def tasks_of(known, me):
    """Return the number of tasks that were there lately."""
    return present(known, STATES + robot_entries(me.setting), me.setting.task_ids)


def judge(known, me):
    """Return whether there are enough robots for the tasks, after a look around."""
    expire(known, me)
    if me.explores:
        look(known, me)
    if not me.setting.knows_count:
        known[STATES + me.id] = state_at(me.step, 1)
    robots = robots_of(known, me)
    set_timeouts(known, robots, me.setting)
    return 1 if robots >= tasks_of(known, me) else 0


def count(known, counts, me):
    """Count the robots and the tasks."""
    counts[0], counts[1] = robots_of(known, me), tasks_of(known, me)


def describe(known, me):
    """Return the numbers of robots and tasks in words."""
    return f"{robots_of(known, me)} robots and {tasks_of(known, me)} tasks lately, by name"


def bits(message, me):
    """Return the length of the header and of both lists."""
    robots, tasks = robot_entries(me.setting), me.setting.task_ids
    length = WIDTH_BITS + 1
    for task in range(ENTRIES + robots, ENTRIES + robots + tasks):
        length += (message[task] != 0) * (2 + POSITION_BITS + message[0])
    if tolerated(me.setting, TOLERATES) > 0:
        length += me.setting.id_bits
    if robots > 0:
        length += 1
        for robot in range(ENTRIES, ENTRIES + robots):
            length += (message[robot] != 0) * (1 + me.setting.id_bits + message[0])
    return length


def layout(wire, message, sender, setting):
    """Go through the sender's id if receivers need it, the length of an age, and both lists."""
    tasks, first = setting.task_ids, ENTRIES + robot_entries(setting)
    tolerates = tolerated(setting, TOLERATES)
    sender = wire.number(sender, setting.id_bits, setting.robots) if tolerates > 0 else -1
    message[0] = wire.number(message[0], WIDTH_BITS, PAST.bit_length())
    list_tasks(wire, message, first, tasks, setting)
    if first > ENTRIES:
        list_robots(wire, message, setting)
    return sender


def list_tasks(wire, message, first, tasks, setting):
    """Go through the tasks in the order of their places, and their ages."""
    last, last_entry = -1, -1
    entry = next_task(message, first, tasks, last, last_entry)
    while wire.flag(entry >= 0):
        known = max(entry, first)
        place = wire.number(message[known + tasks] % SIDE**2, POSITION_BITS)
        wire.check(place > last, "lists tasks out of order")
        task = first + wire.task(place, known - first, tasks)
        wire.check(message[task] == 0, "lists a task twice")
        is_there = wire.flag(message[known] % 2 == 1)
        message[task] = 2 - is_there + 2 * wire.number((message[known] - 1) // 2, message[0])
        message[task + tasks] = place
        last, last_entry = place, task
        entry = next_task(message, first, tasks, last, last_entry)


def next_task(message, first, tasks, place, entry):
    """Return the entry of the task that follows in the order of places, then of entries; -1 at the end."""
    found, nearest = -1, SIDE**2
    for k in range(first, first + tasks):
        there = message[k + tasks] % SIDE**2
        if message[k] != 0 and (there > place or (there == place and k > entry)) and there < nearest:
            found, nearest = k, there
    return found


def list_robots(wire, message, setting):
    """Go through the robots that are there, in rising order, and their ages."""
    last, robots = -1, robot_entries(setting)
    robot = next_robot(message, 0, robots)
    while wire.flag(robot < robots):
        robot = wire.number(robot, setting.id_bits, robots)
        wire.check(robot > last, "lists robots out of order")
        message[ENTRIES + robot] = 1 + 2 * wire.number((message[ENTRIES + robot] - 1) // 2, message[0])
        last = robot
        robot = next_robot(message, last + 1, robots)


def next_robot(message, robot, robots):
    """Return the first robot from this one on that is there; after the last, the number of robots."""
    while robot < robots and message[ENTRIES + robot] == 0:
        robot += 1
    return robot
