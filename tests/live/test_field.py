"""The live page of a field: its steps come from real processes."""

from __future__ import annotations

import re
import threading
import time
from contextlib import contextmanager, suppress
from unittest.mock import patch

import numpy as np
import pytest
from commands import invoke
from serving import Page, serving_at

from feasibee import Scenario
from feasibee.errors import FeasibeeError
from feasibee.field.faults import Fault, parse_fault, schedule
from feasibee.field.plan import Plan
from feasibee.field.supervisor import Field, Network
from feasibee.live import fieldsteps, fieldview, server
from feasibee.live.fieldsession import FieldCatalogue, FieldSession
from feasibee.live.fieldview import FieldView
from feasibee.live.messages import Look
from feasibee.reference import play
from feasibee.simulation.snapshot import FLAGS

LONG = 20_000
"""Steps of a field that goes on until its test ends."""


def small(steps):
    arena = {"arena.side": 8.0, "robots.count": 4, "tasks.count": 4}
    return Scenario().replace({**arena, "run.steps": steps, "run.stop_at_decision": False})


def a_plan(scenario, lockstep=False, hz=20.0, faults=(), seed=1):
    """Return a plan; a robot is silent after 3 s: one that only waits for a busy machine is not."""
    patience = 20.0 if lockstep else 3.0
    return Plan(scenario, seed, 0, lockstep, hz, 0.0, 0.0, 0.0, tuple(faults), patience, 60.0)


def kills(text, steps, hz=20.0):
    return schedule(parse_fault("kill", text, hz), 4, steps)


class LeftError(Exception):
    """The test needs its field no longer."""


@contextmanager
def running(plan, network, folder, tell=lambda event: None):
    """Run a field in a thread, until its end or that of the test."""
    left = threading.Event()

    def run():
        with suppress(LeftError):
            Field(plan, network, folder, told).run()

    def told(event):
        if left.is_set():
            raise LeftError
        tell(event)

    folder.mkdir(exist_ok=True)
    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        left.set()
        thread.join(60)
    assert not thread.is_alive()


@contextmanager
def a_field(folder, scenario, key="", **options):
    """Run a field in a thread; give a viewer that has joined it."""
    views, joined = [], threading.Event()

    def tell(event):
        if event["event"] == "listening" and not views:
            view = FieldView(event["address"], key.encode())
            views.append(view)
            threading.Thread(target=lambda: (view.join(), joined.set())).start()

    with (
        patch.object(fieldview, "JOINING", 60.0),
        patch.object(fieldview, "SILENCE", 60.0),
        running(a_plan(scenario, **options), Network(key=key), folder, tell),
    ):
        try:
            assert joined.wait(60)
            yield views[0]
        finally:
            views[0].close()


def wait_for(view, step):
    assert view.wait_for(view.field, step, 60)


def test_the_steps_of_a_field_in_lockstep_are_those_of_the_run(tmp_path):
    scenario = small(60)
    with a_field(tmp_path, scenario, "a key", lockstep=True) as view:
        wait_for(view, 60)
    swarms = {}
    for step, swarm in enumerate(play(scenario, 1, 0)):
        swarms[step] = [robot.mind.opinion for robot in swarm.robots], swarm.feasible_count
    for each in view.field.views:
        opinions, feasible = swarms[each.step]
        held = {name: each.shown.flags >> bit & 1 for bit, name in enumerate(FLAGS)}
        assert (held["feasible"].astype(int) - held["neutral"]).tolist() == opinions
        assert each.counts[0] == feasible
    assert len(view.field.views) > 30


def test_hardly_a_step_is_missed_while_the_world_starts_again(tmp_path):
    faults = [Fault(20, "restart-world")]
    with a_field(tmp_path, small(LONG), "a key", faults=faults) as view:
        wait_for(view, 60)
        steps = [each.step for each in view.field.views]
    missed = set(range(steps[0], steps[-1])) - set(steps)
    assert len(missed) < 5  # loopback loses packets under load; 16 were missed before the world kept views
    assert steps[0] < 20


def test_a_page_goes_on_with_the_next_field_at_its_address(tmp_path):
    with (
        a_field(tmp_path / "first", small(10), "a key", lockstep=True) as view,
        serving_at(FieldCatalogue(view)) as port,
        Page(port) as page,
    ):
        page.say(type="open")
        assert followed(page, "field", lambda message: message["end"] == 10)
        network = Network(port=int(view.address.rpartition(":")[2]), key="a key")
        with running(a_plan(small(LONG), seed=2), network, tmp_path / "second"):
            assert followed(page, "another", lambda message: True)
            page.say(type="open")
            assert followed(page, "opened", lambda message: message["seed"] == "2")
            assert followed(page, "frame", lambda message: message["step"] > 0)


def followed(page, kind, is_it):
    """Follow a field until the server says something; return whether it does within a minute."""
    until = time.monotonic() + 60
    while time.monotonic() < until:
        message = page.receive()
        if message["type"] == kind and is_it(message):
            return True
        if message["type"] == "frame":
            page.say(type="advance", steps=1)
    return False


def test_the_command_watches_a_field(tmp_path, monkeypatch):
    served = []

    class Server:
        def __init__(self, catalogue, host):
            served.append(catalogue)

        def run(self, sockets):
            """Serve no page."""

    monkeypatch.setattr(server, "server_of", Server)
    with a_field(tmp_path, small(40)) as view:
        options = ["--port", 0, "--no-open"]
        assert invoke("watch", "--field", view.address, *options).exit_code == 0
        assert served[0].to_dict()["title"] == f"field at {view.address}"
        wait_for(served[0].view, 1)
        served[0].view.close()


def test_robots_and_tasks_of_a_field_come_and_go(tmp_path):
    events = [{"step": 10, "tasks": 3, "robots": 2}, {"step": 20, "tasks": -5, "robots": -1}]
    scenario = small(30).replace({"events": events})
    with a_field(tmp_path, scenario, lockstep=True) as view:
        wait_for(view, 30)
        session = FieldSession(view)
        session.begin(None)
        session.inspect(5)
        assert {each["type"] for each in session.messages() if isinstance(each, dict)} >= {"field", "robot"}
        assert session.openings()[0]["numbers"] == 6
    numbers = {}
    for step, swarm in enumerate(play(scenario, 1, 0)):
        numbers[step] = [robot.number for robot in swarm.robots], len(swarm.tasks), swarm.truth
    assert {len(numbers[step][0]) for step in numbers} == {4, 5, 6}
    there = FLAGS.index("there")
    for each in view.field.views:
        robots = np.flatnonzero(each.shown.flags >> there & 1).tolist()
        assert (robots, len(each.tasks), each.truth) == numbers[each.step]
    assert len(view.field.views) > 15


def test_a_page_follows_seeks_and_sees_who_is_silent(tmp_path):
    with (
        a_field(tmp_path, small(120), key="a key", faults=kills("1@10", 120)) as view,
        serving_at(FieldCatalogue(view)) as port,
        Page(port) as page,
    ):
        assert page.welcome["title"] == f"field at {view.address}"
        page.say(type="open")
        opened, received = {}, []
        while not received or received[-1]["step"] < 120:
            message = page.receive()
            if message["type"] == "opened":
                opened = message
            elif message["type"] == "frame":
                received.append(message)
                page.say(type="advance", steps=1)
            elif message["type"] == "field" and message["problems"]:
                assert message["problems"] == ["robot 3 is silent"]
        assert (opened["robots"], opened["field"]["hz"], opened["last"]) == (4, 20.0, 120)
        counts = sum(len(each["feasible_counts"]) for each in received)
        assert counts == 121 - view.field.first
        working = FLAGS.index("working")
        assert received[-1]["flags"][3] >> working & 1 == 0
        assert received[-1]["counted"] == 3
        back = seek(page, 20)
        assert back["step"] == view.field.at(20).step  # a packet may be lost: then the step before


def seek(page, step):
    page.say(type="seek", to=step, jump=1)
    while True:
        message = page.receive()
        if message["type"] == "frame" and message["jump"] == 1:
            return message


def test_a_session_says_what_it_cannot_do_and_what_robots_reported(tmp_path):
    with a_field(tmp_path, small(30), lockstep=True) as view:
        session = FieldSession(view)
        session.begin(None)
        assert "what has happened" in session.look(Look(type="look"), 0.0)["problem"]
        with pytest.raises(FeasibeeError, match="robot = 4"):
            session.inspect(4)
        session.inspect(2)
        said = next(each for each in session.messages() if isinstance(each, dict) and each["type"] == "robot")
        assert [name for name, _ in said["reasons"]] == ["Phase", "Opinion", "Knows"]
        with pytest.raises(FeasibeeError, match="what has happened"):
            session.lane(0)


def test_no_field_a_wrong_key_and_one_that_goes_away_are_said(tmp_path, monkeypatch):
    def refused(address, words, key=b""):
        with monkeypatch.context() as soon:
            soon.setattr(fieldview, "JOINING", 0.5)
            with pytest.raises(FeasibeeError, match=words):
                FieldView(address, key=key).join()

    refused("127.0.0.1:9", "no field answers; start feasibee launch --port 9")
    with a_field(tmp_path, small(LONG), key="a key", hz=40.0) as view:
        refused(view.address, "--key-file", b"another key")
        wait_for(view, 1)
        session = FieldSession(view)
        session.begin(None)
        monkeypatch.setattr(fieldview, "SILENCE", -1.0)
        [state, _] = session.messages()
        assert state["silent"]
        assert view.address in state["problems"][-1]


def test_steps_are_kept_within_a_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(fieldsteps, "ROOM", 10 * fieldsteps.FIXED)
    with a_field(tmp_path, small(40), lockstep=True) as view:
        wait_for(view, 40)
        field = view.field
        assert len(field.views) < 11
        assert field.at(0) is field.views[0]
        assert len(field.counts(field.first, 41)) == 41 - field.first


@pytest.mark.slow
def test_the_page_shows_a_field_to_its_end(visit, tmp_path):
    expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
    with (
        a_field(tmp_path / "first", small(120), faults=kills("1@5", 120)) as view,
        serving_at(FieldCatalogue(view)) as port,
    ):
        page = visit(port)
        expect(page.locator("#controls")).to_be_hidden()
        expect(page.locator("#banner-text")).to_have_text("Robot 3 is silent.")
        expect(page.locator("#retry")).to_be_hidden()
        expect(page.locator("#field-state")).to_have_text("ended at step 120")
        expect(page.locator("#now")).to_have_text("120")
        expect(page.locator("#stopped")).to_have_text("1")
        page.keyboard.press(",")
        expect(page.locator("#now")).to_have_text(
            str(view.field.at(119).step)
        )  # or before, if a packet is lost
        page.keyboard.press("r")
        expect(page.locator("#now")).to_have_text(re.compile(r"^\d{1,2}$"))
        page.keyboard.press("n")  # there is no next run
        expect(page.locator("#field-state")).to_have_text("ended at step 120")
        page.keyboard.press(" ")
        expect(page.locator("#now")).to_have_text("120")
        network = Network(port=int(view.address.rpartition(":")[2]))
        with running(a_plan(small(LONG), seed=2), network, tmp_path / "second"):
            expect(page.locator("#field-which")).to_have_text("2, 0", timeout=60_000)
            expect(page.locator("#banner")).to_be_hidden()
            expect(page.locator("#field-state")).to_have_text("running")
            expect(page.locator("#last")).to_have_text(f"{LONG:,}")
            expect(page.locator("#now")).not_to_have_text("0", timeout=60_000)
