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
from feasibee.scenario.ground import Ground as Surface
from feasibee.scenario.ground import Plan, ground_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.sections import Most

CELLS = 64
"""Cells in a word."""
SHARP, BLUR = 1 << 20, 2
"""Cells up to which each has its byte; in larger places 4 x 4 share one, so that they stay in the cache."""
FARTHEST = 255
"""Largest distance that a byte holds."""


def params_of(scenario: Scenario) -> PlaceParams:
    """Return the grid of a scenario's place; zeros if it has none."""
    plan = scenario.plan
    if plan is None:
        return PlaceParams(False, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1)
    rows, columns = plan.walls.shape
    sight, radio = (
        math.ceil(exact(reach) / plan.cell) + 1 for reach in (scenario.sensing.range, scenario.radio.range)
    )
    blur = _blur(plan)
    numbers = columns, rows, -(-columns // CELLS), blur, -(-columns >> blur), sight, radio
    surface = ground_of(scenario)
    assert surface is not None
    arrived = math.floor(5 * exact(scenario.acting.reach) / plan.cell) if scenario.acts else -1
    return PlaceParams(True, plan.bits, *numbers, surface.near, arrived)


def tables_of(scenario: Scenario) -> Ground:
    """Return the arrays of a scenario's place; empty ones if it has none."""
    surface = ground_of(scenario)
    if surface is None:
        words, places = np.zeros(0, np.uint64), np.zeros((0, 2), np.int32)
        return Ground(words, words, words.astype(np.uint8), words, places[:, 0].copy(), places, places)
    radio, walls = exact(scenario.radio.range), exact(scenario.radio.walls)
    sight = [exact(scenario.sensing.range), *[None] * MOST_WALLS]
    ranges = [*sight, *(radio * walls**k if walls or k == 0 else None for k in range(MOST_WALLS + 1))]
    limits = np.array([_limit(each, surface.plan.unit) for each in ranges], np.uint64)
    return _tables(surface, scenario.most, scenario.robots.avoid_collisions)._replace(limits=limits)


@lru_cache(maxsize=4)
def _tables(surface: Surface, most: Most, avoid_collisions: bool) -> Ground:
    """Return the arrays of a place that don't depend on ranges."""
    return Ground(
        walls=_words(surface.plan.walls),
        passable=_words(surface.passable),
        open_around=_open_around(surface.plan),
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


def _blur(plan: Plan) -> int:
    """Return the power of two of the cells along each axis that share a byte."""
    return BLUR if plan.walls.size > SHARP else 0


@lru_cache(maxsize=4)
def _open_around(plan: Plan) -> NDArray[np.uint8]:
    """Return the cells' distances to the nearest wall, in cells, the larger one along both axes."""
    from scipy.ndimage import distance_transform_cdt

    # Without walls all are -1, which is the largest number of 32 bits.
    distances = distance_transform_cdt(~plan.walls, metric="chessboard").astype(np.uint32)
    found = np.minimum(distances, FARTHEST).astype(np.uint8)
    side = 1 << _blur(plan)
    padded = np.pad(found, [(0, -each % side) for each in found.shape], constant_values=FARTHEST)
    blocks: NDArray[np.uint8] = padded.reshape(padded.shape[0] // side, side, -1, side).min(axis=(1, 3))
    return blocks.ravel()
