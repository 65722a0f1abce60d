"""Robots that declare, know n and their place, and collude: a user's files in both implementations."""

from __future__ import annotations

import pytest
from own_files import HEAD, QUIET, SURE, assert_same, controller, played, replaced

from feasibee import Scenario, Swarm, reference
from feasibee.robot.controller import Controller, Message
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies.contract import Thing

SEEN = "(int(1000 * thing.x) * 5 + int(1000 * thing.y))"
SMALL = {"arena.side": 10.0, "run.steps": 90, "robots.know_count": True}
LIARS = {"faults.byzantine": 0.15, "faults.byzantine_says": "colluding"}
WORLDS = {
    "paper": {},
    "infeasible": {"tasks.count": 24},
    "many, walls and bodies": {
        "robots.count": 40,
        "tasks.count": 30,
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
        "arena.side": 14.0,
    },
    "oblong torus": {"arena.side": [14.0, 7.0], "radio.id_bits": 3},
    "stopped and stubborn": {"faults.stopped": 0.2, "faults.stop_step": 25, "faults.stubborn": 0.2},
    "colluders invent tasks": LIARS,
    "colluders invent robots": {**LIARS, "tasks.count": 24, "robots.count": 21},
}
COSTLY_WORLDS = [
    pytest.param(name, marks=[] if name in ("paper", "colluders invent tasks") else [pytest.mark.slow])
    for name in WORLDS
]
"""The reference takes seconds, so the fast tests have two worlds."""


def scenario_of(path, **changes):
    return Scenario().replace({**SMALL, "decision.strategy": str(path), **changes})


# --- Declaring ---


@pytest.mark.quick(1)
@pytest.mark.parametrize("world", COSTLY_WORLDS)
def test_declaring_is_equal_in_engine_and_reference(write, world):
    record = assert_same(*2 * [scenario_of(write(QUIET), **WORLDS[world])])
    assert (record.declared_feasible + record.declared_infeasible > 0).any()


def test_a_robot_declares_once_adopts_what_it_declares_at_once_and_keeps_it(write):
    """Though the strategy would then decide for the opposite."""
    text = replaced(QUIET, "    return kept(mind.opinion)", "    return 1 - larger(mind.opinion, 0)")
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
    return replaced(QUIET, "    tasks = tasks_in(known)\n    if", f"    {line}\n    tasks = 0\n    if")


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


def test_positions_are_those_of_the_swarm(write):
    """Words hold the last position and the last thing seen, in thousandths of a unit."""
    text = replaced(
        QUIET.replace("3 + (setting", "8 + (setting")
        .replace("known[3 +", "known[8 +")
        .replace("(3, len", "(8, len"),
        f"    known[2] = (known[2] + {SEEN} % 97 * place(me)) % 99991",
        "    known[6] = int(1000 * thing.x)\n    known[7] = int(1000 * thing.y)\n"
        "    known[3] = -1 - thing.id if thing.is_robot else thing.id",
    )
    text = replaced(
        text,
        "    known[2] = (known[2] + place(me)) % 99991\n",
        "    known[4] = int(1000 * me.x)\n    known[5] = int(1000 * me.y)\n    known[2] = int(me.explores)\n",
    )
    path = write(text)
    changes = {"arena.side": [14.0, 7.0], "run.steps": 25, "decision.parameters": {"quiet": 99.0}}
    assert_same(*2 * [scenario_of(path, **changes)])
    plain = reference.Swarm(scenario_of(path, **changes), seed=3, run=0)
    swarm = Swarm(scenario_of(path, **changes), seed=3, run=0)
    seen = set()
    for _ in range(25):
        explored = [not robot.mind.disseminating for robot in plain.robots]
        plain.step()
        swarm.advance()
        for number, robot in enumerate(plain.robots):
            x, y = swarm.positions[number]
            assert robot.mind.knowledge.words[4:6] == [int(1000 * x), int(1000 * y)]
            assert robot.mind.knowledge.words[2] == explored[number]
            thing = robot.mind.knowledge.words[3]
            if explored[number] and any(robot.mind.knowledge.words[6:8]):
                where = swarm.positions[-1 - thing] if thing < 0 else swarm.tasks[thing]
                if plain._sees(
                    robot, plain.robots[-1 - thing].place if thing < 0 else plain.tasks[thing], 0, 0
                ):
                    assert robot.mind.knowledge.words[6:8] == [int(1000 * each) for each in where]
                    seen.add(thing < 0)
    assert seen == {True, False}


@pytest.mark.slow
def test_what_is_not_there_and_what_is_invented_is_nowhere(write):
    text = replaced(QUIET, "BY_NAME = True", "BY_NAME = False")
    text = replaced(
        text,
        "    if not thing.is_robot:\n",
        "    if thing.id < 0 or thing.id >= me.setting.tasks:\n"
        "        known[1] += 1 if thing.x == 0.0 and thing.y == 0.0 else 1000000\n"
        "        return\n    if not thing.is_robot:\n",
    )
    changes = {"sensing.false_robots": 0.3, "sensing.false_tasks": 0.3, "run.steps": 20, "tasks.count": 20}
    (*_, last) = played(scenario_of(write(text), **changes))
    assert all(0 < robot.mind.knowledge.words[1] < 1000000 for robot in last.robots)
    assert_same(*2 * [scenario_of(write(text), **changes)])


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


# --- Helpers ---


@pytest.mark.slow
def test_a_helper_may_read_constants_and_have_the_name_of_a_field(write):
    """The names of attributes are no calls: `tasks` here is both a field and a helper."""
    text = replaced(
        QUIET,
        "def words(setting)",
        "ONE = 1\n\n\ndef tasks(number):\n    return ONE * number\n\n\ndef words(setting)",
    )
    text = replaced(text, "    return opinion\n", "    return tasks(opinion)\n")
    assert_same(scenario_of(write(QUIET)), scenario_of(write(text, "other.py")))


# --- Colluding ---

COUNTING = (
    HEAD.replace("NEEDS_COUNT = True\n", "")
    .replace("BY_NAME = True\n", "")
    .replace("3 + (setting.task_ids + 30) // 31", "5")
    .replace("= place(me)", "= 0 * place(me)")
    + """

def observe(known, thing, me):
    if thing.id >= (me.setting.robots if thing.is_robot else me.setting.tasks):
        known[0 if thing.is_robot else 1] += 1
    known[2] += 1


def merge(known, message, sender, me):
    if message[0] + message[1] > 0:
        known[3] = message[0]
        known[4] = message[1]


def count(known, counts, me):
    counts[0] = known[3]
    counts[me.setting.robot_classes] = known[4]


def bits(message, me):
    return 1000 * message[0] + message[1]
"""
)
"""Robots remember how many invented robots and tasks the last false message held."""
LIAR = {**LIARS, "faults.byzantine": 0.05}
ALL_HEAR = {
    "arena.side": 4.0,
    "radio.range": 2.0,
    "sensing.range": 0.1,
    "arena.boundary": "walls",
    "run.steps": 30,
    "robots.know_count": False,
}


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("tasks", "robots_invented", "tasks_invented"), [(10, 0, 11), (20, 0, 1), (21, 1, 0), (30, 10, 0)]
)
def test_colluders_invent_exactly_what_the_lie_needs(write, tasks, robots_invented, tasks_invented):
    changes = {**ALL_HEAR, **LIAR, "tasks.count": tasks}
    scenario = scenario_of(write(COUNTING), **changes)
    assert_same(scenario, scenario)
    (*_, last) = played(scenario_of(write(COUNTING), **changes))
    heard = [robot.mind.knowledge.words for robot in last.robots if robot.fault != "byzantine"]
    assert {tuple(words[3:5]) for words in heard if words[3] + words[4]} == {
        (robots_invented, tasks_invented)
    }


def test_colluders_that_speak_for_feasible_leave_all_else_out(write):
    """The words of a message that denies tasks are 0 but for what is invented."""
    changes = {**ALL_HEAR, **LIARS, "tasks.count": 24, "sensing.range": 2.0}
    for swarm in played(scenario_of(write(COUNTING), **changes)):
        for robot in swarm.robots:
            if robot.fault == "byzantine":
                said = robot.says(swarm.time)
                assert said.opinion == 1
                assert said.knowledge == (4, 0, 4, 0, 0)  # four inventions, no sighting
    changes |= {**LIAR, "tasks.count": 20}
    (*_, last) = played(scenario_of(write(COUNTING), **changes))
    said = [robot.says(last.time) for robot in last.robots if robot.fault == "byzantine"]
    assert all(each.knowledge[1] == 1 and each.knowledge[2] > 1 and each.opinion == 0 for each in said)


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


@pytest.mark.slow
def test_colluders_with_classes_invent_as_many_as_other_byzantine_robots():
    classes = {
        "robots.classes": [{"name": "a", "count": 12}, {"name": "b", "count": 8}],
        "tasks.classes": [
            {"name": "c", "count": 6, "needs": {"x": 1}},
            {"name": "d", "count": 4, "needs": {"x": 2}},
        ],
    }
    scenario = Scenario().replace({"decision.strategy": "census", **LIARS, **classes})
    names = reference.Swarm(scenario, seed=1, run=0).names
    assert [len(names.inventions(feasible)) for feasible in (1, 0)] == [10, 21]
    assert_same(scenario.replace({"run.steps": 60}), scenario.replace({"run.steps": 60}))


# --- On a robot ---


def test_a_controller_declares_and_knows_its_place(write):
    text = replaced(QUIET, SURE, "    return 0 if me.x == 3.5 and me.y == 4.25 else -1")
    robot = controller(write(text), 100.0, place=(1.0, 2.0))
    assert (robot.knowledge.me.x, robot.knowledge.me.y, robot.knowledge.me.explores) == (1.0, 2.0, True)
    robot.recognise([Thing(False, 4, 0, 1, 1.0, 1.5)])
    robot.end_step()
    assert (robot.declared, robot.opinion) == (-1, -1)
    robot.move_to(3.5, 4.25)
    robot.hear(1, Message(1, knowledge=(0, 0, 0, 3)))
    robot.end_step()
    assert (robot.declared, robot.opinion) == (0, 0)
    robot.move_to(1.0, 1.0)
    for _ in range(9):
        robot.end_step()
    assert (robot.declared, robot.opinion) == (0, 0)


def test_a_robot_without_knowledge_declares_nothing_and_needs_no_place():
    from feasibee.strategies import STRATEGIES

    robot = Controller(STRATEGIES["dmmd"], 1, lambda mean: 3, lambda: (0.5, 0.5))
    robot.move_to(1.0, 2.0)
    assert robot.declared == -1
