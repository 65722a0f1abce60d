"""A run as a bag of ROS 2: an independent reader finds the poses, opinions, tasks and the map of the run."""

from __future__ import annotations

import sys
from collections import defaultdict
from math import atan2, cos, sin

import numpy as np
import pytest
from commands import invoke, refused_in_a_line
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from PIL.ImageColor import getrgb
from walled import PLACE, bitmap

from feasibee import Scenario, Swarm, reference
from feasibee.figures.bag import DELETE, ROBOTS_LIMIT, START, Bag
from feasibee.model.codes import COLOURS, DECISIONS, TASK

TYPES = {
    "pose": "geometry_msgs/msg/PoseStamped",
    "opinion": "std_msgs/msg/Int8",
    "robots": "visualization_msgs/msg/MarkerArray",
    "tasks": "visualization_msgs/msg/MarkerArray",
    "tf": "tf2_msgs/msg/TFMessage",
    "map": "nav_msgs/msg/OccupancyGrid",
}
PLAIN = Scenario(robots={"count": 6}, tasks={"count": 5}, arena={"side": 12.0}, run={"steps": 40})
CHANGING = PLAIN.replace(
    {"events": [{"step": 5, "robots": -2}, {"step": 8, "robots": 1}, {"step": 9, "tasks": -2}]}
).replace({"tasks.arrival_rate": 0.1, "run.steps": 30})


def written(scenario, path, last=None, seed=1):
    """Write a run as a bag; return its messages as the other reader decodes them, by time and topic."""
    Bag(scenario, path).write(
        Swarm(scenario, seed=seed), scenario.run.steps if last is None else last, lambda share: None
    )
    return read(path)


def read(path):
    found, latest = defaultdict(dict), 0
    with path.open("rb") as file:
        for schema, channel, message, decoded in make_reader(
            file, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            assert schema.name == TYPES[channel.topic.rpartition("/")[2]]
            assert message.log_time >= latest
            latest = message.log_time
            found[message.log_time][channel.topic] = decoded
            stamped = [decoded] if hasattr(decoded, "header") else getattr(decoded, "markers", [])
            for each in stamped:
                assert each.header.frame_id == "map"
                assert each.header.stamp.sec * 10**9 + each.header.stamp.nanosec == message.log_time
    return found


def rgb(colour):
    return pytest.approx([each / 255 for each in getrgb(colour)], abs=1e-6)


def colour_of(marker):
    return [marker.color.r, marker.color.g, marker.color.b]


def at(place):
    return place.x, place.y


@pytest.mark.parametrize(("strategy", "held"), [("dmmd", {0, 1}), ("map", {-1})])
def test_the_bag_of_a_plain_run_has_what_the_reference_computes(strategy, held, tmp_path):
    scenario = PLAIN.replace({"decision.strategy": strategy, "robots.know_count": True})
    steps = written(scenario, tmp_path / "run.mcap")
    assert list(steps) == [START + 10**8 * step for step in range(41)]
    assert {
        each.data for step in steps.values() for topic, each in step.items() if "opinion" in topic
    } == held
    for messages, swarm in zip(steps.values(), reference.play(scenario, 1, 0), strict=True):
        unit = float(swarm.world.unit)
        shown = {marker.id: marker for marker in messages["/robots"].markers}
        frames = {each.child_frame_id: each for each in messages["/tf"].transforms}
        assert len(swarm.robots) == len(shown) == len(frames) == 6
        for robot in swarm.robots:
            name, marker = f"robot_{robot.number}", shown[robot.number]
            pose, opinion = messages[f"/{name}/pose"].pose, messages[f"/{name}/opinion"].data
            half = atan2(*robot.velocity[::-1]) / 2
            assert at(pose.position) == tuple(each * unit for each in robot.place)
            assert (pose.orientation.w, pose.orientation.z) == pytest.approx((cos(half), sin(half)))
            assert opinion == robot.mind.opinion
            assert at(marker.pose.position) == at(frames[name].transform.translation) == at(pose.position)
            assert colour_of(marker) == rgb(COLOURS[DECISIONS[opinion]])
        tasks = {marker.id: at(marker.pose.position) for marker in messages["/tasks"].markers}
        assert tasks == {i: tuple(each * unit for each in place) for i, place in swarm.tasks.items()}


def test_viewers_can_show_each_marker(tmp_path):
    """RViz shows nothing without opacity or size, and warns of a rotation that is none."""
    for messages in written(CHANGING, tmp_path / "run.mcap").values():
        for marker in (*messages["/robots"].markers, *messages["/tasks"].markers):
            turn = marker.pose.orientation
            assert turn.w**2 + turn.z**2 == pytest.approx(1)
            if marker.action != DELETE:
                assert min(marker.scale.x, marker.scale.y, marker.scale.z, marker.color.a) > 0


def test_a_viewer_shows_who_is_there_whenever_it_starts(tmp_path):
    steps, swarm = written(CHANGING, tmp_path / "run.mcap"), Swarm(CHANGING, seed=1)
    since, there = {"/robots": set(), "/tasks": set()}, set()
    for messages in steps.values():
        truly = {
            "/robots": set(np.flatnonzero(swarm.present).tolist()),
            "/tasks": set(swarm.task_numbers.tolist()),
        }
        for topic, shown in since.items():
            now = {marker.id for marker in messages[topic].markers if marker.action != DELETE}
            shown.update(now)
            shown.difference_update(each.id for each in messages[topic].markers if each.action == DELETE)
            assert shown == now == truly[topic]
        assert {topic for topic in messages if "pose" in topic} == {
            f"/robot_{robot}/pose" for robot in truly["/robots"]
        }
        there.add(tuple(map(len, truly.values())))
        swarm.advance(1)
    assert len(there) > 3


def test_the_map_is_the_place_and_late_viewers_get_it(tmp_path):
    closed = np.zeros((4, 6), bool)
    closed[0, 5] = True
    placed = PLACE.replace({"units.metres": 0.5, "units.seconds": 2.0})
    mapped = Scenario(place={"map": {**bitmap(closed, 2.0), "origin": [-3.0, 7.0]}}, run={"steps": 1})
    steps = written(placed, tmp_path / "placed.mcap", 1)
    assert list(steps) == [START, START + 2 * 10**9]
    first, second = steps.values()
    grid = first["/map"]
    assert "/map" not in second
    assert (grid.info.resolution, grid.info.width, grid.info.height) == (0.25, 40, 20)
    cells = np.array(grid.data).reshape(20, 40)
    np.testing.assert_array_equal(cells == 100, placed.plan.walls)
    np.testing.assert_array_equal(cells == 50, placed.plan.keepout)
    assert cells[6, 20] == 100  # the wall at x = 10 and y = 3, in units
    assert at(first["/robot_1/pose"].pose.position) == pytest.approx((3.0, 4.0))
    with (tmp_path / "placed.mcap").open("rb") as file:
        channels = {each.topic: each for each in make_reader(file).get_summary().channels.values()}
    assert "durability: transient_local" in channels["/map"].metadata["offered_qos_profiles"]
    (first, _) = written(mapped, tmp_path / "mapped.mcap").values()
    assert at(first["/map"].info.origin.position) == (-3.0, 7.0)
    assert np.array(first["/map"].data).reshape(4, 6)[0, 5] == 100
    corner = np.array([-3.0, 7.0])
    assert at(first["/robot_0/pose"].pose.position) == pytest.approx(
        Swarm(mapped, seed=1).positions[0] + corner
    )


def test_taken_tasks_are_opaque_and_free_ones_are_not(tmp_path):
    acts = Scenario(
        robots={"placement": "points", "points": ((4.0, 8.0), (19.5, 15.0)), "speed": 0.1},
        tasks={"placement": "points", "points": ((4.0, 8.9), (1.1, 15.0))},
        acting={"start": 0},
        run={"steps": 2},
    )
    *_, last = written(acts, tmp_path / "run.mcap").values()
    assert [round(marker.color.a, 3) for marker in last["/tasks"].markers] == [1.0, 0.3]
    assert colour_of(last["/tasks"].markers[0]) == rgb(TASK)


def test_the_command_writes_the_first_run_up_to_its_end(tmp_path):
    path = tmp_path / "run.mcap"
    stops = ("--set", "run.stop_at_decision=true", "--set", "tasks.count=10")
    invoke("run", *stops, "--runs", "2", "--seed", "3", "--run", "5", "--out", path)
    swarm = Swarm(Scenario(tasks={"count": 10}), seed=3, run=5)
    swarm.advance(300)
    decision, step = swarm.first_decision
    assert decision >= 0
    steps = read(path)
    assert len(steps) == step + 1
    again = Swarm(Scenario(tasks={"count": 10}), seed=3, run=5)
    again.advance(step)
    last = list(steps.values())[-1]
    assert [last[f"/robot_{robot}/opinion"].data for robot in range(20)] == again.opinions.tolist()
    assert [each.name for each in tmp_path.iterdir()] == ["run.mcap"]


def test_the_same_run_gives_the_same_bytes_and_an_interrupted_one_leaves_the_old_file(tmp_path):
    path = tmp_path / "run.mcap"
    written(PLAIN, path)
    before = path.read_bytes()
    written(PLAIN, path)
    assert path.read_bytes() == before

    def interrupt(share):
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Bag(PLAIN, path).write(Swarm(PLAIN, seed=2), 40, interrupt)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_what_can_not_be_a_bag_is_told_before_the_runs(tmp_path, monkeypatch):
    many = ("run", "--runs", "1000000", "--out", tmp_path / "run.mcap")
    crowd = ("--set", f"robots.count={ROBOTS_LIMIT + 1}", "--set", "arena.side=400")
    assert "at most 1,000 robots" in refused_in_a_line(*many, *crowd)
    assert "31 bits" in refused_in_a_line(*many, "--set", "units.seconds=1e9")
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    assert 'pip install ".[bag]"' in refused_in_a_line(*many)
