"""The robots of a step in few bytes, and sets of robots as arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FLAGS = (
    "feasible",
    "neutral",
    "disseminating",
    "committed",
    "declared",
    "working",
    "byzantine",
    "stubborn",
    "there",
)
"""Properties of robots, each a set of the engine; ``there`` is false where no robot has the number."""


class Snapshot(NamedTuple):
    """The robots of a step in few bytes, as a page draws them; an entry for each number of a robot."""

    x: NDArray[np.uint16]
    """Position of each robot, in 65,536ths of the arena's longer side."""
    y: NDArray[np.uint16]
    """Position of each robot, in the same unit."""
    flags: NDArray[np.uint16]
    """Properties of each robot: a bit for each of `FLAGS`, the lowest first."""
    heading: NDArray[np.uint8]
    """Direction of each robot, in 256ths of a turn, counterclockwise from the x axis."""


def snapshot_of(state: Any, walls: bool, places: Any) -> Snapshot:
    """Return the robots of a state.

    Parameters
    ----------
    state : State
        The swarm.
    walls : bool
        Whether the arena has walls instead of being a torus.
    places : slice or int64 array, shape (robots,)
        Where the state has each robot.
    """
    from feasibee.engine.layout import Robot

    x, y, step_x, step_y = state.robots[[Robot.X, Robot.Y, Robot.STEP_X, Robot.STEP_Y]][:, places]
    turns = np.arctan2(step_y.astype(np.float32), step_x.astype(np.float32)) * np.float32(128 / np.pi)
    flags = np.zeros(x.size, np.uint16)
    for bit, kind in enumerate(sets_of_flags()):
        flags |= members(state.sets[kind])[places].astype(np.uint16) << np.uint16(bit)
    return Snapshot(
        coarse(x, walls), coarse(y, walls), flags, np.round(turns).astype(np.int16).astype(np.uint8)
    )


def sets_of_flags() -> list[int]:
    """Return the set of the engine whose members have each of `FLAGS`."""
    from feasibee.engine.layout import Set

    return [Set[name.upper()] for name in FLAGS]


def members(words: NDArray[np.uint32]) -> NDArray[np.int8]:
    """Return whether each number is a member of a set of the engine, as 1 or 0: int8, shape (numbers,)."""
    return np.unpackbits(words.view(np.uint8), bitorder="little").view(np.int8)


def coarse(fixed: NDArray[np.int32], walls: bool) -> NDArray[np.uint16]:
    """Convert fixed-point positions to 65,536ths of the arena's longer side."""
    shifted = fixed.view(np.uint32) >> np.uint32(15 if walls else 16)
    places: NDArray[np.uint16] = np.minimum(shifted, 65535).astype(np.uint16)
    return places
