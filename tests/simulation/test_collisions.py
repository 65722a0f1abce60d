"""Discs never overlap (model.md 6.2): at the start, after a step, and at no moment of one.

What is checked is recomputed here from positions alone, step by step, in floats (53 bits; positions: 32).
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError, Swarm, reference

SLACK = 1e-9
"""Units: of rounding in this file; the model's own is upwards, so that discs never overlap at all."""


def robots_for(coverage, sides, diameter):
    """Return how many discs cover a share of the area, and no more than the lattice has room for."""
    wide, high = sides
    room = math.floor(wide / diameter) * math.floor(high / diameter)
    return max(1, min(room, int(coverage * wide * high / (math.pi / 4 * diameter**2))))


def crowd(sides, boundary, count, diameter=1.0, speed=0.5, mean_run=5.0, **robots):
    return Scenario(
        arena={"side": list(sides), "boundary": boundary},
        robots={"count": count, "diameter": diameter, "speed": speed, "avoid_collisions": True, **robots},
        tasks={"count": 0},
        walk={"mean_run": mean_run},
        sensing={"range": min(sides) / 4},
    )


def random_crowd(generator):
    """Draw a small crowded world; every fourth is square."""
    sides = generator.uniform(3, 9, 2)
    sides = sides[[0, 0]] if generator.random() < 0.25 else sides
    boundary = generator.choice(["torus", "walls"])
    diameter = generator.uniform(0.1, 0.24) * min(sides)
    most = (min(sides) / 2 - diameter) / 2 if boundary == "torus" else min(sides) / 2
    count = min(robots_for(generator.uniform(0.05, 0.6), sides, diameter), 140)
    placement = generator.choice(["uniform", "clusters"])
    return crowd(
        [float(side) for side in sides],
        str(boundary),
        count,
        float(diameter),
        float(generator.uniform(0.01, 0.99) * most),
        float(generator.uniform(1, 10)),
        placement=str(placement),
        contact=str(generator.choice(["stand", "deflect"])),
    )


def wrapped(difference, scenario):
    if scenario.arena.boundary == "torus":
        sides = np.array(scenario.arena.size)
        difference = difference - np.round(difference / sides) * sides
    return difference


def nearest_approach(scenario, before, after):
    """Return the least distance of two centres at any moment of a step of straight motions."""
    first, second = np.triu_indices(len(before), 1)
    moves = wrapped(after - before, scenario)
    way = wrapped(before[second] - before[first], scenario)
    approach = moves[second] - moves[first]
    length = (approach**2).sum(axis=1)
    moment = np.clip(-(way * approach).sum(axis=1) / np.where(length > 0, length, 1), 0, 1)
    return np.hypot(*(way + moment[:, None] * approach).T).min(initial=math.inf)


def assert_within_walls(scenario, positions):
    if scenario.arena.boundary == "walls":
        radius = scenario.robots.diameter / 2
        assert positions.min() >= radius - SLACK
        assert (np.array(scenario.arena.size) - positions).min() >= radius - SLACK
    else:
        assert positions.min() >= 0
        assert (positions < np.array(scenario.arena.size)).all()


def assert_keeps_apart(scenario, seed, steps):
    """Check all of a run; return the share of its moves that were made."""
    swarm = Swarm(scenario, seed=seed)
    after, moved = swarm.positions, 0
    assert_within_walls(scenario, after)
    for _ in range(steps):
        before = after
        swarm.advance()
        after = swarm.positions
        assert nearest_approach(scenario, before, after) >= scenario.robots.diameter - SLACK
        assert_within_walls(scenario, after)
        lengths = np.hypot(*wrapped(after - before, scenario).T)
        stays = (after == before).all(axis=1)
        # A robot that turns often becomes slower by roundings, never faster.
        assert (np.abs(lengths[~stays] - scenario.robots.speed + 4e-7) < 5e-7).all()
        moved += (~stays).sum()
    return moved / steps / scenario.robots.count


@pytest.mark.slow
def test_no_two_discs_ever_overlap_in_thousands_of_small_crowds():
    """Catches an overlap at a start, between or within steps, half a move, and a disc in a wall."""
    generator = np.random.default_rng(3)
    shares = {"stand": [], "deflect": []}
    for seed in range(1200):
        scenario = random_crowd(generator)
        shares[scenario.robots.contact].append(assert_keeps_apart(scenario, seed, steps=6))
    stand, deflect = map(np.mean, shares.values())
    assert 0.2 < stand < deflect < 0.95  # there were both: moves and blocks


@pytest.mark.quick(2)
@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize("sides", [(31.0, 13.0), (20.0, 20.0)])
@pytest.mark.parametrize("coverage", [0.6, 0.3])
@pytest.mark.parametrize(
    ("speed", "contact"), [(0.1, "stand"), (1.0, "stand"), (0.1, "deflect"), (1.0, "deflect")]
)
def test_no_two_discs_ever_overlap_in_large_crowds(boundary, sides, coverage, speed, contact):
    """Catches what only a grid of many cells does wrong: a neighbour missed across a cell or the edge."""
    count = robots_for(coverage, sides, 1.0)
    scenario = crowd(sides, boundary, count, speed=speed, contact=contact)
    assert assert_keeps_apart(scenario, seed=1, steps=60) > 0


@pytest.mark.slow
def test_fast_discs_dont_jump_over_each_other():
    """Two on one line, each with a step of many diameters: apart after each step isn't enough."""
    for seed in range(300):
        contact = ("stand", "deflect")[seed % 2]
        scenario = crowd((12.0, 12.0), "torus", 6, diameter=1.0, speed=2.4, contact=contact)
        assert_keeps_apart(scenario, seed, steps=10)


# --- Blocked ---


@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_a_blocked_robot_stands_still_and_takes_another_heading(boundary):
    """Catches a robot that slides, bounces, or keeps pushing; and one that turns though it wasn't blocked."""
    scenario = crowd((6.0, 5.0), boundary, 18, speed=0.4, mean_run=1e6)
    swarm = reference.Swarm(scenario, 4, 0)
    blocked = 0
    for _ in range(40):
        before = [(robot.place, robot.velocity) for robot in swarm.robots]
        swarm.step()
        for robot, (place, velocity) in zip(swarm.robots, before, strict=True):
            if robot.place == place:
                assert robot.velocity != velocity
                blocked += 1
            else:
                assert robot.place == swarm.world.moved(place, velocity)
                assert robot.velocity == velocity
    assert 100 < blocked < 40 * 18


@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_a_blocked_robot_deflects_by_45_or_90_degrees_and_keeps_that_heading(boundary):
    """Catches other angles, a heading drawn though the robot went, and one kept though it stood."""
    swarm = reference.Swarm(crowd((6.0, 5.0), boundary, 18, speed=0.4, mean_run=1e6, contact="deflect"), 4, 0)
    turns, stood = set(), 0
    for _ in range(40):
        before = [(robot.place, robot.velocity) for robot in swarm.robots]
        swarm.step()
        for robot, (place, velocity) in zip(swarm.robots, before, strict=True):
            turn = np.degrees(np.angle(complex(*robot.velocity) / complex(*velocity)))
            if robot.place == place:
                stood += 1
                assert min(abs(turn - each) for each in (-90, -45, 0, 45, 90)) > 1e-3  # drawn
            else:
                assert robot.place == swarm.world.moved(place, robot.velocity)
                turns.add(round(float(turn), 6))
    assert turns == {-90.0, -45.0, 0.0, 45.0, 90.0}
    assert 30 < stood < 40 * 18


@pytest.mark.parametrize("contact", ["stand", "deflect"])
@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_the_order_of_robots_doesnt_matter(boundary, contact):
    """The reference visits its robots in the order of a list: shuffled before each step, nothing changes.

    The engine equals the reference bit for bit (test_conformance), so its order doesn't matter either.
    """
    scenario = crowd((6.0, 5.0), boundary, 18, speed=0.4, contact=contact)
    plain, mixed = reference.Swarm(scenario, 4, 0), reference.Swarm(scenario, 4, 0)
    generator = np.random.default_rng(1)
    for _ in range(30):
        mixed.robots = [mixed.robots[i] for i in generator.permutation(18)]
        plain.step()
        mixed.step()
        there = {robot.number: (robot.place, robot.velocity, robot.mind.opinion) for robot in mixed.robots}
        for robot in plain.robots:
            assert there[robot.number] == (robot.place, robot.velocity, robot.mind.opinion)


@pytest.mark.quick(2)
@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize(
    ("coverage", "speed"),
    [(0.3, 1.0), (0.6, 0.1)]
    + [pytest.param(*each, marks=pytest.mark.slow) for each in [(0.4, 0.5), (0.5, 0.25), (0.6, 0.05)]],
)
@pytest.mark.parametrize("contact", ["stand", "deflect"])
def test_nobody_freezes_while_there_is_room(boundary, coverage, speed, contact):
    """Every robot moves in each half of 1,600 steps, even where many start side by side."""
    count = robots_for(coverage, (12.0, 10.0), 1.0)
    scenario = crowd((12.0, 10.0), boundary, count, speed=speed, contact=contact)
    swarm = Swarm(scenario, seed=2)
    for _ in range(2):
        moved = np.zeros(scenario.robots.count, bool)
        for _ in range(800):
            before = swarm.positions
            swarm.advance()
            moved |= (swarm.positions != before).any(axis=1)
        assert moved.all(), f"{(~moved).sum()} of {moved.size} stood still"


# --- Room ---


@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize("placement", ["uniform", "clusters"])
def test_as_many_as_the_lattice_has_room_for_are_placed(boundary, placement):
    """Catches a lattice one site short, sites doubled, and one that sticks out of a wall."""
    scenario = crowd((7.3, 5.9), boundary, 35, speed=0.2, placement=placement)
    assert_keeps_apart(scenario, seed=1, steps=10)
    assert_keeps_apart(scenario.replace({"robots.count": 34}), seed=1, steps=10)


@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize("sides", [(31.0, 23.0), (27.0, 27.0)])
def test_places_of_a_crowd_are_those_of_the_reference(boundary, sides):
    """More than 512 robots are sorted into cells while they are placed."""
    scenario = crowd(sides, boundary, 600, diameter=0.7)
    there = [robot.place for robot in reference.Swarm(scenario, 1, 0).robots]
    unit = max(sides) / 2 ** (31 if boundary == "walls" else 32)
    assert np.abs(Swarm(scenario, seed=1).positions - np.array(there) * unit).max() < SLACK


@pytest.mark.parametrize("boundary", ["torus", "walls"])
@pytest.mark.parametrize("sides", [(6, 6), (6, 4), (20, 20)])
@pytest.mark.parametrize("diameter", [1.0, 0.7, 0.1, 1 / 3])
def test_the_room_that_is_told_is_there(boundary, sides, diameter):
    """A radius is rounded up to a unit of fixed point: where whole diameters just fit, one may be too many.

    Catches two robots put on one site, because the rule and the lattice count the sites differently.
    """
    wide, high = (float(f"{side * diameter:.12g}") for side in sides)
    with pytest.raises(ScenarioError) as caught:
        crowd((wide, high), boundary, 1000, diameter=diameter, speed=diameter / 10)
    room = int(re.search(r"must be at most (\d+)", str(caught.value))[1])
    assert (sides[0] - 1) * (sides[1] - 1) <= room <= sides[0] * sides[1]
    assert_keeps_apart(crowd((wide, high), boundary, room, diameter, diameter / 10), seed=1, steps=5)


def test_more_robots_than_fit_are_refused():
    with pytest.raises(ScenarioError, match=r"robots\.count = 36: must be at most 35, .*; use fewer"):
        crowd((7.3, 5.9), "walls", 36, speed=0.2)
    Scenario(arena={"side": 5.0}, robots={"count": 1000})  # they pass through each other


def test_given_points_that_overlap_are_refused_across_the_edge_of_a_torus_too():
    near = {"placement": "points", "points": [[0.3, 5.0], [9.5, 5.0]], "speed": 0.5}
    with pytest.raises(ScenarioError, match="robots 1 and 2 must be more than 1 units apart"):
        Scenario(arena={"side": 10.0}, robots={**near, "avoid_collisions": True})
    Scenario(arena={"side": 10.0}, robots=near)
    walled = {**near, "points": [[0.6, 5.0], [9.5, 5.0]], "avoid_collisions": True}
    Scenario(arena={"side": 10.0, "boundary": "walls"}, robots=walled)
