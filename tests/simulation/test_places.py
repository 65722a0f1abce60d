"""Swarms in places: no disc overlaps a wall (model.md 6.20, 6.21)."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from feasibee import Scenario, Swarm
from feasibee.reference.place import ground_of as reference_ground
from feasibee.scenario.runs import Runs
from feasibee.simulation import place
from tests.equal import assert_equal, assert_same_swarms
from tests.places import bitmap, rectangle, rooms

BODIES = {"robots.avoid_collisions": True, "robots.contact": "deflect"}


def in_place(walls=(), side=8.0, **changes):
    """Return a scenario in a place with these walls."""
    place = {"arena.boundary": "walls", "arena.side": side, "place.walls": walls}
    return Scenario().replace(place | {name.replace("__", "."): value for name, value in changes.items()})


@pytest.mark.parametrize("shape", [(1, 300), (300, 1), (130, 140)])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 1.0])
def test_boxes_hold_all_walls_and_nothing_else(shape, share):
    """Each box is within the tile that lists it; those after the last hold no cell."""
    walls, found = np.random.default_rng(1).random(shape) < share, np.zeros(shape, bool)
    boxes, tiles = place._boxes.__wrapped__(SimpleNamespace(walls=walls))
    for tile, (first, end) in enumerate(itertools.pairwise(tiles)):
        row, column = divmod(tile, -(-shape[1] // place.TILE))
        for left, right, top, bottom in boxes[:, first:end].T:
            assert {top // place.TILE, bottom // place.TILE} == {row}
            assert {left // place.TILE, right // place.TILE} == {column}
            found[top : bottom + 1, left : right + 1] = True
    np.testing.assert_array_equal(found, walls)
    left, right, top, bottom = boxes[:, tiles[-1] :]
    assert (left > right).all()
    assert (top > bottom).all()
    assert len(left) >= place.MOST_LANES


@pytest.mark.parametrize(
    ("count", "cells", "share", "walls", "sensing"),
    [
        (60, 140, 0.03, 0.6, {}),
        (130, 140, 0.03, 0.0, {"count_self": True}),
        (60, 28, 0.1, 0.0, {}),
        (130, 28, 0.1, 0.6, {}),
        (130, 28, 0.2, 0.0, {}),
    ],
)
def test_lines_among_scattered_walls(count, cells, share, walls, sensing):
    """Few robots and crowds, over several tiles; in large cells, lines often lead through their corners."""
    closed = np.random.default_rng(2).random((cells, cells)) < share
    tables = {
        "robots": {"count": count, "diameter": 0.05},
        "sensing": {"range": 2.5, **sensing},
        "radio": {"range": 3.0, "walls": walls},
        "decision": {"exploration": 2, "gain": 2},
    }
    scenario = Scenario(place={"map": bitmap(closed, 14 / cells)}, tasks={"count": 30}, **tables)
    assert_equal(scenario.replace({"run.steps": 280 // cells}), 1)


@pytest.mark.parametrize("speed", [0.4, 1.0, 3.0])
def test_no_disc_overlaps_a_wall(speed):
    """At no quarter of a step a centre is nearer than its radius to a wall; robots stay in their rooms."""
    walls = [*rooms(0, 12.0), rectangle(2.0, 2.0, 3.0, 2.2), rectangle(8.0, 6.0, 8.1, 9.0)]
    robots = {"robots__count": 24, "robots__diameter": 0.6, "robots__speed": speed, "run__steps": 300}
    swarm = Swarm(in_place(walls, 12.0, **robots).replace(BODIES), seed=5)
    start = before = swarm.positions
    for _ in range(300):
        swarm.advance(1)
        now = swarm.positions
        for part in (0.25, 0.5, 0.75, 1.0):
            places = before + part * (now - before)
            for (left, low), _, (right, top), _ in walls:
                nearest = np.clip(places, [left, low], [right, top])
                assert np.linalg.norm(places - nearest, axis=1).min() > 0.3
        assert ((now[:, 0] < 6) == (start[:, 0] < 6)).all()
        before = now
    assert np.linalg.norm(now - start, axis=1).mean() > 1.0


def test_fast_robots_deflect_along_walls():
    """Robots that may turn away at a wall stand still less often than those that may not."""
    standing = {}
    for contact in ("stand", "deflect"):
        swarm = Swarm(
            in_place(rooms(2.0), 20.0, robots__diameter=0.5).replace(BODIES | {"robots.contact": contact}), 2
        )
        places = [swarm.positions for _ in range(100) if swarm.advance(1) is None]
        standing[contact] = (np.diff(places, axis=0) == 0).all(axis=2).sum()
    assert standing["deflect"] < standing["stand"] / 2


# --- What is seen and heard past walls ---

CLOSED = np.zeros((80, 80), bool)
CLOSED[30:50, 46] = True
HIDDEN = {  # the wall or no-go area near one robot at (4.05, 4.05), a task's place, whether it is seen
    "a wall on the line": (rectangle(4.6, 3.5, 4.7, 5.0), [5.05, 4.05], False),
    "a wall beside the line": (rectangle(4.6, 4.2, 4.7, 5.0), [5.05, 4.05], True),
    "a wall behind the task": (rectangle(5.6, 3.0, 5.8, 5.0), [5.05, 4.05], True),
    "a corner on the line, which touches all four cells": (
        rectangle(4.5, 4.4, 4.6, 4.5),
        [5.05, 5.05],
        False,
    ),
    "a corner beside the line": (rectangle(4.5, 4.3, 4.6, 4.4), [5.05, 5.15], True),
    "a no-go area": (bitmap(CLOSED, 0.1), [5.05, 4.05], True),
}


@pytest.mark.parametrize("case", HIDDEN)
def test_walls_hide_what_is_behind_them(case):
    obstacle, task, seen = HIDDEN[case]
    robot = {
        "robots__count": 1,
        "robots__speed": 0.001,
        "robots__diameter": 0.2,
        "robots__placement": "points",
    }
    points = {"robots__points": [[4.05, 4.05]], "tasks__placement": "points", "tasks__points": [task]}
    scenario = in_place([obstacle] if isinstance(obstacle, list) else [], **robot, **points)
    swarm = Swarm(
        scenario if isinstance(obstacle, list) else scenario.replace({"place.keepout": obstacle}), 1
    )
    swarm.advance(1)
    assert swarm.robot(0).tasks_seen == (int(seen),)


@pytest.mark.parametrize(
    ("walls", "factor", "bits"),
    [(0, 0.0, True), (1, 0.0, False), (1, 1.0, True), (1, 0.6, True), (2, 0.6, False), (2, 0.8, True)],
)
def test_radio_by_walls(walls, factor, bits):
    """Two robots 1.2 apart, range 3: 0.6 lets one wall pass (1.8), not two (1.08); 0.8 two (1.92)."""
    between = [rectangle(4.3 + 0.4 * k, 0.0, 4.4 + 0.4 * k, 8.0) for k in range(walls)]
    robots = {
        "robots__count": 2,
        "robots__speed": 0.001,
        "robots__diameter": 0.1,
        "robots__placement": "points",
    }
    radio = {"radio__range": 3.0, "radio__walls": factor, "tasks__count": 0, "run__steps": 3}
    talk = {
        "decision__exploration": 0.1,
        "decision__gain": 1000.0,
        "robots__points": [[4.05, 4.05], [5.25, 4.05]],
    }
    scenario = in_place(between or [rectangle(0.0, 0.0, 0.1, 0.1)], **robots, **radio, **talk)
    tasks = {"tasks.count": 1, "tasks.placement": "points", "tasks.points": [[6.0, 6.0]]}
    assert_equal(scenario.replace(tasks), 1)
    swarm = Swarm(scenario, seed=1)
    swarm.advance(3)
    assert [bool(swarm.robot(i).heard) for i in range(2)] == [bits, bits]


def test_stretches_of_wall():
    """Walls in a row are counted one by one, and a touched corner is a wall of its own."""
    cells = np.zeros((16, 16), bool)
    cells[8, [2, 3, 6, 9]] = True
    cells[12, 12] = True
    scenario = Scenario(place={"map": bitmap(cells, 1.0)}, robots={"count": 1, "speed": 0.1, "diameter": 0.1})
    ground = reference_ground(scenario)

    def walls(a, b):
        return ground.walls_between(*((x * 2**ground.bits, y * 2**ground.bits) for x, y in (a, b)))

    assert walls((0, 8), (15, 8)) == walls((15, 8), (0, 8)) == 3
    assert walls((0, 7), (15, 7)) == 0
    assert walls((11, 13), (13, 11)) == 1, "through the cell"
    assert walls((11, 12), (12, 13)) == 1, "through its corner"
    assert walls((10, 12), (12, 14)) == 0, "past its corner"
    assert walls((10, 13), (11, 14)) == 0


# --- Where robots and tasks begin ---


def test_robots_in_zone_and_pieces():
    """Robots start in their zone, apart, and each piece has those that the truth counts."""
    robots = {
        "robots__count": 12,
        "robots__diameter": 0.5,
        "robots__avoid_collisions": True,
        "tasks__count": 30,
    }
    free = in_place(rooms(0), 20.0, **robots, place__zones={"dock": rectangle(0, 0, 5, 5)})
    assert (Swarm(free, seed=3).positions[:, 0] < 10).sum() == 6
    swarm = Swarm(free.replace({"robots.zone": "dock"}), seed=3)
    assert (swarm.positions < 5).all()
    assert math.dist(*swarm.positions[:2]) > 0.5
    assert (swarm.tasks[:, 0] < 10).all()


def test_crowded_dock():
    """Robots for whom 256 attempts find no place stand on a lattice, apart and in their zone."""
    robots = {"robots__count": 40, "robots__diameter": 0.5, "robots__avoid_collisions": True, "run__steps": 3}
    zone = {"place__zones": {"dock": rectangle(0, 0, 4, 4)}, "robots__zone": "dock"}
    scenario = in_place(**robots, **zone)
    positions = Swarm(scenario, seed=1).positions
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=2) + np.eye(40)
    assert apart.min() >= 0.5
    assert positions.max() < 4.0
    assert_equal(scenario, 1)


def test_of_equally_near_cells_the_first_leads_to_a_task():
    """Tasks stand where robots can't: four sides of a kept-out cell are as near (model.md 6.20.9)."""
    kept_out = np.zeros((24, 24), bool)
    kept_out[[6, 16], [6, 14]] = True
    scenario = in_place(
        side=24.0,
        place__keepout=bitmap(kept_out, 1.0),
        place__cell=1.0,
        robots__count=6,
        robots__diameter=0.6,
        robots__speed=0.6,
        tasks__placement="points",
        tasks__points=[[6.5, 6.5], [14.5, 16.5]],
        acting__start=0,
        sensing__range=6.0,
        run__steps=120,
    )
    assert_same_swarms(scenario, Runs(1, 3))
