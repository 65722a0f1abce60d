"""Totals: its row of 16 bits, its rule, arrivals, what it tolerates, and how often the swarm is right."""

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


def test_a_total_that_rounds_up_to_64_units_takes_the_next_unit():
    assert [totals.robots_of(row(number, 0)[0]) for number in (125, 126, 127, 128)] == [126, 126, 128, 128]


def test_totals_that_outgrow_a_row_keep_their_ratio():
    generator = np.random.default_rng(1)
    for larger in [(63 << 15) + 1, 2**21, 2**31 - 1, *generator.integers(2**21, 2**31, 500).tolist()]:
        smaller = int(generator.integers(0, larger))
        for robots, tasks in ((larger, smaller), (smaller, larger)):
            (sent,) = row(robots, tasks)
            assert 0 <= sent < 2**16
            assert max(totals.robots_of(sent), totals.tasks_of(sent)) == 63 << 15
            assert abs(totals.robots_of(sent) * larger / (63 << 15) - robots) <= larger / 125
            assert abs(totals.tasks_of(sent) * larger / (63 << 15) - tasks) <= larger / 125
    assert row(2**31 - 1, 5) == (2**16 - 2**6,)


def test_rounding_a_row_has_no_bias():
    """The mean error over all totals from 64 to 4,095 is below 0.1 %; cutting off would make it 0.8 %."""
    numbers = range(64, 4096)
    errors = [totals.robots_of(row(number, 0)[0]) / number - 1 for number in numbers]
    assert abs(np.mean(errors)) < 1e-3


def test_a_message_holds_the_robots_own_totals_only():
    robot = named()
    robot.merge(row(50, 60), 3)
    robot.observe([ROBOT, TASK, TASK])
    assert robot.message() == row(1, 2)


# --- The rule ---


def test_the_tasks_are_feasible_up_to_as_many_as_robots():
    """Ten robots each saw the nine others and the m tasks 70 times each."""
    for tasks, opinion in ((1, 1), (9, 1), (10, 1), (11, 0), (30, 0)):
        robot = named()
        robot.observe(9 * 7 * [ROBOT] + tasks * 7 * [TASK])
        for other in range(1, 10):
            robot.merge(row(9 * 7, tasks * 7), other)
        assert decided(robot, 1 - opinion) == opinion, tasks


@pytest.mark.parametrize("sightings", [10**4, 10**5, 63 << 15, 10**6, 10**7, 10**8])
def test_robots_that_have_seen_much_are_right(sightings):
    """Twenty robots each saw the others and the tasks as often as an even walk would."""
    for tasks, opinion in ((1, 1), (16, 1), (19, 1), (22, 0), (24, 0), (60, 0)):
        for tolerates in (0.0, 2.0):
            robot = named(counts=(20, tasks), tolerates=tolerates)
            robot.words[:2] = sightings, tasks * sightings // 19
            for other in range(1, 20):
                robot.merge(row(sightings, tasks * sightings // 19), other)
            assert decided(robot, 1 - opinion) == opinion, tasks


@pytest.mark.parametrize("sightings", [63 << 15, 63 << 17, 2**30])
def test_robots_that_have_seen_much_weigh_the_same(sightings):
    """Of five robots two saw tasks only and three robots only: the robot itself is one of the three."""
    robot = named()
    robot.words[0] = sightings
    for other in range(1, 5):
        robot.merge(row(0, sightings) if other < 3 else row(sightings, 0), other)
    assert robot.counted() == ([21 * 3 * (63 << 15)], [18 * 2 * (63 << 15)])


def test_both_totals_are_halved_when_one_fills_its_word():
    for thing, kept in ((ROBOT, [2**30 - 1, 500]), (TASK, [500, 2**30 - 1])):
        robot = named()
        robot.words[:2] = [2 * number if number == 2**30 - 1 else 1001 for number in kept]
        robot.observe([thing])
        assert robot.words[:2] == kept


@pytest.mark.slow
def test_a_swarm_is_right_after_300_000_steps():
    """In so dense a swarm totals outgrow their message by step 220,000."""
    world = {"arena.side": 6.0, "sensing.range": 3.0, "robots.know_count": True, "tasks.count": 24}
    scenario = Scenario().replace({**world, "decision.strategy": "totals", "run.steps": 300_000})
    assert simulate_record(scenario, Runs(1, 1)).infeasible_at_end[0] == 20


def test_a_tie_and_nothing_keep_the_opinion():
    """Of ten robots, 18 sightings of robots and 21 of tasks: 9 * 21 = 10.5 * 18."""
    for sightings in ([], 18 * [ROBOT] + 21 * [TASK]):
        robot = named()
        robot.observe(sightings)
        assert [decided(robot, opinion) for opinion in (0, 1)] == [0, 1]
    assert robot.counted() == ([21 * 18], [18 * 21])
    robot.observe([TASK])
    assert decided(robot, 1) == 0


def test_the_latest_row_of_each_id_counts_whoever_else_spoke():
    robot = named()
    robot.merge(row(30, 9), 2)
    robot.merge(row(3, 1), 4)
    robot.merge(row(20, 6), 2)
    assert robot.counted() == ([21 * 23], [18 * 7])
    robot.merge(row(2, 2), 0)  # of another robot with its own id
    robot.observe([TASK])
    assert robot.counted() == ([21 * 25], [18 * 10])


# --- Arrivals ---


def test_a_thing_counts_when_it_comes_into_view():
    robot = named(arrivals=1.0, kappa=1.0)
    seen = [(TASK,), (TASK, ROBOT), (TASK,), (), (TASK, ROBOT), (TASK, ROBOT)]
    counted = []
    for things in seen:
        robot.observe(things)
        robot.end_step(explores=True)
        counted.append(tuple(robot.words[:2]))
    assert counted == [(0, 1), (1, 1), (1, 1), (1, 1), (2, 2), (2, 2)]


def test_robots_and_tasks_of_the_same_number_are_told_apart_and_false_sightings_always_count():
    robot = named(arrivals=1.0, counts=(10, 12))
    everything = [Thing(True, k, 0, 1) for k in range(10)] + [Thing(False, k, 0, 1) for k in range(12)]
    for _ in range(3):
        robot.observe([*everything, Thing(True, -1, 0, 0), Thing(False, -1, 0, 0)])
        robot.end_step(explores=True)
    assert robot.words[:2] == [10 + 3, 12 + 3]


def test_the_number_of_robots_is_divided_by_kappa():
    robot = named(arrivals=1.0, kappa=2.0)
    robot.merge(row(30, 12), 5)
    assert robot.counted() == ([21 * 15], [18 * 12])
    assert named(arrivals=0.0, kappa=2.0).merge(row(30, 12), 5) is None
    for kappa in (0.0, -3.0):
        robot = named(arrivals=1.0, kappa=kappa)
        robot.merge(row(30, 12), 5)
        assert robot.counted() == ([21 * 30 * 100], [18 * 12])


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


def test_the_extreme_rows_of_both_sides_are_left_out():
    rows = {1: (9, 1), 2: (9, 9), 3: (9, 8), 4: (9, 10), 5: (0, 63 << 15), 6: (63 << 15, 0), 7: (9, 30)}
    for tolerated, left in ((0, "1234567"), (1, "12347"), (2, "234"), (3, "2"), (4, ""), (9, "")):
        robot = named(tolerates=float(tolerated))
        robot.observe([TASK])
        for sender, each in rows.items():
            robot.merge(row(*each), sender)
        kept = [rows[int(sender)] for sender in left]
        robots, tasks = sum(each[0] for each in kept), 1 + sum(each[1] for each in kept)
        assert robot.counted() == ([21 * robots], [18 * tasks]), tolerated


def test_no_row_is_left_out_twice_when_all_are_the_same():
    for tolerated in (1, 2, 3):
        for heard in range(2 * tolerated, 10):
            robot = named(tolerates=float(tolerated))
            for sender in range(1, heard + 1):
                robot.merge(row(7, 6), sender)
            left = heard - 2 * tolerated
            assert robot.counted() == ([21 * 7 * left], [18 * 6 * left])


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
