"""Assignments: equal to scipy's, to pairs tried one after another, and to worlds done by hand."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from commands import invoke
from scipy.optimize import linear_sum_assignment

from feasibee import Scenario, Swarm, simulate
from feasibee.studies.assignment import Least, _cheapest, done_between, least, ways_between
from feasibee.studies.limits import DONE, LIMITS, TAKEN, limits

ACTS = {"acting.start": 40}


@pytest.mark.parametrize("shape", [(1, 1), (7, 7), (5, 9), (9, 5), (20, 20), (3, 0)], ids=str)
def test_the_cheapest_pairs_cost_what_those_of_scipy_cost(shape):
    draw = np.random.default_rng(5)
    for costs in (draw.random(shape), draw.integers(0, 4, shape).astype(float)):
        pairs = _cheapest(costs)
        assert pairs.size == min(shape)
        assert pairs.sum() == pytest.approx(costs[linear_sum_assignment(costs)].sum())


@pytest.mark.parametrize("able", [1.0, 0.4, 0.1])
def test_the_best_assignments_are_those_of_all(able):
    """With few able pairs not all robots have a task: as many are taken as can be."""
    draw = np.random.default_rng(3)
    for _ in range(20):
        ways = np.where(draw.random((5, 4)) < able, 9 * draw.random((5, 4)), np.inf)
        every = [ways[list(robots), range(4)] for robots in itertools.permutations(range(5), 4)]
        most = max(np.isfinite(each).sum() for each in every)
        steps = [np.ceil(np.maximum(each[np.isfinite(each)], 1)) for each in every]
        fair = [each for each in steps if each.size == most]
        found = least(ways)
        assert found.moves == min(each.sum() for each in fair)
        assert found.maximum_steps == min(each.max(initial=0) for each in fair)
        assert found.sum_steps in {each.max(initial=0) for each in fair if each.sum() == found.moves}


def test_the_way_is_the_short_one_on_a_torus_and_straight_within_walls():
    robots, tasks = np.array([[1.0, 1.0]]), np.array([[19.0, 1.0], [1.0, 1.5]])
    torus, walls = Scenario(), Scenario().replace({"arena.boundary": "walls", "robots.speed": 0.5})
    assert ways_between(torus, robots, tasks).tolist() == [[1.0, -0.5]]
    assert ways_between(walls, robots, tasks).tolist() == [[34.0, -1.0]]
    assert ways_between(torus, robots, tasks, np.array([[False, True]])).tolist() == [[math.inf, -0.5]]


def test_among_equal_numbers_of_steps_the_shortest_way_counts():
    """Both pairings take 5 steps, until step 3 or until step 4."""
    assert least(np.array([[2.1, 3.9], [0.5, 1.1]])) == Least(3, 3, 5)
    assert least(np.array([[2.9, 3.1], [0.5, 1.1]])) == Least(4, 3, 5)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"tasks.count": 30},
        {"tasks.count": 7, "robots.speed": 0.5, "acting.reach": 0.75},
        {"arena.boundary": "walls", "arena.side": [18.0, 14.0]},
        {"faults.byzantine": 0.2, "faults.byzantine_says": "feasible"},
    ],
    ids=str,
)
def test_limits_of_robots_that_act_are_those_of_scipy(changes):
    scenario = Scenario().replace({**ACTS, **changes})
    searches = scenario.replace({"acting.start": None, "acting.reach": 1.0})
    found, searching = limits(scenario, runs=3, seed=4), limits(searches, runs=3, seed=4)
    assert list(found.steps) == [*LIMITS, *TAKEN]
    moves = []
    for run in range(3):
        swarm = Swarm(searches, 4, run)
        at = {"least": 0, "mapped": int(found.steps["complete_map"][run])}
        for name, start in at.items():
            swarm.advance(start - swarm.step)
            ways = ways_between(scenario, swarm.positions[swarm.counted], swarm.tasks)
            steps = np.maximum(1, np.ceil(ways - 1e-6))
            pairs = steps[linear_sum_assignment(steps + 1e-4 * ways)]
            assert found.steps[f"{name}_sum"][run] == start + pairs.max()
            assert found.steps[f"{name}_maximum"][run] == start + min(
                each for each in np.unique(steps) if _taken(steps <= each) == pairs.size
            )
            moves += [pairs.sum()] if start == 0 else []
    assert found.distance == np.mean(moves) * scenario.robots.speed / scenario.robots.count
    for name in LIMITS:
        np.testing.assert_array_equal(found.steps[name], searching.steps[name])


def _taken(near):
    return near[linear_sum_assignment(near, maximize=True)].sum()


def test_the_assignments_of_acting_robots_are_those_that_were_measured():
    """Medians and 95 % of 2,000 runs of a program of our own, with 10 and 20 tasks."""
    for tasks, least_sum, soonest in ((20, (6, 9), (5, 6)), (10, (4, 6), (4, 5))):
        times = limits(Scenario().replace({**ACTS, "tasks.count": tasks}), runs=200, seed=1).times
        assert times["least_sum"][:2] == least_sum
        assert times["least_maximum"][:2] == soonest


def finishes(order, ways, apart, work):
    """Return when all is done if robots do tasks in this order, each by the given robot, at once."""
    at, free = [None] * len(ways), [0.0] * len(ways)
    for robot, task in order:
        way = ways[robot][task] if at[robot] is None else apart[at[robot]][task]
        free[robot] += max(1.0, math.ceil(way)) + work
        at[robot] = task
    return max(free)


@pytest.mark.parametrize("work", [1, 6])
def test_no_schedule_is_before_the_bound_and_one_is_at_the_deadline(work):
    """All orders and all robots are tried; robots of the model lose a step or two at each task."""
    draw = np.random.default_rng(work)
    for _ in range(20):
        robots, tasks = draw.random((2, 2)) * 12, draw.random((3, 2)) * 12
        ways = np.linalg.norm(robots[:, None] - tasks, axis=2)
        apart = np.linalg.norm(tasks[:, None] - tasks, axis=2)
        best = min(
            finishes(zip(who, order, strict=True), ways, apart, work)
            for order in itertools.permutations(range(3))
            for who in itertools.product(range(2), repeat=3)
        )
        bound, schedule = done_between(ways, apart, work)
        assert bound <= best <= schedule <= 2 * best + 12


def test_a_deadline_is_bounded_only_if_tasks_take_time():
    working = Scenario().replace({**ACTS, "tasks.count": 40, "tasks.work": 50, "run.steps": 400})
    found = limits(working, runs=3, seed=1)
    assert list(found.steps) == [*LIMITS, *TAKEN, *DONE]
    done = simulate(working, 3, seed=1).all_done_step
    assert (found.steps["done_bound"] < found.steps["done_schedule"]).all()
    assert (found.steps["done_bound"] < done).all()
    assert (done > 0).all()


def test_without_a_complete_map_nobody_starts_with_one():
    found = limits(Scenario().replace({**ACTS, "run.steps": 20}), runs=2, seed=1)
    assert found.steps["complete_map"].tolist() == found.steps["mapped_maximum"].tolist() == [-1, -1]
    assert (found.steps["least_maximum"] > 0).all()


def test_a_task_that_no_robot_reaches_is_no_robots_task():
    """A wall parts the arena, with one robot and one task on one side, and one task on the other."""
    wall = {"walls": [[[9.5, 0.0], [10.5, 0.0], [10.5, 20.0], [9.5, 20.0]]]}
    placed = {"placement": "points", "points": [[7.0, 10.0]]}
    tasks = {"placement": "points", "points": [[7.0, 16.0], [11.5, 10.0]]}
    scenario = Scenario(
        **{"arena": {"boundary": "walls"}, "place": wall, "acting": {"start": 0}},
        **{"robots": {"count": 1, **placed}, "tasks": tasks},
    )
    found = limits(scenario, runs=1)
    assert found.steps["least_maximum"].tolist() == [5]
    assert found.distance == 5.0


def test_the_command_tells_limits_of_acting_robots(tmp_path):
    asked = ("compare", "--limits", "--strategies", "none", "--runs", 5, "--out", tmp_path)
    asked += ("--set", "acting.start=0")
    done = invoke(*asked)
    assert done.exit_code == 0, done.output
    assert "least maximum" in done.stdout
    assert "Distance of a robot until least sum" in done.stdout
    (found,) = json.loads(invoke(*asked, "--json").stdout)
    assert {*TAKEN, "distance"} <= found.keys()
    (without,) = json.loads(invoke(*asked[:-2], "--json").stdout)
    assert not {*TAKEN, "distance"} & without.keys()
