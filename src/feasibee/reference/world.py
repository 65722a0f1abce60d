"""The arena: places in fixed point, distances, collisions of discs, and placement at the start."""

from __future__ import annotations

import math
from collections.abc import Iterable

from feasibee.model.codes import ATTEMPTS, exact
from feasibee.model.purposes import (
    CENTRE_ROBOT,
    CENTRE_TASK,
    CLUSTER_ROBOT,
    CLUSTER_TASK,
    PLACE_ROBOT,
    PLACE_TASK,
    SCATTER_ROBOT,
    SCATTER_TASK,
    SITE,
)
from feasibee.reference.draws import TURN, choose, normal, philox, shuffle
from feasibee.scenario.fields import Placed
from feasibee.scenario.scenario import Scenario

Place = tuple[int, int]
ROBOT_PURPOSES = (PLACE_ROBOT, CENTRE_ROBOT, CLUSTER_ROBOT, SCATTER_ROBOT)
TASK_PURPOSES = (PLACE_TASK, CENTRE_TASK, CLUSTER_TASK, SCATTER_TASK)


class World:
    """A torus or a walled arena; lengths in whole units of fixed point (model.md 1.1, 6.1).

    On the torus the longer side is 2**32 units, in a walled arena 2**31.
    """

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        width, height = (exact(side) for side in scenario.arena.size)
        self.is_torus = scenario.arena.boundary == "torus"
        self.unit = max(width, height) / (TURN if self.is_torus else TURN // 2)
        self.size = (math.floor(width / self.unit), math.floor(height / self.unit))
        self.radius = math.ceil(exact(scenario.robots.diameter) / self.unit / 2)
        self.scenario = scenario
        self._seed, self._run = seed, run

    def in_units(self, place: Place) -> tuple[float, float]:
        """Return a place in units."""
        x, y = place
        return x * float(self.unit), y * float(self.unit)

    def squared(self, length: float) -> int:
        """Return the square of a length, rounded down."""
        return math.floor((exact(length) / self.unit) ** 2)

    def way(self, a: Place, b: Place) -> Place:
        """Return the difference of two places, the short way round on the torus."""
        differences = (q - p for p, q in zip(a, b, strict=True))
        if not self.is_torus:
            return tuple(differences)  # type: ignore[return-value]
        halves = zip(differences, self.size, strict=True)
        return tuple((d + side // 2) % side - side // 2 for d, side in halves)  # type: ignore[return-value]

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
        apart = (2 * self.radius) ** 2
        places: list[Place] = []
        for i in range(section.count):
            for place in self._candidates(section, i, self.radius, ROBOT_PURPOSES):
                if not section.avoid_collisions or section.placement == "points":
                    break
                if all(self.squared_distance(place, other) >= apart for other in places):
                    break
            else:
                return self._lattice(section.count)
            places.append(place)
        return places

    def task_place(self, i: int) -> Place:
        """Return the place of a task (model.md 1.3, 6.4, 6.17.4)."""
        return next(iter(self._candidates(self.scenario.tasks, i, 0, TASK_PURPOSES)))

    def joining_place(self, i: int, joined: int, others: Iterable[Place]) -> Place | None:
        """Return a place for a robot that joins as the given one of its number; None if none is free."""
        section, apart = self.scenario.robots, (2 * self.radius) ** 2
        for place in self._candidates(section, i, self.radius, ROBOT_PURPOSES, joined, True):
            if not section.avoid_collisions or all(
                self.squared_distance(place, other) >= apart for other in others
            ):
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
            yield self._held(self._given(section.points[i]), margin)
            return
        first = ATTEMPTS * joined
        for attempt in range(ATTEMPTS):
            if section.placement == "points":
                word = philox(self._seed, self._run, i, first + attempt, uniform)[0]
                yield self._held(self._given(section.points[choose(word, len(section.points))]), margin)
                continue
            if section.placement == "uniform":
                yield self._uniform(i, first + attempt, margin, uniform)
                continue
            word = philox(self._seed, self._run, i, joined, cluster)[0]
            middle = self._uniform(choose(word, section.clusters), 0, margin, centre)
            # The more attempts have failed, the wider it spreads.
            spread = math.floor(exact(section.spread) / self.unit) * (1 + attempt // 32)
            words = [
                word
                for part in range(6)
                for word in philox(self._seed, self._run, i, 6 * (first + attempt) + part, scatter)
            ]
            dx, dy = normal(words[:12], spread), normal(words[12:], spread)
            yield self._held((middle[0] + dx, middle[1] + dy), margin)

    def _uniform(self, i: int, attempt: int, margin: int, purpose: int) -> Place:
        x, y, _, _ = philox(self._seed, self._run, i, attempt, purpose)
        low = 0 if self.is_torus else margin
        width, height = (side - 2 * low for side in self.size)
        return low + choose(x, width), low + choose(y, height)

    def _given(self, point: tuple[float, float]) -> Place:
        x, y = (math.floor(exact(coordinate) / self.unit) for coordinate in point)
        return x, y

    def _held(self, place: Place, margin: int) -> Place:
        if self.is_torus:
            return place[0] % self.size[0], place[1] % self.size[1]
        x, y = (min(max(p, margin), side - margin) for p, side in zip(place, self.size, strict=True))
        return x, y

    def _lattice(self, count: int) -> list[Place]:
        """Return places on a square lattice over the whole arena, in random order."""
        step = 2 * self.radius
        columns, rows = self.size[0] // step, self.size[1] // step
        order = shuffle(count, lambda k: philox(self._seed, self._run, 0, k, SITE)[0])
        sites = (place * (columns * rows) // count for place in order)
        return [(self.radius + site % columns * step, self.radius + site // columns * step) for site in sites]
