"""The ways around walls to tasks in a place, in plain Python (model.md 6.25.15 to 6.25.17)."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from functools import cache

from feasibee.base.codes import exact
from feasibee.reference.place import QUARTERS, Ground, Pair

SIDE, CORNER = 5, 7
"""Fifths of a cell's side from a cell to one at its side, and to one at its corner."""


class Ways:
    """The ways to tasks in a place; at a distance of ``reach`` units, a robot has reached its task."""

    def __init__(self, ground: Ground, reach: float) -> None:
        self._ground = ground
        self._reach = math.floor(5 * exact(reach) / (ground.unit * 2**ground.bits))

    def length(self, place: Pair, task: Pair) -> int | None:
        """Return the way from a position to a task's; None if no way leads there."""
        return self._to(self._ground.cell(task)).get(self._ground.cell(place))

    def has_arrived(self, place: Pair, task: Pair) -> bool:
        """Return whether a robot at a position has reached a task."""
        length = self.length(place, task)
        return length is not None and length <= self._reach

    def step(self, place: Pair, task: Pair, longest: float) -> Pair:
        """Return the step of a robot towards a task to which it has a way."""
        ways, here = self._to(self._ground.cell(task)), self._ground.cell(place)
        chain = [here]
        while ways[chain[-1]] and (chain[-1] == here or self._off(place, chain[-1]) <= longest):
            chain.append(min(self._joined(chain[-1]), key=lambda cell: (ways[cell], cell[1], cell[0])))
        number = len(chain) - 1
        while True:
            step = self._towards(place, chain[number], longest)
            end = self._ground.cell((place[0] + step[0], place[1] + step[1]))
            is_shorter = end in ways and ways[end] < ways[here]
            if number <= 1 or (is_shorter and self._ground.ends(place, step) == QUARTERS):
                return step
            number //= 2

    @cache  # noqa: B019  # ways live as long as their swarm
    def _to(self, cell: Pair) -> dict[Pair, int]:
        """Return the ways of all cells from which one leads to a task in a cell."""
        first = cell if cell in self._ground.passable else self._ground.reached_from(cell)
        found: dict[Pair, int] = {}
        waiting = [(0, first)] if first else []
        while waiting:
            way, here = heapq.heappop(waiting)
            if here not in found:
                found[here] = way
                for other in self._joined(here):
                    side = here[0] == other[0] or here[1] == other[1]
                    heapq.heappush(waiting, (way + (SIDE if side else CORNER), other))
        return found

    def _joined(self, cell: Pair) -> Iterator[Pair]:
        """Yield the passable cells around a cell to which a robot goes straight."""
        column, row = cell
        for dx, dy in ((dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy):
            if {(column + dx, row), (column, row + dy), (column + dx, row + dy)} <= self._ground.passable:
                yield column + dx, row + dy

    def _centre(self, cell: Pair) -> Pair:
        """Return the middle of a cell."""
        column, row = (side * 2**self._ground.bits + 2**self._ground.bits // 2 for side in cell)
        return column, row

    def _off(self, place: Pair, cell: Pair) -> float:
        """Return how far the middle of a cell is from a position, as a double."""
        (x, y), (right, up) = place, self._centre(cell)
        return math.sqrt(float((right - x) ** 2 + (up - y) ** 2))

    def _towards(self, place: Pair, cell: Pair, longest: float) -> Pair:
        """Return the step towards the middle of a cell."""
        (x, y), (right, up) = place, self._centre(cell)
        off = self._off(place, cell)
        if off <= longest:
            return right - x, up - y
        return tuple(math.floor(longest * (part / off) + 0.5) for part in (right - x, up - y))  # type: ignore[return-value]
