"""Robots that declare, know n and their place, and collude: a user's files in both implementations."""

from __future__ import annotations

import pytest
from own_files import FADING, QUIET, SURE, assert_same, controller, played, replaced

from feasibee import Scenario, Swarm, reference
from feasibee.robot.controller import Controller, Message
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Thing

SMALL = {"arena.side": 10.0, "run.steps": 90, "robots.know_count": True}
QUIET = replaced(QUIET, '{"quiet": 100.0}', '{"quiet": 12.0}')
LIARS = {"faults.byzantine": 0.15, "faults.byzantine_says": "colluding"}


def scenario_of(path, **changes):
    return Scenario().replace({**SMALL, "decision.strategy": str(path), **changes})


def judging(path, **changes):
    return scenario_of(path, **{"arena.side": 8.0, "run.steps": 60, "decision.gain": 5.0, **changes})


# --- Declaring ---


def test_a_robot_declares_once_adopts_what_it_declares_at_once_and_keeps_it(write):
    """Though the strategy would then decide for the opposite."""
    text = replaced(QUIET, "    return mind.opinion", "    return 1 - max(mind.opinion, 0)")
    path = write(text)
    declared = [-1] * 20
    for swarm in played(scenario_of(path)):
        for number, robot in enumerate(swarm.robots):
            if declared[number] == -1:
                declared[number] = robot.mind.declared
            assert robot.mind.declared == declared[number]
            if declared[number] != -1:
                assert robot.mind.opinion == declared[number]
    assert min(declared) >= 0
    assert_same(*2 * [scenario_of(path)])


@pytest.mark.slow
def test_a_stubborn_robot_declares_but_keeps_its_opinion(write):
    path = write(replaced(QUIET, "STARTS_NEUTRAL = True", "STARTS_NEUTRAL = False"))
    changes = {"faults.stubborn": 0.99}
    swarms = [(swarm.feasible_count, swarm.declared(1)) for swarm in played(scenario_of(path, **changes))]
    assert 0 < swarms[0][0] < 20
    assert {feasible for feasible, _ in swarms} == {swarms[0][0]}
    last = list(played(scenario_of(path, **changes)))[-1]
    assert all(robot.mind.declared == 1 for robot in last.robots)
    record = assert_same(*2 * [scenario_of(path, **changes)])
    assert (record.feasible_at_end < 20).all()
    assert (record.declare_step > 0).all()


COUNTED = "    number = number_of(known)\n"
BY_TURNS = "return me.id % 2 if me.step == me.id + 1 else -1"
"""Robot i declares in step i + 2, feasible and infeasible by turns."""
STOPPED = {"faults.stopped": 0.25, "run.steps": 30}
DECLARED = [
    # what robots declare, changes, numbers of robots that declared feasible and infeasible, step
    ("return 1 if me.step >= 0 else -1", {"faults.byzantine": 0.25, "run.steps": 4}, 15, 0, 1),
    *(
        ("return 1 if me.step >= 9 else -1", {**STOPPED, "faults.stop_step": stop}, 15, 0, 10)
        for stop in (5, 10, 20)
    ),
    *(
        (BY_TURNS, {"decision.threshold": threshold}, 10, 10, step)
        for threshold, step in ((0.5, 12), (0.9, 20), (0.94, 20), (0.95, 21), (0.99, 21))
    ),
]


def declaring(line):
    """Return the strategy's text with another rule by which robots declare."""
    return replaced(QUIET, f"{COUNTED}    if", f"    {line}\n{COUNTED}    if")


@pytest.mark.slow
@pytest.mark.parametrize(("line", "changes", "feasible", "infeasible", "step"), DECLARED)
def test_honest_working_robots_declare_and_the_step_is_the_first_above_the_threshold(
    write, line, changes, feasible, infeasible, step
):
    scenario = scenario_of(write(declaring(line)), **changes)
    record = assert_same(scenario, scenario)
    assert record.declared_feasible.tolist() == [feasible] * 3
    assert record.declared_infeasible.tolist() == [infeasible] * 3
    assert record.declare_step.tolist() == [step] * 3
    if step > 1:
        short = simulate_record(scenario.replace({"run.steps": step - 1}), Runs(2, 2))
        assert short.declare_step.tolist() == [-1] * 2


# --- What a robot knows of itself ---


PLACES = """
PARAMETERS = {"quiet": 1.0}


def words(setting):
    return 6


def observe(known, thing, me):
    known[3] = -1 - thing.id if thing.is_robot else thing.id
    known[4] = int(1000 * thing.x)
    known[5] = int(1000 * thing.y)


def merge(known, message, sender, me):
    pass


def count(known, counts, me):
    counts[0] = 1


def bits(message, me):
    return 1


def declare(known, me):
    known[0] = int(1000 * me.x)
    known[1] = int(1000 * me.y)
    known[2] = int(me.explores)
    return -1


def decide(mind, inbox):
    return mind.opinion
"""
"""Words hold the last position and the last thing seen, in thousandths of a unit."""


def test_positions_are_those_of_the_swarm(write):
    scenario = scenario_of(write(PLACES), **{"arena.side": [14.0, 7.0], "run.steps": 25})
    swarm, seen = Swarm(scenario, seed=3, run=0), set()
    for plain in played(scenario):
        swarm.advance()
        for robot, (x, y) in zip(plain.robots, swarm.positions.tolist(), strict=True):
            *own, explored, thing, seen_x, seen_y = robot.mind.knowledge.words
            assert own == [int(1000 * x), int(1000 * y)]
            there = plain.robots[-1 - thing].place if thing < 0 else plain.tasks[thing]
            if explored and seen_x and plain._sees(robot, there, 0, 0):
                where = swarm.positions[-1 - thing] if thing < 0 else swarm.tasks[thing]
                assert [seen_x, seen_y] == [int(1000 * each) for each in where]
                seen.add(thing < 0)
    assert seen == {True, False}


@pytest.mark.slow
def test_the_setting_has_the_numbers_of_the_world(write):
    world = {
        "arena.side": [14.0, 7.0],
        "arena.boundary": "walls",
        "sensing.range": 2.5,
        "radio.range": 3.0,
        "robots.speed": 0.5,
        "run.steps": 1,
    }
    wanted = {"width": 14.0, "height": 7.0, "sight": 2.5, "radio": 3.0, "speed": 0.5}
    wanted |= {"walled": True, "knows_count": True, "colluding": False}
    holds = " and ".join(f"me.setting.{name} == {value}" for name, value in wanted.items())
    scenario = scenario_of(write(declaring(f"return 1 if {holds} else 0")), **world)
    assert assert_same(scenario, scenario).declared_feasible.tolist() == [20] * 3
    assert scenario.setting._asdict().items() >= wanted.items()


# --- Colluding ---

CLASSES = {
    "robots.classes": [{"name": "a", "count": 12}, {"name": "b", "count": 8}],
    "tasks.classes": [{"name": "c", "count": 10, "needs": {"x": 2}}],
}


@pytest.mark.parametrize(
    ("changes", "robots", "tasks"),
    [
        ({"tasks.count": 10}, -10, 11),
        ({"tasks.count": 20}, 0, 1),
        ({"tasks.count": 30}, 10, -9),
        (CLASSES, 10, 21),  # as many as other Byzantine robots
    ],
)
def test_colluders_invent_exactly_what_the_lie_needs(changes, robots, tasks):
    scenario = Scenario().replace({"decision.strategy": "census", **LIARS, **changes})
    names = reference.Swarm(scenario, seed=1, run=0).names
    assert [len(names.inventions(feasible)) for feasible in (1, 0)] == [max(0, robots), max(0, tasks)]


@pytest.mark.parametrize("strategy", ["dmmd", "dc", "census"])
def test_colluders_send_in_every_step_also_while_exploring(strategy):
    scenario = Scenario().replace({"decision.strategy": strategy, **LIARS, "run.steps": 40})
    swarm = reference.Swarm(scenario, seed=1, run=0)
    explored = 0
    for _ in range(40):
        swarm.step()
        for robot in swarm.robots:
            message = robot.says(swarm.time)
            if robot.fault == "byzantine":
                explored += not robot.mind.disseminating
                assert message.opinion == 0  # the truth is feasible
                assert message.value == 0
            else:
                assert (message is None) == (not robot.mind.disseminating)
    assert explored > 20


def test_colluding_bits_are_those_of_every_step():
    """Three liars of twenty, and no other robot that speaks: 6 bits a message, 40 steps."""
    changes = {**LIARS, "run.steps": 40, "decision.exploration": 1e6}
    record = simulate_record(Scenario().replace(changes), Runs(3, 1))
    assert record.bits_sent.tolist() == [3 * 40 * 6] * 3
    changes |= {"faults.stopped": 0.8, "faults.stop_step": 1}
    assert simulate_record(Scenario().replace(changes), Runs(3, 1)).bits_sent.tolist() == [3 * 40 * 6] * 3


# --- Opinions that follow from knowledge in every step ---


BOTH = "    robots, tasks = total(known, me, 0), total(known, me, 1)\n"


def test_a_robot_holds_what_it_judged_and_at_minus_1_its_own_opinion(write):
    """Robot i judges -1 up to step i, then 0 and 1 by turns; `decide` keeps that."""
    own = "-1 if me.step < me.id else (me.step + me.id) % 2"
    path = write(replaced(FADING, BOTH, f"    if me.step >= 0:\n        return {own}\n{BOTH}"))
    first = [robot.mind.opinion for robot in reference.Swarm(judging(path), 3, 0).robots]
    for step, swarm in enumerate(played(judging(path))):
        for number, robot in enumerate(swarm.robots):
            wanted = first[number] if step < number else (step + number) % 2
            assert robot.mind.opinion == wanted
    assert_same(*2 * [judging(path)])


def test_a_stubborn_robot_is_asked_but_keeps_its_opinion(write):
    path = write(FADING)
    (*_, last) = swarms = list(played(judging(path, **{"faults.stubborn": 0.99, "tasks.count": 2})))
    assert len({swarm.feasible_count for swarm in swarms}) == 1
    assert 0 < last.feasible_count < 20
    assert all(robot.mind.knowledge.me.memory[0] % 1 for robot in last.robots)  # whole numbers faded


def test_a_controller_follows_what_it_knows(write):
    robot = controller(write(FADING), 150.0)
    robot.recognise([Thing(False, 4 + k, 0, 1, 1.0, 1.5) for k in range(3)])
    for robots, opinion in ((1, 0), (3, 1)):  # of 5; feasible up to 5.5 / 4 tasks seen for each
        robot.recognise([Thing(True, k, 0, 1, 1.0, 1.5) for k in range(2, 2 + robots)])
        robot.end_step()
        assert (robot.opinion, robot.declared) == (opinion, -1)


# --- On a robot ---


def test_a_controller_declares_and_knows_its_place(write):
    text = replaced(QUIET, SURE, "    return 0 if me.x == 3.5 and me.y == 4.25 else -1")
    robot = controller(write(text), 100.0, place=(1.0, 2.0))
    assert (robot.knowledge.me.x, robot.knowledge.me.y, robot.knowledge.me.explores) == (1.0, 2.0, True)
    robot.recognise([Thing(False, 4, 0, 1, 1.0, 1.5)])
    robot.end_step()
    assert (robot.declared, robot.opinion) == (-1, -1)
    robot.move_to(3.5, 4.25)
    robot.hear(1, Message(1, knowledge=(0, 1, *(0,) * 7)))
    robot.end_step()
    assert (robot.declared, robot.opinion) == (0, 0)
    robot.move_to(1.0, 1.0)
    for _ in range(9):
        robot.end_step()
    assert (robot.declared, robot.opinion) == (0, 0)


def test_a_robot_without_knowledge_declares_nothing_and_needs_no_place():
    robot = Controller(STRATEGIES["dmmd"], 1, lambda mean: 3, lambda: (0.5, 0.5))
    robot.move_to(1.0, 2.0)
    assert robot.declared == -1
