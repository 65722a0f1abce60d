"""Bodies: a step of robots at given places with given velocities, in the engine and in the reference."""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario, Swarm, reference
from feasibee.reference.robot import eighth


class Bodies:
    """A swarm in both implementations, whose robots are put anywhere."""

    def __init__(self, robots, boundary, side=8.0, contact="stand"):
        about = {"diameter": 1.0, "speed": 0.5, "avoid_collisions": True, "contact": contact}
        arena = {"side": side, "boundary": boundary}
        self.scenario = Scenario(arena=arena, robots={"count": robots, **about})
        self.plain = reference.Swarm(self.scenario, 1, 0)
        self.swarm = Swarm(self.scenario, 1, 0)
        self.world = self.plain.world

    def steps_made(self, places, steps):
        """Return the way that each robot goes in a step, which is the same in both."""
        count, numbers = len(places), self.swarm._state.robots
        for rows, values in ((("X", "Y"), places), (("STEP_X", "STEP_Y"), steps)):
            for row, column in zip(rows, np.array(values).T, strict=True):
                numbers[row][:count] = column.astype(np.uint32).view(np.int32)
        numbers["WALK_LEFT"][:count] = 1000
        for robot, place, step in zip(self.plain.robots, places, steps, strict=True):
            robot.place, robot.velocity, robot._walk_left = place, step, 1000
        self.swarm.advance()
        self.plain.step()
        found = np.array([numbers[row][:count] for row in ("X", "Y")]).T.astype(np.uint32)
        np.testing.assert_array_equal(found, [each.place for each in self.plain.robots])
        return [
            self.world.way(place, robot.place) for place, robot in zip(places, self.plain.robots, strict=True)
        ]


@pytest.mark.quick(4)
@pytest.mark.parametrize("contact", ["stand", "deflect"])
@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize(
    ("robots", "side"), [(24, 8.0), (24, [8.0, 5.0]), (24, [5.0, 9.0]), (128, 18.0), (40, [9.0, 12.0])]
)
def test_the_quick_test_of_collisions_equals_exact_integers(contact, boundary, robots, side):
    """Catches a sign, a robot taken for the other, and a pair round the torus; places may overlap."""
    generator = np.random.default_rng(1)
    bodies = Bodies(robots, boundary, side, contact)
    reach, blocked = int(bodies.plain.robots[0].reach), set()
    for _ in range(40):
        places = [tuple(map(int, each)) for each in generator.integers(0, bodies.world.size, (robots, 2))]
        steps = [tuple(map(int, each)) for each in generator.integers(-reach // 2, reach // 2, (robots, 2))]
        made = bodies.steps_made(places, steps)
        blocked.add(made.count((0, 0)))
    assert len(blocked) > 3


@pytest.mark.parametrize("more", [-1, 0, 1])
def test_a_distance_that_floats_cant_tell_is_compared_exactly(more):
    """The step is a Pythagorean triple, and the discs pass at their diameter less or more by one in 2**56."""
    bodies = Bodies(2, "walls")
    diameter = 2 * bodies.world.radius
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
    made = bodies.steps_made([place, (place[0] + way[0], place[1] + way[1])], [(-dx, -dy), (0, 0)])
    assert (made[0] == (0, 0)) == (more < 0)


def test_opposite_robots_both_take_the_way_round_in_the_same_direction():
    """Half the torus is as far one way as the other, and the ways of two robots are equal, not opposite."""
    half, quarter = 2**31, 2**30
    for steps in ([(quarter, 0), (0, 0)], [(-quarter, 0), (0, 0)], [(quarter, 0), (quarter // 2, 0)]):
        Bodies(2, "torus", 4.0).steps_made([(0, 0), (half, 0)], steps)


# --- Contact, by hand ---


def steps_made(places, steps, boundary="walls"):
    """Return the step of each robot in units, None for one that stands; both implementations agree on it."""
    bodies = Bodies(len(places), boundary, contact="deflect")
    unit = float(1 / bodies.world.unit)
    places, steps = ([(round(x * unit), round(y * unit)) for x, y in each] for each in (places, steps))
    made = bodies.steps_made(places, steps)
    return [tuple(part / unit for part in step) if any(step) else None for step in made]


def turned(step, degrees):
    """Return a step turned to the left."""
    angle = math.radians(degrees)
    x, y = step
    return (x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle))


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
    (made,) = steps_made([place], [step])
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
    made = steps_made([(3.0, 4.0), *others], [EAST, *[(0.0, 0.0)] * len(others)], boundary)
    if degrees is None:
        assert made[0] is None
    else:
        assert made[0] == pytest.approx(turned(EAST, degrees), abs=1e-8)


def test_two_robots_that_meet_head_on_pass_each_other():
    made = steps_made([(3.0, 4.0), (4.5, 4.0)], [EAST, (-0.5, 0.0)])
    assert made[0] == pytest.approx(turned(EAST, 45), abs=1e-8)
    assert made[1] == pytest.approx(turned((-0.5, 0.0), 45), abs=1e-8)


def test_of_two_robots_that_would_turn_into_one_gap_neither_goes_first():
    """Side by side they run into a wall, and turn towards each other: no order of the robots decides."""
    made = steps_made([(7.45, 3.2), (7.45, 4.3)], [(0.3, 0.4), (0.3, -0.4)])
    assert made == [None, None]


def test_a_turned_robot_is_never_faster():
    """The shortest possible steps, and steps of every angle: turning rounds towards 0."""
    for u in range(-9, 10):
        for v in range(-9, 10):
            for left in (True, False):
                x, y = eighth((u, v), left)
                assert x * x + y * y <= u * u + v * v
