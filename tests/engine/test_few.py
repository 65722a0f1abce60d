"""Collisions of up to 32 robots: floats find what exact integers find, also where floats can't tell."""

from __future__ import annotations

import numpy as np
import pytest
from numba import uint32

from feasibee import Scenario
from feasibee.engine import few
from feasibee.engine.allocation import empty_state, first_room
from feasibee.engine.compile import entry
from feasibee.engine.layout import Robot, Set
from feasibee.engine.params import packed
from feasibee.engine.signatures import PARAMS, STATE
from feasibee.reference.world import World
from feasibee.simulation.lowering import lower


@entry(uint32(PARAMS, STATE))
def find_colliding(params, state):
    return few.find_colliding(params, state.robots, state.links, state.sets[Set.THERE, 0])


def world_of(robots, boundary, side=8.0):
    return Scenario(
        arena={"side": side, "boundary": boundary},
        robots={"count": robots, "diameter": 1.0, "speed": 0.5, "avoid_collisions": True},
    )


def found_and_expected(scenario, places, steps):
    """Return the set of colliding robots by the engine and by the reference's exact integers."""
    lowered = lower(scenario, 1)
    state = empty_state(lowered.params, lowered.tables, first_room(lowered.params))
    count, world = scenario.robots.count, World(scenario, 1, 0)
    for row, values in zip((Robot.X, Robot.Y), np.array(places).T, strict=True):
        state.robots[row, :count] = values.astype(np.uint32).view(np.int32)
    for row, values in zip((Robot.STEP_X, Robot.STEP_Y), np.array(steps).T, strict=True):
        state.robots[row, :count] = values
    word = int(find_colliding(packed(lowered.params), state))
    found = {i for i in range(32) if word >> i & 1}
    expected = set()
    for i in range(count):
        for j in set(range(count)) - {i}:
            way = world.way(places[i], places[j])
            alone = (-steps[i][0], -steps[i][1])
            both = (alone[0] + steps[j][0], alone[1] + steps[j][1])
            if world.meet(way, alone) or world.meet(way, both):
                expected.add(i)
    return found, expected


@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize("side", [8.0, [8.0, 5.0], [5.0, 9.0]])
def test_the_quick_test_of_collisions_equals_exact_integers(boundary, side):
    """Catches a sign, a robot taken for the other, and a pair round the torus."""
    generator = np.random.default_rng(1)
    scenario = world_of(24, boundary, side)
    arena = lower(scenario, 1).params.arena
    reach = int(lower(scenario, 1).params.robots.reach)
    seen = set()
    for _ in range(100):
        places = [(int(x), int(y)) for x, y in generator.integers(0, (arena.width, arena.height), (24, 2))]
        steps = [(int(x), int(y)) for x, y in generator.integers(-reach, reach, (24, 2))]
        found, expected = found_and_expected(scenario, places, steps)
        assert found == expected
        seen.add(len(found))
    assert len(seen) > 3


@pytest.mark.parametrize("more", [-1, 0, 1])
def test_a_distance_that_floats_cant_tell_is_compared_exactly(more):
    """The step is a Pythagorean triple, and the discs pass at their diameter less or more by one in 2**56."""
    scenario = world_of(2, "walls")
    diameter = 2 * World(scenario, 1, 0).radius
    m, n = 9001, 5000
    dx, dy, length = m * m - n * n, 2 * m * n, m * m + n * n
    across = diameter * length + more  # way_x dy - way_y dx
    way_x = across * pow(dy, -1, dx) % dx
    way_y = (way_x * dy - across) // dx
    turns = -(way_x * dx + way_y * dy) // length**2  # so that they pass within the step
    way = (way_x + turns * dx, way_y + turns * dy)
    assert way[0] * dy - way[1] * dx == across
    assert -(length**2) < way[0] * dx + way[1] * dy < 0
    place = (2**30, 2**30)
    found, expected = found_and_expected(
        scenario, [place, (place[0] + way[0], place[1] + way[1])], [(-dx, -dy), (0, 0)]
    )
    assert found == expected
    assert (0 in found) == (more < 0)


def test_opposite_robots_both_take_the_way_round_in_the_same_direction():
    """Half the torus is as far one way as the other, and the ways of two robots are equal, not opposite."""
    scenario = world_of(2, "torus", 4.0)
    half, quarter = 2**31, 2**30
    for steps in ([(quarter, 0), (0, 0)], [(-quarter, 0), (0, 0)], [(quarter, 0), (quarter // 2, 0)]):
        found, expected = found_and_expected(scenario, [(0, 0), (half, 0)], steps)
        assert found == expected
