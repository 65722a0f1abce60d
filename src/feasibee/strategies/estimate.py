"""Estimate: a tally that knows that nobody sees itself.

The table, the messages and the memory are those of `tally`. A robot that has k rows in its table knows of k
robots. Each saw only the k - 1 others, so that the number of tasks is about

    (k - 1) sum m_j / sum n_j

and the tasks are feasible if this is less than k + 1/2, halfway to the first number that isn't, and
infeasible if it is more; at k + 1/2 exactly, a tie, a robot keeps its opinion. So the swarm is about as often
right with one task too many as with just enough robots; a tally is neutral at m = n - 1.

References
----------
Our own.
"""

from feasibee.strategies import tally

quality = tally.quality
dissemination = tally.dissemination
decide = tally.decide


class Knowledge(tally.Knowledge):
    """The table of a tally, and both sides of the comparison made of it."""

    def counted(self):
        """Return the sums, times 2k + 1 for robots and 2k - 2 for tasks, by class."""
        robots, tasks = super().counted()
        known = len(self.totals)
        return [(2 * known + 1) * each for each in robots], [(2 * known - 2) * each for each in tasks]
