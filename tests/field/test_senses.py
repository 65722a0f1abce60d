"""A real robot, a process without a world: its driver writes what it senses to a pipe, or over UDP."""

from __future__ import annotations

import json
import os
import select
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from commands import refused_in_a_line

from feasibee import FeasibeeError, Scenario
from feasibee.field.node import replay
from feasibee.field.senses import _split_address

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
    command = [sys.executable, "-m", "feasibee", "robot", "join", "--id", "1", "--senses", source, *options]
    robot = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield robot
    finally:
        robot.kill()
        robot.communicate()


PORT = 10_000 + os.getpid() % 20_000
"""A port that no system gives to a process that asks for any free one, and no other worker uses."""


def answers(robot):
    """Return the steps that a robot has answered, until it ends, and what it said on standard error."""
    said, problems = robot.communicate(timeout=LIMIT)
    assert robot.returncode == 0, problems
    return [json.loads(line) for line in said.splitlines()], problems


def test_a_robot_steps_with_what_a_pipe_holds(tmp_path):
    senses, log = tmp_path / "senses", tmp_path / "robot-1.jsonl"
    lines = [*map(json.dumps, SENSED), "x" * 1_000_000]
    senses.write_text("".join(f"{each}\n" for each in lines))
    with a_robot(str(senses), "--out", log) as robot:
        steps, problems = answers(robot)
    assert [each["step"] for each in steps] == [1, 2, 3]
    assert "feasibee: dropped, malformed message: 2" in problems.splitlines()
    seen = [json.loads(line)["see"] for line in log.read_text().splitlines()[1:]]
    assert [[each[0] for each in step] for step in seen] == [[1, 0, 0], [1], [0]]
    assert replay(log).steps == 3


def test_a_robot_steps_with_the_datagrams_of_its_driver():
    with a_robot(f"udp:127.0.0.1:{PORT}") as robot:
        radio = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        until = time.monotonic() + LIMIT
        while not select.select([robot.stdout], [], [], 0.05)[0] and time.monotonic() < until:
            radio.sendto(json.dumps(SENSED[0]).encode(), ("127.0.0.1", PORT))  # until the robot listens
        radio.sendto(b'{"robots": -1}', ("127.0.0.1", PORT))
        radio.sendto(b'{"end" : true}', ("127.0.0.1", PORT))
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
        "STEP, PORT = 0.1, 7401": f"STEP, PORT = 0.02, {PORT}",
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


def test_the_acting_driver_goes_to_the_free_task_and_stands_there(tmp_path):
    (tmp_path / "mine.toml").write_text(
        Scenario().replace({"robots.count": 3, "tasks.count": 2, "acting.start": 5}).to_toml()
    )
    text = (DRIVER.parent / "acting_driver.py").read_text()
    changes = {
        '"feasibee",': 'sys.executable, "-m", "feasibee",',
        '/dev/stdin"]': '/dev/stdin", "--out", "robot-0.jsonl"]',
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "driver.py").write_text(text)
    command = [sys.executable, "driver.py", "0", "mine.toml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT, check=True)
    lines = done.stdout.splitlines()
    assert lines[:4] == [f"{step} walks about" for step in (1, 2, 3, 4)]
    x, y = json.loads(lines[4].removeprefix("5 goes to "))
    assert (round(x, 3), round(y, 3)) == (2, 3)
    assert lines[-1].endswith("stands")
    assert replay(tmp_path / "robot-0.jsonl").steps == len(lines)


def test_an_acting_robot_that_loses_its_task_goes_on(tmp_path):
    """Its object says that the task is done; a deed that can't be is dropped."""
    scenario = Scenario().replace(
        {
            "robots.classes": [
                {"name": "a", "count": 1, "skills": ["x", "y"]},
                {"name": "b", "count": 2, "skills": ["x"]},
            ],
            "tasks.classes": [{"name": "t", "count": 2, "needs": {"x": 1}}],
            "acting.start": 0,
        }
    )
    see = {"see": [[0, 0, 0, 0, 3.0, 3.0, 0], [0, 1, 0, 0, 9.0, 9.0, 1]], "place": [3.0, 4.0]}
    objects = [
        see,
        {**see, "acts": [["reached", 0]]},
        {**see, "acts": [["vanished", 0]]},
        {**see, "acts": [["lost", -1]], "taken": [[0, -1]]},
        {**see, "see": see["see"][:1], "acts": [["reached", -1]], "taken": [[0, -1]]},
    ]
    (tmp_path / "mine.toml").write_text(scenario.to_toml())
    (tmp_path / "senses").write_text("".join(f"{json.dumps(each)}\n" for each in objects))
    command = [
        sys.executable,
        "-m",
        "feasibee",
        "robot",
        "join",
        tmp_path / "mine.toml",
        "--id",
        "0",
        "--seed",
        "1",
    ]
    done = subprocess.run(
        [*command, "--senses", tmp_path / "senses"], capture_output=True, text=True, timeout=LIMIT, check=True
    )
    held = [json.loads(line) for line in done.stdout.splitlines()]
    assert [each["stand"] for each in held] == [False, True, False, False]
    assert [each["go"] and round(each["go"][0]) for each in held] == [3, None, 9, None]
    assert "invalid object: 1" in done.stderr


@pytest.mark.parametrize(
    ("number", "source", "rule"),
    [
        (1, "udp:7447", "must be HOST:PORT"),
        (20, "senses", "must be below robots.count, 20"),
    ],
)
def test_a_source_without_address_and_a_number_without_robot_are_errors(number, source, rule):
    assert rule in refused_in_a_line("robot", "join", "--id", number, "--senses", source)


@pytest.mark.parametrize("port", [0, 65_536])
def test_a_port_that_cannot_be_is_an_error(port):
    with pytest.raises(FeasibeeError, match="must be HOST:PORT"):
        _split_address(f"127.0.0.1:{port}")
