"""Which share of a place robots see on average, for strategies that count what is in sight."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.scenario.ground import Ground
from feasibee.strategies.sight import TASKS, WALL

SEED: Final = 28
WALKERS: Final = 4096
STEPS: Final = 25
"""Steps after which robots are about as often at walls as later."""
WAYS: Final = 16
"""Ways of each walker to a cell in range, drawn at random."""


@lru_cache(maxsize=16)
def share_in_sight(ground: Ground, reach: float, speed: float, mean_run: float) -> float:
    """Return the mean share that a robot sees of the cells in which tasks may be.

    By robots that walk by themselves; lines are looked at every half cell. Rounded to three digits: so it is
    the same everywhere, though cosines may differ in their last bit.
    """
    far = min(reach / float(ground.plan.cell), math.hypot(*ground.pieces.shape))  # no cell is farther away
    random = np.random.default_rng(SEED)
    cells = np.frombuffer(ground.sketch, np.uint8).reshape(ground.pieces.shape)
    around = np.arange(-math.floor(far), math.floor(far) + 1)
    ways = np.argwhere(around[:, None] ** 2 + around**2 <= far**2) + around[0]
    start = np.repeat(_walked(ground, speed / float(ground.plan.cell), mean_run, random), WAYS, axis=0)
    way = ways[random.integers(len(ways), size=len(start))]
    inside = ((start + way >= 0) & (start + way < cells.shape)).all(axis=1)
    start, way = start[inside], way[inside]
    seen = cells[tuple((start + way).T)] & TASKS > 0
    halves = 2 * len(around)
    for k in range(halves):
        seen &= cells[tuple((start + (k * way + halves // 2) // halves).T)] & WALL == 0
    share = math.pi * far**2 * seen.sum() / inside.size / max(np.count_nonzero(cells & TASKS), 1)
    return min(float(f"{share:.3g}"), 1.0)


def _walked(ground: Ground, step: float, mean_run: float, random: Any) -> NDArray[np.int64]:
    """Return row and column of robots after a walk in steps of so many cells; blocked ones stand and turn."""
    free = np.isin(ground.pieces, ground.robots.piece) & (ground.pieces > 0)
    cells = np.flatnonzero(free)
    place = np.stack(np.divmod(cells[random.integers(len(cells), size=WALKERS)], free.shape[1]), axis=1) + 0.5
    heading = random.random(WALKERS)
    for _ in range(STEPS):
        way = step * np.stack([np.sin(2 * np.pi * heading), np.cos(2 * np.pi * heading)], axis=1)
        quarters = np.floor(place + way * np.arange(1, 5)[:, None, None] / 4).astype(np.int64)
        quarters = np.clip(quarters, 0, np.array(free.shape) - 1)
        goes = free[quarters[..., 0], quarters[..., 1]].all(axis=0)
        place[goes] += way[goes]
        turns = ~goes | (random.random(WALKERS) > math.exp(-1 / mean_run))
        heading[turns] = random.random(turns.sum())
    return np.floor(place).astype(np.int64)
