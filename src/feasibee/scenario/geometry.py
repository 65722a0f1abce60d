"""Positions and lines in pictures of the arena, with their images across the edges of a torus."""

from __future__ import annotations

from typing import NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", np.float64, np.int64)


class Acting(NamedTuple):
    """What robots that act do at a step (model.md 6.25), as pictures and pages draw it."""

    aims: NDArray[np.int64]
    """Task to which each robot walks, or at which it stands: int64, shape (robots,).

    It is the task's place among those of the step. -1 stands for none, or for one that has vanished.
    """
    standing: NDArray[np.bool_]
    """Whether each robot stands at a task: bool, shape (robots,)."""
    holders: NDArray[np.int64]
    """Robot that stands at each task of the step, or has marked it: int64, shape (tasks,).

    -1 stands for none, and -2 for a done task.
    """

    @property
    def looks(self) -> NDArray[np.uint8]:
        """0 for each free task of the step, 1 for a taken one, 2 for a done one: uint8, shape (tasks,)."""
        return np.choose(np.minimum(self.holders, 0) + 2, [2, 0, 1]).astype(np.uint8)

    @property
    def achieved(self) -> str:
        """At how many tasks robots stand, and how many are done, in words."""
        done = int((self.looks == 2).sum())
        more = f" and have done {done}" if done else ""
        return f"robots stand at {self.standing.sum()} of {len(self.holders)} tasks{more}"

    @classmethod
    def of(
        cls,
        targets: NDArray[np.int32],
        standing: NDArray[np.bool_],
        holders: NDArray[np.int32],
        numbers: NDArray[np.int64],
    ) -> Self:
        """Return what robots do; targets and holders are those of ``Swarm``, numbers those of its tasks."""
        aims = np.where(np.isin(targets, numbers), np.searchsorted(numbers, targets), -1)
        held = holders[numbers].astype(np.int64)
        at = np.flatnonzero((held >= 0) & standing[held])
        aims[held[at]] = at
        return cls(aims, standing, held)


def images(
    places: NDArray[Number], reach: float, size: tuple[float, float], walls: bool
) -> tuple[NDArray[Number], NDArray[np.int64]]:
    """Return positions to draw: those of all things and, on a torus, their images beyond the opposite edges.

    Parameters
    ----------
    places : float64 or int64 array, shape (things, 2)
        Positions, from 0 to the sides of the arena.
    reach : float
        Distance from its position up to which a thing is drawn, in the same unit.
    size : tuple of float
        Width and height of the arena, in the same unit.
    walls : bool
        Whether the arena has walls; then there are no images.

    Returns
    -------
    array of the type of ``places``, shape (images, 2)
        The positions of the things, in their order, and then those of their images.
    int64 array, shape (images,)
        Number of the thing of each position.
    """
    names = np.arange(len(places))
    for axis, side in enumerate(() if walls else size):
        low, high = (places[:, axis] < reach).nonzero()[0], (places[:, axis] > side - reach).nonzero()[0]
        every = np.concatenate([np.arange(len(places)), low, high])
        shift = np.zeros((len(every), 2), places.dtype)
        shift[len(places) : len(places) + len(low), axis] = side
        shift[len(places) + len(low) :, axis] = -side
        places, names = places[every] + shift, names[every]
    return places, names


def segments(
    starts: NDArray[np.float64], ends: NDArray[np.float64], size: tuple[float, float], walls: bool
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return lines to draw from places to others: on a torus the shortest way, from both ends if it wraps.

    Parameters
    ----------
    starts, ends : float64 array, shape (lines, 2)
        Positions, from 0 to the sides of the arena.
    size, walls
        As in `images`.

    Returns
    -------
    float64 array, shape (parts, 2, 2)
        Start and end of each line, and then of each second part.
    int64 array, shape (parts,)
        Number of the line of each part.
    """
    straight = ends - starts
    ways = straight if walls else straight - np.round(straight / size) * size
    wrapped = (ways != straight).any(axis=1).nonzero()[0]
    whole, second = np.stack([starts, starts + ways], axis=1), np.stack([ends - ways, ends], axis=1)
    return np.concatenate([whole, second[wrapped]]), np.concatenate([np.arange(len(starts)), wrapped])
