"""Laws of robots that act (model.md 6.25): each holds in every run, or by a margin over many."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, Swarm, simulate
from research.limits import apart, assigned, ways_of

ACTS = {"acting.start": 0, "run.stop_when_taken": True, "run.steps": 4000, "run.stop_at_decision": False}
"""Robots that go to the nearest task that they know to be free, as soon as they know one."""
WAYS = [
    {"tasks.count": 12},
    {"tasks.count": 30, "acting.start": 30},
    {"acting.hold": "tag", "acting.start": 60},
    {"acting.choose": "rank", "acting.start": 40},
    {"robots.avoid_collisions": True, "arena.boundary": "walls", "tasks.count": 15},
    {"faults.byzantine": 0.1, "faults.byzantine_says": "feasible", "tasks.count": 17},
]


QUIET = {"decision__strategy": "quiet-census", "robots__know_count": True}
"""Robots that look for half of the time."""


def acting(**changes):
    return Scenario().replace({**ACTS, **{key.replace("__", "."): value for key, value in changes.items()}})


@pytest.mark.parametrize("changes", WAYS, ids=str)
def test_no_task_has_two_robots_and_no_robot_two_tasks(changes):
    scenario = Scenario().replace({**ACTS, **changes})
    swarm = Swarm(scenario, seed=3)
    stood, shifts = np.zeros(scenario.robots.count, bool), False
    for _ in range(200):
        before, at = swarm.standing, swarm.positions
        swarm.advance()
        stood, holders = swarm.standing, swarm.holders
        shifts |= (at[before] != swarm.positions[before]).any()
        assert (stood >= before).all(), "who stands has stood for good"
        of_tasks = holders[holders >= 0]
        assert len(set(of_tasks.tolist())) == len(of_tasks)
        assert set(np.flatnonzero(stood)) <= set(of_tasks.tolist())
        for task in np.flatnonzero(holders >= 0):
            if stood[holders[task]]:
                way = apart(scenario, swarm.positions[[holders[task]]], swarm.tasks[[task]])
                assert way.item() < scenario.acting.reach + 1e-6
    assert stood.any()
    assert shifts == scenario.robots.avoid_collisions, "only bodies give way to each other"


@pytest.mark.parametrize("start", [0, 40])
@pytest.mark.parametrize("tasks", [10, 20, 40])
def test_no_swarm_is_sooner_than_the_limits(tasks, start):
    scenario = acting(tasks__count=tasks, acting__start=start)
    found = simulate(scenario, runs=60, seed=2)
    bounds = [assigned(ways_of(scenario, Swarm(scenario, seed=2, run=run))) for run in range(60)]
    soonest, fewest = np.transpose(bounds)
    steps = found.all_taken_step.values
    assert (steps >= start + 1).all()
    assert (steps >= soonest).all()
    assert found.distance_walked.values.sum() >= fewest.sum() * scenario.robots.speed


def test_the_mean_of_one_mind_is_at_most_that_of_gossip():
    """Radio as wide as the torus allows soon tells each robot what any robot has seen."""
    for start in (0, 40):
        steps = [
            simulate(acting(acting__start=start, radio__range=reach), runs=400, seed=1).all_taken_step.values
            for reach in (10.0, 2.0, 0.01)
        ]
        one, gossip, none = (each.mean() for each in steps)
        assert one < gossip < none


def test_with_complete_lists_no_robot_arrives_in_vain_by_rank():
    """Robots that have wide radio know all 20 tasks by step 300, and each goes to its own."""
    found = simulate(acting(acting__choose="rank", acting__start=300, radio__range=10.0), runs=50, seed=1)
    assert found.vain_arrivals.values.sum() == 0
    assert (found.all_taken_step.values <= 300 + 14).all(), "no way is longer on the torus"
    sooner = simulate(acting(acting__choose="rank", acting__start=20), runs=50, seed=1)
    assert sooner.vain_arrivals.values.sum() > 0


def expected(robots, tasks, rate):
    """Return how long greedy robots take if each finds each task at a rate, and all seek anew (act.md)."""
    return sum(1 / (k * (k + robots - tasks)) for k in range(1, tasks + 1)) / rate


@pytest.mark.slow
@pytest.mark.parametrize(("tasks", "steps"), [(10, 45), (18, 140), (20, 319)])
def test_greedy_robots_take_a_little_less_than_their_formula(tasks, steps):
    """A robot finds a given task at rate 0.005; what is in sight at the start helps."""
    rate = 2 * 2.0 / 20.0**2 / 2  # half of the time it looks
    assert expected(20, tasks, rate) == pytest.approx(steps, abs=1)
    found = simulate(acting(tasks__count=tasks, radio__loss=1.0, **QUIET), runs=2000, seed=1)
    mean = found.all_taken_step.values.mean()
    assert 1.10 <= expected(20, tasks, rate) / mean <= 1.35


@pytest.mark.parametrize("changes", [{}, {"arena.boundary": "walls", "robots.contact": "deflect"}], ids=str)
def test_bodies_make_way_for_each_other_at_their_tasks(changes):
    """Robots that only stood would do all tasks in 0.94 of the swarms within walls."""
    bodies = {"acting.start": 60, "robots.avoid_collisions": True, "run.stop_when_taken": True, **changes}
    found = simulate(Scenario().replace(bodies), 400, seed=2)
    assert (found.all_taken_step >= 0).mean() >= 0.98
