"""Swarms in places: no disc overlaps a wall (model.md 6.20, 6.21)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario, Swarm, simulate
from feasibee.reference.place import Ground
from feasibee.reference.place import ground_of as reference_ground
from feasibee.simulation import place
from tests.equal import assert_equal
from tests.places import bitmap, rectangle, rooms


@pytest.fixture(params=[place.SHARP, 0])
def sharp(request, monkeypatch):
    """Let cells share bytes in small places, too; no other test finds arrays made so, whatever happens."""
    caches = place._tables, place._open_around
    monkeypatch.setattr(place, "SHARP", request.param)
    for each in caches:
        each.cache_clear()
    yield request.param
    for each in caches:
        each.cache_clear()


@pytest.mark.parametrize("radio", [{"range": 3.0, "walls": 0.6}, {}])
def test_crowd_once(sharp, radio):
    """Many robots in two rooms, with walls between some that see each other; cells may share bytes."""
    scenario = Scenario(
        arena={"boundary": "walls", "side": 12.0},
        place={"walls": rooms(2.0, 12.0), "cell": 0.2},
        robots={"count": 130, "diameter": 0.2, "avoid_collisions": True, "contact": "deflect"},
        tasks={"count": 40},
        sensing={"count_self": not radio},
        radio=radio,
        decision={"exploration": 2, "gain": 2},
        run={"steps": 20},
    )
    assert_equal(scenario, 1)


@pytest.mark.parametrize("speed", [0.4, 1.0, 3.0])
def test_no_disc_overlaps_a_wall(speed):
    """At no quarter of a step a centre is nearer than its radius to a wall; robots stay in their rooms."""
    walls = [*rooms(0, 12.0), rectangle(2.0, 2.0, 3.0, 2.2), rectangle(8.0, 6.0, 8.1, 9.0)]
    scenario = Scenario(
        arena={"boundary": "walls", "side": 12.0},
        place={"walls": walls},
        robots={"count": 24, "diameter": 0.6, "speed": speed, "avoid_collisions": True, "contact": "deflect"},
        run={"steps": 300},
    )
    swarm = Swarm(scenario, seed=5)
    rooms_at_start, before = swarm.positions[:, 0] < 6, swarm.positions
    for _ in range(300):
        swarm.advance(1)
        now = swarm.positions
        for part in (0.25, 0.5, 0.75, 1.0):
            places = before + part * (now - before)
            for (left, low), _, (right, top), _ in walls:
                nearest = np.clip(places, [left, low], [right, top])
                assert np.linalg.norm(places - nearest, axis=1).min() > 0.3
        assert ((now[:, 0] < 6) == rooms_at_start).all()
        before = now
    moved = np.linalg.norm(now - Swarm(scenario, seed=5).positions, axis=1)
    assert moved.mean() > 1.0


def test_fast_robots_deflect_along_walls():
    """Robots that may turn away at a wall stand still less often than those that may not."""
    standing = {}
    for contact in ("stand", "deflect"):
        scenario = Scenario(
            arena={"boundary": "walls"},
            place={"walls": rooms(2.0)},
            robots={"avoid_collisions": True, "contact": contact, "diameter": 0.5},
        )
        swarm, still = Swarm(scenario, seed=2), 0
        for _ in range(100):
            before = swarm.positions
            swarm.advance(1)
            still += int((swarm.positions == before).all(axis=1).sum())
        standing[contact] = still
    assert standing["deflect"] < standing["stand"] / 2


def by_hand(tasks, walls, **more):
    """Return what one robot in the middle of a hall counts of tasks in its first step."""
    scenario = Scenario(
        arena={"boundary": "walls", "side": 8.0},
        place={"walls": walls},
        robots={"count": 1, "speed": 0.001, "placement": "points", "points": [[4.05, 4.05]], "diameter": 0.2},
        tasks={"placement": "points", "points": tasks},
        decision={"exploration": 1000.0},
        run={"steps": 1},
        **more,
    )
    swarm = Swarm(scenario, seed=1)
    swarm.advance(1)
    return swarm.robot(0).tasks_seen[0]


@pytest.mark.parametrize(
    ("wall", "seen"),
    [
        (rectangle(4.6, 3.5, 4.7, 5.0), 0),
        (rectangle(4.6, 4.2, 4.7, 5.0), 1),
        (rectangle(5.6, 3.0, 5.8, 5.0), 1),
    ],
)
def test_walls_hide(wall, seen):
    """A task is hidden by a wall on the line to it, not by one to the side or behind it."""
    assert by_hand([[5.05, 4.05]], [wall]) == seen


def test_a_corner_hides():
    """A line through a corner touches all of the four cells there."""
    assert by_hand([[5.05, 5.05]], [rectangle(4.5, 4.4, 4.6, 4.5)]) == 0
    assert by_hand([[5.05, 5.15]], [rectangle(4.5, 4.3, 4.6, 4.4)]) == 1


def test_keepout_hides_nothing():
    """Who may not enter an area sees across."""
    cells = np.zeros((80, 80), bool)
    cells[30:50, 46] = True
    scenario = Scenario(
        arena={"boundary": "walls", "side": 8.0},
        place={"keepout": bitmap(cells, 0.1)},
        robots={"count": 1, "speed": 0.001, "placement": "points", "points": [[4.05, 4.05]], "diameter": 0.2},
        tasks={"placement": "points", "points": [[5.05, 4.05]]},
        decision={"exploration": 1000.0},
        run={"steps": 1},
    )
    swarm = Swarm(scenario, seed=1)
    swarm.advance(1)
    assert swarm.robot(0).tasks_seen == (1,)


@pytest.mark.parametrize(
    ("walls", "factor", "bits"),
    [(0, 0.0, True), (1, 0.0, False), (1, 1.0, True), (1, 0.6, True), (2, 0.6, False), (2, 0.8, True)],
)
def test_radio_by_walls(walls, factor, bits):
    """Two robots 1.2 apart, range 3: 0.6 lets one wall pass (1.8), not two (1.08); 0.8 two (1.92)."""
    between = [rectangle(4.3 + 0.4 * k, 0.0, 4.4 + 0.4 * k, 8.0) for k in range(walls)]
    scenario = Scenario(
        arena={"boundary": "walls", "side": 8.0},
        place={"walls": between},
        robots={
            "count": 2,
            "speed": 0.001,
            "diameter": 0.1,
            "placement": "points",
            "points": [[4.05, 4.05], [5.25, 4.05]],
        },
        tasks={"count": 0},
        radio={"range": 3.0, "walls": factor},
        decision={"exploration": 0.1, "gain": 1000.0},
        run={"steps": 3},
    )
    swarm = Swarm(scenario, seed=1)
    swarm.advance(3)
    assert [bool(swarm.robot(i).heard) for i in range(2)] == [bits, bits]
    assert_equal(scenario, 1)


def test_stretches_of_wall():
    """Walls in a row are counted one by one, and a touched corner is a wall of its own."""
    cells = np.zeros((16, 16), bool)
    cells[8, [2, 3, 6, 9]] = True
    cells[12, 12] = True
    scenario = Scenario(place={"map": bitmap(cells, 1.0)}, robots={"count": 1, "speed": 0.1, "diameter": 0.1})
    ground = reference_ground(scenario)
    assert isinstance(ground, Ground)

    def walls(a, b):
        return ground.walls_between(*((x * 2**ground.bits, y * 2**ground.bits) for x, y in (a, b)))

    assert walls((0, 8), (15, 8)) == walls((15, 8), (0, 8)) == 3
    assert walls((0, 7), (15, 7)) == 0
    assert walls((11, 13), (13, 11)) == 1, "through the cell"
    assert walls((11, 12), (12, 13)) == 1, "through its corner"
    assert walls((10, 12), (12, 14)) == 0, "past its corner"
    assert walls((10, 13), (11, 14)) == 0


def test_robots_in_zone_and_pieces():
    """Robots start in their zone, apart, and each piece has those that the truth counts."""
    scenario = Scenario(
        arena={"boundary": "walls"},
        place={"walls": rooms(0), "zones": {"dock": rectangle(0, 0, 5, 5)}},
        robots={"count": 12, "zone": "dock", "diameter": 0.5, "avoid_collisions": True},
        tasks={"count": 30},
    )
    positions = Swarm(scenario, seed=3).positions
    assert (positions < 5).all()
    assert math.dist(*positions[:2]) > 0.5
    swarm = Swarm(scenario.replace({"robots.zone": None}), seed=3)
    assert (swarm.positions[:, 0] < 10).sum() == 6
    assert (Swarm(scenario, seed=3).tasks[:, 0] < 10).all()


def test_crowded_dock():
    """Robots for whom 256 attempts find no place stand on a lattice, apart and in their zone."""
    scenario = Scenario(
        arena={"boundary": "walls", "side": 8.0},
        place={"zones": {"dock": rectangle(0, 0, 4, 4)}},
        robots={"count": 40, "zone": "dock", "diameter": 0.5, "avoid_collisions": True},
        run={"steps": 3},
    )
    positions = Swarm(scenario, seed=1).positions
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=2) + np.eye(40)
    assert apart.min() >= 0.5
    assert positions.max() < 4.0
    assert_equal(scenario, 1)


def test_results_of_several_runs():
    """Runs in a place are decided like others."""
    results = simulate(
        Scenario(arena={"boundary": "walls"}, place={"walls": rooms(4.0)}, tasks={"count": 10}),
        runs=20,
        seed=1,
    )
    assert (results.decision.values >= 0).mean() > 0.5
