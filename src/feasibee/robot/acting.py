"""What one robot knows of tasks, and which one it goes to (model.md 6.25). Standard library only.

The same object runs in the reference simulation and on a real robot: give it what the robot sees of tasks
and what it hears of them, let it choose at the end of each step, and tell it how the task is that it reaches.

Examples
--------
A robot that hears of two free tasks goes to the nearer one, which another robot has taken meanwhile:

>>> from feasibee.robot.acting import Errand, Rules
>>> errand = Errand(Rules(start=40))
>>> errand.hear({3: 0, 8: 0})
>>> away = {3: 2.0, 8: 5.0}
>>> errand.choose(step=39, declared=-1, way=away.get)
>>> errand.target
-1
>>> errand.choose(step=40, declared=-1, way=away.get)
>>> errand.target
3
>>> errand.arrive(status=1)  # a robot of rank 1 has it
False
>>> errand.choose(step=41, declared=-1, way=away.get)
>>> errand.target, errand.arrive(status=0), errand.task
(8, True, 8)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

NONE: Final = -1
"""No task, no step, or not declared."""
FREE: Final = 0
"""Status of a task that nobody has; other statuses are ranks."""
GONE: Final = 2**30
"""Version of a task that has vanished."""
PATIENCE: Final = 20
"""Steps after which a robot without a task of its own by rank goes to the nearest."""

Way = Callable[[int], float | None]
"""Returns how far away a task is, or its square; None if the robot can't do it or get there."""


@dataclass(frozen=True, kw_only=True)
class Rules:
    """The rules by which one robot acts, which never change."""

    start: int = GONE
    """Step from the end of which on it acts."""
    by_word: bool = False
    """Whether it acts once it has declared feasible."""
    by_rank: bool = False
    """Whether it takes the task that comes after as many known ones as its number says."""
    tags: bool = False
    """Whether it marks a free task before it acts."""
    comes_free: bool = False
    """Whether a taken task may come free again, so that versions count."""
    number: int = 0
    """Number of the robot, from 0 on."""
    rank: int = 1
    """Rank of the robot: 1 for those with the most skills."""
    ranks: int = 1
    """Number of ranks."""
    count: int | None = None
    """Number of robots, if it knows that."""


class Errand:
    """What one robot knows of tasks, and what it has and goes to.

    Parameters
    ----------
    rules : Rules
        How it acts.
    """

    def __init__(self, rules: Rules) -> None:
        self.rules = rules
        self.known: dict[int, int] = {}
        """The version of each task that it knows (model.md 6.25.5)."""
        self.target = NONE
        """The task that it goes to."""
        self.task = NONE
        """The task at which it stands."""
        self.mark = NONE
        """The task that it has marked."""
        self.began = NONE
        """The step at whose end it began to act."""
        self.count = rules.count
        """Number of robots, if it knows that."""

    def status(self, task: int) -> int:
        """Return the status of a task as it knows it; -1 if it doesn't, or if the task has vanished."""
        version = self.known.get(task, GONE)
        return NONE if version == GONE else version % (self.rules.ranks + 1)

    def see(self, task: int, status: int | None) -> None:
        """Store the status of a task in sight; None if it is done."""
        self.known[task] = GONE if status is None else self._version(self.known.get(task), status)

    def _version(self, version: int | None, status: int) -> int:
        """Return the least version with a status, from a version on."""
        if version in (None, GONE) or not self.rules.comes_free:
            return status
        return version + (status - version) % (self.rules.ranks + 1)

    def news(self, lies: bool = False) -> dict[int, int]:
        """Return what it says: all versions; a Byzantine robot, that others have all tasks."""
        last = self.rules.ranks
        return {
            task: self._version(version, last) if lies and version != GONE else version
            for task, version in self.known.items()
        }

    def hear(self, news: Mapping[int, int]) -> None:
        """Keep the larger versions of those that a robot says (model.md 6.25.6)."""
        for task, version in news.items():
            self.known[task] = max(version, self.known.get(task, NONE))

    def choose(self, step: int, declared: int, way: Way) -> None:
        """Choose the target at the end of a step (model.md 6.25.8 to 6.25.10).

        Parameters
        ----------
        step : int
            The step that ends.
        declared : int
            What the robot has declared: 1 feasible, 0 infeasible, -1 nothing.
        way : callable
            Returns how far away a task is, or its square; None if the robot can't do it or get there.
        """
        self.target = NONE
        if self.task != NONE or declared == 0 or self._knows_too_many:
            return
        if step >= self.rules.start or (self.rules.by_word and declared == 1):
            self.began = step if self.began == NONE else self.began
        elif not self.rules.tags or self.mark != NONE:
            return
        if self.mark != NONE:
            self.target = self.mark if way(self.mark) is not None else NONE
        elif self.rules.by_rank and step < self.began + PATIENCE:
            self.target = self._of_rank(way)
        else:
            self.target = self._nearest(way)

    @property
    def _knows_too_many(self) -> bool:
        there = sum(version != GONE for version in self.known.values())
        return self.count is not None and there > self.count

    def _of_rank(self, way: Way) -> int:
        """Return the task that comes after as many known ones as its number, if it is free."""
        known = sorted(task for task, version in self.known.items() if version != GONE)
        task = known[self.rules.number] if self.rules.number < len(known) else NONE
        return task if self.status(task) == FREE and way(task) is not None else NONE

    def _nearest(self, way: Way) -> int:
        """Return the nearest free task."""
        free = [task for task in self.known if self.status(task) == FREE]
        ways = [(far, task) for task in free if (far := way(task)) is not None]
        return min(ways, default=(0, NONE))[1]

    def arrive(self, status: int | None) -> bool:
        """Store how the target is, which it has reached; return whether it gets it (model.md 6.25.3).

        It stands there if it acts, and else marks the task. The status is None if the task is done or
        gone.
        """
        task = self.target
        if status is None:
            self.known[task] = GONE
            return False
        gets = status == FREE or self.mark == task
        if gets:
            self.target = NONE
            self.task, self.mark = (task, NONE) if self.began != NONE else (NONE, task)
        self.see(task, self.rules.rank if gets else status)
        return gets

    def announce(self, robots: int) -> None:
        """Store how many robots there are if more have joined, if it knows n (model.md 6.25.8)."""
        if self.rules.count is not None:
            self.count = max(self.rules.count, robots)

    def lose(self) -> None:
        """Go on without its task or its mark."""
        self.task = self.mark = NONE
