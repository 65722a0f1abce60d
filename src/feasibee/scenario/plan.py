"""The floor plan of a place: cells of walls, no-go areas and zones (model.md 6.20.1, 6.20.2)."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import exact
from feasibee.scenario.fields import Bitmap, Place, Point

Cells = NDArray[np.bool_]
SIDE_BITS = 31
"""Bits of a coordinate within walls."""
MOST_CELLS = 4096 * 4096


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
        return self.cell / 2**self.bits


def plan_of(place: Place, size: tuple[float, float]) -> Plan | None:
    """Return the cells of a place in an arena of this width and height; None if it has none."""
    return _plan(place.model_dump_json(), size) if place.exists else None


@lru_cache(maxsize=16)
def _plan(text: str, size: tuple[float, float]) -> Plan:
    place = Place.model_validate_json(text)
    cell = exact(place.map.cell if place.map else place.cell)
    shape = math.ceil(exact(size[1]) / cell), math.ceil(exact(size[0]) / cell)
    walls, keepout = np.zeros(shape, bool), np.zeros(shape, bool)
    if place.map:
        walls |= cells_of(place.map)
    for polygon in place.walls:
        walls |= touched(polygon, float(cell), shape)
    if place.keepout:
        keepout |= cells_of(place.keepout)
    zones = {
        name: np.logical_or.reduce([centred(polygon, float(cell), shape) for polygon in polygons])
        for name, polygons in place.zones.items()
    }
    return Plan(cell, walls, keepout, zones)


def cells_of(bitmap: Bitmap) -> Cells:
    """Return which cells of a map are closed."""
    from PIL import Image

    with Image.open(io.BytesIO(base64.b64decode(bitmap.image)), formats=["PNG"]) as image:
        return ~np.asarray(image.convert("1"))[::-1]


def touched(polygon: Sequence[Point], cell: float, shape: tuple[int, int]) -> Cells:
    """Return which cells a polygon touches."""
    return centred(polygon, cell, shape)


def centred(polygon: Sequence[Point], cell: float, shape: tuple[int, int]) -> Cells:
    """Return the cells whose centres are in a polygon: those with an odd number of edges to the right."""
    rows, columns = shape
    ys, xs = (np.arange(rows)[:, None] + 0.5) * cell, (np.arange(columns)[None, :] + 0.5) * cell
    inside = np.zeros(shape, bool)
    for (ax, ay), (bx, by) in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
        if ay != by:
            inside ^= ((ay > ys) != (by > ys)) & (xs < ax + (ys - ay) * (bx - ax) / (by - ay))
    return inside
