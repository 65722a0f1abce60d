"""A field in lockstep equals the run, bit for bit, for each kind of strategy."""

from __future__ import annotations

import pytest
from commands import refused_in_a_line
from fields import MINE, NEEDS_GROUPS, PUT, STREAMS, a_plan, opinions, run, simulated, small, steps_of
from nets import play as play_in_memory

from feasibee import Scenario
from feasibee.base.codes import DECISIONS
from feasibee.base.errors import FeasibeeError
from feasibee.field.brain import compiled
from feasibee.field.node import replay
from feasibee.field.recording import Recording
from feasibee.field.supervisor import Field
from feasibee.reference import play
from feasibee.reference.swarm import WORKED
from feasibee.scenario.plugins import strategy_of
from feasibee.strategies import STRATEGIES
from tests.places import rooms
from tests.robot.driving import needs


def check_equal(scenario, folder, result):
    steps = steps_of(folder)
    expected, (decision, decision_step) = simulated(scenario)
    assert opinions(steps) == expected
    for step, swarm in zip(steps, play(scenario, 1, 0), strict=True):
        errands = [robot.errand for robot in swarm.robots]
        goes = [[each.target, each.task, each.mark] for each in errands]
        done = sorted(swarm.work.done) if swarm.work else None
        assert (step.get("goes"), step.get("done")) == (goes if swarm.work else None, done), step["step"]
        minds = [(mind[3], mind[4]) for mind in step["minds"]]
        assert minds == [(robot.mind.phase_left, robot.mind.phases) for robot in swarm.robots], step["step"]
    assert [step["step"] for step in steps] == list(range(len(expected)))
    assert (result["decision"], result["decision_step"]) == (DECISIONS[decision], decision_step)
    assert result["lost"] == []
    if swarm.work:
        assert result["acting"] == {name: getattr(swarm.work, name) for name in WORKED}


def check_recorded(scenario, folder):
    """Each task is marked, taken or done in the recording when it is so in the run."""
    field = Recording(folder)
    for field.step, swarm in enumerate(play(scenario, 1, 0)):
        has = {task: robot.number for task, robot in swarm.work.holders.items()} | dict.fromkeys(
            swarm.work.done, -2
        )
        assert field.acting.holders.tolist() == [has.get(task, -1) for task in swarm.tasks], field.step


CLASSES = {
    "robots.classes": [
        {"name": "a", "count": 3, "skills": ["x"]},
        {"name": "b", "count": 2, "skills": ["x", "y"]},
    ],
    "tasks.classes": [
        {"name": "c", "count": 2, "needs": {"x": 1, "y": 1}},
        {"name": "d", "count": 1, "needs": {"y": 1}},
        {"name": "e", "count": 2, "needs": {"x": 1}},
    ],
}
WORLDS = {
    **{name: {"decision.strategy": name, "robots.know_count": True} for name in STRATEGIES},
    "a rule to declare, and knowledge": {
        "decision.strategy": "tally",
        "decision.declare": {"quorum": 0.6, "rounds": 1, "heard": 1},
    },
    "declaring by votes": {"decision.declare": {"quorum": 0.7, "rounds": 1, "heard": 1}},
    "first sight, and a robot that keeps its coin": {
        "decision.start": "first-sight",
        "decision.exploration": 3.0,
        "faults.stubborn": 0.4,
    },
    "faults": {
        "robots.count": 6,
        "faults.stopped": 0.2,
        "faults.stop_step": 20,
        "faults.byzantine": 0.2,
        "faults.byzantine_says": "colluding",
        "faults.stubborn": 0.2,
    },
    "liars who lie about what they saw": {
        "robots.count": 6,
        "decision.strategy": "tally",
        "faults.byzantine": 0.3,
        "faults.byzantine_says": "random",
    },
    **{f"classes and {name}": {**CLASSES, "decision.strategy": name} for name in ("dmmd", "tally", "census")},
    "bad senses and radio": {
        "sensing.miss": 0.2,
        "sensing.false_robots": 0.3,
        "sensing.false_tasks": 0.3,
        "sensing.observation": "unique",
        "radio.loss": 0.3,
        "radio.id_bits": 2,
    },
    "tasks named by position": {
        "robots.count": 6,
        "decision.strategy": "roster",
        "robots.know_count": True,
        "run.stop_at_decision": False,
    },
    "late messages of robots that stop, leave and join": {
        "radio.delay": 3,
        "robots.count": 6,
        "faults.stopped": 0.2,
        "faults.stop_step": 12,
        "events": [{"step": 8, "robots": -2}, {"step": 16, "robots": 2}],
    },
    "robots that see what is ahead": {"sensing.view": 120.0},
    "two rooms": {
        "arena.boundary": "walls",
        "place.walls": rooms(2.0, 8.0),
        "radio.walls": 0.6,
        "robots.know_count": True,
        "decision.strategy": "roster",
        "run.stop_at_decision": False,
    },
    "tasks under wrong names": {
        "decision.strategy": "quiet-census",
        "robots.know_count": True,
        "sensing.misname": 0.1,
        "run.stop_at_decision": False,
    },
    "noisy positions": {
        "decision.strategy": "census",
        "tasks.count": 30,
        "sensing.position_error": 0.1,
        "sensing.gate": 0.5,
    },
    "tasks under wrong names and liars, by position": {
        "robots.count": 6,
        "decision.strategy": "roster",
        "sensing.misname": 0.1,
        "faults.byzantine": {"count": 1},
    },
    "tasks that appear and vanish": {
        "decision.strategy": "roster",
        "robots.know_count": True,
        "events": [{"step": 10, "tasks": 4}, {"step": 25, "tasks": -5}],
    },
    "robots and tasks that are put at points": {"decision.strategy": "roster", "events": PUT},
    "senses and radio that get worse": {
        "robots.know_count": True,
        "decision.strategy": "roster",
        "decision.exploration": 3.0,
        "decision.gain": 3.0,
        "events": [{"step": 5, "radio": {"loss": 0.7}}, {"step": 10, "sensing": {"miss": 0.7}}],
    },
    "robots that join and leave": {
        "events": [{"step": 0, "robots": 1}, {"step": 10, "robots": -3}, {"step": 20, "robots": 4}]
    },
    "robots and tasks that come and go": STREAMS,
    "liars by name in a world that changes": {
        "robots.count": 6,
        "decision.strategy": "roster",
        "faults.byzantine": 0.3,
        "faults.byzantine_says": "colluding",
        "events": [{"step": 10, "tasks": 8}, {"step": 25, "robots": 2}],
    },
    "liars by name": {
        "robots.count": 6,
        "decision.strategy": "census",
        "faults.byzantine": 0.3,
        "faults.byzantine_says": "feasible",
    },
}
ACTING = {
    "at once": {"acting.start": 0},
    "by rank once declared": {
        "acting.start": "declared",
        "acting.choose": "rank",
        "decision.strategy": "quiet-census",
        "robots.know_count": True,
        "run.steps": 120,
    },
    "tags of bodies": {
        "acting.start": 25,
        "acting.hold": "tag",
        "robots.avoid_collisions": True,
        "robots.diameter": 0.8,
        "robots.count": 7,
    },
    "liars and late messages": {
        "acting.start": 5,
        "robots.count": 7,
        "faults.byzantine": {"count": 1},
        "radio.delay": 2,
    },
    "robots and tasks that come and go": {**STREAMS, "acting.start": 0, "tasks.lifetime": 30.0},
    "two rooms, in which the nearest task by a straight line isn't the nearest": {
        "arena.side": 12.0,
        "arena.boundary": "walls",
        "place.walls": rooms(1.0, 12.0),
        "acting.start": 8,
        "radio.walls": 1.0,
        "robots.count": 12,
        "tasks.count": 12,
    },
    "tasks that take time": {"acting.start": 0, "tasks.count": 7, "tasks.work": 6, "run.steps": 80},
    "robots that stop, and a run that ends": {
        "acting.start": 0,
        "robots.count": 6,
        "tasks.count": 3,
        "faults.stopped": 0.4,
        "faults.stop_step": 15,
        "run.steps": 100,
    },
}


def of(world):
    """Return a small world; classes have their own numbers of robots and tasks."""
    if "classes" in world:
        return Scenario().replace({"arena.side": 8.0, "run.steps": 40, **WORLDS[world]})
    return small(**WORLDS[world]).with_flooding(20)


@pytest.mark.quick(8)
@pytest.mark.parametrize("world", WORLDS)
def test_a_field_in_lockstep_equals_the_run(world, tmp_path):
    scenario = of(world)
    check_equal(scenario, tmp_path, play_in_memory(a_plan(scenario), tmp_path)[1])


@pytest.mark.quick(8)
@pytest.mark.parametrize("world", WORLDS)
def test_robots_in_c_equal_the_run(world, tmp_path):
    """The program that is flashed, in the simulated world; Byzantine robots stay in Python."""
    needs("cc", "gcc")
    scenario = of(world)
    brain = compiled(strategy_of(scenario.manifest), scenario.setting, tmp_path)
    check_equal(scenario, tmp_path, play_in_memory(a_plan(scenario), tmp_path, brain=brain)[1])


@pytest.mark.quick(3)
@pytest.mark.parametrize("world", ACTING)
def test_acting_robots_of_a_field_equal_the_run(world, tmp_path):
    """Their targets and tasks at each step, and what comes of it; and their logs replay."""
    changes = {"run.stop_at_decision": False, **ACTING[world]}
    usual = {"arena.side": 8.0, "run.steps": 50}
    scenario = (
        Scenario().replace({**usual, **changes})
        if "tasks.classes" in changes
        else small(**{**usual, **changes})
    )
    _, result, *_ = play_in_memory(a_plan(scenario), tmp_path)
    check_equal(scenario, tmp_path, result)
    assert result["acting"]["tasks_taken"] > 0
    check_recorded(scenario, tmp_path)
    for log in tmp_path.glob("robot-*.jsonl"):
        replay(log)


@NEEDS_GROUPS
def test_robots_with_clocks_of_their_own_take_all_tasks(tmp_path):
    scenario = small(
        **{"acting.start": 10, "run.steps": 400, "run.stop_when_taken": True, "run.stop_at_decision": False}
    )
    result = run(a_plan(scenario, lockstep=False, hz=100.0, jitter=0.2), tmp_path)[0]
    assert result["acting"]["tasks_taken"] == 4
    assert result["acting"]["all_taken_step"] > 10
    for log in tmp_path.glob("robot-*.jsonl"):
        replay(log)


def test_what_acting_robots_of_a_field_can_not_do_is_an_error():
    with pytest.raises(FeasibeeError, match="robots of a field that act know only the tasks of the start"):
        Field(a_plan(small(**{"acting.start": 3, "events": PUT[:1]})), None, print)
    assert "frames in C" in refused_in_a_line("robot", "launch", "--c", "--set", "acting.start=3")


@NEEDS_GROUPS
@pytest.mark.parametrize("own", [False, True])
def test_a_field_of_processes_equals_the_run(own, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    scenario = small(**{"decision.strategy": str(path)} if own else {})
    check_equal(scenario, tmp_path, run(a_plan(scenario), tmp_path)[0])


@pytest.mark.slow
@NEEDS_GROUPS
def test_fifty_processes_equal_the_run(tmp_path):
    scenario = Scenario().replace({"robots.count": 50, "run.steps": 100})
    check_equal(scenario, tmp_path, run(a_plan(scenario), tmp_path)[0])
