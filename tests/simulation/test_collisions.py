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
BOUNDARIES = pytest.mark.parametrize("boundary", ["torus", "walls"])
CONTACTS = pytest.mark.parametrize("contact", ["stand", "deflect"])


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
    boundary = str(generator.choice(["torus", "walls"]))
    diameter = generator.uniform(0.1, 0.24) * min(sides)
    most = (min(sides) / 2 - diameter) / 2 if boundary == "torus" else min(sides) / 2
    count = min(robots_for(generator.uniform(0.05, 0.6), sides, diameter), 140)
    words = {"placement": ["uniform", "clusters"], "contact": ["stand", "deflect"]}
    speed, run = float(generator.uniform(0.01, 0.99) * most), float(generator.uniform(1, 10))
    chosen = {name: str(generator.choice(each)) for name, each in words.items()}
    return crowd(sides.tolist(), boundary, count, float(diameter), speed, run, **chosen)


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


def assert_keeps_apart(scenario, seed, steps):
    """Check all of a run; return the share of its moves that were made."""
    swarm, robots, sides = Swarm(scenario, seed=seed), scenario.robots, np.array(scenario.arena.size)
    radius = robots.diameter / 2 - SLACK if scenario.arena.boundary == "walls" else 0.0
    moved, after = 0, swarm.positions
    assert_inside(after, sides, radius)
    for _ in range(steps):
        before = after
        swarm.advance()
        after = swarm.positions
        assert_inside(after, sides, radius)
        assert nearest_approach(scenario, before, after) >= robots.diameter - SLACK
        lengths = np.hypot(*wrapped(after - before, scenario).T)
        stays = (after == before).all(axis=1)
        # A robot that turns often becomes slower by roundings, never faster.
        assert (np.abs(lengths[~stays] - robots.speed + 4e-7) < 5e-7).all()
        moved += (~stays).sum()
    return moved / steps / robots.count


def assert_inside(places, sides, radius):
    assert places.min() >= radius
    assert (places < sides - radius).all()


@pytest.mark.parametrize("seeds", [range(60), pytest.param(range(60, 1200), marks=pytest.mark.slow)], ids=len)
def test_no_two_discs_ever_overlap_in_small_crowds(seeds):
    """Catches an overlap at a start, between or within steps, half a move, and a disc in a wall."""
    shares = {"stand": [], "deflect": []}
    for seed in seeds:
        scenario = random_crowd(np.random.default_rng(seed))
        shares[scenario.robots.contact].append(assert_keeps_apart(scenario, seed, steps=6))
    stand, deflect = map(np.mean, shares.values())
    assert 0.2 < stand < deflect < 0.95  # there were both: moves and blocks


@pytest.mark.quick(2)
@pytest.mark.parametrize("contact", ["stand", "deflect"])
@pytest.mark.parametrize(
    ("boundary", "sides", "coverage", "speed"),
    [
        ("torus", (31.0, 13.0), 0.6, 0.1),
        ("walls", (31.0, 13.0), 0.3, 1.0),
        ("torus", (20.0, 20.0), 0.3, 1.0),
        ("walls", (20.0, 20.0), 0.6, 0.1),
        ("torus", (31.0, 13.0), 0.3, 0.1),
        ("walls", (20.0, 20.0), 0.6, 1.0),
    ],
)
def test_no_two_discs_ever_overlap_in_large_crowds(boundary, sides, coverage, speed, contact):
    """Catches what only a grid of many cells does wrong: a neighbour missed across a cell or the edge."""
    count = robots_for(coverage, sides, 1.0)
    scenario = crowd(sides, boundary, count, speed=speed, contact=contact)
    assert assert_keeps_apart(scenario, seed=1, steps=60) > 0


# --- Blocked ---


def steps_of(boundary, contact):
    """Yield place and velocity before and after each step of each robot of a crowd, in the reference."""
    swarm = reference.Swarm(crowd((6.0, 5.0), boundary, 18, speed=0.4, mean_run=1e6, contact=contact), 4, 0)
    for _ in range(40):
        before = [(robot.place, robot.velocity) for robot in swarm.robots]
        swarm.step()
        for robot, old in zip(swarm.robots, before, strict=True):
            yield *old, robot.place, robot.velocity, swarm.world.moved


@BOUNDARIES
def test_a_blocked_robot_stands_still_and_takes_another_heading(boundary):
    """Catches a robot that slides, bounces, or keeps pushing; and one that turns though it wasn't blocked."""
    blocked = 0
    for place, velocity, now, then, moved in steps_of(boundary, "stand"):
        assert (then != velocity) == (now == place)
        assert now in (place, moved(place, velocity))
        blocked += now == place
    assert 100 < blocked < 40 * 18


@BOUNDARIES
def test_a_blocked_robot_deflects_by_45_or_90_degrees_and_keeps_that_heading(boundary):
    """Catches other angles, a heading drawn though the robot went, and one kept though it stood."""
    turns, stood = set(), 0
    for place, velocity, now, then, moved in steps_of(boundary, "deflect"):
        turn = np.degrees(np.angle(complex(*then) / complex(*velocity)))
        if now == place:
            stood += 1
            assert min(abs(turn - each) for each in (-90, -45, 0, 45, 90)) > 1e-3  # drawn
        else:
            assert now == moved(place, then)
            turns.add(round(float(turn), 6))
    assert turns == {-90.0, -45.0, 0.0, 45.0, 90.0}
    assert 30 < stood < 40 * 18


@CONTACTS
@BOUNDARIES
def test_the_order_of_robots_doesnt_matter(boundary, contact):
    """The reference visits its robots in the order of a list: shuffled before each step, nothing changes."""
    scenario = crowd((6.0, 5.0), boundary, 18, speed=0.4, contact=contact)
    plain, mixed = reference.Swarm(scenario, 4, 0), reference.Swarm(scenario, 4, 0)
    generator = np.random.default_rng(1)
    for _ in range(30):
        mixed.robots = [mixed.robots[i] for i in generator.permutation(18)]
        plain.step()
        mixed.step()
        found, expected = (
            {robot.number: (robot.place, robot.velocity, robot.mind.opinion) for robot in swarm.robots}
            for swarm in (mixed, plain)
        )
        assert found == expected


@pytest.mark.quick(2)
@BOUNDARIES
@pytest.mark.parametrize(
    ("coverage", "speed"),
    [
        (0.3, 1.0),
        (0.6, 0.1),
        *(pytest.param(*each, marks=pytest.mark.slow) for each in [(0.5, 0.25), (0.6, 0.05)]),
    ],
)
@CONTACTS
def test_nobody_freezes_while_there_is_room(boundary, coverage, speed, contact):
    """Every robot moves in each half of 1,600 steps, even where many start side by side."""
    count = robots_for(coverage, (12.0, 10.0), 1.0)
    swarm = Swarm(crowd((12.0, 10.0), boundary, count, speed=speed, contact=contact), seed=2)
    for _ in range(2):
        moved = np.zeros(count, bool)
        for _ in range(800):
            before = swarm.positions
            swarm.advance()
            moved |= (swarm.positions != before).any(axis=1)
        assert moved.all(), f"{(~moved).sum()} of {moved.size} stood still"


# --- Room ---


@BOUNDARIES
@pytest.mark.parametrize("sides", [(31.0, 23.0), (27.0, 27.0)])
def test_places_of_a_crowd_are_those_of_the_reference(boundary, sides):
    """More than 512 robots are sorted into cells while they are placed."""
    scenario = crowd(sides, boundary, 600, diameter=0.7)
    there = [robot.place for robot in reference.Swarm(scenario, 1, 0).robots]
    unit = max(sides) / 2 ** (31 if boundary == "walls" else 32)
    assert np.abs(Swarm(scenario, seed=1).positions - np.array(there) * unit).max() < SLACK


@BOUNDARIES
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
    for placement in ("uniform", "clusters"):
        robots = {"placement": placement, "spread": diameter}
        scenario = crowd((wide, high), boundary, room, diameter, diameter / 10, **robots)
        assert_keeps_apart(scenario, seed=1, steps=5)
