"""The floor plan of a place, where robots can be in it, and who stands in which piece (model.md 6.20)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import exact
from feasibee.scenario.cells import Cells, cells_of, centred, touched
from feasibee.scenario.fields import Arena, Bitmap, Place, Placed, Point, Robots, Tasks
from feasibee.strategies.sight import TASKS, WALL

SIDE_BITS = 31
"""Bits of a coordinate within walls."""


@dataclass(frozen=True, eq=False)
class Plan:
    """The cells of a place, in arrays of shape (rows, columns) whose row 0 has the lowest y."""

    cell: Fraction
    """Side of a cell, in units."""
    walls: Cells
    keepout: Cells
    zones: Mapping[str, Cells]

    @property
    def bits(self) -> int:
        """Number of bits of a position that are within its cell (model.md 6.20.2)."""
        return math.floor(math.log2(2**SIDE_BITS / max(self.walls.shape)))

    @property
    def unit(self) -> Fraction:
        """Unit of fixed point, in units of length."""
        return self.cell / (1 << self.bits)


def plan_of(place: Place, size: tuple[float, float]) -> Plan | None:
    """Return the cells of a place in an arena of this width and height; None if it has none."""
    return _plan(place.model_dump_json(), size) if place.exists else None


@lru_cache(maxsize=16)
def _plan(text: str, size: tuple[float, float]) -> Plan:
    place = Place.model_validate_json(text)
    cell = exact(place.map.cell if place.map else place.cell)
    shape = shape_of(place, size)
    walls, keepout = np.zeros(shape, bool), np.zeros(shape, bool)
    if place.map:
        walls |= cells_of(place.map.image)
    walls |= touched(([ring] for ring in place.walls), cell, shape)
    if place.keepout:
        keepout |= cells_of(place.keepout.image)
    zones = {
        name: centred(([ring] for ring in polygons), cell, shape) for name, polygons in place.zones.items()
    }
    return Plan(cell, walls, keepout, zones)


def size_of(bitmap: Bitmap) -> float | tuple[float, float]:
    """Return the sides of the arena of a map, in units: one if they are equal."""
    height, width = (float(cells * exact(bitmap.cell)) for cells in cells_of(bitmap.image).shape)
    return width if width == height else (width, height)


def shape_of(place: Place, size: tuple[float, float]) -> tuple[int, int]:
    """Return the number of rows and of columns of a place's cells: those of its map, if any."""
    if place.map:
        rows, columns = cells_of(place.map.image).shape
        return rows, columns
    width, height = (math.ceil(exact(side) / exact(place.cell)) for side in size)
    return height, width


Numbers = NDArray[np.int64]
SLACK: Final = 16
"""Units by which a step may be longer than its speed, because its parts are rounded."""


class Stands(NamedTuple):
    """The cells in which robots or tasks are placed."""

    cells: NDArray[np.int32]
    """Numbers of cells, row by row, piece after piece."""
    first: Numbers
    """For each piece, from number 0 on (no piece), where its cells begin, and where the last one's end."""
    piece: Numbers
    """The piece of each robot or task of the start; 0 if no robot reaches it."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The passable cells of a place for robots of a size and speed."""

    plan: Plan
    radius: int
    """In units of fixed point."""
    passable: Cells
    near: int
    """Largest square of the gap, in cells, between a task and the cell from which robots reach it."""
    pieces: NDArray[np.int32]
    """Number of each cell's piece, from 1 on, in the order of their first cells; 0 where no robot can be."""
    robots: Stands
    tasks: Stands
    sketch: bytes
    """What robots know of each cell, row by row: `feasibee.strategies.sight.WALL` and ``TASKS``."""

    @property
    def is_one(self) -> bool:
        """Whether all robots and tasks are in one piece."""
        pieces = np.concatenate([self.robots.piece, self.tasks.piece])
        return bool((pieces == pieces[0]).all())

    @cached_property
    def lattice(self) -> list[tuple[Numbers, Numbers]]:
        """The x and y of the sites of each piece, from piece 1 on, in fixed point (model.md 6.20.8)."""
        cells = self.robots.cells
        allowed = np.zeros(self.pieces.shape, np.int32)
        allowed.flat[cells] = self.pieces.flat[cells]
        ys, xs = (
            np.arange(self.radius, side << self.plan.bits, 2 * self.radius) for side in self.pieces.shape
        )
        found = allowed[np.ix_(ys >> self.plan.bits, xs >> self.plan.bits)]
        sites = [(found == piece).nonzero() for piece in range(1, len(self.robots.first) - 1)]
        return [(xs[columns], ys[rows]) for rows, columns in sites]


class Sited(Protocol):
    """The sections of a scenario that say who can be where."""

    @property
    def place(self) -> Place:
        """What stands in the arena."""

    @property
    def arena(self) -> Arena:
        """How large it is."""

    @property
    def robots(self) -> Robots:
        """Who moves in it."""

    @property
    def tasks(self) -> Tasks:
        """What they look for."""


def ground_of(scenario: Sited) -> Surface | None:
    """Return where robots can be in a scenario's place; None if it has none."""
    if not scenario.place.exists:
        return None
    robots, tasks = scenario.robots, scenario.tasks
    bodies = robots.diameter, robots.speed
    key = scenario.place.model_dump_json(), scenario.arena.size, bodies
    return _ground(*key, *((each.count, each.zone, _points(each)) for each in (robots, tasks)))


def _points(section: Placed) -> tuple[Point, ...] | None:
    return section.points if section.placement == "points" else None


@lru_cache(maxsize=16)
def _ground(
    text: str, size: tuple[float, float], bodies: tuple[float, float], robots: Any, tasks: Any
) -> Surface:
    plan, radius, passable, pieces = _surface(text, size, bodies)
    most = _least(bodies, plan, radius) // (16 * 4**plan.bits)
    (count, zone, points), (tasks_count, tasks_zone, tasks_points) = robots, tasks
    own = stands_in(pieces, plan.zones.get(zone), np.ones(int(pieces.max()) + 1, bool))
    if points is None:
        own = own._replace(piece=shares(np.diff(own.first), count))
    else:
        own = own._replace(piece=np.array([pieces.flat[cell] for cell in cells_at(plan, points)], np.int64))
    held = np.isin(np.arange(pieces.max() + 1), own.piece)
    others = stands_in(pieces, plan.zones.get(tasks_zone), held)
    if tasks_points is None:
        others = others._replace(piece=shares(np.diff(others.first), tasks_count))
    else:
        near = [nearest(pieces, cell, most) for cell in cells_at(plan, tasks_points)]
        others = others._replace(piece=np.array(near, np.int64))
    sketch = plan.walls.astype(np.uint8) * WALL
    sketch.flat[others.cells] |= TASKS
    sketch.flat[cells_at(plan, tasks_points or ())] |= TASKS
    return Surface(plan, radius, passable, most, pieces, own, others, sketch.tobytes())


@lru_cache(maxsize=16)
def _surface(
    text: str, size: tuple[float, float], bodies: tuple[float, float]
) -> tuple[Plan, int, Cells, NDArray[np.int32]]:
    """Return a plan, the radius of robots of a diameter and speed, their passable cells and the pieces."""
    plan = plan_of(Place.model_validate_json(text), size)
    assert plan is not None
    radius = math.ceil(exact(bodies[0]) / plan.unit / 2)
    most = (_least(bodies, plan, radius) - 1) // (64 * 4**plan.bits)
    passable = ~grown(plan.walls | plan.keepout, most)
    return plan, radius, passable, connected(passable, _step(bodies, plan) ** 2 // (16 * 4**plan.bits))


def _step(bodies: tuple[float, float], plan: Plan) -> int:
    """Return a length that no step exceeds, in units of fixed point."""
    return math.ceil(exact(bodies[1]) / plan.unit) + SLACK


def _least(bodies: tuple[float, float], plan: Plan, radius: int) -> int:
    """Return 64 times the square of the least distance from a wall (model.md 6.20.3)."""
    return int(64 * radius**2 + _step(bodies, plan) ** 2)


def cells_at(plan: Plan, points: Sequence[Point]) -> list[int]:
    """Return the numbers of the cells of points."""
    rows, columns = plan.walls.shape
    return [
        min(max(math.floor(exact(y) / plan.cell), 0), rows - 1) * columns
        + min(max(math.floor(exact(x) / plan.cell), 0), columns - 1)
        for x, y in points
    ]


def grown(closed: Cells, most: int) -> Cells:
    """Return which cells have a gap, squared, of at most ``most`` cells to a closed one or to the edge."""
    from scipy.ndimage import binary_dilation, distance_transform_edt

    # The gap between two cells is the distance from one to the nearest of the other and its eight neighbours.
    around = binary_dilation(np.pad(closed, 1, constant_values=True), np.ones((3, 3)))
    rows, columns = distance_transform_edt(~around, return_distances=False, return_indices=True)
    height, width = around.shape
    rows -= np.arange(height, dtype=np.int32)[:, None]
    columns -= np.arange(width, dtype=np.int32)
    near: Cells = (rows * rows + columns * columns <= most)[1:-1, 1:-1]
    return near


def connected(passable: Cells, most: int) -> NDArray[np.int32]:
    """Return the piece of each passable cell; those whose gap squared is at most ``most`` go together."""
    from scipy.ndimage import label
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pieces: NDArray[np.int32] = label(passable, np.ones((3, 3)))[0]
    count = int(pieces.max(initial=0))
    if most == 0 or count < 2:
        return pieces
    first, second = _leaps(pieces, most)
    pairs = coo_array((np.ones(len(first)), (first - 1, second - 1)), (count, count))
    merged = connected_components(pairs, directed=False)[1]
    return np.concatenate([[0], merged + 1]).astype(np.int32)[pieces]


def _leaps(pieces: NDArray[np.int32], most: int) -> tuple[Numbers, Numbers]:
    """Return pairs of different pieces that a quarter of a step joins."""
    count = int(pieces.max()) + 1
    largest = np.bincount(pieces.ravel())[1:].argmax() + 1  # one of a pair isn't in it, and few cells aren't
    reach = math.isqrt(most) + 1
    padded = np.pad(pieces, reach)
    closed = padded == 0
    # From a cell without a closed neighbour, its piece has one that is no farther from any other cell.
    closed[1:-1, 1:-1] |= closed[2:, 1:-1] | closed[:-2, 1:-1] | closed[1:-1, 2:] | closed[1:-1, :-2]
    flat = padded.ravel()
    cells = np.flatnonzero(closed.ravel() & (flat > 0) & (flat != largest))
    here, found = flat[cells], [np.zeros(0, np.int64)]
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            if max(abs(dy) - 1, 0) ** 2 + max(abs(dx) - 1, 0) ** 2 <= most:
                there = flat[cells + (dy * padded.shape[1] + dx)]
                differ = (there > 0) & (there != here)
                found.append(np.unique(here[differ].astype(np.int64) * count + there[differ]))
    first, second = np.divmod(np.unique(np.concatenate(found)), count)
    return first, second


def stands_in(pieces: NDArray[np.int32], zone: Cells | None, held: Cells) -> Stands:
    """Return the cells of a zone, piece by piece, in those pieces that are held."""
    chosen = held[pieces] & (pieces > 0)
    if zone is not None:
        chosen &= zone
    cells = np.flatnonzero(chosen)
    kinds = pieces.flat[cells]
    order = np.argsort(kinds, kind="stable") if len(held) > 2 else slice(None)
    first = np.cumsum(np.bincount(kinds + 1, minlength=len(held) + 1)[: len(held) + 1])
    return Stands(cells[order].astype(np.int32), first, np.zeros(0, np.int64))


def shares(areas: Numbers, count: int) -> Numbers:
    """Return the piece of each of ``count`` robots or tasks; each goes to the one farthest behind its share.

    ``areas`` has the cells of each piece; piece 0, none, has none.
    """
    total, given = int(areas.sum()), np.zeros(len(areas), np.int64)
    if total == 0 or (areas > 0).sum() == 1:
        return np.full(count, int(np.argmax(areas)), np.int64)
    found = np.zeros(count, np.int64)
    for k in range(count):
        found[k] = np.argmax(areas * (k + 1) - given * total)
        given[found[k]] += 1
    return found


def nearest(pieces: NDArray[np.int32], cell: int, most: int) -> int:
    """Return the piece of the passable cell nearest to a cell; 0 if the gap's square is above ``most``."""
    row, column = divmod(cell, pieces.shape[1])
    reach = math.isqrt(most) + 1
    top, left = max(row - reach, 0), max(column - reach, 0)
    around = pieces[top : row + reach + 1, left : column + reach + 1]
    dy = np.maximum(np.abs(np.arange(around.shape[0]) + top - row) - 1, 0)
    dx = np.maximum(np.abs(np.arange(around.shape[1]) + left - column) - 1, 0)
    gaps = np.where(around > 0, dy[:, None] ** 2 + dx[None, :] ** 2, most + 1)
    best = int(np.argmin(gaps))
    return int(around.flat[best]) if gaps.flat[best] <= most else 0
