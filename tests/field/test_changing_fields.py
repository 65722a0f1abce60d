"""Fields whose world changes: with clocks, after faults, and with robots from elsewhere."""

from __future__ import annotations

import json
from threading import Thread

import pytest
from commands import invoke
from fields import NEEDS_GROUPS, a_plan, opinions, run, simulated, small

from feasibee.base.codes import DECISIONS
from feasibee.field.node import replay
from feasibee.field.robot import take_part
from feasibee.reference import play

pytestmark = NEEDS_GROUPS

EVENTS = small(
    events=[{"step": 5, "robots": -3, "tasks": 3}, {"step": 12, "robots": 2, "tasks": -1}], steps=30
)
"""Most robots leave, and others join."""


def members(scenario):
    """Return the robots and tasks of the reference at each step."""
    return [([each.number for each in swarm.robots], [*swarm.tasks]) for swarm in play(scenario, 1, 0)]


def logged(steps):
    return [(step["robots"], step["tasks"]) for step in steps]


@pytest.mark.quick(1)
@pytest.mark.parametrize("lockstep", [True, False])
def test_robots_and_tasks_come_and_go_as_in_the_run(lockstep, tmp_path):
    result, events, steps = run(a_plan(EVENTS, lockstep), tmp_path)
    assert logged(steps) == members(EVENTS)
    told = [(event["event"], event["robot"], event["step"]) for event in events if "robot" in event]
    (stays,) = set(range(4)) - {robot for what, robot, _ in told if what == "leaves"}
    leave = [("leaves", k, 5) for k in range(4) if k != stays]
    assert told == [*leave, ("comes", 4, 12), ("comes", 5, 12)]
    assert (result["lost"], result["robots"], result["steps"]) == ([], 3, 30)
    replays = {path.stem: replay(path) for path in tmp_path.glob("robot-*.jsonl")}
    free = sorted({0, 1, 2, 3} - {stays})
    numbers = {f"robot-{process}": number for process, number in enumerate([0, 1, 2, 3, *free[:2]])}
    assert {name: each.number for name, each in replays.items()}.items() <= numbers.items()
    if lockstep:  # clocks may be slow
        played = [replays[name].steps for name in numbers]
        assert played == [30 if k == stays else 4 for k in range(4)] + [19, 19]


@pytest.mark.quick(1)
@pytest.mark.parametrize("lockstep", [True, False])
def test_a_field_whose_robots_have_all_left_goes_on(lockstep, tmp_path):
    scenario = small(**{"robots.failure_rate": 0.5, "run.steps": 30})
    result, _, steps = run(a_plan(scenario, lockstep), tmp_path)
    assert logged(steps) == members(scenario)
    assert (result["robots"], result["steps"], len(steps)) == (0, 30, 31)
    if not lockstep:
        assert result["achieved_hz"] < 60  # by the world's own clock


def test_a_robot_from_elsewhere_waits_until_it_comes(tmp_path):
    scenario = small(robots=2, steps=20, events=[{"step": 5, "robots": 1}, {"step": 10, "robots": -1}])
    ended = {}

    def take(address, number):
        ended[number] = take_part({"connect": address, "number": number, "brain": ""})

    def follow(event):
        if event["event"] == "listening":
            threads.extend(Thread(target=take, args=(event["address"], number)) for number in range(4))
            for each in threads:
                each.start()

    threads = []
    _, _, steps = run(a_plan(scenario), tmp_path, starts_robots=False, follow=follow)
    for each in threads:
        each.join(30)
    assert opinions(steps) == simulated(scenario)[0]
    assert ended == dict.fromkeys(range(4), (0, ""))  # robot 3 never comes


def test_the_command_prints_the_decision_and_the_measures_of_the_run(tmp_path):
    path = tmp_path / "changing.toml"
    events = [{"step": 10, "tasks": 6}, {"step": 30, "tasks": -7}]
    scenario = small(**{"decision.strategy": "roster", "events": events, "run.steps": 60})
    path.write_text(scenario.to_toml())
    found = json.loads(invoke("robot", "launch", path, "--lockstep", "--seed", 1, "--json").stdout)
    expected = json.loads(invoke("run", path, "--runs", 1, "--seed", 1, "--json").stdout)
    names = ("right_share", "detection_delay", "missed", "false_alarms", "truth_intervals")
    assert {name: found[name] for name in names} == {name: expected[name] for name in names}
    assert len(found["truth_intervals"]) == 3
    code, step = simulated(scenario)[1]
    assert (found["decision"], found["decision_step"]) == (DECISIONS[code], step)
