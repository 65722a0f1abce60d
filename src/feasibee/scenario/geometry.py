"""Where things show in a picture of the arena; all that draws it in Python asks here."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", np.float64, np.int64)


def images(
    places: NDArray[Number], reach: float, size: tuple[float, float], walls: bool
) -> tuple[NDArray[Number], NDArray[np.int64]]:
    """Return where things show: at their places and, on a torus, also beyond each edge that they reach.

    Parameters
    ----------
    places : float64 or int64 array, shape (things, 2)
        Where they are, from 0 to the sides.
    reach : float
        How far from its place a thing is drawn.
    size : tuple of float
        Width and height of the arena, in the same unit.
    walls : bool
        Whether the arena is closed, and not a torus: nothing shows beyond its edges then.

    Returns
    -------
    array of the type of ``places``, shape (images, 2)
        First the things themselves, in their order.
    int64 array, shape (images,)
        Of which thing each is an image.
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
