"""A scenario and a seed as the engine takes them, and what threads that simulate share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.base.errors import FeasibeeError
from feasibee.base.record import Record
from feasibee.engine.params import Params
from feasibee.strategies.contract import Setting, Strategy

WORD = 32
"""Robots per word of a set."""
FEW = 128
"""Robots of the largest swarm that senses together, by sets of robots in sight."""

Int32s = NDArray[np.int32]
Int64s = NDArray[np.int64]
Limits = NDArray[np.uint64]


class EventColumn(IntEnum):
    """Columns of `Tables.events`."""

    STEP = 0
    TASKS = 1  # that appear, or vanish if negative
    ROBOTS = 2  # that join, or leave
    MISS = 3  # new probability times 2**32, or -1
    LOSS = 4
    TASK = 5  # number of the one that vanishes or is put elsewhere, or -1
    ROBOT = 6
    X = 7  # where, or -1
    Y = 8


class Ground(NamedTuple):
    """The cells of a place, row by row (model.md 6.20)."""

    walls: Annotated[Limits, "word of cells"]  # rows begin at whole words
    passable: Annotated[Limits, "word of cells"]
    boxes: Annotated[Int32s, "left, right, top, bottom", "box"]  # of walls, tile by tile
    tiles: Annotated[Int32s, "tile"]  # first of its boxes, and the end of all
    limits: Annotated[Limits, "sense, walls"]  # squared distances that are too far, behind so many walls
    stands: Annotated[Int32s, "cell"]  # where things are placed, piece by piece
    stand_of: Annotated[Int32s, "robot, then task", "first, number"]  # of its cells in `stands`
    lattice: Annotated[Int32s, "robot", "x, y"]


class Tables(NamedTuple):
    """The arrays of a scenario: classes, skills (model.md 6.7), given points, events, place."""

    class_of: Annotated[Int32s, "robot, then task"]
    adds: Annotated[Int64s, "set of skills", "class of robots, then of tasks"]  # per member of the class
    points: Annotated[Int32s, "robot, then task of the start", "x, y"]  # zeros unless they are given
    ranks: Annotated[Int64s, "class of robots"]  # 1 for the most skilled (model.md 6.25.1)
    able: Annotated[Int64s, "class of robots", "class of tasks"]  # 1 if they can do them
    events: Annotated[Int64s, "event", "Event"]  # in their order (model.md 6.17)
    ground: Ground


class Lowered(NamedTuple):
    """A scenario and a seed in the form that the engine takes."""

    params: Params
    tables: Tables
    strategy: Strategy
    setting: Setting
    fast: bool  # whether the code of the paper's world plays it, else that of any world


@dataclass(frozen=True, eq=False)
class Control:
    """The numbers that a simulating thread shares with the thread that waits for it: one each."""

    steps_done: NDArray[np.int64]
    cancelled: NDArray[np.bool_]


Player = Callable[[Record, Control], None]
"""What plays a chunk of runs, and fills in its part of the record."""


class EndlessLoopError(FeasibeeError):
    """A function of a strategy doesn't end: Python must not call it again."""


class RunError(Exception):
    """A strategy has raised an error in a run: the number of that run, and the error."""

    def __init__(self, run: int, error: Exception) -> None:
        super().__init__(run, error)
        self.run = run
        self.error = error
