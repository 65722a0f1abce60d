"""The floor plan of a place: cells of walls, no-go areas and zones (model.md 6.20.1, 6.20.2)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np

from feasibee.model.codes import exact
from feasibee.scenario.bitmaps import Cells, cells_of
from feasibee.scenario.fields import Bitmap, Place
from feasibee.scenario.raster import centred, touched

SIDE_BITS = 31
"""Bits of a coordinate within walls."""


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
        return self.cell / (1 << self.bits)


def plan_of(place: Place, size: tuple[float, float]) -> Plan | None:
    """Return the cells of a place in an arena of this width and height; None if it has none."""
    return _plan(place.model_dump_json(), size) if place.exists else None


@lru_cache(maxsize=16)
def _plan(text: str, size: tuple[float, float]) -> Plan:
    place = Place.model_validate_json(text)
    cell = exact(place.map.cell if place.map else place.cell)
    shape = shape_of(place, size)
    walls, keepout = np.zeros(shape, bool), np.zeros(shape, bool)
    if place.map:
        walls |= cells_of(place.map.image)
    walls |= touched(([ring] for ring in place.walls), cell, shape)
    if place.keepout:
        keepout |= cells_of(place.keepout.image)
    zones = {
        name: centred(([ring] for ring in polygons), cell, shape) for name, polygons in place.zones.items()
    }
    return Plan(cell, walls, keepout, zones)


def size_of(bitmap: Bitmap) -> float | tuple[float, float]:
    """Return the sides of the arena of a map, in units: one if they are equal."""
    height, width = (float(cells * exact(bitmap.cell)) for cells in cells_of(bitmap.image).shape)
    return width if width == height else (width, height)


def shape_of(place: Place, size: tuple[float, float]) -> tuple[int, int]:
    """Return the number of rows and of columns of a place's cells: those of its map, if any."""
    if place.map:
        rows, columns = cells_of(place.map.image).shape
        return rows, columns
    width, height = (math.ceil(exact(side) / exact(place.cell)) for side in size)
    return height, width
