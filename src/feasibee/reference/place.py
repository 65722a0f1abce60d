"""A place in plain Python: passable cells, pieces, steps that avoid walls, lines that cross them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import cache, cached_property, lru_cache

from feasibee.base.codes import exact
from feasibee.scenario.fields import Placed
from feasibee.scenario.ground import Plan
from feasibee.scenario.scenario import Scenario

QUARTERS = 4
"""Parts of a step whose ends must be in passable cells (model.md 6.20.4)."""

Pair = tuple[int, int]


class Ground:
    """The cells of a place, pairs of column and row; robots' size and speed decide which are passable."""

    def __init__(self, plan: Plan, scenario: Scenario) -> None:
        rows, columns = plan.walls.shape
        self.size = (columns, rows)
        self.bits = 0
        while max(self.size) * 2 ** (self.bits + 1) <= 2**31:
            self.bits += 1
        self.unit = plan.cell / 2**self.bits
        self._radius = math.ceil(exact(scenario.robots.diameter) / self.unit / 2)
        self._step = math.ceil(exact(scenario.robots.speed) / self.unit) + 16
        self._plan, self._scenario = plan, scenario
        self.walls = {cell for cell in self._all() if plan.walls[cell[1], cell[0]]}
        self.passable = set(self._all()) - set(self._near_walls())
        self.piece = self._pieces()
        self.robot_pieces = self._shares(scenario.robots, set(self.piece.values()))
        self.task_pieces = self._shares(scenario.tasks, set(self.robot_pieces))

    def _all(self) -> Iterator[Pair]:
        """Yield all cells, row by row."""
        return ((column, row) for row in range(self.size[1]) for column in range(self.size[0]))

    def cell(self, place: Pair) -> Pair:
        """Return the cell of a position."""
        return place[0] // 2**self.bits, place[1] // 2**self.bits

    def _gap(self, a: Pair, b: Pair) -> int:
        """Return the square of the distance of two cells, in units of fixed point."""
        dx, dy = (max(abs(p - q) - 1, 0) << self.bits for p, q in zip(a, b, strict=True))
        return dx * dx + dy * dy

    def _around(self, cell: Pair, squared: Fraction) -> Iterator[Pair]:
        """Yield the cells nearer to a cell than the root of a square, row by row, also beyond the edges."""
        column, row = cell
        return ((column + across, row + up) for across, up in self._steps_within(squared))

    @cache  # noqa: B019  # compared once, not for each cell: a map of 600 by 300 cells took half a minute
    def _steps_within(self, squared: Fraction) -> list[Pair]:
        """Return the differences of columns and rows to the cells nearer than the root of a square."""
        reach = math.isqrt(math.ceil(squared / 4**self.bits)) + 2
        span = range(-reach, reach + 1)
        return [(across, up) for up in span for across in span if self._gap((0, 0), (across, up)) < squared]

    @property
    def _clearance(self) -> Fraction:
        """The square of the least distance from a wall (model.md 6.20.3)."""
        return Fraction(64 * self._radius * self._radius + self._step * self._step, 64)

    def _near_walls(self) -> Iterator[Pair]:
        """Yield the cells that are too near to walls, no-go cells or the edges."""
        columns, rows = self.size
        for row in range(-1, rows + 1):
            for column in range(-1, columns + 1):
                if self._is_closed((column, row)):
                    yield from self._around((column, row), self._clearance)

    def _is_closed(self, cell: Pair) -> bool:
        """Return whether robots can't enter a cell: a wall, a no-go cell, or beyond the edges."""
        (column, row), (columns, rows) = cell, self.size
        if not (0 <= column < columns and 0 <= row < rows):
            return True
        return bool(self._plan.walls[row, column] or self._plan.keepout[row, column])

    def _pieces(self) -> dict[Pair, int]:
        """Return the piece of each passable cell, from 1 on (model.md 6.20.6)."""
        found: dict[Pair, int] = {}
        quarter = Fraction(self._step, 4) ** 2 + Fraction(1, 16)  # at most a quarter of a step, not less than
        number = 0
        for first in self._all():
            if first not in self.passable or first in found:
                continue
            number += 1
            found[first], new = number, [first]
            while new:
                for cell in self._around(new.pop(), quarter):
                    if cell in self.passable and cell not in found:
                        found[cell] = number
                        new.append(cell)
        return found

    @cache  # noqa: B019  # a ground lives as long as its scenario
    def stands(self, zone: str | None) -> dict[int, list[Pair]]:
        """Return the cells of each piece in which things may be placed, row by row (model.md 6.20.7)."""
        mask = self._plan.zones[zone] if zone else None
        found: dict[int, list[Pair]] = {}
        for column, row in self._all():
            if (column, row) in self.piece and (mask is None or mask[row, column]):
                found.setdefault(self.piece[column, row], []).append((column, row))
        return found

    def _shares(self, section: Placed, allowed: set[int]) -> list[int]:
        """Return the piece of each robot or task of the start; 0 if no robot reaches it (model.md 6.20.7)."""
        if section.placement == "points":
            points = ((exact(x) / self._plan.cell, exact(y) / self._plan.cell) for x, y in section.points)
            return [self._nearest((math.floor(x), math.floor(y))) for x, y in points]
        areas = {piece: len(cells) for piece, cells in self.stands(section.zone).items() if piece in allowed}
        given, total = dict.fromkeys(areas, 0), sum(areas.values())
        found = []
        for k in range(section.count):  # type: ignore[attr-defined]  # robots and tasks have it
            best = max(sorted(areas), key=lambda piece: areas[piece] * (k + 1) - given[piece] * total)
            given[best] += 1
            found.append(best)
        return found

    def _nearest(self, cell: Pair) -> int:
        """Return the piece from which robots reach a task in a cell; 0 if none do (model.md 6.20.9)."""
        first = self.reached_from(cell)
        return self.piece[first] if first else 0

    def reached_from(self, cell: Pair) -> Pair | None:
        """Return the passable cell nearest to a task's, if that is near enough (model.md 6.20.9)."""
        cell = min(cell[0], self.size[0] - 1), min(cell[1], self.size[1] - 1)
        near = [
            each for each in self._around(cell, 4 * self._clearance + Fraction(1, 16)) if each in self.piece
        ]
        return min(near, key=lambda each: self._gap(cell, each), default=None)

    @cached_property
    def lattice(self) -> list[Pair]:
        """The site of each robot if they don't find places otherwise (model.md 6.20.8)."""
        sites: dict[int, list[Pair]] = {}
        allowed = self.stands(self._scenario.robots.zone)
        of_cell = {cell: piece for piece, cells in allowed.items() for cell in cells}
        right, top = (side * 2**self.bits for side in self.size)
        for y in range(self._radius, top, 2 * self._radius):
            for x in range(self._radius, right, 2 * self._radius):
                if self.cell((x, y)) in of_cell:
                    sites.setdefault(of_cell[self.cell((x, y))], []).append((x, y))
        numbers = {piece: self.robot_pieces.count(piece) for piece in sites}
        before = dict.fromkeys(sites, 0)
        found = []
        for piece in self.robot_pieces:
            found.append(sites[piece][before[piece] * len(sites[piece]) // numbers[piece]])
            before[piece] += 1
        return found

    def ends(self, place: Pair, step: Pair) -> int:
        """Return how many of the four quarters of a step end in passable cells (model.md 6.20.4)."""
        quarter, half = ([part // size for part in step] for size in (4, 2))
        three = [a + b for a, b in zip(quarter, half, strict=True)]
        ways = (quarter, half, three, step)
        return sum(self.cell((place[0] + u, place[1] + v)) in self.passable for u, v in ways)

    def walls_between(self, a: Pair, b: Pair) -> int:
        """Return in how many stretches the line between the centres of two positions' cells touches walls.

        A number from 0 to 1 says where on the line. A wall cell and its border take an interval of it.
        Intervals that touch are one stretch.
        """
        start, end = self.cell(a), self.cell(b)
        columns, rows = (range(min(p, q), max(p, q) + 1) for p, q in zip(start, end, strict=True))
        wall_cells = ((column, row) for column in columns for row in rows if (column, row) in self.walls)
        intervals = sorted(filter(None, (crossing(start, end, cell) for cell in wall_cells)))
        stretches, last = 0, Fraction(-1)
        for low, high in intervals:
            stretches += low > last
            last = max(last, high)
        return stretches


@lru_cache(maxsize=4)
def ground_of(scenario: Scenario) -> Ground | None:
    """Return the cells of a scenario's place, if it has one."""
    return Ground(scenario.plan, scenario) if scenario.plan else None


def crossing(start: Pair, end: Pair, cell: Pair) -> tuple[Fraction, Fraction] | None:
    """Return which part of the line between two cells' centres lies in a closed cell, if any."""
    low, high = Fraction(0), Fraction(1)
    for p, q, side in zip(start, end, cell, strict=True):
        if p == q:
            continue  # the cell is in this row or column
        bounds = sorted(Fraction(2 * side + edge - 2 * p - 1, 2 * (q - p)) for edge in (0, 2))
        low, high = max(low, bounds[0]), min(high, bounds[1])
    return (low, high) if low <= high else None
