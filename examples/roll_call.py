"""Roll call: a grow-only set of the ids of robots and tasks, which robots pass on."""

BY_NAME = True


def decide(mind, inbox):
    """Return feasible if at least as many robots as tasks are known."""
    return 1 if mind.feasible_quality >= 0.5 else 0


def words(setting):
    """Return the length of the row: a word for each id of a robot, and then of a task."""
    return setting.robot_ids + setting.task_ids


def start(known, me):
    """Add the robot itself to what it knows."""
    known[me.id] = 1


def observe(known, thing, me):
    """Add a robot or task in sight to what the robot knows."""
    known[thing.id if thing.is_robot else me.setting.robot_ids + thing.id] = 1


def merge(known, message, sender, me):
    """Unite what is known with what a neighbour knows."""
    for k in range(len(known)):
        known[k] = max(known[k], message[k])


def count(known, counts, me):
    """Count the robots and the tasks."""
    for k in range(len(known)):
        counts[0 if k < me.setting.robot_ids else 1] += known[k]


def bits(message, me):
    """Return the length: 1 bit and an id, or 1 bit and a position in 32 bits, and 1 bit to end each list."""
    length = 2
    for k in range(len(message)):
        length += message[k] * (1 + (me.setting.id_bits if k < me.setting.robot_ids else 32))
    return length
