"""Totals: its row of 16 bits, its rule, kappa, lies, and how often the swarm is right; its steps equal C."""

from __future__ import annotations

import math

import numpy as np
import pytest
from minds import knowing
from scipy import integrate

from feasibee import Scenario
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES, totals
from feasibee.strategies.contract import Inbox, Mind, Thing

ROBOT, TASK = Thing(True, 3, 0, 7), Thing(False, 4, 0, 7)


def named(number=0, counts=(10, 12), **changes):
    """Return the knowledge of a robot."""
    return knowing("totals", counts, number, mark=1, **changes)


def decided(robot, opinion=0):
    """Return the opinion of a robot after its decision, from one before."""
    robots, tasks = robot.counted()
    quality = STRATEGIES["totals"].quality(sum(robots), sum(tasks))
    return totals.decide(Mind(opinion, 0.5, quality, 1, [], []), Inbox(0, 0, -1, 0.0, 0.0, 0.0))


def row(robots, tasks):
    return (totals.row_of(robots, tasks),)


# --- The message ---


def test_a_row_is_exact_up_to_63_and_to_one_part_in_64_above():
    for robots in range(64):
        for tasks in (0, 1, 40, 63):
            (sent,) = row(robots, tasks)
            assert (totals.robots_of(sent), totals.tasks_of(sent)) == (robots, tasks)
    generator = np.random.default_rng(1)
    edges = [64, 126, 127, 128, 4095, 63 << 15]
    for larger in [*edges, *np.exp(generator.uniform(4, 14.5, 500)).astype(int).tolist()]:
        smaller = int(generator.integers(0, larger))
        for robots, tasks in ((larger, smaller), (smaller, larger)):
            (sent,) = row(robots, tasks)
            assert 0 <= sent < 2**16
            assert abs(totals.robots_of(sent) - robots) <= larger / 64
            assert abs(totals.tasks_of(sent) - tasks) <= larger / 64


# --- The rule ---


def test_the_tasks_are_feasible_up_to_as_many_as_robots():
    """Ten robots each saw the nine others and the m tasks 70 times each."""
    for tasks, opinion in ((1, 1), (9, 1), (10, 1), (11, 0), (30, 0)):
        robot = named()
        robot.observe(9 * 7 * [ROBOT] + tasks * 7 * [TASK])
        for other in range(1, 10):
            robot.merge(row(9 * 7, tasks * 7), other)
        assert decided(robot, 1 - opinion) == opinion, tasks


@pytest.mark.slow
def test_a_swarm_is_right_after_300_000_steps():
    """In so dense a swarm totals outgrow their message by step 220,000."""
    world = {"arena.side": 6.0, "sensing.range": 3.0, "robots.know_count": True, "tasks.count": 24}
    scenario = Scenario().replace({**world, "decision.strategy": "totals", "run.steps": 300_000})
    assert simulate_record(scenario, Runs(1, 1)).infeasible_at_end[0] == 20


# --- Arrivals ---


def test_robots_and_tasks_of_the_same_number_are_told_apart_and_false_sightings_always_count():
    robot = named(arrivals=1.0, counts=(10, 12))
    everything = [Thing(True, k, 0, 1) for k in range(10)] + [Thing(False, k, 0, 1) for k in range(12)]
    for _ in range(3):
        robot.observe([*everything, Thing(True, -1, 0, 0), Thing(False, -1, 0, 0)])
        robot.end_step(explores=True)
    assert robot.words[:2] == [10 + 3, 12 + 3]


def overlap(apart, radius=2.0):
    """Return the area that two discs share."""
    return 2 * radius**2 * math.acos(apart / 2 / radius) - apart / 2 * math.sqrt(4 * radius**2 - apart**2)


def test_kappa_is_what_the_docstring_computes():
    disc, steps = 4 * math.pi, 1 / (1 - math.exp(-0.1))  # of a mean of 10, in whole steps
    mean, _ = integrate.quad(lambda angle: overlap(2 * math.sin(angle / 2)) / math.pi, 0, math.pi)
    ratio = (disc + (steps - 1) * (disc - mean)) / (disc + (steps - 1) * (disc - overlap(1.0)))
    assert ratio == pytest.approx(1.19, abs=0.005)
    assert totals.PARAMETERS["kappa"] == 1.19


# --- Liars ---


@pytest.mark.parametrize("parameter", [-2.0, 0.9])
def test_less_than_one_row_is_none(parameter):
    robot = named(tolerates=parameter)
    robot.merge(row(7, 6), 1)
    assert robot.counted() == ([21 * 7], [18 * 6])


def test_a_byzantine_robot_calls_all_that_it_saw_robots_or_tasks():
    robot = named()
    robot.observe([ROBOT, TASK, TASK])
    assert [robot.lie(robot.message(), feasible, []) for feasible in (1, 0)] == [row(3, 0), row(0, 3)]
    colluder = named(colluding=True)
    most = 63 << 15
    assert [colluder.lie(colluder.message(), feasible, []) for feasible in (1, 0)] == [
        row(most, 0),
        row(0, most),
    ]


# --- How often the swarm is right ---

RUNS = 400


def right_at_end(tasks, **changes):
    """Return the share of runs at whose end more than 90 % of the counted robots hold the right opinion."""
    base = {"decision.strategy": "totals", "robots.know_count": True, "tasks.count": tasks}
    scenario = Scenario().replace({**base, **changes})
    record = simulate_record(scenario, Runs(RUNS, 1))
    right = record.feasible_at_end if tasks <= scenario.robots.count else record.infeasible_at_end
    return (right > 0.9 * round(scenario.robots.count * (1 - scenario.faults.byzantine))).mean()


@pytest.mark.slow
def test_one_colluder_of_twenty_outweighs_all_unless_it_is_tolerated():
    """At m = 16: right in every run or in none, measured; 400 runs catch a share of 1 %."""
    liar = {"faults.byzantine": 0.05, "faults.byzantine_says": "colluding"}
    assert right_at_end(16, **liar) == 0
    assert right_at_end(16, **liar, **{"decision.parameters": {"tolerates": 1.0}}) > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("arrivals", [0.0, 1.0])
@pytest.mark.parametrize(("tasks", "target"), [(18, 0.98), (19, 0.92), (22, 0.88)])
def test_the_targets_of_accuracy_at_the_end(arrivals, tasks, target):
    share = right_at_end(tasks, **{"decision.parameters": {"arrivals": arrivals}})
    assert share > target - 2 * math.sqrt(target * (1 - target) / RUNS)
