"""A robot's node: its parameters, its life, what it takes from sensors and others, what it tells."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, Quaternion
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from std_msgs.msg import Float32, Header, Int8, String, UInt8MultiArray

from feasibee import Scenario
from feasibee.field.node import replay
from feasibee.robot import Message, Wire
from feasibee.strategies import STRATEGIES
from feasibee_ros.messages import frame_from, frame_message, reported
from feasibee_ros.robot import LOGGED, Robot
from feasibee_ros.senses import OBJECTS, Senses

EXAMPLES = Path(__file__).parents[1] / "examples"
NEVER = 1e-3
"""Hertz of a robot whose steps a test takes."""


def robot_of(nodes, number=0, start=True, **parameters):
    """Return a robot with parameters; ``__`` in their names stands for a dot."""
    given = {"hz": NEVER, "seed": 7, **parameters}
    plain = [Parameter(name.replace("__", "."), value=value) for name, value in given.items()]
    robot = nodes.add(Robot(namespace=f"/robot_{number}", parameter_overrides=plain))
    if start:
        robot.start()
    return robot


def test_no_thread_of_fast_dds_looks_up_types(nodes):
    """Two of them sometimes ended a node that started together with many."""
    robot_of(nodes)
    names = [path.read_text() for path in Path("/proc/self/task").glob("*/comm")]
    assert any(name.startswith("dds.") for name in names)
    assert not any(name.startswith("dds.tls") for name in names)


class Listener:
    """Keeps what a topic says."""

    def __init__(self, nodes, kind, topic, qos=10):
        self.heard = []
        self.node = nodes.all[0]
        self.made = self.node.create_subscription(kind, topic, self.heard.append, qos)
        nodes.until(self.made.get_publisher_count)


def poses(*places, frame="map"):
    return PoseArray(header=Header(frame_id=frame), poses=[Pose(position=Point(x=x, y=y)) for x, y in places])


def odometry(x, y, yaw=0.0, roll=0.0):
    message = Odometry(header=Header(frame_id="map"), child_frame_id="base_link")
    (c, s), (d, t) = ((math.cos(each / 2), math.sin(each / 2)) for each in (yaw, roll))
    turned = Quaternion(w=c * d, x=c * t, y=s * t, z=s * d)
    message.pose.pose = Pose(position=Point(x=x, y=y), orientation=turned)
    return message


def test_a_robot_counts_what_it_sees_and_tells_what_it_holds(nodes):
    robot = robot_of(nodes, 3, decision__exploration=5.0)
    told = {topic: Listener(nodes, Int8, f"/robot_3/{topic}") for topic in ("opinion", "declaration")}
    told["confidence"] = Listener(nodes, Float32, "/robot_3/confidence")
    status = Listener(nodes, DiagnosticArray, "/robot_3/status")
    makers = [robot.create_publisher(PoseArray, f"/robot_3/{name}", 10) for name in ("robots", "tasks")]
    nodes.until(lambda: all(each.get_subscription_count() for each in makers))
    makers[0].publish(poses((1.0, 2.0), (2.0, 3.0), (3.0, 4.0)))
    makers[1].publish(poses((5.0, 5.0)))
    nodes.until(lambda: len(robot.senses.sensed(None, [])["see"]) == 4)
    while not robot.mind.status.disseminating:
        robot.tick()
    robot.tick()
    steps = robot.step - 1
    nodes.until(lambda: all(len(each.heard) == steps for each in (*told.values(), status)))
    held = reported(status.heard[-1])
    assert told["opinion"].heard[-1].data == held["opinion"] == robot.mind.status.opinion
    assert told["declaration"].heard[-1].data == -1
    of_feasible = 3 / 4  # three robots and one task in each look
    quality = of_feasible if held["opinion"] == 1 else 1 - of_feasible
    assert told["confidence"].heard[-1].data == held["confidence"] == quality


def test_robots_that_hear_each_other_declare_the_same(nodes):
    rule = "{quorum = 1.0, rounds = 1, heard = 1}"
    radio = {"topics__heard": "/radio", "topics__said": "/radio"}
    known = {"decision__exploration": 3.0, "decision__gain": 5.0, "decision__declare": rule, **radio}
    swarm = [robot_of(nodes, k, seed=k, hz=100.0, stale=3600.0, **known) for k in range(3)]
    for robot in swarm:
        robot.senses.take_poses("robots", poses((1.0, 1.0)))
        robot.senses.take_poses("tasks", poses((2.0, 2.0)))
    nodes.until(lambda: all(robot.mind.status.declared != -1 for robot in swarm))
    assert len({robot.mind.status.declared for robot in swarm}) == 1
    assert not any(robot.mind.dropped["malformed message"] for robot in swarm)


def test_what_a_robot_says_is_a_frame_and_it_hears_frames_of_others_only(nodes):
    robot = robot_of(nodes, 2, decision__exploration=2.0)
    said = Listener(nodes, UInt8MultiArray, "/robot_2/said", 1000)
    while robot._said is None:
        robot.tick()
    nodes.until(lambda: said.heard)
    wire = Wire(STRATEGIES["dmmd"], 5)
    sender, step, text = frame_from(said.heard[0])
    assert (sender, step, wire.decode(bytes.fromhex(text))[0]) == (2, robot.step, 2)
    other = wire.encode(1, Message(opinion=1)).hex()
    for message in (
        said.heard[0],
        frame_message(1, 9, other),
        UInt8MultiArray(),
        frame_message(4, 9, "00ff"),
    ):
        robot.take_frame(message)
    robot.end()
    assert robot.mind._line["heard"] == [[1, other]]
    assert robot.mind.dropped["malformed message"] == 2
    robot.tick()
    robot.end()
    assert robot.mind._line["heard"] == []  # each message once


def test_poses_in_the_robots_frame_are_turned_and_moved():
    senses = Senses(0.5, "poses")
    senses.take_odometry(odometry(1.0, 2.0, math.atan2(4, 3), roll=0.3))
    senses.take_poses("tasks", poses((0.5, 0.3), frame="base_link"))
    senses.take_poses("robots", poses((0.5, 0.0)))
    assert senses.place == (2.0, 4.0)
    task, robot = senses.sensed(None, [])["see"]
    assert task[:4] == [0, -1, 0, 0]
    assert task[4:6] == pytest.approx([2.12, 5.16])
    assert robot[4:6] == [1.0, 0.0]
    senses.take_poses("tasks", poses((math.nan, 0.0)))
    senses.take_odometry(odometry(math.inf, 0.0))
    senses.take_poses("tasks", poses((0.5, 0.0), frame="camera"))
    assert (senses.dropped, senses.place, senses.foreign) == (3, (2.0, 4.0), "camera")
    assert senses.sensed(None, [])["see"] == [task, robot]


def test_objects_are_those_of_a_driver_and_invalid_ones_are_counted():
    senses = Senses(1.0, OBJECTS)
    senses.take_object(String(data=json.dumps({"robots": 2, "tasks": 1, "place": [3, 4]})))
    assert (senses.place, len(senses.sensed(None, [])["see"])) == ((3, 4), 3)
    for text in ("", "[]", '{"robots": -1}', "{" * 5000):
        senses.take_object(String(data=text))
    assert senses.dropped == 4


def test_a_goal_is_reached_with_how_the_nearest_task_there_is():
    senses = Senses(1.0, OBJECTS)
    see = [[0, 7, 0, 0, 3.2, 4.0, 0], [0, 8, 0, 0, 3.9, 4.0, 1], [1, 7, 0, 0, 3.8, 4.0, -1]]
    senses.take_object(String(data=json.dumps({"see": see, "place": [3, 4], "taken": [[0, 2], [1, -1]]})))
    assert senses.arrived([3.3, 4.0], 1.0) == [["reached", 2]]
    assert senses.arrived([3.8, 4.0], 1.0) == [["reached", -1]]
    assert senses.arrived([3.0, 4.5], 0.5) == [["reached", -1]]  # no task is there
    assert senses.arrived([4.5, 4.0], 1.0) == []
    senses.take_object(String(data=json.dumps({"see": see, "place": [3, 4]})))
    assert senses.arrived([3.3, 4.0], 1.0) == [["reached", 0]]


def test_what_a_driver_says_of_the_body_is_told_once():
    senses = Senses(1.0, OBJECTS)
    senses.take_object(String(data=json.dumps({"acts": [["reached", 2]]})))
    assert [senses.sensed([1, 2, 3], [])["acts"] for _ in range(2)] == [[3, [("reached", 2)]], [3, []]]


def test_its_log_replays_to_the_bit(nodes, tmp_path):
    robot = robot_of(nodes, 1, decision__strategy="census")
    lines = Listener(nodes, String, "/robot_1/log", LOGGED)
    robot.senses = Senses(1.0, OBJECTS)
    for k in range(40):
        see = [[1, k % 20, 0, 5, 1.0, 2.0, -1], [0, k % 7, 0, 9, 2.0, 2.0, -1]]
        robot.senses.take_object(String(data=json.dumps({"see": see})))
        robot.tick()
    nodes.until(lambda: len(lines.heard) == 40)  # the head, and each step that has ended
    log = tmp_path / "robot-1.jsonl"
    log.write_text("".join(f"{line.data}\n" for line in lines.heard))
    assert (replay(log).steps, replay(log).number) == (39, 1)


def test_a_robot_that_acts_gets_goals_until_it_has_its_task(nodes, tmp_path):
    scenario = Scenario().replace({"acting.start": 3, "acting.reach": 1.0, "units.metres": 2.0})
    file = tmp_path / "acting.toml"
    file.write_text(scenario.to_toml())
    robot = robot_of(nodes, 0, scenario=str(file))
    goals = Listener(nodes, PoseStamped, "/robot_0/goal_pose")
    robot.senses.take_odometry(odometry(0.0, 0.0))
    robot.senses.take_poses("tasks", poses((8.0, 6.0)))
    while not robot.mind.way["go"]:
        robot.tick()
    nodes.until(lambda: goals.heard)
    goal = goals.heard[0].pose.position
    assert (goal.x, goal.y) == pytest.approx((8.0, 6.0), abs=0.02)  # tasks are named by cells
    again = []
    robot.topics["goal_pose"] = SimpleNamespace(publish=again.append)
    robot.tick()
    assert robot.mind.way["go"]
    assert not again
    robot.senses.take_odometry(odometry(goal.x, goal.y))
    robot.tick()
    robot.tick()
    assert robot.mind.way["stand"]


def test_parameters_change_the_decision(nodes):
    robot = robot_of(nodes, 1, decision__strategy="dc", decision__gain=12.5)
    line = json.loads(json.dumps(robot.mind._line))
    assert (line["strategy"], line["settings"]["gain"]) == ("dc", 12.5)
    robot = robot_of(nodes, 2, hz=0.0, set=["units.seconds=0.5", "decision.gain=3"])
    assert (robot.period, robot.mind._line["settings"]["gain"]) == (0.5, 3.0)


def test_the_file_for_a_turtlebot_gives_its_parameters(nodes):
    arguments = ["--ros-args", "--params-file", str(EXAMPLES / "turtlebot4.yaml")]
    robot = nodes.add(Robot(namespace="/robot_4", cli_args=arguments))
    robot.start()
    assert (robot.number, robot.mind.goes is not None, robot.period) == (4, True, 0.2)
    assert {each.topic_name for each in robot.ears} >= {"/robot_4/odom", "/radio", "/robot_4/task_poses"}
    assert robot.topics["said"].topic_name == "/radio"


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"decision__strategy": "nosuch"}, "decision.strategy = 'nosuch': must be the path of a .py file"),
        ({"decision__gain": -1.0}, "decision.gain = -1.0: must be > 0"),
        ({"detections": "lidar"}, "detections = lidar: must be poses or objects"),
        ({"number": 20}, "must be below robots.count, 20"),
        ({"scenario": "nosuch.toml"}, "nosuch.toml: can't be read"),
    ],
)
def test_wrong_parameters_are_named_and_end_the_robot(nodes, parameters, problem):
    robot = robot_of(nodes, **parameters)
    assert (robot.status, robot.has_ended, robot.mind) == (2, True, None)
    assert problem in robot.problem


def test_a_robot_without_a_number_says_what_to_do(nodes):
    robot = nodes.add(Robot(namespace="/alice"))
    robot.start()
    assert "id: namespace /alice ends with no number; set id" in robot.problem


def test_a_robot_lives_through_its_states_and_begins_anew(nodes):
    robot = robot_of(nodes, 0, autostart=False)
    assert robot.mind is None
    robot.trigger_configure()
    robot.trigger_activate()
    robot.tick()
    robot.tick()
    robot.trigger_deactivate()
    assert (robot.step, robot._clocks) == (2, [])
    robot.trigger_cleanup()
    assert robot.mind is None
    robot.set_parameters([Parameter("decision.strategy", value="voter")])
    robot.trigger_configure()
    assert (robot.step, robot.mind._line["strategy"]) == (0, "voter")
    robot.trigger_shutdown()
    assert (robot.mind, robot.has_ended) == (None, True)


def test_a_silent_sense_is_reported_and_its_last_detections_dont_count_any_more(nodes):
    robot = robot_of(nodes, 0, stale=3600.0)
    diagnostics = Listener(nodes, DiagnosticArray, "/diagnostics")
    robot.senses.take_poses("robots", poses((1.0, 1.0)))
    robot.senses.take_poses("tasks", poses((1.0, 1.0)))
    robot.tick()
    robot.diagnose()
    robot._sensed_at["tasks"] -= 4000.0
    robot.tick()
    robot.diagnose()
    nodes.until(lambda: len(diagnostics.heard) == 2)
    fine, warned = (message.status[0] for message in diagnostics.heard)
    assert (fine.level, warned.level) == (DiagnosticStatus.OK, DiagnosticStatus.WARN)
    assert warned.message == "silent: tasks for 4000 s; check the topics"
    assert [each[0] for each in robot.senses.sensed(None, [])["see"]] == [1]
    assert diagnostics.heard[0].header.stamp != Time()
