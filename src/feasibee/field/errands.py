"""The errand of a robot in a process of its own: where its tasks are, and what its body did."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from feasibee.base.errors import FeasibeeError
from feasibee.robot.acting import NONE, Errand, Rules
from feasibee.strategies import roster
from feasibee.strategies.contract import Setting, Thing

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario

_ROSTER: Final[Any] = roster
"""The strategy's file, whose functions have no types."""
REACHED, LOST, JOINED = "reached", "lost", "joined"
"""What a body reports to its robot: it has reached its target, has lost its task, or more are there."""


def check_tasks(scenario: Scenario) -> None:
    """Raise an error if robots act on tasks put at points, of which messages of a field can't say where."""
    if scenario.acts and scenario.puts:
        rule = "robots of a field that act know only the tasks of the start and those at random"
        raise FeasibeeError(f"events = {len(scenario.events)} in all: {rule}; leave at out of them")


class RemoteErrand(Errand):
    """The errand of a robot in another process, as far as its body knows it, and what the body did of it."""

    def __init__(self, rules: Rules) -> None:
        super().__init__(rules)
        self.deeds: list[list[Any]] = []
        """All that has happened: REACHED with a status, LOST with -1, JOINED with a number."""
        self.heeded = 0
        """Number of deeds that the robot knew when it last reported."""

    def arrive(self, status: int | None) -> bool:
        """Let the robot know that it has reached its target, which has this status."""
        self.deeds.append([REACHED, NONE if status is None else status])
        return super().arrive(status)

    def lose(self) -> None:
        """Let the robot know that it doesn't have its task any more."""
        self.deeds.append([LOST, NONE])
        super().lose()

    def announce(self, robots: int) -> None:
        """Let the robot know how many robots there are, if that is new to it."""
        before = self.count
        super().announce(robots)
        if self.count is not None and self.count != before:
            self.deeds.append([JOINED, self.count])

    def report(self, goes: Sequence[int], tasks: Mapping[int, Any]) -> None:
        """Keep the target that the robot reports, unless it doesn't know yet what its body did."""
        target, began, heeded = goes
        self.heeded = min(heeded, len(self.deeds))
        if heeded == len(self.deeds) and self.task == NONE and (target == NONE or target in tasks):
            self.target, self.began = target, began


class Errands:
    """The errand of one robot, whose tasks have numbers in a world, or else their places as names.

    ``orders`` are what the robot is sent when it joins: ``rules``, which classes of tasks it is ``able`` to
    do, the ``frame`` of places, and place and class of the world's ``tasks``.
    """

    def __init__(self, orders: Mapping[str, Any], setting: Setting) -> None:
        self.errand = Errand(Rules(**orders["rules"]))
        self.done = 0
        """Number of deeds of its body that it knows."""
        self._able, self._setting = orders["able"], setting
        self._unit, self._width, self._height, self._is_torus = orders["frame"]
        self._tasks: Sequence[Sequence[int]] | None = orders["tasks"]
        self._kinds: dict[int, int] = {}
        self._place = 0, 0
        self._ways: Mapping[int, int] | None = None

    def move_to(self, place: tuple[float, float]) -> None:
        """Store the robot's position, in units."""
        x, y = (round(each / self._unit) for each in place)
        self._place = x, y

    def name(self, thing: Thing, number: int) -> int:
        """Return the name of a task in sight; -1 if it has none."""
        if self._tasks is not None or number == NONE:
            return number if self._tasks is not None and number < len(self._tasks) else NONE
        name = int(_ROSTER.place_of(thing, self._setting))
        self._kinds[name] = thing.kind
        return name

    def place(self, name: int) -> tuple[int, int]:
        """Return where a task is, in the frame's unit."""
        if self._tasks is not None:
            return self._tasks[name][0], self._tasks[name][1]
        across, along = divmod(name, _ROSTER.SIDE)
        x, y = (
            (part + 0.5) / _ROSTER.SIDE * side
            for part, side in ((across, self._setting.width), (along, self._setting.height))
        )
        return round(x / self._unit), round(y / self._unit)

    def way(self, name: int) -> int | None:
        """Return how far a task is, squared or around walls; None if the robot can't do it or get there."""
        if self._ways is not None:
            return self._ways.get(name)
        kind = self._kinds.get(name, 0) if self._tasks is None else self._tasks[name][2]
        if not self._able[kind]:
            return None
        total = 0
        for own, there, side in zip(self._place, self.place(name), (self._width, self._height), strict=True):
            way = there - own
            if self._is_torus:
                way = (way + side // 2) % side - side // 2
            total += way * way
        return total

    def hear(self, news: Iterable[tuple[int, int]]) -> None:
        """Keep what a robot says of tasks that there can be."""
        there = None if self._tasks is None else len(self._tasks)
        self.errand.hear({name: version for name, version in news if there is None or name < there})

    def sense(self, told: Mapping[str, Any]) -> None:
        """Keep what a sense says of walls and of the body, as `node.WORK` names it."""
        if "ways" in told:
            self._ways = dict(told["ways"])
        if "acts" in told:
            self._heed(*told["acts"])

    def see(self, seen: Iterable[tuple[Thing, int]], taken: Iterable[Any]) -> None:
        """Store how the tasks in sight are: free, unless they are among those taken, by number."""
        ranks = dict(taken)
        for thing, number in seen:
            if not thing.is_robot and (name := self.name(thing, number)) != NONE:
                self.errand.see(name, None if ranks.get(number) == NONE else ranks.get(number, 0))

    def _heed(self, first: int, deeds: Sequence[Sequence[Any]]) -> None:
        """Store what the body did, from deed number ``first`` on; the robot knows some of them already."""
        for what, status in deeds[max(0, self.done - first) :]:
            self.done += 1
            if what == JOINED:
                self.errand.announce(status)
            elif what == LOST:
                self.errand.lose()
            elif self.errand.target != NONE:
                self.errand.arrive(None if status == NONE else status)

    @property
    def goes(self) -> list[int]:
        """What the robot reports to its body: its target, since when it acts, and which deeds it knows."""
        return [self.errand.target, self.errand.began, self.done]

    @property
    def in_units(self) -> dict[str, Any]:
        """Where its driver shall go, in units, and whether it shall stand."""
        target = self.errand.target
        go = None if target == NONE else [each * self._unit for each in self.place(target)]
        return {"go": go, "stand": self.errand.task != NONE}
