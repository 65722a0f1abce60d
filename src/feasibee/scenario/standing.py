"""The rules about where robots and tasks stand in a place: they need its passable cells (model.md 6.20)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from feasibee.scenario.bitmaps import cells_of
from feasibee.scenario.ground import Ground, cells_at, ground_of, nearest
from feasibee.scenario.rules import Conflict
from feasibee.scenario.sections import Sections

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


def _full(scenario: Sections, ground: Ground) -> Conflict:
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


def _robots(scenario: Sections, ground: Ground) -> Iterator[Conflict]:
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


def _tasks(scenario: Sections, ground: Ground) -> Iterator[Conflict]:
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


def _changing(scenario: Sections, ground: Ground) -> Iterator[Conflict]:
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
