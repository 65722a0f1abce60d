"""A field of nodes equals the run in lockstep; with clocks it ends; faults happen as in one without ROS."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from fields import PUT, STREAMS, a_plan, opinions, run, simulated, small
from std_msgs.msg import String

from feasibee.base.codes import DECISIONS
from feasibee.field.bodies import Bodies
from feasibee.field.node import replay
from feasibee.field.plan import Fault
from feasibee.reference import play
from feasibee_ros.field.world import _are_nameless
from feasibee_ros.simulated import SimulatedRobot

NODES = "feasibee_ros.field"
WORLDS = {
    "opinions": {},
    "names": {"decision.strategy": "turns", "robots.know_count": True},
    "positions": {"decision.strategy": "map", "robots.know_count": True},
    "a rule to declare": {"decision.declare": {"quorum": 0.7, "rounds": 1, "heard": 1}},
    "liars": {"robots.count": 6, "faults.byzantine": 0.2, "faults.byzantine_says": "colluding"},
    "bad senses and radio": {
        "sensing.miss": 0.2,
        "sensing.false_tasks": 0.3,
        "sensing.observation": "unique",
        "radio.loss": 0.3,
    },
    "metres": {"units.metres": 0.3},
    "late messages": {"radio.delay": 3},
    "acting": {"acting.start": 10, "arena.boundary": "walls", "run.stop_at_decision": False},
}
QUICK = "opinions", "names"


def check_equal(scenario, folder, result, steps):
    expected, (decision, decision_step) = simulated(scenario)
    assert opinions(steps) == expected
    for step, swarm in zip(steps, play(scenario, 1, 0), strict=True):
        minds = [(mind[1], mind[3], mind[4]) for mind in step["minds"]]
        held = [(each.mind.declared, each.mind.phase_left, each.mind.phases) for each in swarm.robots]
        assert minds == held, step["step"]
    assert (result["decision"], result["decision_step"]) == (DECISIONS[decision], decision_step)
    assert result["lost"] == []
    for log in folder.glob("robot-*.jsonl"):
        replay(log)


@pytest.mark.parametrize(
    "world", [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in WORLDS]
)
def test_nodes_in_lockstep_equal_the_run(world, tmp_path):
    scenario = small(**WORLDS[world])
    result, _, steps = run(a_plan(scenario), tmp_path, package=NODES)
    check_equal(scenario, tmp_path, result, steps)


@pytest.mark.slow
@pytest.mark.parametrize("changes", [STREAMS, {"events": PUT}], ids=["streams", "put"])
def test_nodes_come_and_go_as_in_the_run(changes, tmp_path):
    scenario = small(steps=20, **changes)
    result, _, steps = run(a_plan(scenario), tmp_path, package=NODES)
    check_equal(scenario, tmp_path, result, steps)


@pytest.mark.slow
def test_twenty_nodes_over_300_steps_equal_the_run(tmp_path):
    scenario = small(robots=20, steps=300, **{"arena.side": 20.0, "run.stop_at_decision": False})
    result, _, steps = run(a_plan(scenario), tmp_path, package=NODES)
    assert len(steps) == 301
    check_equal(scenario, tmp_path, result, steps)


def test_nodes_with_clocks_play_all_steps_and_their_logs_replay(tmp_path):
    scenario = small(steps=30)
    plan = a_plan(scenario, lockstep=False, hz=20.0, drift=0.05, jitter=0.3, delay=2.0)
    result, _, steps = run(plan, tmp_path, package=NODES)
    assert (result["steps"], result["lost"], len(steps)) == (30, [], 31)
    assert all(replay(tmp_path / f"robot-{number}.jsonl").steps >= 20 for number in range(4))


@pytest.mark.parametrize(
    "changes", [{"sensing.observation": "unique"}, {"faults.byzantine": 0.5}, {"decision.strategy": "census"}]
)
def test_robots_see_poses_unless_they_need_names(changes):
    assert _are_nameless(small())
    assert not _are_nameless(small(**changes))


WITHOUT_A_WORLD = """
import os
from pathlib import Path
from feasibee_ros.field.robot import take_part
status, why = take_part({"number": 1, "patience": 0.0, "brain": ""})
print(status, "fastdds_" in Path("/proc/self/maps").read_text(), flush=True)
os._exit(0)
"""


def test_a_robot_whose_world_is_gone_leaves_no_shared_memory(monkeypatch):
    """Though it ends at once. In its domain it maps no memory of a node that an earlier test left."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "101")  # conftest.py gives 1 to 100
    done = subprocess.run([sys.executable, "-c", WITHOUT_A_WORLD], capture_output=True, text=True, check=True)
    assert done.stdout == "3 False\n"


def test_a_simulated_robot_has_one_clock_however_often_it_sees(nodes):
    scenario = small()
    bodies = Bodies(scenario, 1, 0)
    orders = bodies.orders(bodies.everyone[0])
    clock = {"clock": {"period": 1000.0, "drift": 0.0, "jitter": 0.0}}
    robot = nodes.add(SimulatedRobot(namespace="/robot_0"))
    robot.start()
    robot._take_orders(String(data=json.dumps({**orders, **clock, "metres": 1.0, "detections": "objects"})))
    before = len(robot._clocks)
    for step in range(3):
        seen = {"t": step, "place": [1.0, 2.0], "see": []}
        robot.senses.take_object(String(data=json.dumps(seen)))
        robot.has_sensed()
    assert len(robot._clocks) == before + 1


@pytest.mark.slow
def test_killed_and_stopped_nodes_are_lost_and_their_logs_replay(tmp_path):
    scenario = small(robots=6)
    faults = (Fault(10, "kill", 2, (4, 5)), Fault(20, "pause", 1, (3,)))
    result, events, _ = run(a_plan(scenario, faults=faults, patience=5.0), tmp_path, package=NODES)
    assert result["lost"] == [3, 4, 5]
    assert [(e["robot"], e["step"]) for e in events if e["event"] == "lost"] == [(4, 10), (5, 10), (3, 20)]
    assert [replay(tmp_path / f"robot-{number}.jsonl").steps for number in range(6)] == [40, 40, 40, 19, 9, 9]


@pytest.mark.slow
def test_a_node_that_was_stopped_takes_part_again(tmp_path):
    faults = (Fault(20, "pause", 1, (4,)), Fault(150, "resume", 1, (4,)))
    plan = a_plan(small(robots=5, steps=300), lockstep=False, faults=faults, patience=3.0, hz=20.0)
    result, events, _ = run(plan, tmp_path, package=NODES)
    assert [event["robot"] for event in events if event["event"] in ("lost", "back")] == [4, 4]
    assert result["lost"] == []
