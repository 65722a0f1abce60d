"""A robot's log replays to the same decisions; a damaged or changed one is an error that names the line."""

from __future__ import annotations

import json

import pytest
from commands import invoke, refused_in_a_line
from fields import NEEDS_GROUPS, a_plan, change_line, small
from nets import play

from feasibee.base.errors import FeasibeeError
from feasibee.field.node import replay


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """The text of the log of a robot in a small field of 100 steps."""
    folder = tmp_path_factory.mktemp("played")
    scenario = small(steps=100, **{"decision.strategy": "voter", "run.stop_at_decision": False})
    play(a_plan(scenario), folder)
    return (folder / "robot-1.jsonl").read_text()


@pytest.fixture
def log(tmp_path, played):
    """A log to change."""
    path = tmp_path / "robot-1.jsonl"
    path.write_text(played)
    return path


def test_a_log_replays_to_the_same_decisions(log):
    found = replay(log)
    assert (found.number, found.steps, found.cut) == (1, 100, False)
    assert found.decisions > 1


def test_a_log_of_a_killed_robot_replays_without_its_last_line(log):
    log.write_text(log.read_text() + '{"step":101,"pl')
    assert replay(log) == replay(log)._replace(steps=100, cut=True)


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("status", [1, -1, True, 9999, 1, None], "status is .* in the log"),
        ("said", "00", "said is '00' in the log"),
        ("draws", [[1, 2, 3, 4]], "too many draws"),
        ("draws", "none", "can't be read"),
        ("heard", [[2]], "can't be read"),
        ("see", [[1, 2, 3]], "can't be read"),
        ("place", None, "can't be read"),
    ],
)
def test_a_changed_line_is_named(log, name, value, told):
    lines = log.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if i > 4 and not json.loads(line)["draws"])
    change_line(log, at + 1, **{name: value})
    with pytest.raises(FeasibeeError, match=rf"robot-1\.jsonl: line {at + 1}: .*{told}"):
        replay(log)


def test_a_log_never_says_which_file_to_run(log, tmp_path):
    bomb = tmp_path / "bomb.py"
    bomb.write_text("raise SystemExit('ran')")
    change_line(log, 1, strategy=str(bomb))
    with pytest.raises(FeasibeeError, match="give --strategy FILE"):
        replay(log)


def test_the_command_replays_a_folder(log):
    assert "Robot 1: 100 steps" in invoke("robot", "replay", log.parent).stdout
    (found,) = json.loads(invoke("robot", "replay", log, "--json").stdout)
    assert found["steps"] == 100
    log.write_text('{"a": 1}\n')
    assert "isn't the log of a robot" in refused_in_a_line("robot", "replay", log)


def test_a_real_robot_draws_new_numbers_at_each_start_unless_it_has_a_seed(tmp_path):
    senses = tmp_path / "senses"
    senses.write_text('{"robots": 1, "tasks": 2}\n' * 40)

    def first_draws(*options):
        log = tmp_path / "robot-1.jsonl"
        invoke("robot", "join", "--id", "1", "--senses", senses, "--out", log, *options)
        replay(log)
        return json.loads(log.read_text().splitlines()[0])["draws"]

    assert first_draws() != first_draws()
    assert first_draws("--seed", "7") == first_draws("--seed", "7") != first_draws("--seed", "8")
    assert "seed = -1" in refused_in_a_line("robot", "join", "--id", "1", "--senses", senses, "--seed", "-1")
    told = refused_in_a_line("robot", "join", "--id", "1", "--connect", "world.json", "--seed", "1")
    assert "leave out --seed" in told


@NEEDS_GROUPS
def test_a_field_leaves_no_logs_of_an_earlier_one_and_keeps_those_of_robots_that_come_later(tmp_path):
    scenario = tmp_path / "more.toml"
    scenario.write_text("run.steps = 4\nrobots.count = 2\n[[events]]\nstep = 2\nrobots = 1\n")
    logs = tmp_path / "logs"
    logs.mkdir()
    (logs / "robot-3.jsonl").write_text("of an earlier field")
    invoke("robot", "launch", scenario, "--lockstep", "--out", logs)
    robots = [f"robot-{number}.jsonl" for number in range(3)]
    assert sorted(path.name for path in logs.glob("*.jsonl")) == [*robots, "world.jsonl"]
