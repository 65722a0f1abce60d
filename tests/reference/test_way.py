"""Ways around walls: who follows them arrives, and never at a wall (model.md 6.25.15).

The engine's ways are those of robots that act in the worlds of test_conformance.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError, reference
from feasibee.reference.way import Ways
from tests.places import bitmap, random_cells


class Walker:
    """A robot and a task in a place."""

    def __init__(self, scenario):
        plain = reference.Swarm(scenario, 1, 0)
        self.ground, self.longest = plain.world.ground, plain.robots[0].reach
        self.ways = Ways(self.ground, scenario.acting.reach)

    def walk(self, place, task):
        """Walk to a task; each step ends nearer to it, or in the same cell, and at no wall."""
        length = self.ways.length(place, task)
        while not self.ways.has_arrived(place, task):
            step = self.ways.step(place, task, self.longest)
            assert step != (0, 0)
            assert self.ground.ends(place, step) == 4
            before, place = place, (place[0] + step[0], place[1] + step[1])
            left = self.ways.length(place, task)
            assert left < length or self.ground.cell(place) == self.ground.cell(before)
            length = left


def world(closed, cell, speed=1.0, diameter=0.4):
    """Return a place in which robots act."""
    reach = max(1.0, speed, diameter)
    return Scenario(
        place={"map": bitmap(closed, cell)},
        robots={"count": 3, "diameter": diameter, "speed": speed},
        tasks={"count": 2},
        acting={"start": 0, "reach": reach},
    )


def drawn(random):
    """Return a valid random place."""
    while True:
        rows, columns = random.integers(12, 40, 2)
        closed = random_cells(random, rows, columns, random.integers(0, 12))
        cell, speed = float(random.choice([0.1, 0.3, 0.5, 1.2])), float(random.choice([0.2, 1.0, 1.5]))
        try:
            return world(closed, cell, speed, float(random.choice([0.2, 0.7])))
        except ScenarioError:
            continue


def within(random, cell, bits):
    """Return a random position in a cell."""
    return tuple(int(side * 2**bits + random.integers(0, 2**bits)) for side in cell)


@pytest.mark.parametrize("seed", range(12))
def test_who_follows_a_way_arrives(seed):
    random = np.random.default_rng(seed)
    walker = Walker(drawn(random))
    ground, passable, ways = walker.ground, sorted(walker.ground.passable), 0
    for _ in range(12):
        task = within(random, [int(random.integers(0, side)) for side in ground.size], ground.bits)
        for cell in (passable[k] for k in random.integers(0, len(passable), 5)):
            place = within(random, cell, ground.bits)
            if walker.ways.length(place, task) is not None:
                walker.walk(place, task)
                ways += 1
    assert ways


def length_of(closed, place, task, cell=0.5, **robots):
    """Return the way between the centres of two cells, and the passable cells."""
    walker = Walker(world(closed, cell, **robots))
    half = 1 << (walker.ground.bits - 1)
    ends = (tuple((side << walker.ground.bits) + half for side in each) for each in (place, task))
    return walker.ways.length(*ends), walker.ground.passable


def test_a_way_leads_around_a_wall_and_nobody_arrives_through_it():
    """The way up past a wall and down again costs 5 fifths for each side of a cell, and 7 for a corner."""
    closed = np.zeros((20, 20), bool)
    closed[:15, 10] = True
    length, passable = length_of(closed, (7, 4), (13, 4), speed=0.4, diameter=0.2)
    assert {(9, 14), (9, 15)}.isdisjoint(passable)
    assert (9, 16) in passable
    assert length == 2 * (7 + 11 * 5) + 4 * 5


def test_corners_arent_cut():
    """Next to the cells that a wall closes, two sides lead where one corner would."""
    closed = np.zeros((11, 11), bool)
    closed[5, 5] = True
    assert length_of(closed, (3, 6), (4, 7), speed=0.1, diameter=0.1)[0] == 10
    assert length_of(closed, (3, 7), (4, 8), speed=0.1, diameter=0.1)[0] == 7


def test_a_task_that_no_robot_reaches_has_no_way():
    """Neither one in a wall nor one in another room has a way."""
    closed = np.zeros((16, 16), bool)
    closed[:, 6:11] = True
    assert length_of(closed, (2, 8), (8, 8))[0] is None
    assert length_of(closed, (2, 8), (13, 8))[0] is None
    assert length_of(closed, (2, 8), (5, 8))[0] is not None, "next to the wall"
