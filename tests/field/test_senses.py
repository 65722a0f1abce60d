"""A real robot, a process without a world: its driver writes what it senses to a pipe, over UDP or zenoh."""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from commands import refused_in_a_line

from feasibee import Scenario
from feasibee.field.links import open_link
from feasibee.field.replay import replay

DRIVER = Path(__file__).parents[2] / "examples" / "driver.py"
SENSED = [
    {"robots": 1, "tasks": 2},
    {"robots": -1},
    {"robots": 1, "heard": [[2, "x"], [1, "x"], 5]},
    {"tasks": 1},
]
LIMIT = 60.0
"""Seconds in which a robot must have started, or have answered."""


@contextmanager
def a_robot(source, *options):
    """Start a robot; kill it at the end if it still runs."""
    command = [sys.executable, "-m", "feasibee", "robot", "--id", "1", "--senses", source, *options]
    robot = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield robot
    finally:
        robot.kill()
        robot.communicate()


@contextmanager
def a_publisher(port, key="robot/1"):
    """Give a publisher of zenoh that a robot at this port listens to."""
    zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh isn't installed")
    from feasibee.field.zenoh_link import open_session

    until = time.monotonic() + LIMIT
    with open_session(f"127.0.0.1:{port}", listens=False) as session:
        # By default zenoh drops what a busy receiver doesn't take at once, such as the end.
        publisher = session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK)
        while not publisher.matching_status.matching:
            assert time.monotonic() < until
            time.sleep(0.02)
        yield publisher


def free_port(kind):
    with closing(socket.socket(socket.AF_INET, kind)) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def answers(robot):
    """Return the steps that a robot has answered, until it ends, and what it said on standard error."""
    said, problems = robot.communicate(timeout=LIMIT)
    assert robot.returncode == 0, problems
    return [json.loads(line) for line in said.splitlines()], problems


def test_a_robot_steps_with_what_is_published_under_its_key(tmp_path):
    port, log = free_port(socket.SOCK_STREAM), tmp_path / "robot-1.jsonl"
    with a_robot(f"zenoh:127.0.0.1:{port}/robot/1", "--out", log) as robot, a_publisher(port) as publisher:
        for each in SENSED:
            publisher.put(json.dumps(each))
        publisher.put(b"x" * 1_000_000)
        publisher.put('{"end": true}')
        steps, problems = answers(robot)
    assert [each["step"] for each in steps] == [1, 2, 3]
    assert sorted(problems.splitlines()) == [
        "feasibee: dropped, invalid object: 2",
        "feasibee: dropped, malformed message: 2",
    ]
    seen = [json.loads(line)["see"] for line in log.read_text().splitlines()[1:]]
    assert [[each[0] for each in step] for step in seen] == [[1, 0, 0], [1], [0]]
    assert replay(log).steps == 3


@pytest.mark.skipif(sys.platform == "win32", reason="a process can't be sent Ctrl-C")
def test_ctrl_c_ends_a_robot_that_waits_for_zenoh():
    port = free_port(socket.SOCK_STREAM)
    with a_robot(f"zenoh:127.0.0.1:{port}/robot/1") as robot, a_publisher(port):
        robot.send_signal(signal.SIGINT)
        assert answers(robot) == ([], "")


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_a_robot_over_zenoh_listens_at_its_address_only():
    port = free_port(socket.SOCK_STREAM)
    with a_robot(f"zenoh:127.0.0.1:{port}/robot/1") as robot, a_publisher(port):
        assert listening(robot.pid) == [("tcp", f"0100007F:{port:04X}")]


def listening(process):
    """Return kind and address (in hexadecimal digits) of the sockets at which a process can be reached."""
    links = [str(each.readlink()) for each in Path(f"/proc/{process}/fd").iterdir()]
    mine = {each[8:-1] for each in links if each.startswith("socket:[")}
    found = []
    for kind in ("tcp", "tcp6", "udp", "udp6"):
        for row in Path(f"/proc/{process}/net/{kind}").read_text().splitlines()[1:]:
            _, address, _, state, *_, inode = row.split()[:10]
            if inode in mine and (state == "0A" or kind.startswith("udp")):  # 0A: it listens
                found.append((kind, address))
    return found


def test_a_robot_steps_with_the_datagrams_of_its_driver():
    port = free_port(socket.SOCK_DGRAM)
    with a_robot(f"udp:127.0.0.1:{port}") as robot:
        radio = open_link("udp", "127.0.0.1", port, listens=False)
        until = time.monotonic() + LIMIT
        while not select.select([robot.stdout], [], [], 0.05)[0] and time.monotonic() < until:
            radio.send(json.dumps(SENSED[0]).encode())  # until the robot listens
        radio.send(b'{"robots": -1}')
        radio.send(b'{"end" : true}')
        radio.close()
        steps, problems = answers(robot)
    assert steps[0]["step"] == 1
    assert problems == "feasibee: dropped, invalid object: 1\n"


@pytest.mark.skipif(sys.platform == "win32", reason="has no named pipes of this kind")
def test_a_robot_answers_each_line_of_a_named_pipe_before_the_next_one(tmp_path):
    pipe = tmp_path / "senses"
    os.mkfifo(pipe)
    with a_robot(str(pipe)) as robot:
        with pipe.open("w", buffering=1) as driver:
            for step in (1, 2, 3):
                driver.write(json.dumps({"robots": step}) + "\n")
                assert json.loads(robot.stdout.readline())["step"] == step
        assert answers(robot) == ([], "")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="broadcasts to the loopback interface")
def test_two_drivers_of_the_example_hear_each_other(tmp_path):
    text = DRIVER.read_text()
    changes = {
        "255.255.255.255": "127.255.255.255",
        "STEP, PORT = 0.1, 7401": f"STEP, PORT = 0.02, {free_port(socket.SOCK_DGRAM)}",
        '"/dev/stdin"]': '"/dev/stdin", "--out", f"robot-{number}.jsonl"]',
        '"feasibee",': 'sys.executable, "-m", "feasibee",',
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "driver.py").write_text(text)
    (tmp_path / "mine.toml").write_text(Scenario().to_toml())
    command = [sys.executable, "driver.py"]
    drivers = [subprocess.Popen([*command, number, "mine.toml"], cwd=tmp_path) for number in ("1", "2")]
    try:
        until = time.monotonic() + LIMIT
        while (heard := [senders(tmp_path / f"robot-{number}.jsonl") for number in (1, 2)]) != [{2}, {1}]:
            assert time.monotonic() < until, heard
            time.sleep(0.05)
    finally:
        for driver in drivers:
            driver.kill()
            driver.wait()


def senders(log):
    """Return the numbers of the robots that a robot has heard, by the complete lines of its log."""
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    return {sender for line in lines for sender, _ in json.loads(line).get("heard", [])}


def test_the_drivers_example_has_thirty_lines_at_most():
    assert len(DRIVER.read_text().splitlines()) <= 30


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("zenoh:robot/1", "must be HOST:PORT"),
        ("zenoh:127.0.0.1:7447", "has no key; use HOST:PORT/KEY, such as zenoh:127.0.0.1:7447/robot-3"),
        ("udp:7447", "must be HOST:PORT"),
    ],
)
def test_a_source_without_address_or_key_is_an_error(source, told):
    assert told in refused_in_a_line("robot", "--id", 1, "--senses", source)
