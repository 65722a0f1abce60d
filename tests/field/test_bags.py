"""A bag with the logs of robots replays as their files do; a damaged one is an error in one line."""

from __future__ import annotations

import json
import os
import random
import sqlite3
import sys
from contextlib import closing

import pytest
from bags import STRING, write_bag
from commands import invoke, refused_in_a_line
from fields import a_plan, small
from nets import play
from test_edited_logs import bounded

from feasibee import Swarm
from feasibee.errors import FeasibeeError
from feasibee.field.bags import files_of, logs_in
from feasibee.field.recording import Recording
from feasibee.field.replay import replay
from feasibee.figures.bag import Bag

STORAGES = ("mcap", "sqlite3")


def replay_bag(path):
    """Replay the logs of a bag, as the command does."""
    return {topic: replay(topic, None, lines) for topic, lines in logs_in(path).items()}


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """The logs of the robots of a small field of 60 steps, by topic."""
    folder = tmp_path_factory.mktemp("played")
    play(a_plan(small(steps=60, **{"decision.strategy": "voter", "run.stop_at_decision": False})), folder)
    return {f"/{path.stem.replace('-', '_')}/log": path for path in sorted(folder.glob("robot-*.jsonl"))}


@pytest.fixture(scope="module")
def topics(logs):
    """The lines of each log."""
    return {topic: path.read_text().splitlines() for topic, path in logs.items()}


@pytest.mark.parametrize("storage", STORAGES)
def test_a_bag_replays_as_the_files_do_from_its_folder_or_its_file(storage, logs, topics, tmp_path):
    bag = write_bag(tmp_path / "bag", topics, storage)
    (file,) = files_of(bag)
    assert replay_bag(bag) == replay_bag(file) == {topic: replay(path) for topic, path in logs.items()}


def test_the_command_replays_a_bag_and_names_the_topics(topics, tmp_path):
    bag = write_bag(tmp_path / "bag", topics)
    assert "Robot 3: 60 steps" in invoke("replay", bag).stdout
    found = json.loads(invoke("replay", bag, "--json").stdout)
    assert [each["log"] for each in found] == [f"{bag}: {topic}" for topic in topics]


def test_a_recording_of_a_field_gives_the_bag_of_its_run(tmp_path):
    scenario = small(steps=20, **{"run.stop_at_decision": False})
    play(a_plan(scenario), tmp_path)
    bags = []
    for name, source in {"field": Recording(tmp_path), "run": Swarm(scenario, seed=1)}.items():
        path = tmp_path / f"{name}.mcap"
        Bag(scenario, path).write(source, 20, lambda share: None)
        bags.append(path.read_bytes())
    assert bags[0] == bags[1]


def test_a_changed_or_missing_message_is_named_with_its_topic(topics, tmp_path):
    lines = topics["/robot_1/log"]
    at = next(i for i, line in enumerate(lines) if i > 4 and not json.loads(line)["draws"])
    changed = {**json.loads(lines[at]), "status": [1, -1, True, 9999, 1, None]}
    bags = {
        "changed": [*lines[:at], json.dumps(changed), *lines[at + 1 :]],
        "damaged": [*lines[:at], lines[at][:-9]],
        "missing": [*lines[:at], *lines[at + 1 :]],
    }
    for name, each in bags.items():
        told = refused_in_a_line("replay", write_bag(tmp_path / name, {"/robot_1/log": each}))
        assert f"{name}: /robot_1/log: line {at + 1}: " in told
    late = write_bag(tmp_path / "late", {"/robot_1/log": lines[1:]})
    assert "/robot_1/log: doesn't begin as the log of a robot" in refused_in_a_line("replay", late)


def test_a_bag_without_logs_is_refused_with_what_it_lacks(topics, tmp_path):
    for name, bag in {
        "no": write_bag(tmp_path / "no", {"/robot_1/logs": ["a"]}),
        "type": write_bag(tmp_path / "type", {"/robot_1/log": [1]}, kind="std_msgs/msg/Int8"),
        "empty": write_bag(tmp_path / "empty", {"/robot_1/log": [], "/a": ["b"]}),
    }.items():
        assert f"{name}: has no {STRING} on a topic that ends with /log" in refused_in_a_line("replay", bag)


@pytest.mark.skipif(sys.platform == "win32", reason="no pipes there")
def test_a_pipe_is_never_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe.mcap")
    assert "it isn't a plain file" in refused_in_a_line("replay", tmp_path / "pipe.mcap")


def test_a_missing_file_and_a_missing_package_are_told(topics, tmp_path, monkeypatch):
    assert "can't be read" in refused_in_a_line("replay", tmp_path / "none.mcap")
    bag = write_bag(tmp_path / "bag", topics)
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    assert 'pip install ".[bag]"' in refused_in_a_line("replay", bag)


def test_nothing_of_a_bag_is_run_neither_its_types_nor_its_strategy(topics, tmp_path):
    """rosbags makes code of the definitions of types that a bag holds, if it is asked to."""
    lines = topics["/robot_1/log"]
    bomb = tmp_path / "bomb.py"
    bomb.write_text("raise SystemExit('ran')")
    named = json.dumps({**json.loads(lines[0]), "strategy": str(bomb)})
    bag = write_bag(tmp_path / "strategy", {"/robot_1/log": [named, *lines[1:]]})
    assert "give --strategy FILE" in refused_in_a_line("replay", bag)
    bag = write_bag(tmp_path / "types", {"/robot_1/log": lines})
    (file,) = bag.glob("*.mcap")
    data = file.read_bytes()
    assert data.count(b"string data") == 2
    file.write_bytes(data.replace(b"string data", b"int8 data()"))
    assert replay_bag(file)["/robot_1/log"].steps == 60


def test_no_query_of_a_bag_is_run(topics, tmp_path):
    """A view can compute for ever, and rosbags reads from one where it expects a table."""
    bag = write_bag(tmp_path / "bag", topics, "sqlite3")
    with closing(sqlite3.connect(next(bag.glob("*.db3")))) as base:
        base.execute("DROP TABLE schema")
        endless = "WITH RECURSIVE n(schema_version) AS (SELECT 1 UNION ALL SELECT schema_version + 1 FROM n)"
        base.execute(f"CREATE VIEW schema AS {endless} SELECT max(schema_version) AS schema_version FROM n")
        base.commit()
    assert "it has views or triggers" in refused_in_a_line("replay", bag)


def damaged(generator, data):
    """Return bytes that are cut off, or of which some are changed."""
    if generator.randrange(4) == 0:
        return data[: generator.randrange(len(data))]
    found = bytearray(data)
    for _ in range(generator.choice((1, 3, 30))):
        at = generator.randrange(len(found))
        near_an_end = generator.choice((at, at % 400, -1 - at % 2_000))
        found[near_an_end] ^= 1 << generator.randrange(8)
    return bytes(found)


@pytest.mark.parametrize("edits", [60, pytest.param(2_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("what", [".mcap", ".db3"])
def test_a_damaged_bag_is_replayed_or_refused_in_a_line(what, edits, topics, tmp_path):
    few = {topic: lines[:8] for topic, lines in list(topics.items())[:2]}
    bag = write_bag(tmp_path / "bag", few, "sqlite3" if what == ".db3" else "mcap")
    (file,) = bag.glob(f"*{what}")
    data, generator, refused = file.read_bytes(), random.Random(1), 0
    for edit in range(edits):
        file.write_bytes(damaged(generator, data))
        try:
            with bounded():
                replay_bag(file)
        except FeasibeeError as error:
            refused += str(error).isprintable()
        except BaseException as error:
            raise AssertionError(f"edit {edit}") from error
    assert refused > edits // 4
