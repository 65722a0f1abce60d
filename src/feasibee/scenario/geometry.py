"""Positions of robots and tasks in pictures of the arena, with their images across the edges of a torus."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", np.float64, np.int64)


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
