"""The live page of a field: its steps come from the log of its world, while it is written and later."""

from __future__ import annotations

import json
import re
import threading
import time
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from commands import invoke
from serving import Page, decode, serving_at

from feasibee import Scenario
from feasibee.errors import FeasibeeError
from feasibee.field.plan import Plan, parse_fault, schedule
from feasibee.field.supervisor import Field
from feasibee.live import fieldsession, server
from feasibee.live.fieldsession import FieldCatalogue, FieldSession
from feasibee.live.messages import NO_TASK, Look, encode_frame
from feasibee.live.scene import Logged
from feasibee.reference import play
from feasibee.simulation.snapshot import FLAGS

LONG = 20_000
"""Steps of a field that goes on until its test ends."""
LIMIT = 60.0
"""Seconds that a busy machine may take."""


def small(steps):
    arena = {"arena.side": 8.0, "robots.count": 4, "tasks.count": 4}
    return Scenario().replace({**arena, "run.steps": steps, "run.stop_at_decision": False})


def a_plan(scenario, lockstep=False, hz=20.0, faults=(), seed=1):
    """Return a plan; a robot is silent after 3 s: one that only waits for a busy machine is not."""
    patience = 20.0 if lockstep else 3.0
    return Plan(scenario, seed, 0, lockstep, hz, 0.0, 0.0, 0.0, tuple(faults), patience, LIMIT)


def kills(text, steps, hz=20.0):
    return schedule([parse_fault("kill", text, hz)], 4, steps)


class LeftError(Exception):
    """The test needs its field no longer."""


@contextmanager
def running(plan, folder):
    """Run a field in a thread, until its end or that of the test; give the thread once there is a step."""
    left, began = threading.Event(), threading.Event()

    def run():
        with suppress(LeftError):
            Field(plan, folder, told).run()

    def told(event):
        if left.is_set():
            raise LeftError
        if event["event"] == "step":
            began.set()

    folder.mkdir(exist_ok=True)
    thread = threading.Thread(target=run)
    thread.start()
    try:
        assert began.wait(LIMIT)
        yield thread
    finally:
        left.set()
        thread.join(LIMIT)
    assert not thread.is_alive()


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """The folder of a field in lockstep that has ended, and its scenario."""
    folder, scenario = tmp_path_factory.mktemp("ended"), small(60).replace({"acting.start": 5})
    Field(a_plan(scenario, lockstep=True), folder, lambda event: None).run()
    return folder, scenario


def test_the_steps_of_a_field_in_lockstep_are_those_of_the_run(ended):
    folder, scenario = ended
    field = Logged(folder)
    assert field.last == 60
    for step, swarm in enumerate(play(scenario, 1, 0)):
        field.step = step
        shown = decode(encode_frame(field, 0, 0))
        held = {name: shown["flags"] >> bit & 1 for bit, name in enumerate(FLAGS)}
        opinions = [robot.mind.opinion for robot in swarm.robots]
        assert (held["feasible"].astype(int) - held["neutral"]).tolist() == opinions
        assert (shown["feasible"], shown["infeasible"]) == (swarm.feasible_count, swarm.infeasible_count)
        assert shown["truth"] == swarm.truth
        errands = [robot.errand for robot in swarm.robots]
        assert held["standing"].tolist() == [each.task >= 0 for each in errands]
        aims = [max(each.target, each.task) for each in errands]
        assert np.where(shown["aims"] == NO_TASK, -1, shown["aims"].astype(int)).tolist() == aims
        assert shown["taken"].tolist() == [any(each.task == task for each in errands) for task in range(4)]
    assert held["standing"].any()
    session = FieldSession(folder)
    session.begin(None)
    session.rewind(60, 0)
    session.inspect(robot := int(np.flatnonzero(held["standing"])[0]))
    said = next(each for each in session.messages() if isinstance(each, dict) and each["type"] == "robot")
    assert ["Acts", f"stands at task {errands[robot].task}"] in said["reasons"]


def test_a_log_that_grows_is_that_of_the_whole_file(ended, tmp_path):
    lines = (ended[0] / "world.jsonl").read_text().splitlines(keepends=True)
    growing, copy = tmp_path / "world.jsonl", None
    for until in (1, 2, 30, len(lines)):
        # A world may be in the middle of a line.
        growing.write_text("".join(lines[:until]) + ("" if until == len(lines) else lines[until][:9]))
        copy = copy or Logged(tmp_path)
        assert copy.grow()
        assert copy.last == min(until, len(lines) - 1) - 2
    whole = Logged(ended[0])
    whole.step = copy.step = whole.last
    assert copy.has_ended
    assert encode_frame(copy, 0, 0) == encode_frame(whole, 0, 0)
    growing.write_text(lines[0].replace("session", "another") + lines[1])
    assert not copy.grow()


def test_a_page_goes_on_with_the_next_field_in_its_folder(tmp_path):
    with (
        running(a_plan(small(10), lockstep=True), tmp_path) as first,
        serving_at(FieldCatalogue(tmp_path)) as port,
        Page(port) as page,
    ):
        page.say(type="open")
        assert followed(page, "field", lambda message: message["end"] == 10)
        first.join(LIMIT)  # it holds the folder
        with running(a_plan(small(LONG), seed=2), tmp_path):
            assert followed(page, "another", lambda message: True)
            page.say(type="open")
            assert followed(page, "opened", lambda message: message["seed"] == "2")
            assert followed(page, "frame", lambda message: message["step"] > 0)


def followed(page, kind, is_it):
    """Follow a field until the server says something; return whether it does in time."""
    until = time.monotonic() + LIMIT
    while time.monotonic() < until:
        message = page.receive()
        if message["type"] == kind and is_it(message):
            return True
        if message["type"] == "frame":
            page.say(type="advance", steps=1)
    return False


def test_the_command_watches_a_field(ended, monkeypatch):
    served = []

    class Server:
        def __init__(self, catalogue, host):
            served.append(catalogue)

        def run(self, sockets):
            """Serve no page."""

    monkeypatch.setattr(server, "server_of", Server)
    assert invoke("watch", ended[0], "--port", 0, "--no-open").exit_code == 0
    assert served[0].to_dict()["title"] == f"field in {ended[0]}"
    assert "can't change" in invoke("watch", ended[0], "--seed", 1).stderr


def test_robots_and_tasks_of_a_field_come_and_go(tmp_path):
    events = [{"step": 10, "tasks": 3, "robots": 2}, {"step": 20, "tasks": -5, "robots": -1}]
    scenario = small(30).replace({"events": events})
    Field(a_plan(scenario, lockstep=True), tmp_path, lambda event: None).run()
    session = FieldSession(tmp_path)
    session.begin(None)
    session.inspect(5)
    assert {each["type"] for each in session.messages() if isinstance(each, dict)} >= {"field", "robot"}
    assert session.openings()[0]["numbers"] == 6
    field, there = Logged(tmp_path), FLAGS.index("there")
    for step, swarm in enumerate(play(scenario, 1, 0)):
        field.step = step
        shown = decode(encode_frame(field, 0, 0))
        numbers = np.flatnonzero(shown["flags"] >> there & 1).tolist()
        found = numbers, shown["taskX"].size, shown["truth"]
        assert found == ([robot.number for robot in swarm.robots], len(swarm.tasks), swarm.truth)


def test_a_session_says_what_it_cannot_do_and_what_robots_reported(ended):
    session = FieldSession(ended[0])
    session.begin(None)
    assert "what has happened" in session.look(Look(type="look"), 0.0)["problem"]
    with pytest.raises(FeasibeeError, match="robot = 4"):
        session.inspect(4)
    session.inspect(2)
    said = next(each for each in session.messages() if isinstance(each, dict) and each["type"] == "robot")
    assert [name for name, _ in said["reasons"]] == ["Phase", "Opinion", "Knows"]
    with pytest.raises(FeasibeeError, match="what has happened"):
        session.lane(0)


def test_a_field_that_goes_away_is_said(ended, tmp_path, monkeypatch):
    lines = (ended[0] / "world.jsonl").read_text().splitlines(keepends=True)
    assert json.loads(lines[-1]) == {"event": "end"}
    (tmp_path / "world.jsonl").write_text("".join(lines[:1]))
    monkeypatch.setattr(fieldsession, "SILENCE", -1.0)
    with pytest.raises(FeasibeeError, match="no step for"):
        FieldSession(tmp_path).begin(None)
    (tmp_path / "world.jsonl").write_text("".join(lines[:-1]))
    session = FieldSession(tmp_path)
    session.begin(None)
    [state, _] = session.messages()
    assert state["silent"]
    assert str(tmp_path) in state["problems"][-1]


@pytest.mark.slow
def test_the_page_shows_a_field_to_its_end(visit, tmp_path):
    expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
    with (
        running(a_plan(small(120), faults=kills("1@5", 120)), tmp_path) as first,
        serving_at(FieldCatalogue(tmp_path)) as port,
    ):
        page = visit(port)
        expect(page.locator("#controls")).to_be_hidden()
        expect(page.locator("#banner-text")).to_have_text("Robot 3 is silent.")
        expect(page.locator("#retry")).to_be_hidden()
        expect(page.locator("#field-state")).to_have_text("ended at step 120")
        expect(page.locator("#now")).to_have_text("120")
        expect(page.locator("#stopped")).to_have_text("1")
        page.keyboard.press(",")
        expect(page.locator("#now")).to_have_text("119")
        page.keyboard.press("r")
        expect(page.locator("#now")).to_have_text(re.compile(r"^\d{1,2}$"))
        page.keyboard.press("n")  # there is no next run
        expect(page.locator("#field-state")).to_have_text("ended at step 120")
        page.keyboard.press(" ")
        expect(page.locator("#now")).to_have_text("120")
        first.join(LIMIT)
        with running(a_plan(small(LONG), seed=2), tmp_path):
            expect(page.locator("#field-which")).to_have_text("2, 0", timeout=60_000)
            expect(page.locator("#banner")).to_be_hidden()
            expect(page.locator("#field-state")).to_have_text("running")
            expect(page.locator("#last")).to_have_text(f"{LONG:,}")
            expect(page.locator("#now")).not_to_have_text("0", timeout=60_000)


def test_watch_of_a_missing_path_names_scenario_and_folder(tmp_path):
    told = invoke("watch", tmp_path / "none", "--no-open").stderr
    assert told.endswith("none: not found; name a scenario in TOML, or the folder of a sweep or field\n")
