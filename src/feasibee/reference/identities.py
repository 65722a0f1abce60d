"""What robots and tasks are called: ids, which may collide, and the hashes of what a sketch notes."""

from __future__ import annotations

from functools import cache

from feasibee.model.purposes import IDENTITY
from feasibee.reference.draws import philox
from feasibee.scenario.scenario import Scenario

Name = tuple[int, int, int]


class Names:
    """The names of one run's robots and tasks, and of what liars invent.

    Things are numbered: robots, tasks, invented robots (as many as tasks), invented tasks (one more than
    robots).
    """

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        self._seed, self._run = seed, run
        self._robots, self._tasks = scenario.robots.count, scenario.tasks.count
        bits = scenario.radio.id_bits
        self.id_bits = bits or max(1, (self._robots - 1).bit_length())
        ids = [self._word(i, 0) >> (32 - bits) if bits else i for i in range(self._robots)]
        first = {each: i for i, each in reversed(list(enumerate(ids)))}
        self._holder = [first[each] for each in ids]

    def id(self, number: int) -> int:
        """Return a robot's id: the number of the first robot that has the same."""
        return self._holder[number]

    def robot(self, number: int, kind: int) -> Name:
        """Return a robot's id, class and mark."""
        return self.id(number), kind, self.mark(self.id(number))

    def task(self, number: int, kind: int) -> Name:
        """Return a task's name, class and mark."""
        return number, kind, self.mark(self._robots + number)

    def inventions(self, feasible: int) -> list[tuple[int, int]]:
        """Return name and mark of each robot, or task, that a liar invents to make its point."""
        first = self._robots + self._tasks
        if feasible:
            return [(k, self.mark(k)) for k in range(first, first + self._tasks)]
        first += self._tasks
        return [(k, self.mark(k)) for k in range(first, first + self._robots + 1)]

    @cache  # noqa: B019  # a run's names live as long as the run
    def mark(self, thing: int) -> int:
        """Return the hash of a thing: 32 random bits."""
        return self._word(thing, 1)

    def _word(self, thing: int, which: int) -> int:
        return philox(self._seed, self._run, thing, 0, IDENTITY)[which]
