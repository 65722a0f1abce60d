"""Ways around walls: engine and reference agree, and who follows them arrives (model.md 6.25.15)."""

from __future__ import annotations

import numpy as np
import pytest
from feasibee.engine.compile import entry
from feasibee.engine.layout import Point, Robot, empty_state, first_room
from feasibee.engine.signatures import PARAMS, STATE
from numba import int64, void

from feasibee import Scenario, ScenarioError
from feasibee.engine import way
from feasibee.engine.params import packed
from feasibee.reference.place import ground_of
from feasibee.reference.way import Ways
from feasibee.simulation.lowering import lower
from tests.places import bitmap, random_cells


@entry(int64(PARAMS, STATE, int64, int64))
def way_to(params, state, i, task):
    return way.way_around(params, state, i, task)


@entry(void(PARAMS, STATE, int64, int64))
def set_step(params, state, i, task):
    u, v = way.step_around(params, state, i, task)
    state.robots[Robot.STEP_X, i], state.robots[Robot.STEP_Y, i] = u, v


class Walker:
    """A robot and a task in a place, in the engine and in the reference."""

    def __init__(self, scenario):
        lowered = lower(scenario, 1)
        self.params = packed(lowered.params)
        self.state = empty_state(lowered.params, lowered.tables, first_room(lowered.params))
        self.ground = ground_of(scenario)
        self.ways = Ways(self.ground, scenario.acting.reach)
        self.longest = lowered.params.robots.reach
        self.arrived = lowered.params.arena.place.arrived

    def put(self, place, task):
        """Place robot and task."""
        self.state.robots[[Robot.X, Robot.Y], 0] = place
        self.state.tasks[[Point.X, Point.Y], 0] = task
        self.state.ways[0, 0] = 0

    def way(self):
        """Return the robot's way in the engine, or None."""
        found = way_to(self.params, self.state, 0, 0)
        return None if found == way.NO_WAY else found

    def step(self):
        """Return the robot's step in the engine."""
        set_step(self.params, self.state, 0, 0)
        return tuple(map(int, self.state.robots[[Robot.STEP_X, Robot.STEP_Y], 0]))

    def walk(self, place, task):
        """Walk to a task, and see that both minds take the same ways; return the number of steps."""
        self.put(place, task)
        length, steps = self.way(), 0
        while length > self.arrived:
            assert not self.ways.has_arrived(place, task)
            step = self.step()
            assert step == self.ways.step(place, task, self.longest)
            assert self.ground.ends(place, step) == 4
            before, place, steps = place, (place[0] + step[0], place[1] + step[1]), steps + 1
            self.state.robots[[Robot.X, Robot.Y], 0] = place
            assert self.way() < length or self.ground.cell(place) == self.ground.cell(before)
            assert place != before
            length = self.way()
            assert length == self.ways.length(place, task)
        assert self.ways.has_arrived(place, task)
        return steps


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


@pytest.mark.parametrize("seed", range(25))
def test_two_ways(seed):
    """Ways, steps and arrivals of random places are those of the reference; steps avoid walls and end."""
    random = np.random.default_rng(seed)
    walker = Walker(drawn(random))
    ground, passable = walker.ground, sorted(walker.ground.passable)
    for _ in range(12):
        column, row = (int(random.integers(0, side)) for side in ground.size)
        task = within(random, (column, row), ground.bits)
        walker.put((0, 0), task)
        for cell in (passable[k] for k in random.integers(0, len(passable), 5)):
            place = within(random, cell, ground.bits)
            walker.state.robots[[Robot.X, Robot.Y], 0] = place
            assert walker.way() == walker.ways.length(place, task)
            if walker.way() is not None:
                walker.walk(place, task)


def walker_at(closed, place, task, cell=0.5, **robots):
    """Return a walker of which both minds say the same: one robot and task, at cells' centres."""
    walker = Walker(world(closed, cell, **robots))
    half = 1 << (walker.ground.bits - 1)
    walker.put(*(tuple((side << walker.ground.bits) + half for side in each) for each in (place, task)))
    return walker


def test_a_way_leads_around_a_wall_and_nobody_arrives_through_it():
    """The way up past a wall and down again costs 5 fifths for each side of a cell, and 7 for a corner."""
    closed = np.zeros((20, 20), bool)
    closed[:15, 10] = True
    walker = walker_at(closed, (7, 4), (13, 4), speed=0.4, diameter=0.2)
    assert {(9, 14), (9, 15)}.isdisjoint(walker.ground.passable)
    assert (9, 16) in walker.ground.passable
    assert walker.way() == 2 * (7 + 11 * 5) + 4 * 5


def test_corners_arent_cut():
    """Next to the cells that a wall closes, two sides lead where one corner would."""
    closed = np.zeros((11, 11), bool)
    closed[5, 5] = True
    assert walker_at(closed, (3, 6), (4, 7), speed=0.1, diameter=0.1).way() == 10
    assert walker_at(closed, (3, 7), (4, 8), speed=0.1, diameter=0.1).way() == 7


def test_a_task_that_no_robot_reaches_has_no_way():
    """Neither one in a wall nor one in another room has a way."""
    closed = np.zeros((16, 16), bool)
    closed[:, 6:11] = True
    assert walker_at(closed, (2, 8), (8, 8)).way() is None
    assert walker_at(closed, (2, 8), (13, 8)).way() is None
    assert walker_at(closed, (2, 8), (5, 8)).way() is not None, "next to the wall"
