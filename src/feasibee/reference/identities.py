"""The ids of robots and tasks, which may collide, and their hashes."""

from __future__ import annotations

from functools import cache

from feasibee.model.purposes import IDENTITY
from feasibee.reference.draws import philox
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Thing


class Names:
    """The ids and hashes of one run's robots and tasks, and of those that Byzantine robots invent.

    Things are numbered: robots, tasks, invented robots (as many as tasks), invented tasks (one more than
    robots). Each task has a wrong name, too, with the highest ids.
    """

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        self._seed, self._run = seed, run
        self._robots, self._tasks = scenario.most
        self._wrong = scenario.setting.task_ids - self._tasks
        self._width = scenario.arena.size[0]
        self._exactly = scenario.setting.colluding and not (scenario.robots.classes or scenario.tasks.classes)
        bits = scenario.radio.id_bits
        self.id_bits = scenario.setting.id_bits
        ids = [self._word(i, 0) >> (32 - bits) if bits else i for i in range(self._robots)]
        first = {each: i for i, each in reversed(list(enumerate(ids)))}
        self._holder = [first[each] for each in ids]

    def inform(self, truth: int, robots: int, tasks: int) -> None:
        """Store the truth of a step and how many robots and tasks are there, which Byzantine robots know."""
        self.truth, self._robots_there, self._tasks_there = truth, robots, tasks

    def id(self, number: int) -> int:
        """Return a robot's id: the number of the first robot with the same random id."""
        return self._holder[number]

    def robot(self, number: int, kind: int, x: float, y: float) -> Thing:
        """Return a robot as others see it."""
        return Thing(True, self.id(number), kind, self.hash(self.id(number)), x, y)

    def me(self, number: int, kind: int) -> tuple[int, int, int]:
        """Return a robot's id, class and hash."""
        return self.id(number), kind, self.hash(self.id(number))

    def task(self, number: int, kind: int, x: float, y: float) -> Thing:
        """Return a task as robots see it."""
        return Thing(False, number, kind, self.hash(self._robots + number), x, y)

    def misnamed(self, number: int, kind: int, x: float, y: float) -> Thing:
        """Return a task under its wrong name: id and hash of its own, half the arena away (model.md 6.3)."""
        mark = self._word(self._robots + number, 2)
        beside = x + self._width / 2 if x < self._width / 2 else x - self._width / 2
        return Thing(False, self._wrong + number, kind, mark, beside, y)

    def inventions(self, feasible: int) -> list[Thing]:
        """Return the robots (feasible) or tasks that a Byzantine robot invents (model.md 6.12, 6.16)."""
        first = self._robots + self._tasks
        if feasible:
            number = self._tasks_there - (self._robots_there if self._exactly else 0)
            return [Thing(True, self._robots + k, 0, self.hash(first + k)) for k in range(number)]
        first += self._tasks
        number = self._robots_there + 1 - (self._tasks_there if self._exactly else 0)
        return [Thing(False, self._tasks + k, 0, self.hash(first + k)) for k in range(number)]

    @cache  # noqa: B019  # a run's names live as long as the run
    def hash(self, thing: int) -> int:
        """Return the hash of a robot or task: 32 random bits."""
        return self._word(thing, 1)

    def _word(self, thing: int, which: int) -> int:
        return philox(self._seed, self._run, thing, 0, IDENTITY)[which]
