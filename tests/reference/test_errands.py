"""Robots that act, in the reference (model.md 6.25)."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, reference
from feasibee.reference import play
from feasibee.reference.mind import BYZANTINE
from feasibee.robot.acting import GONE, Errand, Rules
from feasibee.scenario.runs import Runs


def scenario_of(acting, tasks=6, robots=None, **other):
    """Return a scenario of eight robots that know their number, or what is given."""
    tables = {"decision": {"strategy": "quiet-census"}, "run": {"steps": 150}, **other}
    if not isinstance(tasks, dict):
        tasks = {"count": tasks}
    robots = {"count": 8, "know_count": True, **(robots or {})}
    return Scenario(arena={"side": 12}, robots=robots, tasks=tasks, acting=acting, **tables)


def steps_of(scenario, run=0):
    """Yield the swarm of one run after each step."""
    return (swarm for swarm in play(scenario, 1, run) if swarm.time)


def record_of(scenario, runs=20):
    return reference.simulate(scenario, Runs(runs, 1, 0))


# --- What a robot knows ---


def test_a_version_is_the_least_with_the_status_that_is_seen():
    errand = Errand(Rules(comes_free=True, ranks=2))
    seen = []
    for status in (0, 2, 0, 0, 1, 2, 1):
        errand.see(5, status)
        seen.append(errand.known[5])
    assert seen == [0, 2, 3, 3, 4, 5, 7]
    still = Errand(Rules(ranks=2))
    for status in (2, 0, 1):
        still.see(5, status)
        assert still.known == {5: status}


def test_the_larger_version_is_kept_and_a_vanished_task_has_the_largest():
    errand = Errand(Rules(comes_free=True))
    errand.hear({3: 2, 4: 1})
    errand.hear({3: 1, 4: 5, 6: GONE})
    assert errand.known == {3: 2, 4: 5, 6: GONE}
    assert [errand.status(task) for task in (3, 4, 6, 7)] == [0, 1, -1, -1]
    errand.target = 3
    assert not errand.arrive(None)
    errand.hear({3: 4})
    assert errand.known[3] == GONE


def test_a_liar_says_that_robots_of_the_last_rank_have_all_tasks():
    errand = Errand(Rules(comes_free=True, ranks=2))
    errand.known = {1: 0, 2: 1, 3: 5, 4: GONE}
    assert errand.news(lies=True) == {1: 2, 2: 2, 3: 5, 4: GONE}
    assert errand.news() == errand.known


@pytest.mark.parametrize(
    ("number", "step", "target"), [(0, 45, 2), (1, 45, -1), (2, 45, 7), (3, 45, -1), (1, 59, -1), (1, 60, 7)]
)
def test_by_rank_a_robot_goes_to_the_task_after_its_number_and_later_to_the_nearest(number, step, target):
    errand = Errand(Rules(start=40, by_rank=True, number=number))
    errand.known = {2: 0, 4: 1, 5: GONE, 7: 0}
    away = {2: 9.0, 4: 1.0, 7: 3.0}.get
    errand.choose(40, -1, away)
    errand.choose(step, -1, away)
    assert errand.target == target


def test_who_declared_infeasible_or_knows_too_many_tasks_never_acts():
    away = {1: 1.0, 2: 2.0}.get
    for rules, declared, target in (
        (Rules(start=1), 0, -1),
        (Rules(start=1), -1, 1),
        (Rules(start=1, count=1), -1, -1),
        (Rules(start=1, count=2), -1, 1),
        (Rules(by_word=True), -1, -1),
        (Rules(by_word=True), 1, 1),
    ):
        errand = Errand(rules)
        errand.known = {1: 0, 2: 0, 3: GONE}
        errand.choose(5, declared, away)
        assert errand.target == target


def test_by_rank_a_task_that_is_known_to_be_done_does_not_count():
    errand = Errand(Rules(start=40, by_rank=True, number=1, comes_free=True))
    for task, status in ((2, 0), (4, 1), (7, 0)):
        errand.see(task, status)
    away = {2: 9.0, 4: 1.0, 7: 3.0}.get
    errand.choose(40, -1, away)
    assert errand.target == -1
    errand.see(4, None)
    errand.choose(40, -1, away)
    assert errand.target == 7


def test_who_declares_infeasible_keeps_its_mark_and_marks_no_more():
    away = {1: 1.0, 2: 2.0}.get
    marked, unmarked = (Errand(Rules(start=90, tags=True)) for _ in range(2))
    for errand in (marked, unmarked):
        errand.known = {1: 0, 2: 0}
        errand.choose(5, -1, away)
        assert errand.target == 1
    assert marked.arrive(0)
    for step in (6, 95):
        for errand in (marked, unmarked):
            errand.choose(step, 0, away)
            assert errand.target == -1
    assert (marked.mark, unmarked.mark) == (1, -1)


# --- Swarms ---


def test_without_acting_nothing_changes():
    """Robots that never begin to act do all as without acting, with longer messages."""
    plain, idle = ({"start": None}, {"start": 1000})
    records = [record_of(scenario_of(acting), runs=3) for acting in (plain, idle)]
    walked = records[1].distance_walked.copy()
    records[1].account[:, -6:] = records[0].account[:, -6:]
    records[1].bits_sent[:] = records[0].bits_sent
    np.testing.assert_array_equal(records[0].account, records[1].account)
    assert (walked == 8 * 150).all()


def test_a_robot_goes_straight_to_its_target_and_then_on_with_its_run():
    scenario = scenario_of({"start": 20}, robots={"count": 1}, tasks=1)
    swarm = next(steps_of(scenario))
    run = swarm.robots[0].velocity
    before = None
    for swarm in steps_of(scenario, 3):
        (robot,) = swarm.robots
        way = swarm.world.squared_distance(robot.place, swarm.tasks[0]) ** 0.5
        if before is not None:
            assert way == pytest.approx(before - robot.reach, rel=1e-6)
        before = way if robot.errand.target == 0 else None
        if robot.errand.task == 0:
            break
    assert robot.errand.task == 0
    assert run != (0, 0)
    left, place = robot._walk_left, robot.place
    kept = robot.velocity
    swarm.step()
    assert (robot._walk_left, robot.velocity, robot.place, robot.heading) == (left, kept, place, (0, 0))


def test_a_robot_at_its_target_makes_no_step():
    points = {"placement": "points", "points": [(3, 3)]}
    scenario = scenario_of({"start": 0}, robots={"count": 1, **points}, tasks=points)
    for swarm in steps_of(scenario):
        (robot,) = swarm.robots
        robot.place, robot.errand.target = swarm.tasks[0], 0
        assert swarm.work.course(robot) == (0, 0)
        break


def test_at_once_robots_arrive_in_vain_and_a_run_ends_once_all_tasks_are_taken():
    scenario = scenario_of({"start": 0}, tasks=8, run={"steps": 600, "stop_when_taken": True})
    record = record_of(scenario)
    assert record.vain_arrivals.sum() > 0
    np.testing.assert_array_equal(record.all_taken_step, record.last_step)
    assert (record.tasks_taken == 8).all()
    assert (record.starts_in_vain == 0).all()


def test_robots_start_in_vain_where_the_tasks_are_infeasible():
    at_once, asked = (record_of(scenario_of({"start": each}, tasks=9), runs=8) for each in (0, 120))
    assert (at_once.starts_in_vain > 0).all()
    assert asked.starts_in_vain.sum() < at_once.starts_in_vain.sum() / 4
    assert (at_once.tasks_taken <= 8).all()


def test_tags_are_seen_as_taken_and_lead_each_robot_back():
    scenario = scenario_of({"start": 60, "hold": "tag"})
    marked = 0
    for swarm in steps_of(scenario):
        if swarm.time < 60:
            assert swarm.work.tasks_taken == 0
            marked = len(swarm.work.holders)
            assert all(robot.errand.mark == task for task, robot in swarm.work.holders.items())
    assert marked > 3
    assert swarm.work.tasks_taken == 6


def test_the_task_of_a_robot_that_stops_comes_free_and_another_takes_it():
    scenario = scenario_of(
        {"start": 0}, tasks=5, faults={"stopped": {"count": 2}, "stop_step": 90}, run={"steps": 400}
    )
    runs = [
        [(swarm.work.tasks_taken, dict(swarm.work.holders)) for swarm in steps_of(scenario, run)]
        for run in range(5)
    ]
    assert any(run[88][0] > run[89][0] for run in runs)
    assert all(run[-1][0] == 5 for run in runs)
    assert not any(robot.fault == "stopped" for run in runs for robot in run[-1][1].values())


def test_robots_whose_tasks_vanish_go_on_and_learn_of_it_on_arrival():
    scenario = scenario_of(
        {"start": 0},
        run={"steps": 200},
        decision={},
        events=[{"step": 80, "tasks": -3}, {"step": 120, "tasks": 2}],
    )
    knew = False
    for swarm in steps_of(scenario):
        assert set(swarm.work.holders) <= set(swarm.tasks)
        assert all(swarm.work.holders[r.errand.task] is r for r in swarm.robots if r.errand.task != -1)
        knew |= any(GONE in robot.errand.known.values() for robot in swarm.robots)
    assert swarm.work.tasks_taken == len(swarm.tasks) == 5


def test_byzantine_robots_never_have_a_task_but_know_of_them():
    scenario = scenario_of({"start": 0}, faults={"byzantine": {"count": 2}})
    for swarm in steps_of(scenario):
        liars = [robot for robot in swarm.robots if robot.fault == BYZANTINE]
        assert all((robot.errand.target, robot.errand.task) == (-1, -1) for robot in liars)
    assert all(robot.errand.known for robot in liars)


def test_messages_say_where_tasks_are_unless_the_strategy_does():
    """With the strategy's own places, a status is 1 bit; else 33 more, and 1 at the end."""
    for strategy, each, end in (("quiet-census", 1, 0), ("dmmd", 34, 1)):
        tables = {"decision": {"strategy": strategy}, "run": {"steps": 60}}
        told = scenario_of({"start": 1000}, **tables)
        untold = scenario_of({"start": None}, **tables)
        longer, speaking, known = 0, [], []
        for swarm in steps_of(told):
            for robot_speaks, number in zip(speaking, known, strict=True):
                longer += (number * each + end) * robot_speaks
            speaking = [robot.mind.disseminating for robot in swarm.robots]
            known = [len(robot.errand.known) for robot in swarm.robots]
        assert longer > 0
        assert int(record_of(told, 1).bits_sent[0] - record_of(untold, 1).bits_sent[0]) == longer


def test_a_blocked_robot_walks_another_way_for_some_steps():
    """Bodies: with detours all tasks are taken."""
    scenario = scenario_of(
        {"start": 30},
        robots={"avoid_collisions": True, "diameter": 0.5},
        tasks=8,
        run={"steps": 600, "stop_when_taken": True},
    )
    assert (record_of(scenario, runs=10).all_taken_step >= 0).all()
    steps = [[robot.detour for robot in swarm.robots] for swarm in steps_of(scenario, 2)]
    detours = [steps[k][i : i + 1] + steps[k + 1][i : i + 1] for k in range(100) for i in range(8)]
    assert max(map(max, detours)) == 3
    assert all([before, before - 1] in detours for before in (3, 2, 1))
