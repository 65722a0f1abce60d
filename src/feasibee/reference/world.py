"""The arena: places in fixed point, distances, collisions and placement, and the names of what is in it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cache

from feasibee.base import purposes
from feasibee.base.codes import ATTEMPTS, exact
from feasibee.reference.draws import TURN, choose, normal, philox, shuffle
from feasibee.reference.place import ground_of
from feasibee.scenario.fields import Placed
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Thing

Place = tuple[int, int]
ROBOT_PURPOSES = (purposes.PLACE_ROBOT, purposes.CENTRE_ROBOT, purposes.CLUSTER_ROBOT, purposes.SCATTER_ROBOT)
TASK_PURPOSES = (purposes.PLACE_TASK, purposes.CENTRE_TASK, purposes.CLUSTER_TASK, purposes.SCATTER_TASK)


class World:
    """A torus or a walled arena; lengths in whole units of fixed point (model.md 1.1, 6.1).

    On the torus the longer side is 2**32 units, in a walled arena 2**31.
    """

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        width, height = (exact(side) for side in scenario.arena.size)
        self.is_torus = scenario.arena.boundary == "torus"
        self.ground = ground_of(scenario)
        self.unit = max(width, height) / (TURN if self.is_torus else TURN // 2)
        if self.ground:
            self.unit = self.ground.unit
        self.size = (math.floor(width / self.unit), math.floor(height / self.unit))
        self.radius = math.ceil(exact(scenario.robots.diameter) / self.unit / 2)
        self.scenario = scenario
        self.run = (seed, run)

    def draw(self, number: int, counter: int, purpose: int) -> tuple[int, int, int, int]:
        """Return the random words of a coordinate of this run."""
        return philox(*self.run, number, counter, purpose)

    def in_units(self, place: Place) -> tuple[float, float]:
        """Return a place in units."""
        x, y = place
        return x * float(self.unit), y * float(self.unit)

    def squared(self, length: Fraction) -> int:
        """Return the square of a length, rounded down."""
        return math.floor((length / self.unit) ** 2)

    def way(self, a: Place, b: Place) -> Place:
        """Return the difference of two places, the short way round on the torus."""
        x, y = b[0] - a[0], b[1] - a[1]
        if not self.is_torus:
            return x, y
        width, height = self.size
        return (x + width // 2) % width - width // 2, (y + height // 2) % height - height // 2

    def squared_distance(self, a: Place, b: Place) -> int:
        """Return the square of the distance of two places."""
        dx, dy = self.way(a, b)
        return dx * dx + dy * dy

    def moved(self, place: Place, velocity: Place) -> Place:
        """Return the place after a step: wrapped on the torus, possibly outside within walls."""
        x, y = place[0] + velocity[0], place[1] + velocity[1]
        return (x % self.size[0], y % self.size[1]) if self.is_torus else (x, y)

    def meet(self, way: Place, approach: Place) -> bool:
        """Return whether two discs overlap at some moment of a step (model.md 6.2).

        ``way`` is the difference of their places at the start, ``approach`` that of their velocities.
        """
        least = (2 * self.radius) ** 2
        along = way[0] * approach[0] + way[1] * approach[1]
        length = approach[0] ** 2 + approach[1] ** 2
        if along >= 0:  # they part
            return way[0] ** 2 + way[1] ** 2 < least
        if -along >= length:  # they come closer until the end
            return (way[0] + approach[0]) ** 2 + (way[1] + approach[1]) ** 2 < least
        across = way[0] * approach[1] - way[1] * approach[0]
        return across**2 < least * length  # they pass

    def robot_places(self) -> list[Place]:
        """Return the first places of the robots, apart if they avoid collisions (model.md 1.2, 6.4)."""
        section = self.scenario.robots
        places: list[Place] = []
        for i in range(section.count):
            candidates = self._candidates(section, i, self.radius, ROBOT_PURPOSES)
            place = self._free(candidates, [] if section.placement == "points" else places)
            if place is None:
                return self._lattice(section.count)
            places.append(place)
        return places

    def task_place(self, i: int) -> Place:
        """Return the place of a task (model.md 1.3, 6.4, 6.17.4)."""
        return next(iter(self._candidates(self.scenario.tasks, i, 0, TASK_PURPOSES)))

    def place_at(self, point: tuple[float, float], margin: int = 0) -> Place:
        """Return the place at a point, within a margin of walls."""
        return self._held(self._given(point), margin)

    def free_place_at(self, point: tuple[float, float], others: Iterable[Place]) -> Place | None:
        """Return the place at a point for a robot (model.md 6.17.12); None if it isn't free."""
        return self._free([self.place_at(point, self.radius)], others)

    def chains(self, tasks: Mapping[int, Place]) -> dict[int, int]:
        """Return for each task the lowest number in its chain of tasks under one name (model.md 6.24)."""
        merged = exact(self.scenario.sensing.merged)
        limit = self.squared(merged) if merged >= 0 else -1
        near = {
            i: [j for j, other in tasks.items() if i == j or self.squared_distance(place, other) <= limit]
            for i, place in tasks.items()
        }
        lowest = {i: i for i in tasks}
        while lowest != (spread := {i: min(lowest[j] for j in others) for i, others in near.items()}):
            lowest = spread
        return lowest

    def joining_place(self, i: int, joined: int, others: Iterable[Place]) -> Place | None:
        """Return a place for a robot that joins as the given one of its number; None if none is free."""
        candidates = self._candidates(self.scenario.robots, i, self.radius, ROBOT_PURPOSES, joined, True)
        return self._free(candidates, others)

    def _free(self, candidates: Iterable[Place], others: Iterable[Place]) -> Place | None:
        """Return the first place that is apart from others, if robots avoid collisions; None if none is."""
        avoided, apart = others if self.scenario.robots.avoid_collisions else (), (2 * self.radius) ** 2
        for place in candidates:
            if all(self.squared_distance(place, other) >= apart for other in avoided):
                return place
        return None

    def _candidates(
        self,
        section: Placed,
        i: int,
        margin: int,
        purposes: tuple[int, int, int, int],
        joined: int = 0,
        joins: bool = False,
    ) -> Iterable[Place]:
        """Yield the places drawn for a robot or task; places outside are moved to the wall."""
        uniform, centre, cluster, scatter = purposes
        if section.placement == "points" and not joins and i < len(section.points):
            yield self.place_at(section.points[i], margin)
            return
        first = ATTEMPTS * joined
        for attempt in range(ATTEMPTS):
            if section.placement == "points":
                word = self.draw(i, first + attempt, uniform)[0]
                yield self.place_at(section.points[choose(word, len(section.points))], margin)
                continue
            if self.ground:
                yield self._on_ground(section, i, first + attempt, uniform)
                continue
            if section.placement == "uniform":
                yield self._uniform(i, first + attempt, margin, uniform)
                continue
            word = self.draw(i, joined, cluster)[0]
            middle = self._uniform(choose(word, section.clusters), 0, margin, centre)
            # The more attempts have failed, the wider it spreads.
            spread = math.floor(exact(section.spread) / self.unit) * (1 + attempt // 32)
            words = [
                word for part in range(6) for word in self.draw(i, 6 * (first + attempt) + part, scatter)
            ]
            dx, dy = normal(words[:12], spread), normal(words[12:], spread)
            yield self._held((middle[0] + dx, middle[1] + dy), margin)

    def _uniform(self, i: int, attempt: int, margin: int, purpose: int) -> Place:
        x, y, _, _ = self.draw(i, attempt, purpose)
        low = 0 if self.is_torus else margin
        width, height = (side - 2 * low for side in self.size)
        return low + choose(x, width), low + choose(y, height)

    def _on_ground(self, section: Placed, i: int, attempt: int, purpose: int) -> Place:
        """Return a place in a cell of the robot's or task's piece and zone (model.md 6.20.7)."""
        ground = self.ground
        assert ground is not None
        pieces = ground.robot_pieces if section is self.scenario.robots else ground.task_pieces
        cells = ground.stands(section.zone)[pieces[i] if i < len(pieces) else ground.robot_pieces[0]]
        cell, x, y, _ = self.draw(i, attempt, purpose)
        column, row = cells[choose(cell, len(cells))]
        width = 2**ground.bits
        return column * width + choose(x, width), row * width + choose(y, width)

    def _given(self, point: tuple[float, float]) -> Place:
        x, y = (math.floor(exact(coordinate) / self.unit) for coordinate in point)
        return x, y

    def _held(self, place: Place, margin: int) -> Place:
        if self.is_torus:
            return place[0] % self.size[0], place[1] % self.size[1]
        edge = max(margin, 1) if self.ground else margin  # what stands on the far wall is in no cell
        x, y = (min(max(p, margin), side - edge) for p, side in zip(place, self.size, strict=True))
        return x, y

    def _lattice(self, count: int) -> list[Place]:
        """Return places on a square lattice over the whole arena, in random order, or over the ground."""
        if self.ground:
            return self.ground.lattice
        step = 2 * self.radius
        columns, rows = self.size[0] // step, self.size[1] // step
        order = shuffle(count, lambda k: self.draw(0, k, purposes.SITE)[0])
        sites = (place * (columns * rows) // count for place in order)
        return [(self.radius + site % columns * step, self.radius + site // columns * step) for site in sites]


class Names:
    """The ids, which may collide, and the hashes of a run's robots and tasks, and of invented ones.

    Things are numbered: robots, tasks, invented robots (as many as tasks), invented tasks (one more than
    robots). Each task has a wrong name, too, with the highest ids.
    """

    def __init__(self, world: World) -> None:
        scenario, self._draw = world.scenario, world.draw
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
        return Thing(True, *self.me(number, kind), x, y)

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
        return self._draw(thing, 0, purposes.IDENTITY)[which]
