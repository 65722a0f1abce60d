"""The rules between the fields of a place and those of its arena, robots and tasks (model.md 6.20)."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from typing import Final

from feasibee.model.codes import exact
from feasibee.scenario.bitmaps import MOST, cells_of
from feasibee.scenario.fields import Place
from feasibee.scenario.plan import shape_of, size_of
from feasibee.scenario.rules import Conflict, Rule, both, never
from feasibee.scenario.sections import Sections


def _size(scenario: Sections) -> Iterator[Conflict]:
    """Find an arena whose sides aren't those of the map or, without a map, whole numbers of cells."""
    place, size = scenario.place, scenario.arena.size
    if not place.exists:
        return
    if place.map:
        found = size_of(place.map)
        if size != (found if isinstance(found, tuple) else (found, found)):
            rule = f"must be the size of the map, {_shown(found)} units"
            yield Conflict("arena.side", rule, "leave it out: the map sets it")
        elif max(size) > 1e6:
            rule = "must be at most 1e6 units, but the map is larger"
            yield Conflict("arena.side", rule, "raise units.metres")
        return
    cell = exact(place.cell)
    columns, rows = (exact(side) / cell for side in size)
    if max(columns, rows) > MOST:
        rule = f"makes {math.ceil(columns)} x {math.ceil(rows)} cells, above {MOST} x {MOST}"
        least = math.ceil(max(size) / MOST * 1000) / 1000
        yield Conflict("place.cell", rule, f"set it to {least:g} or more")
    elif columns.denominator * rows.denominator > 1:
        sides = [float(cell * math.ceil(each)) for each in (columns, rows)]
        rule = f"must be a whole number of cells of place.cell = {place.cell:g} units"
        yield Conflict("arena.side", rule, f"set it to [{sides[0]:g}, {sides[1]:g}], or choose another cell")


def _shown(side: float | tuple[float, float]) -> str:
    return " x ".join(f"{each:g}" for each in side) if isinstance(side, tuple) else f"{side:g} x {side:g}"


def _keepout(scenario: Sections) -> Iterator[Conflict]:
    """Find a map of no-go cells that isn't one of the place's cells."""
    place = scenario.place
    if not place.keepout:
        return
    cell, shape = place.map.cell if place.map else place.cell, shape_of(place, scenario.arena.size)
    found = cells_of(place.keepout.image).shape
    if (place.keepout.cell, found) != (cell, shape) and max(shape) <= MOST:
        (rows, columns), (height, width) = shape, found
        rule = f"must have {columns} x {rows} cells of {cell:g} units, as the place"
        value = f"{width} x {height} cells of {place.keepout.cell:g}"
        yield Conflict("place.keepout", rule, "name its file again, so that it is fitted to the place", value)


def _zone(scenario: Sections, name: str) -> Iterator[Conflict]:
    zone, zones = getattr(scenario, name).zone, scenario.place.zones
    if zone is None or zone in zones:
        return
    alike = difflib.get_close_matches(zone, zones, 1)
    remedy = f"add it to place.zones, or leave {name}.zone out"
    if alike:
        remedy = f"did you mean {alike[0]}?"
    elif zones:
        remedy = f"use one of {', '.join(zones)}"
    yield Conflict(f"{name}.zone", "must be the name of a zone of place.zones", remedy)


def _clusters(scenario: Sections, name: str) -> Iterator[Conflict]:
    if scenario.place.exists and getattr(scenario, name).placement == "clusters":
        remedy = f'set {name}.placement = "uniform", and {name}.zone to place them together'
        yield Conflict(f"{name}.placement", "can't be combined with a place", remedy)


PLACES: Final[tuple[Rule, ...]] = (
    never(
        "arena.boundary",
        lambda s: s.place.exists and s.arena.boundary != "walls",
        'must be "walls" around a place',
        'set arena.boundary = "walls"',
    ),
    _size,
    _keepout,
    *both(_zone, _clusters),
    never(
        "place.cell",
        lambda s: not s.place.exists and s.place.cell != Place().cell,
        "needs a place: this one has no map, walls, keepout or zones",
        "add place.walls, or leave it out",
    ),
    never(
        "radio.walls",
        lambda s: not s.place.exists and s.radio.walls > 0,
        "needs a place: without one, there are no walls on the way",
        "add [place], or leave it out",
    ),
)
"""All rules about places that need no passable cells."""
