"""Whatever is edited in a log, reading it gives an answer or an error, with bounded time and memory."""

from __future__ import annotations

import copy
import json
import random
import signal
import sys
import tracemalloc
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path

import pytest
from fields import STREAMS, a_plan, small
from nets import play

from feasibee import Scenario
from feasibee.errors import FeasibeeError
from feasibee.field.recording import Recording
from feasibee.field.replay import _Declare, _Setting, _Settings, replay
from feasibee.reference.mind import Settings
from feasibee.robot import Declare
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Setting

FEW, MANY = 40, 400
"""Edits of each robot's log; the many are slow."""
SECONDS = 30
"""Time of the processor that reading one log may take; usually it takes some milliseconds."""
MEMORY = 768 * 2**20
"""Bytes that reading any log may take in addition."""
COLLUDING = {"faults.byzantine": 0.25, "faults.byzantine_says": "colluding"}
CLASSES = {
    "robots.classes": [
        {"name": "a", "count": 2, "skills": ["x"]},
        {"name": "b", "count": 2, "skills": ["y"]},
    ],
    "tasks.classes": [{"name": "c", "count": 3, "needs": {"x": 1, "y": 1}}],
}
RULE = {"decision.declare": {"quorum": 0.75, "rounds": 2, "heard": 1}, "decision.inbox_size": 3}
KNOWING = {"robots.know_count": True}
WORLDS = {
    **{name: {"decision.strategy": name, **KNOWING} for name in STRATEGIES},
    "declaring by votes": RULE,
    "classes": CLASSES,
    "liars": {"decision.strategy": "census", **COLLUDING},
    "liars with a roster": {"decision.strategy": "roster", **KNOWING, **COLLUDING},
    "random ids": {"decision.strategy": "census", "radio.id_bits": 3},
    "streams": {"decision.strategy": "roster", **KNOWING, **STREAMS},
}
VALUES = (
    *(None, True, False, 0, 1, -1, 2, 3.5, -0.0, 17, 2**16, 2**31 - 1, 2**32, 2**53, 2**63, 10**30, -(2**31)),
    *(1e-320, 1e308, -1e308, float("nan"), float("inf"), float("-inf")),
    *("", "x", "00", "1/0", "1e999999999", "9" * 400, "dmmd", "roster", "\u202e"),
    *([], [[]], {}, [1, 2], {"": 0}),
)


class HangError(BaseException):
    """Reading a log takes too long; no library catches this."""


def logs_of(scenario, folder, steps=12):
    """Return the lines of a field's logs, by the names of the files."""
    changes = {"arena.side": 8.0, "run.steps": steps, "run.stop_at_decision": False}
    play(a_plan(scenario.replace(changes)), folder)
    return {log.name: log.read_text().splitlines() for log in sorted(folder.glob("*.jsonl"))}


def places(value, path=()):
    """Yield the path of each value within a JSON value."""
    yield path
    if isinstance(value, dict | list):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            yield from places(each, (*path, key))


def edited_value(generator, line):
    """Return a line with one value deleted, replaced, repeated or changed a little."""
    line = copy.deepcopy(line)
    *path, last = generator.choice([each for each in places(line) if each])
    within = line
    for key in path:
        within = within[key]
    old = within[last]
    how = generator.randrange(5)
    if how == 0:
        del within[last]
    elif how == 1 and isinstance(old, list):
        within[last] = old * generator.choice((2, 1000))
    elif how <= 2 and isinstance(old, int | float) and not isinstance(old, bool):
        within[last] = generator.choice((old + 1, old - 1, -old, old * 1000, float(old), str(old)))
    else:
        within[last] = generator.choice(VALUES)
    return json.dumps(line)


def edited_text(generator, text):
    """Return a line as bytes that may be no JSON, no UTF-8, too deep, or have a key twice."""
    data = text.encode()
    at = generator.randrange(len(data))
    return generator.choice(
        (
            data[:at],
            data[:at] + bytes([generator.randrange(256)]) + data[at + 1 :],
            data[:at] + b"\xff\xfe" + data[at:],
            data[:at] + b"\n" + data[at:],
            b'{"step":1,' + data[1:],
            data[:-1] + b',"settings":{},"heard":[]}',
            b'{"see":' + b"[" * 100_000,
            b'{"see":' + b"[" * 500 + b"]" * 500 + b"," + data[1:],
            b"",
            data + b"\n" + data,
            b"null",
        )
    )


def edited(generator, lines):
    """Return a log with one edit, half of the times in its head."""
    lines = list(lines)
    at = generator.choice((0, generator.randrange(len(lines))))
    if generator.randrange(4):
        lines[at] = edited_value(generator, json.loads(lines[at])).encode()
    else:
        lines[at] = edited_text(generator, lines[at])
    texts = [each if isinstance(each, bytes) else each.encode() for each in lines]
    return b"\n".join(texts) + b"\n" * generator.randrange(2)


@contextmanager
def bounded():
    """Bound time and memory; more of them is an error that nothing catches."""
    if sys.platform != "linux":
        yield
        return
    import resource

    def stop(*signalled):
        raise HangError

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    handler = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, handler)


def refusals(read, path, lines, seed, edits):
    """Read a log with each of some edits; return how many were refused, and see that each gives an answer."""
    generator, found = random.Random(seed), 0
    for edit in range(edits):
        data = edited(generator, lines)
        path.write_bytes(data)
        try:
            with bounded():
                read(path)
        except FeasibeeError as error:
            found += str(error).isprintable()
        except BaseException as error:
            raise AssertionError(f"edit {edit}: {data[:3000]!r}") from error
    return found


@pytest.mark.quick(6)
@pytest.mark.parametrize("edits", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", WORLDS)
def test_an_edited_log_of_a_robot_is_replayed_or_refused_in_a_line(name, edits, tmp_path):
    base = Scenario() if name == "classes" else small()
    logs = logs_of(base.replace(WORLDS[name]), tmp_path)
    del logs["world.jsonl"]
    for log, lines in logs.items():
        assert replay(tmp_path / log).steps == len(lines) - 1
    path = tmp_path / "robot-3.jsonl"
    assert refusals(replay, path, logs[path.name], sorted(WORLDS).index(name), edits) > edits // 4


@pytest.mark.parametrize("edits", [150, pytest.param(3_000, marks=pytest.mark.slow)])
def test_an_edited_log_of_a_world_is_shown_or_refused_in_a_line(edits, tmp_path):
    lines = logs_of(small(**WORLDS["liars"]), tmp_path)["world.jsonl"]
    fault = {"event": "fault", "step": 3, "kind": "partition", "count": 0, "robots": [], "lasts": 5.0}
    lines.insert(-1, json.dumps(fault))
    path = tmp_path / "world.jsonl"
    path.write_text("\n".join(lines) + "\n")
    assert Recording(tmp_path).last == 12
    assert refusals(lambda path: shown(Recording(path.parent)), path, lines, 1, edits) > edits // 2


def shown(recording):
    """Look at a recording as who paints it does."""
    for step in range(recording.last + 1):
        for name in ("tasks", "positions", "headings", "opinions", "counted", "lost", "feasible_counts"):
            getattr(recording, name)
        recording.notes_at(step)
        recording.advance()
    recording.step = recording.last


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """The lines of the logs of a short field of liars."""
    return logs_of(small(**WORLDS["liars with a roster"]), tmp_path_factory.mktemp("short"), 2)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("task_ids", 2**31 - 1),
        ("robots", 10**9),
        ("tasks", 10**7),
        ("robot_ids", 2**25),
        ("robot_classes", 10**6),
        ("id_bits", 10**9),
        ("parameters", [1.0] * 100),
        ("width", 1e-300),
        ("sight", 1e6),
    ],
)
def test_no_number_of_a_logs_head_takes_more_memory_than_its_scenario(short, tmp_path, name, value):
    head, *steps = short["robot-0.jsonl"]
    head = json.loads(head)
    head["settings"]["setting"][name] = value
    path = tmp_path / "robot-0.jsonl"
    path.write_text("\n".join([json.dumps(head), *steps]) + "\n")
    refuses_with_little_memory(lambda: replay(path), r"line 1: has no valid settings\.")


def test_a_worlds_log_takes_no_more_memory_than_its_lines(short, tmp_path):
    """The scenario in its head has a million tasks, and its first step four."""
    head, step, *_ = short["world.jsonl"]
    head = json.loads(head) | {"scenario": small(**{"tasks.count": 10**6}).to_toml()}
    (tmp_path / "world.jsonl").write_text(f"{json.dumps(head)}\n{step}\n")
    refuses_with_little_memory(lambda: Recording(tmp_path), "line 2: has no valid tasks")


def refuses_with_little_memory(read, why):
    tracemalloc.start()
    try:
        with pytest.raises(FeasibeeError, match=why):
            read()
        assert tracemalloc.get_traced_memory()[1] < 20 * 2**20
    finally:
        tracemalloc.stop()


def test_all_settings_of_a_mind_are_checked():
    assert set(_Settings.model_fields) == {each.name for each in fields(Settings)}
    for model, kind in {_Setting: Setting, _Declare: Declare}.items():
        assert tuple(model.model_fields) == kind._fields
