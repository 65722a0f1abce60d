"""A scenario's place as the engine takes it (model.md 6.20, 6.21)."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import MOST_WALLS, exact
from feasibee.engine.params import PlaceParams
from feasibee.engine.tables import Ground, Int32s
from feasibee.scenario.cells import Cells
from feasibee.scenario.ground import Plan, Surface, ground_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.sections import Most

CELLS = 64
"""Cells in a word."""
TILE = 64
"""Cells along the sides of a tile, as in place.h."""
MOST_LANES = 16
"""Boxes that the engine reads at once, at most."""


def params_of(scenario: Scenario) -> PlaceParams:
    """Return the grid of a scenario's place; zeros if it has none."""
    plan = scenario.plan
    if plan is None:
        return PlaceParams(False, 0, 0, 0, 0, 0, 0, 0, -1)
    rows, columns = plan.walls.shape
    numbers = columns, rows, -(-columns // CELLS), -(-columns // TILE), _boxes(plan)[0].shape[1]
    surface = ground_of(scenario)
    assert surface is not None
    arrived = math.floor(5 * exact(scenario.acting.reach) / plan.cell) if scenario.acts else -1
    return PlaceParams(True, plan.bits, *numbers, surface.near, arrived)


def tables_of(scenario: Scenario) -> Ground:
    """Return the arrays of a scenario's place; empty ones if it has none."""
    surface = ground_of(scenario)
    if surface is None:
        words, places = np.zeros(0, np.uint64), np.zeros((0, 2), np.int32)
        none = places[:, 0].copy()
        return Ground(words, words, none, none, words, none, places, places)
    radio, walls = exact(scenario.radio.range), exact(scenario.radio.walls)
    sight = [exact(scenario.sensing.range), *[None] * MOST_WALLS]
    ranges = [*sight, *(radio * walls**k if walls or k == 0 else None for k in range(MOST_WALLS + 1))]
    limits = np.array([_limit(each, surface.plan.unit) for each in ranges], np.uint64)
    return _tables(surface, scenario.most, scenario.robots.avoid_collisions)._replace(limits=limits)


@lru_cache(maxsize=4)
def _tables(surface: Surface, most: Most, avoid_collisions: bool) -> Ground:
    """Return the arrays of a place that don't depend on ranges."""
    boxes, tiles = _boxes(surface.plan)
    return Ground(
        walls=_words(surface.plan.walls),
        passable=_words(surface.passable),
        boxes=boxes,
        tiles=tiles,
        limits=np.zeros(0, np.uint64),
        **_stands(surface, most, avoid_collisions),
    )


def _limit(reach: Fraction | None, unit: Fraction) -> int:
    """Return the least squared distance that is too far."""
    return 0 if reach is None else min(math.floor((reach / unit) ** 2) + 1, 2**63 + 1)


def _words(cells: Cells) -> NDArray[np.uint64]:
    """Return cells as words of 64 bits; each row begins with a new word."""
    padded = np.pad(cells, [(0, 0), (0, -cells.shape[1] % CELLS)])
    return np.packbits(padded, axis=1, bitorder="little").view("<u8").astype(np.uint64).ravel()


def _stands(surface: Surface, most: Most, avoid_collisions: bool) -> dict[str, Int32s]:
    """Return where robots and tasks are placed; those beyond the start are where the first robot is."""
    rows, before = [], 0
    own, others = surface.robots, surface.tasks
    for each, count in ((own, most.robots), (others, most.tasks)):
        pieces = np.full(count, own.piece[0])
        pieces[: len(each.piece)] = each.piece
        first = each.first[pieces]
        rows.append(np.stack([first + before, each.first[pieces + 1] - first], axis=1))
        before += len(each.cells)
    lattice, numbers = np.zeros((most.robots, 2), np.int32), own.piece
    for piece, (xs, ys) in enumerate(surface.lattice if avoid_collisions else (), start=1):
        members = np.flatnonzero(numbers == piece)
        if len(members) and len(xs):
            sites = np.arange(len(members)) * len(xs) // len(members)
            lattice[members] = np.stack([xs[sites], ys[sites]], axis=1)
    return {
        "stands": np.concatenate([own.cells, others.cells]).astype(np.int32),
        "stand_of": np.concatenate(rows).astype(np.int32),
        "lattice": lattice,
    }


@lru_cache(maxsize=4)
def _boxes(plan: Plan) -> tuple[Int32s, Int32s]:
    """Return the walls as boxes of cells, and the first box of each tile; the last ones hold no cell.

    A box is as many runs of walls as are alike in consecutive rows of a tile.
    """
    rows, columns = plan.walls.shape
    in_tiles = np.pad(plan.walls, [(0, 0), (0, -columns % TILE)]).reshape(rows, -1, TILE)
    edges = np.diff(np.pad(in_tiles, [(0, 0), (0, 0), (1, 1)]).astype(np.int8))
    (row, tile, left), (_, _, end) = (np.argwhere(edges == sign).T for sign in (1, -1))
    runs = np.stack([tile, row // TILE, left, end - 1, row])
    tile, tile_row, left, right, row = runs[:, np.lexsort(runs[[4, 3, 2, 0, 1]])]
    goes_on = (np.diff([tile, tile_row, left, right]) == 0).all(axis=0) & (np.diff(row) == 1)
    first, last = (np.pad(~goes_on, side, constant_values=True)[: len(row)] for side in ((1, 0), (0, 1)))
    boxes = [(TILE * tile + left)[first], (TILE * tile + right)[first], row[first], row[last]]
    after = np.repeat([[columns], [-1], [rows], [-1]], MOST_LANES, axis=1)
    number = (tile_row * in_tiles.shape[1] + tile)[first]
    tiles = np.searchsorted(number, np.arange(in_tiles.shape[1] * -(-rows // TILE) + 1))
    return np.hstack([np.stack(boxes), after]).astype(np.int32), tiles.astype(np.int32)
