"""Bodies of few robots: floats find what exact integers find, and cases of contact by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from feasibee.engine.compile import entry
from feasibee.engine.layout import Link, Robot, Set, empty_state, first_room
from feasibee.engine.signatures import PARAMS, PART, STATE
from feasibee.engine.team import parts_of
from numba import boolean, void

from feasibee import Scenario
from feasibee.engine import few
from feasibee.engine.params import packed
from feasibee.reference.robot import eighth, steps_of
from feasibee.reference.world import World
from feasibee.simulation.lowering import lower


@entry(void(PARAMS, STATE, PART))
def find_colliding(params, state, part):
    sets, pairs = state.sets, state.heard[0]
    listed = few.list_pairs(params, state.robots, state.links[Link.CLOSE], sets[Set.THERE], pairs, part)
    few.find_meeting(params, state.robots, sets, pairs, listed, True)


@entry(boolean(PARAMS, STATE, PART))
def find_standing(params, state, part):
    """Return who stands; the steps of the other robots are those that they make."""
    return few.find_standing(params, state, part)


def world_of(robots, boundary, side=8.0, contact="stand"):
    return Scenario(
        arena={"side": side, "boundary": boundary},
        robots={
            "count": robots,
            "diameter": 1.0,
            "speed": 0.5,
            "avoid_collisions": True,
            "contact": contact,
        },
    )


def state_of(scenario, places, steps):
    """Return the numbers of a scenario, a state whose robots have these places and steps, and its part."""
    lowered = lower(scenario, 1)
    state = empty_state(lowered.params, lowered.tables, first_room(lowered.params))
    count = scenario.robots.count
    for row, values in zip((Robot.X, Robot.Y), np.array(places).T, strict=True):
        state.robots[row, :count] = values.astype(np.uint32).view(np.int32)
    for row, values in zip((Robot.STEP_X, Robot.STEP_Y), np.array(steps).T, strict=True):
        state.robots[row, :count] = values
    (part,) = parts_of(lowered.params)
    return packed(lowered.params), state, part


def members(words):
    """Return the robots of a set."""
    return {32 * w + k for w, word in enumerate(words) for k in range(32) if int(word) >> k & 1}


def found_and_expected(scenario, places, steps):
    """Return the set of colliding robots by the engine and by the reference's exact integers."""
    count, world = scenario.robots.count, World(scenario, 1, 0)
    params, state, part = state_of(scenario, places, steps)
    find_colliding(params, state, part)
    found = members(state.sets[Set.MET])
    expected = set()
    for i in range(count):
        for j in set(range(count)) - {i}:
            way = world.way(places[i], places[j])
            alone = (-steps[i][0], -steps[i][1])
            both = (alone[0] + steps[j][0], alone[1] + steps[j][1])
            if world.meet(way, alone) or world.meet(way, both):
                expected.add(i)
    return found, expected


@pytest.mark.quick(4)
@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize(
    ("robots", "side"), [(24, 8.0), (24, [8.0, 5.0]), (24, [5.0, 9.0]), (128, 18.0), (40, [9.0, 12.0])]
)
def test_the_quick_test_of_collisions_equals_exact_integers(boundary, robots, side):
    """Catches a sign, a robot taken for the other, and a pair round the torus."""
    generator = np.random.default_rng(1)
    scenario = world_of(robots, boundary, side)
    arena = lower(scenario, 1).params.arena
    reach = int(lower(scenario, 1).params.robots.reach)
    seen = set()
    for _ in range(100):
        places = [
            (int(x), int(y)) for x, y in generator.integers(0, (arena.width, arena.height), (robots, 2))
        ]
        steps = [(int(x), int(y)) for x, y in generator.integers(-reach // 2, reach // 2, (robots, 2))]
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


# --- Contact, by hand: both implementations ---


class Body:
    """What the rule of contact asks of a robot of the reference."""

    def __init__(self, place, velocity):
        self.place, self.velocity = place, velocity


def steps_made(places, steps, working, boundary="walls"):
    """Return the step of each robot in units, None for one that stands; both implementations agree on it."""
    scenario = world_of(len(places), boundary, contact="deflect")
    world = World(scenario, 1, 0)
    unit = float(1 / world.unit)
    places, steps = ([(round(x * unit), round(y * unit)) for x, y in each] for each in (places, steps))
    params, state, part = state_of(scenario, places, steps)
    state.sets[Set.WORKING, 0] = sum(1 << i for i in working)
    bodies = [Body(*each) for each in zip(places, steps, strict=True)]
    expected = steps_of(scenario.robots, world, bodies, [bodies[i] for i in working])
    assert find_standing(params, state, part) == state.sets[Set.BLOCKED].any()
    standing = members(state.sets[Set.BLOCKED])
    found = {
        body: (int(state.robots[Robot.STEP_X, i]), int(state.robots[Robot.STEP_Y, i]))
        for i, body in enumerate(bodies)
        if i in set(working) - standing
    }
    assert found == expected
    in_units = {body: tuple(part / unit for part in step) for body, step in found.items()}
    return [in_units.get(body) for body in bodies]


def turned(step, degrees):
    """Return a step turned to the left."""
    angle = math.radians(degrees)
    x, y = step
    return (
        x * math.cos(angle) - y * math.sin(angle),
        x * math.sin(angle) + y * math.cos(angle),
    )


EAST = (0.5, 0.0)
ALONE = {
    "nothing in its way": ((4.0, 4.0), EAST, 0),
    "straight at a wall: left, and 45 degrees aren't enough": ((7.3, 4.0), EAST, 90),
    "a wall on its left": ((7.3, 4.0), (0.4, -0.3), -45),
    "a wall on its right": ((7.3, 4.0), (0.4, 0.3), 45),
    "the west wall on its left": ((0.7, 4.0), (-0.4, 0.3), -45),
    "the north wall on its left": ((4.0, 7.3), (0.3, 0.4), -45),
    "the south wall on its left": ((4.0, 0.7), (-0.3, -0.4), -45),
    "a corner: walls on both sides": ((7.4, 7.4), (0.4, 0.3), None),
    "a corner it passes by": ((7.4, 7.1), (0.3, 0.4), 90),
}


@pytest.mark.parametrize("case", ALONE)
def test_a_robot_turns_away_from_walls_on_one_side_and_left_otherwise(case):
    place, step, degrees = ALONE[case]
    (made,) = steps_made([place], [step], [0])
    if degrees is None:
        assert made is None
    else:
        assert made == pytest.approx(turned(step, degrees), abs=1e-8)


@pytest.mark.parametrize("boundary", ["walls", "torus"])
@pytest.mark.parametrize(
    ("others", "degrees"),
    [
        ([(4.2, 4.3)], -45),  # on its left
        ([(4.2, 3.7)], 45),
        ([(4.45, 4.0)], 45),  # straight ahead
        ([(4.2, 3.7), (4.2, 4.95)], 45),  # one on its right blocks it; one further on its left doesn't
        ([(4.02, 4.3), (4.02, 3.3)], 90),  # on both sides
        ([(4.1, 4.0), (3.0, 5.1)], None),  # ahead and left
        ([(4.02, 4.3), (2.6, 2.92)], None),  # on its left, and one where it would turn to
        ([(4.02, 4.3), (2.6, 2.55)], -90),
    ],
)
def test_a_robot_turns_away_from_robots_that_stand(others, degrees, boundary):
    made = steps_made([(3.0, 4.0), *others], [EAST, *[(0.0, 0.0)] * len(others)], [0], boundary)
    if degrees is None:
        assert made[0] is None
    else:
        assert made[0] == pytest.approx(turned(EAST, degrees), abs=1e-8)


def test_two_robots_that_meet_head_on_pass_each_other():
    made = steps_made([(3.0, 4.0), (4.5, 4.0)], [EAST, (-0.5, 0.0)], [0, 1])
    assert made[0] == pytest.approx(turned(EAST, 45), abs=1e-8)
    assert made[1] == pytest.approx(turned((-0.5, 0.0), 45), abs=1e-8)


def test_of_two_robots_that_would_turn_into_one_gap_neither_goes_first():
    """Side by side they run into a wall, and turn towards each other: no order of the robots decides."""
    made = steps_made([(7.45, 3.2), (7.45, 4.3)], [(0.3, 0.4), (0.3, -0.4)], [0, 1])
    assert made == [None, None]


def test_a_turned_robot_is_never_faster():
    """The shortest possible steps, and steps of every angle: turning rounds towards 0."""
    for u in range(-9, 10):
        for v in range(-9, 10):
            for left in (True, False):
                x, y = eighth((u, v), left)
                assert x * x + y * y <= u * u + v * v
