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
POSITION_BITS = 32
MEMBERS = 31
"""Number of a set's members in a word."""


def quality(robots_known, tasks_known):
    """Return the share of robots among all things known, 1/2 without any."""
    if robots_known + tasks_known == 0:
        return 0.5
    return robots_known / (robots_known + tasks_known)


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps: g, whatever the quality."""
    return gain


def decide(mind, inbox):
    """Return feasible if there are as many robots as tasks, or more."""
    return 1 if mind.feasible_quality >= 0.5 else 0


def words(setting):
    """Return the size of all sets: one of ids for each class of robots, and then of tasks."""
    robots = setting.robot_classes * ((setting.robot_ids + MEMBERS - 1) // MEMBERS)
    return robots + setting.task_classes * ((setting.task_ids + MEMBERS - 1) // MEMBERS)


def start(known, me):
    """Add the robot itself to what it knows."""
    first = me.kind * ((me.setting.robot_ids + MEMBERS - 1) // MEMBERS)
    known[first + me.id // MEMBERS] |= 1 << (me.id % MEMBERS)


def observe(known, thing, me):
    """Add a robot or task in sight to what the robot knows."""
    robot_words = (me.setting.robot_ids + MEMBERS - 1) // MEMBERS
    if thing.is_robot:
        first = thing.kind * robot_words
    else:
        first = me.setting.robot_classes * robot_words
        first += thing.kind * ((me.setting.task_ids + MEMBERS - 1) // MEMBERS)
    known[first + thing.id // MEMBERS] |= 1 << (thing.id % MEMBERS)


def merge(known, message, sender, me):
    """Unite the sets."""
    for k in range(len(known)):
        known[k] |= message[k]


def count(known, counts, me):
    """Count the members of each set."""
    word = 0
    for k in range(len(counts)):
        ids = me.setting.robot_ids if k < me.setting.robot_classes else me.setting.task_ids
        for _ in range((ids + MEMBERS - 1) // MEMBERS):
            counts[k] += known[word].bit_count()
            word += 1


def bits(message, me):
    """Return the length of all sets."""
    first = max(me.setting.robot_classes * ((me.setting.robot_ids + MEMBERS - 1) // MEMBERS), 0)
    robots, tasks = 0, 0
    for k in range(first):
        robots += message[k].bit_count()
    for k in range(len(message) - first):  # with max above: the compiler vectorizes
        tasks += message[first + k].bit_count()
    robot_bits = 1 + me.setting.id_bits + (me.setting.robot_classes - 1).bit_length()
    task_bits = 1 + POSITION_BITS + (me.setting.task_classes - 1).bit_length()
    return robots * robot_bits + 1 + tasks * task_bits + 1
