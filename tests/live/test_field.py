"""The live page of a field: its steps come from real processes."""

from __future__ import annotations

import re
import threading
import time
from contextlib import contextmanager

import pytest
from commands import invoke
from serving import Page, serving_at

from feasibee import Scenario
from feasibee.errors import FeasibeeError
from feasibee.field.faults import parse_fault, schedule
from feasibee.field.plan import Plan
from feasibee.field.supervisor import Field, Network
from feasibee.live import fieldview, server
from feasibee.live.fieldsession import FieldCatalogue, FieldSession
from feasibee.live.fieldview import FieldView
from feasibee.live.messages import Look
from feasibee.reference import play
from feasibee.simulation.snapshot import FLAGS


def small(steps):
    arena = {"arena.side": 8.0, "robots.count": 4, "tasks.count": 4}
    return Scenario().replace({**arena, "run.steps": steps, "run.stop_at_decision": False})


@contextmanager
def a_field(folder, scenario, lockstep=False, hz=20.0, kill="", patience=1.0, key="", transport="udp"):
    """Run a field in a thread; give a viewer that has joined it."""
    faults = schedule(parse_fault("kill", kill, hz), 4, scenario.run.steps) if kill else ()
    plan = Plan(scenario, 1, 0, lockstep, hz, 0.0, 0.0, 0.0, tuple(faults), patience, 60.0)
    views, joined = [], threading.Event()

    def tell(event):
        if event["event"] == "listening":
            view = FieldView(event["address"], transport, key.encode())
            views.append(view)
            threading.Thread(target=lambda: (view.join(), joined.set())).start()

    running = threading.Thread(target=Field(plan, Network(transport, key=key), folder, tell).run)
    running.start()
    try:
        assert joined.wait(60)
        yield views[0]
    finally:
        running.join(60)
        views[0].close()
    assert not running.is_alive()


@pytest.mark.parametrize("transport", ["udp", "zenoh"])
def test_the_steps_of_a_field_in_lockstep_are_those_of_the_run(tmp_path, transport):
    if transport == "zenoh":
        pytest.importorskip("zenoh", reason="eclipse-zenoh isn't installed")
    scenario = small(60)
    with a_field(tmp_path, scenario, True, patience=20.0, key="a key", transport=transport) as view:
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


def test_the_command_watches_a_field_over_zenoh(tmp_path, monkeypatch):
    pytest.importorskip("zenoh", reason="eclipse-zenoh isn't installed")
    served = []

    class Server:
        def __init__(self, catalogue, host):
            served.append(catalogue)

        def run(self, sockets):
            """Serve no page."""

    monkeypatch.setattr(server, "server_of", Server)
    with a_field(tmp_path, small(40), transport="zenoh") as view:
        options = ["--transport", "zenoh", "--port", 0, "--no-browser"]
        assert invoke("watch", "--field", view.address, *options).exit_code == 0
        assert served[0].to_dict()["title"] == f"field at {view.address}"
        assert served[0].view.wait_for(1, 60)


def test_a_page_follows_seeks_and_sees_who_is_silent(tmp_path):
    with (
        a_field(tmp_path, small(60), kill="1@10", key="a key") as view,
        serving_at(FieldCatalogue(view)) as port,
        Page(port) as page,
    ):
        assert page.welcome["title"] == f"field at {view.address}"
        page.say(type="open")
        opened, received = {}, []
        while not received or received[-1]["step"] < 60:
            message = page.receive()
            if message["type"] == "opened":
                opened = message
            elif message["type"] == "frame":
                received.append(message)
                page.say(type="advance", steps=1)
            elif message["type"] == "field" and message["problems"]:
                assert message["problems"] == ["robot 3 is silent"]
        assert (opened["robots"], opened["field"]["hz"], opened["last"]) == (4, 20.0, 60)
        counts = sum(len(each["feasible_counts"]) for each in received)
        assert counts == 61 - view.first
        working = FLAGS.index("working")
        assert received[-1]["flags"][3] >> working & 1 == 0
        assert received[-1]["counted"] == 3
        back = seek(page, 20)
        assert back["step"] == 20


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
        a_field(tmp_path, small(60), kill="1@5") as view,
        serving_at(FieldCatalogue(view)) as port,
    ):
        page = visit(port)
        expect(page.locator("#controls")).to_be_hidden()
        expect(page.locator("#banner-text")).to_have_text("Robot 3 is silent.", timeout=20_000)
        expect(page.locator("#retry")).to_be_hidden()
        expect(page.locator("#field-state")).to_have_text("ended at step 60", timeout=20_000)
        expect(page.locator("#now")).to_have_text("60")
        expect(page.locator("#stopped")).to_have_text("1")
        page.keyboard.press(",")
        expect(page.locator("#now")).to_have_text("59")
        page.keyboard.press("r")
        expect(page.locator("#now")).to_have_text(re.compile(r"^\d{1,2}$"))
        page.keyboard.press("n")  # there is no next run
        time.sleep(0.2)
        expect(page.locator("#field-state")).to_have_text("ended at step 60")
