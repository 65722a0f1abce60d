"""Roll call: a grow-only set of the ids of robots and tasks, which robots pass on."""

BY_NAME = True


def decide(mind, inbox):
    """Return feasible if at least as many robots as tasks are known."""
    return 1 if mind.feasible_quality >= 0.5 else 0


def words(setting):
    """Return the length of the row of words that a robot knows: one for each robot, then for each task."""
    return setting.robot_ids + setting.task_ids


def start(known, me):
    """Write what a robot knows at first: itself."""
    known[me.id] = 1


def observe(known, thing, me):
    """Add a robot or task in sight."""
    known[thing.id if thing.is_robot else me.setting.robot_ids + thing.id] = 1


def merge(known, message, sender, me):
    """Add what a neighbour broadcast. The order of messages, and hearing one twice, must not matter."""
    for k in range(len(known)):
        known[k] = max(known[k], message[k])


def count(known, counts, me):
    """Write the numbers of robots and of tasks that are known; they are rated when a phase ends."""
    for k in range(len(known)):
        counts[0 if k < me.setting.robot_ids else 1] += known[k]


def bits(message, me):
    """Return the length: 1 bit and an id, or 1 bit and a position in 32 bits, and 1 bit to end each list."""
    length = 2
    for k in range(len(message)):
        length += message[k] * (1 + (me.setting.id_bits if k < me.setting.robot_ids else 32))
    return length
