"""Tally: each robot's sightings over its life, told on by all.

Each robot keeps a table of every robot's totals, n_j sightings of robots and m_j of tasks, by id. It adds to
its own row when it explores, broadcasts the table for g steps on average, and keeps the newest of each row
that it hears: as totals only grow, that is the larger. At the end of each dissemination it decides on the
sums: feasible if sum n_j > sum m_j, infeasible if less, for the scarcest set of skills; a tie keeps the
opinion. No sighting is counted twice.

Message: for each row that isn't zero 1 bit, the id and the totals at the width of the largest, 5 bits for
this width and 1 bit at the end. Memory: the same.

References
----------
Our own; a table whose rows only grow is the grow-only counter of Shapiro et al., "Conflict-free replicated
data types", 2011.
"""


def quality(robots_seen, tasks_seen):
    """Return the quality of *feasible*: the share of robots in all sightings, 1/2 without any."""
    if robots_seen + tasks_seen == 0:
        return 0.5
    return robots_seen / (robots_seen + tasks_seen)


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps: g, whatever the quality."""
    return gain


def decide(mind, inbox):
    """Return what the sums say; a tie keeps the opinion."""
    if mind.feasible_quality == 0.5:
        return mind.opinion
    return 1 if mind.feasible_quality > 0.5 else 0


class Knowledge:
    """The totals of each robot: sightings of robots and then of tasks, by class.

    Parameters
    ----------
    me : tuple of int
        Own id, class, and 32-bit mark.
    classes : tuple of int
        How many classes of robots and of tasks there are.
    """

    def __init__(self, me, classes):
        self.me = me[0]
        self.classes = classes
        self.totals = {}

    def see_robot(self, robot, kind, mark):
        """Count a robot in sight."""
        self._add(kind)

    def see_task(self, task, kind, mark):
        """Count a task in sight."""
        self._add(self.classes[0] + kind)

    def message(self):
        """Return what to broadcast."""
        return dict(self.totals)

    def lie(self, feasible, phantoms):
        """Return what a liar broadcasts: all that it saw were robots, or tasks."""
        own = sum(self.totals.get(self.me, ()))
        row = [0] * sum(self.classes)
        row[0 if feasible else self.classes[0]] = own
        return {**self.totals, self.me: tuple(row)} if own else self.message()

    def merge(self, message):
        """Take in what was heard."""
        for robot, heard in message.items():
            if robot == self.me:  # nobody knows it better
                continue
            known = self.totals.get(robot, heard)
            self.totals[robot] = tuple(max(pair) for pair in zip(known, heard, strict=True))

    def counted(self):
        """Return all sightings of robots and of tasks, by class."""
        sums = [sum(column) for column in zip(*self.totals.values(), strict=True)] or [0] * sum(self.classes)
        return sums[: self.classes[0]], sums[self.classes[0] :]

    def bits(self, message, id_bits):
        """Return the length of a message."""
        width = max((max(row) for row in message.values()), default=0).bit_length()
        return 5 + len(message) * (1 + id_bits + sum(self.classes) * width) + 1

    def _add(self, kind):
        row = list(self.totals.get(self.me, (0,) * sum(self.classes)))
        row[kind] += 1
        self.totals[self.me] = tuple(row)
