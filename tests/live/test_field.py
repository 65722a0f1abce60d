"""The live page of a field: its steps come from real processes."""

from __future__ import annotations

import re
import threading
import time
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
import pytest
from serving import Page, serving_at

from feasibee import Scenario
from feasibee.errors import FeasibeeError
from feasibee.field.faults import parse_fault, schedule
from feasibee.field.plan import Plan
from feasibee.field.supervisor import Field, Network
from feasibee.live import fieldview
from feasibee.live.fieldsession import FieldCatalogue, FieldSession
from feasibee.live.fieldview import FieldView
from feasibee.live.messages import Look
from feasibee.reference import play
from feasibee.simulation.snapshot import FLAGS


def small(steps):
    arena = {"arena.side": 8.0, "robots.count": 4, "tasks.count": 4}
    return Scenario().replace({**arena, "run.steps": steps, "run.stop_at_decision": False})


@contextmanager
def a_field(folder, scenario, lockstep=False, hz=20.0, kill="", key=""):
    """Run a field in a thread; give a viewer that has joined it.

    A robot is silent after 3 s: one that only waits for a busy machine is not.
    """
    patience = 20.0 if lockstep else 3.0
    faults = schedule(parse_fault("kill", kill, hz), 4, scenario.run.steps) if kill else ()
    plan = Plan(scenario, 1, 0, lockstep, hz, 0.0, 0.0, 0.0, tuple(faults), patience, 60.0)
    views, joined = [], threading.Event()

    def tell(event):
        if event["event"] == "listening":
            view = FieldView(event["address"], key=key.encode())
            views.append(view)
            threading.Thread(target=lambda: (view.join(), joined.set())).start()

    running = threading.Thread(target=Field(plan, Network(key=key), folder, tell).run)
    with patch.object(fieldview, "JOINING", 60.0), patch.object(fieldview, "SILENCE", 60.0):
        running.start()
        try:
            assert joined.wait(60)
            yield views[0]
        finally:
            running.join(60)
            views[0].close()
    assert not running.is_alive()


def test_the_steps_of_a_field_in_lockstep_are_those_of_the_run(tmp_path):
    scenario = small(60)
    with a_field(tmp_path, scenario, lockstep=True, key="a key") as view:
        assert view.wait_for(60, 60)
    swarms = {}
    for step, swarm in enumerate(play(scenario, 1, 0)):
        swarms[step] = [robot.mind.opinion for robot in swarm.robots], swarm.feasible_count
    for each in view.views:
        opinions, feasible = swarms[each.step]
        held = {name: each.shown.flags >> bit & 1 for bit, name in enumerate(FLAGS)}
        assert (held["feasible"].astype(int) - held["neutral"]).tolist() == opinions
        assert each.counts[0] == feasible
    assert len(view.views) > 30


def test_robots_and_tasks_of_a_field_come_and_go(tmp_path):
    events = [{"step": 10, "tasks": 3, "robots": 2}, {"step": 20, "tasks": -5, "robots": -1}]
    scenario = small(30).replace({"events": events})
    with a_field(tmp_path, scenario, lockstep=True, patience=20.0) as view:
        assert view.wait_for(30, 60)
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
    for each in view.views:
        robots = np.flatnonzero(each.shown.flags >> there & 1).tolist()
        assert (robots, len(each.tasks), each.truth) == numbers[each.step]
    assert len(view.views) > 15


def test_a_page_follows_seeks_and_sees_who_is_silent(tmp_path):
    with (
        a_field(tmp_path, small(120), kill="1@10", key="a key") as view,
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
        assert counts == 121 - view.first
        working = FLAGS.index("working")
        assert received[-1]["flags"][3] >> working & 1 == 0
        assert received[-1]["counted"] == 3
        back = seek(page, 20)
        assert back["step"] == view.at(20).step  # a packet may be lost: then the step before


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

    refused("127.0.0.1:9", "no field answers; start feasibee field --port 9")
    with a_field(tmp_path, small(40), hz=40.0, key="a key") as view:
        refused(view.address, "--key-file", b"another key")
        assert view.wait_for(1, 30)
        session = FieldSession(view)
        session.begin(None)
        end = time.monotonic() + 60
        while not view.has_ended and time.monotonic() < end:
            time.sleep(0.01)
        view.has_ended = False  # as if its last packets were lost; the thread that receives is done
        monkeypatch.setattr(fieldview, "SILENCE", -1.0)
        [state, _] = session.messages()
        assert state["silent"]
        assert view.address in state["problems"][-1]


def test_steps_are_kept_within_a_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(fieldview, "ROOM", 10 * fieldview.FIXED)
    with a_field(tmp_path, small(40), lockstep=True) as view:
        assert view.wait_for(40, 60)
        assert len(view.views) < 11
        assert view.at(0) is view.views[0]
        assert len(view.counts(view.first, 41)) == 41 - view.first


def test_the_page_shows_a_field_to_its_end(visit, tmp_path):
    expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect
    with (
        a_field(tmp_path, small(120), kill="1@5") as view,
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
        expect(page.locator("#now")).to_have_text(str(view.at(119).step))  # or before, if a packet is lost
        page.keyboard.press("r")
        expect(page.locator("#now")).to_have_text(re.compile(r"^\d{1,2}$"))  # where the viewer began
        page.keyboard.press("n")  # there is no next run
        page.wait_for_timeout(200)
        expect(page.locator("#field-state")).to_have_text("ended at step 120")
