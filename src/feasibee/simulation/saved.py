"""Copies of the state of a swarm, to return to a step of its run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from feasibee.model.record import Record

CONSTANT = frozenset(("robot_cells", "tasks", "task_cells", "task_lists", "tables"))
"""Fields of the state that stay the same in a run, or that are tuples of arrays."""


class Saved(NamedTuple):
    """The state of a swarm at a step, to return to; see `feasibee.simulation.swarm.Swarm.save`."""

    step: int
    """Number of steps simulated."""
    nbytes: int
    """Memory that it takes, in bytes."""
    room: Any
    """Room of the inboxes."""
    arrays: tuple[NDArray[Any], ...]
    """Copies of the arrays that change in a run."""

    @classmethod
    def of(cls, step: int, room: Any, changing: Iterable[NDArray[Any]]) -> Self:
        """Copy the arrays of a step."""
        arrays = tuple(each.copy() for each in changing)
        return cls(step, sum(each.nbytes for each in arrays), room, arrays)

    def copy_to(self, changing: Iterable[NDArray[Any]]) -> None:
        """Overwrite the arrays of the same run by those of the step."""
        for array, old in zip(changing, self.arrays, strict=True):
            np.copyto(array, old)


def changing_arrays(state: Any, record: Record, changes: bool) -> list[NDArray[Any]]:
    """Return the arrays that a step may change, without the curves: they are written again.

    Parameters
    ----------
    state : State
        The swarm.
    record : Record
        Its outcomes.
    changes : bool
        Whether the world changes (model.md 6.17), and tasks with it.
    """
    arrays = [getattr(state, each.name) for each in fields(state) if each.name not in CONSTANT]
    if changes:  # places and classes belong to numbers: the next task of a number has the same again
        arrays += [*state.task_cells, *state.task_lists]
    return [*arrays, *state.robot_cells, record.decision, record.decision_step, record.account]
