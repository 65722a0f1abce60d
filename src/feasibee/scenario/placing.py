"""The rules about a place (model.md 6.20): its fields, and where robots and tasks stand in it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from feasibee.base.codes import exact
from feasibee.scenario.cells import MOST, cells_of
from feasibee.scenario.fields import Place
from feasibee.scenario.ground import Surface, cells_at, ground_of, nearest, shape_of, size_of
from feasibee.scenario.rules import Breaks, Conflict, Rule, both, rows
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


OF_BORDERS: Final[Mapping[str, Breaks]] = {
    'arena.boundary: must be "walls" around a place; set arena.boundary = "walls"': lambda s: (
        s.place.exists and s.arena.boundary != "walls"
    ),
}
OF_NO_PLACE: Final[Mapping[str, Breaks]] = {
    "place.cell: needs a place: this one has no map, walls, keepout or zones"
    "; add place.walls, or leave it out": lambda s: not s.place.exists and s.place.cell != Place().cell,
    "radio.walls: needs a place: without one, there are no walls on the way"
    "; add [place], or leave it out": lambda s: not s.place.exists and s.radio.walls > 0,
}
PLACES: Final[tuple[Rule, ...]] = (
    *rows(OF_BORDERS),
    _size,
    _keepout,
    *both(_zone, _clusters),
    *rows(OF_NO_PLACE),
)
"""All rules about places that need no passable cells."""


# --- Passable cells, in which robots and tasks stand, one thing after the other ---


_NEGATE: Final = "in a .yaml file, write negate: 0 if the image has dark walls, negate: 1 if white ones"


def standing(scenario: Sections) -> Iterator[Conflict]:
    """Find what keeps robots or tasks from standing anywhere, one thing after the other.

    The place, its robots' number and speed must be valid: passable cells are computed from them.
    """
    ground = ground_of(scenario)
    if ground is None:
        return
    if not ground.passable.any():
        yield _full(scenario, ground)
        return
    found = [*_robots(scenario, ground)] or [*_tasks(scenario, ground)] or [*_changing(scenario, ground)]
    yield from found


def _full(scenario: Sections, ground: Surface) -> Conflict:
    """Return the problem of a place without a passable cell: that of the field that closes most cells."""
    place, plan = scenario.place, ground.plan
    mapped = int(cells_of(place.map.image).sum()) if place.map else 0
    closed = {
        "place.walls": int(plan.walls.sum()) - mapped,
        "place.map": mapped,
        "place.keepout": int(plan.keepout.sum()),
    }
    path = max(closed, key=closed.__getitem__)
    rule = f"leaves no cell in which a robot of diameter {scenario.robots.diameter:g} could be"
    if not closed[path]:
        return Conflict("robots.diameter", rule, "use smaller robots, or enlarge arena.side")
    value = f"{closed[path]:,} closed cells of {plan.walls.size:,}"
    if path == "place.walls":
        return Conflict(path, rule, "use smaller robots, or fewer walls", value)
    return Conflict(path, rule, f"use smaller robots; {_NEGATE}", value)


def _robots(scenario: Sections, ground: Surface) -> Iterator[Conflict]:
    robots = scenario.robots
    if robots.placement == "points":
        for number in np.flatnonzero(ground.robots.piece == 0):
            rule = f"point {number + 1}: a robot of diameter {robots.diameter:g} is too near a wall there"
            yield Conflict("robots.points", rule, "move the point", robots.points[number])
        return
    if not len(ground.robots.cells):
        rule = f"has no cell in which a robot of diameter {robots.diameter:g} could be"
        yield Conflict("robots.zone", rule, "enlarge the zone, or use smaller robots")
        return
    for piece, (xs, _) in enumerate(ground.lattice if robots.avoid_collisions else (), start=1):
        inside = int((ground.robots.piece == piece).sum())
        if inside > len(xs):
            where = f"zone {robots.zone}" if robots.zone else f"piece {piece} of the place"
            rule = f"puts {inside} robots into {where}, where {len(xs)} discs fit on a square grid"
            remedy = "use fewer or smaller robots, or a larger zone"
            yield Conflict("robots.count", rule, remedy)


def _tasks(scenario: Sections, ground: Surface) -> Iterator[Conflict]:
    tasks = scenario.tasks
    if tasks.placement != "points":
        if not len(ground.tasks.cells):
            yield Conflict(
                "tasks.zone", "has no cell that a robot reaches", "enlarge the zone, or open a way"
            )
        return
    walls = ground.plan.walls.ravel()[cells_at(ground.plan, tasks.points)]
    for number in np.flatnonzero(walls):
        rule = f"point {number + 1}: is in a wall"
        yield Conflict("tasks.points", rule, "move the point", tasks.points[number])


def _changing(scenario: Sections, ground: Surface) -> Iterator[Conflict]:
    if scenario.dynamic and not ground.is_one:
        rule = "has parts that no robot leaves, but the world of this scenario changes"
        remedy = "open a way between them, set robots.zone, or leave out events, rates and missing robots"
        yield Conflict("place", rule, remedy, f"{int(ground.pieces.max())} pieces")
        return
    for number, event in enumerate(scenario.events):
        if event.at is None:
            continue
        (cell,) = cells_at(ground.plan, [event.at])
        pieces = ground.pieces
        piece = nearest(pieces, cell, ground.near) if event.of_tasks else int(pieces.flat[cell])
        if ground.plan.walls.flat[cell] or piece != ground.robots.piece[0]:
            yield Conflict(f"events.{number}.at", "is in a wall, or where no robot gets", "move the point")
