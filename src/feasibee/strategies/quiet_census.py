"""Quiet census: robots count the tasks by name, and declare once nothing new has come for long enough.

Each robot keeps the set of the tasks that it knows. It adds what it sees when it explores, broadcasts the
set for g steps on average, and takes in every set that it hears. A robot that knows n, the number of robots,
declares infeasible as soon as it knows more than n tasks. It declares feasible after a quiet time without a
new name, q = c / lambda steps. lambda = n 2 r v share / area is how often the swarm finds a given task,
where share is the part of its time that a robot explores. If robots meet more rarely by radio, that rate is
taken. c grows with n; within walls q is twice as long. In long arenas, and where robots turn often, q is
longer: see `certified.steps_for`. A robot that does not know n counts the robots by name, too, and declares
after the quiet time, whatever the answer. Until then it has no opinion.

With ``hurry`` = h above 0, a robot that knows of fewer than h tasks per robot broadcasts for one step only:
it has little to tell, and soon explores again. Later it broadcasts for ``lasts`` steps on average; 0: g. The
quiet time is that of broadcasts of g steps or ``lasts`` / 2, whichever is longer.

``quiet`` sets q, in steps; 0: computed. With ``tolerates`` = f, the name of a robot or task that the robot
did not see counts once f + 1 different neighbours have sent it. Robots broadcast only names that count.

A Byzantine robot adds one task more than there are robots, or as many robots as there are tasks. A colluding
one adds the n + 1 - m tasks that the lie needs; to speak for feasible it sends m - n robots and nothing
else.

Message: for each task 1 bit and its position in 32 bits, and 1 bit at the end; without n, for each robot 1
bit and its id, and 1 bit at the end; with f > 0, the sender's id. Memory: the same, the end of the quiet
time, and for each name that does not count yet the neighbours that sent it, at most f.

References
----------
Our own. Names by f + 1 neighbours: Koo, "Broadcast in radio networks tolerating Byzantine adversarial
behavior", 2004.
"""

import math

from feasibee.strategies.census import POSITION_BITS, list_names, members
from feasibee.strategies.certified import (
    NEVER,
    sightings_to_flood,
    steps_given,
    steps_with,
    tasks_to_invent,
    told_enough,
    tolerated,
)
from feasibee.strategies.clock import has_come

BY_NAME = True
NEEDS_IDS = True
NEEDS_NAMES = True
SENDS_POSITIONS = True
STARTS_NEUTRAL = True
ONE_CLASS = True
PARAMETERS = {"quiet": 0.0, "tolerates": 0.0, "hurry": 0.0, "lasts": 0.0}
QUIET, TOLERATES, HURRY, LASTS = 0, 1, 2, 3
MEMBERS = 31
"""Number of a set's members in a word."""
ROUNDING = 1e-9
"""Least difference of a ratio of tasks to robots from `HURRY` that counts."""
NAMES, UNTIL, SETS = 0, 1, 2
"""Words of what is known: number of names, until when to wait for another; then the sets."""


def lasting(mind, gain):
    """Return the mean duration of broadcasting: one step in a hurry, then as given, or g."""
    feasible, hurry, lasts = mind.feasible_quality, mind.parameters[HURRY], mind.parameters[LASTS]
    if 1.0 - feasible < hurry * feasible - ROUNDING:
        return 0.0
    return min(lasts, float(NEVER)) if lasts > 0 else gain


def decide(mind, inbox):
    """Return the opinion that the robot has: declaring changes it."""
    return mind.opinion


def say(mind):
    """Return any opinion, so that the robot is not silent: its message holds knowledge only."""
    return max(mind.opinion, 0)


def robot_words(setting):
    """Return the size of the set of robots, which is counted only if n is unknown."""
    return 0 if setting.knows_count else (setting.robot_ids + MEMBERS - 1) // MEMBERS


def message_words(setting):
    """Return the size of the sets: of robots, and then of tasks."""
    return robot_words(setting) + (setting.task_ids + MEMBERS - 1) // MEMBERS


def words(setting):
    """Return the size of the sets, and of the list of who sent each name."""
    sets = message_words(setting)
    return SETS + sets + sets * MEMBERS * tolerated(setting, TOLERATES)


def start(known, me):
    """Add the robot itself to the robots that it knows, if it counts them."""
    if not me.setting.knows_count:
        known[SETS + me.id // MEMBERS] |= 1 << (me.id % MEMBERS)


def observe(known, thing, me):
    """Add a task in sight to what the robot knows, or a robot if it counts them."""
    if thing.is_robot and me.setting.knows_count:
        return
    first = SETS if thing.is_robot else SETS + robot_words(me.setting)
    known[first + thing.id // MEMBERS] |= 1 << (thing.id % MEMBERS)


def encode(message, known, me):
    """Write the sets of accepted names."""
    for k in range(len(message)):
        message[k] = known[SETS + k]


def lie(message, feasible, me):
    """Invent tasks, or robots where they are counted; colluding, as many as needed (model.md 6.16)."""
    robots, tasks, exact = me.setting.robots, me.setting.tasks, me.setting.colluding
    first = robot_words(me.setting)
    if feasible == 1 and exact:
        for k in range(len(message)):
            message[k] = 0
    if feasible == 0:
        for k in range(tasks, tasks + tasks_to_invent(me.setting)):
            message[first + k // MEMBERS] |= 1 << (k % MEMBERS)
    elif first > 0:
        for k in range(robots, robots + (max(tasks - robots, 0) if exact else tasks)):
            message[k // MEMBERS] |= 1 << (k % MEMBERS)


def merge(known, message, sender, me):
    """Add the names that enough neighbours have sent."""
    tolerates = tolerated(me.setting, TOLERATES)
    told = SETS + len(message)
    for k in range(len(message)):
        new = message[k] & ~known[SETS + k]
        while new != 0:
            member = (new & -new).bit_length() - 1
            new &= new - 1
            if told_enough(known, told + (k * MEMBERS + member) * tolerates, tolerates, sender):
                known[SETS + k] |= 1 << member


def robots_of(known, me):
    """Return the number of robots that the robot knows of."""
    if me.setting.knows_count:
        return me.setting.robots
    return members(known, SETS, robot_words(me.setting))


def tasks_of(known, me):
    """Return the number of tasks that the robot knows of."""
    first = robot_words(me.setting)
    return members(known, SETS + first, message_words(me.setting) - first)


def count(known, counts, me):
    """Count robots and tasks."""
    counts[0] = robots_of(known, me)
    counts[1] = tasks_of(known, me)


def describe(known, me):
    """Return the numbers of names in words."""
    robots = (
        f"{me.setting.robots} robots, as told" if me.setting.knows_count else f"{robots_of(known, me)} robots"
    )
    return f"{robots}, and {tasks_of(known, me)} tasks, by name; quiet until step {known[UNTIL]}"


def bits(message, me):
    """Return the length of the lists of names, and of the sender's id if receivers need it."""
    first = robot_words(me.setting)
    length = members(message, first, len(message) - first) * (1 + POSITION_BITS) + 1
    if first > 0:
        length += members(message, 0, first) * (1 + me.setting.id_bits) + 1
    return length + (me.setting.id_bits if tolerated(me.setting, TOLERATES) > 0 else 0)


def patience(robots, tolerates):
    """Return c, the number of times that the swarm would find a task in the quiet time.

    Fitted to n robots and n + 1 tasks, for n from 5 to 200: at most 2 wrong runs in 1,000 without Byzantine
    robots, 4 with 1 to 6 among 20 or 50, 14 with 1 among 5. With f of 2 f robots, no robot is ever sure.
    """
    flooding = sightings_to_flood(robots)
    if tolerates == 0:
        return flooding
    if robots <= 2 * tolerates:
        return math.inf
    return flooding + 0.9 * tolerates * robots / (robots - 2 * tolerates)


def quiet_steps(robots, setting):
    """Return q, the quiet time after which a robot that knows of so many robots is sure, in steps."""
    if setting.parameters[QUIET] > 0:
        return steps_given(setting.parameters[QUIET])
    return computed_steps(robots, setting)


def computed_steps(robots, setting):
    """Return the quiet time of robots that aren't given one, in steps."""
    lasts = max(setting.dissemination, min(setting.parameters[LASTS], float(NEVER)) / 2.0)
    exploring = setting.exploration / (setting.exploration + lasts)
    return steps_with(exploring, patience(robots, tolerated(setting, TOLERATES)), robots, setting)


def declare(known, me):
    """Return infeasible if there are more tasks than n; otherwise the answer, after the quiet time."""
    robots, tasks = robots_of(known, me), tasks_of(known, me)
    if me.setting.knows_count and tasks > robots:
        return 0
    if robots + tasks != known[NAMES]:
        known[NAMES] = robots + tasks
        known[UNTIL] = me.step + quiet_steps(robots, me.setting)
    if not has_come(known[UNTIL], me.step):
        return -1
    return 1 if robots >= tasks else 0


def layout(wire, message, sender, setting):
    """Go through the sender's id if receivers need it, and the names of robots, if counted, and of tasks."""
    tolerates, first = tolerated(setting, TOLERATES), robot_words(setting)
    sender = wire.number(sender, setting.id_bits, setting.robots) if tolerates > 0 else -1
    if first > 0:
        list_names(wire, message, 0, first, MEMBERS, 1, True, setting)
    list_names(wire, message, first, len(message), MEMBERS, 1, False, setting)
    return sender
