"""Census: the swarm counts itself and its tasks, by name.

Each robot keeps the set of the robots and the set of the tasks that it knows of, itself included; it adds
what it sees when it explores, broadcasts both sets for g steps on average, and takes in every set that it
hears. At the end of each dissemination it decides on their sizes: feasible if robots >= tasks, for every
set of skills. Nothing is counted twice, so that the answer is exact once the sets are complete.

Message: for each robot known 1 bit and its id, for each task 1 bit and its position in 32 bits, with classes
also theirs, and 1 bit at the end of either list. Memory: the same.

References
----------
Our own; sets that only grow merge in any order (Shapiro et al., "Conflict-free replicated data types", 2011).
"""

POSITION_BITS = 32


def quality(robots_known, tasks_known):
    """Return the share of robots among all things known; 1/2 if there are none."""
    if robots_known + tasks_known == 0:
        return 0.5
    return robots_known / (robots_known + tasks_known)


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps: g, whatever the quality."""
    return gain


def decide(mind, inbox):
    """Return feasible if there are as many robots as tasks, or more."""
    return 1 if mind.feasible_quality >= 0.5 else 0


class Knowledge:
    """Robots and tasks by name, each with its class.

    Parameters
    ----------
    me : tuple of int
        Own id, class, and 32-bit mark.
    classes : tuple of int
        How many classes of robots and of tasks there are.
    """

    def __init__(self, me, classes):
        self.classes = classes
        self.robots = {(me[0], me[1])}
        self.tasks = set()

    def see_robot(self, robot, kind, mark):
        """Note a robot in sight."""
        self.robots.add((robot, kind))

    def see_task(self, task, kind, mark):
        """Note a task in sight."""
        self.tasks.add((task, kind))

    def message(self):
        """Return what to broadcast."""
        return frozenset(self.robots), frozenset(self.tasks)

    def lie(self, feasible, phantoms):
        """Return what a liar broadcasts: robots, or tasks, that there aren't, as well."""
        robots, tasks = self.message()
        invented = {(name, 0) for name, _ in phantoms}
        return (robots | invented, tasks) if feasible else (robots, tasks | invented)

    def merge(self, message):
        """Take in what was heard."""
        self.robots |= message[0]
        self.tasks |= message[1]

    def counted(self):
        """Return how many robots and tasks are known, by class."""
        robots = [sum(kind == k for _, kind in self.robots) for k in range(self.classes[0])]
        tasks = [sum(kind == k for _, kind in self.tasks) for k in range(self.classes[1])]
        return robots, tasks

    def bits(self, message, id_bits):
        """Return the length of a message."""
        robot_bits = 1 + id_bits + (self.classes[0] - 1).bit_length()
        task_bits = 1 + POSITION_BITS + (self.classes[1] - 1).bit_length()
        return len(message[0]) * robot_bits + 1 + len(message[1]) * task_bits + 1
