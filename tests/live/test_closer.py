"""Seeking, comparing and inspecting, as the server does it."""

from __future__ import annotations

import numpy as np
import pytest
from playing import swarm_at
from serving import Page, serving_at

from feasibee import Scenario, Swarm, simulate
from feasibee.live.catalogue import Catalogue
from feasibee.live.reasons import reasons_of
from feasibee.scenario.tables import PRESETS

pytestmark = pytest.mark.usefixtures("patient")


def same(one, other):
    return all(np.array_equal(one[name], other[name]) for name in one if name not in ("jump", "generation"))


def messages_until_frame(page):
    """Return what the page receives, up to the frame of the first swarm."""
    found = []
    while not found or found[-1]["type"] != "frame" or found[-1]["lane"]:
        found.append(page.receive())
    return [each for each in found if each["type"] != "going"]


def opened(page, **message):
    page.say(type="open", **message)
    return messages_until_frame(page)


@pytest.mark.parametrize("events", ["", "[{step = 20, tasks = 6}, {step = 138, robots = -8, tasks = -20}]"])
def test_a_step_is_the_same_however_it_is_reached(port, events):
    asked = {"run": "3", "changes": {"events": events} if events else {}}
    with Page(port) as page, Page(port) as other:
        page.open(**asked)
        for jump, step in enumerate((400, 399, 0, 20, 1000, 5000, 137), 1):
            frame = page.answer("frame", type="seek", to=step, jump=jump)
            assert (frame["step"], frame["jump"]) == (min(step, 1000), jump)
            expected = other.open(**asked, step=step)
            counts = ("first", "arrays", "feasibleCounts", "infeasibleCounts", "countedCounts", "truths")
            for each in (frame, expected):
                for name in counts:
                    del each[name]
            assert same(frame, expected)
        frame = page.answer("frame", type="advance", steps=3)
        assert (frame["step"], frame["jump"]) == (140, 7)


def test_seeking_sends_every_count_once(port):
    expected = simulate(Scenario(), 1, 1, curves=True)
    counts = []
    with Page(port) as page:
        frames = [page.open()]
        for jump, step in enumerate((90, 20, 100, 3, 1000), 1):
            frames.append(page.answer("frame", type="seek", to=step, jump=jump))
    for frame in frames:
        if frame["truths"].size:
            assert frame["first"] == len(counts)
            counts += frame["feasibleCounts"].tolist()
    assert counts == expected.feasible_count[0].values.tolist()


def test_the_decision_is_gone_to_if_there_is_one(port):
    expected = simulate(Scenario(), 1, 1)
    with Page(port) as page:
        page.open()
        frame = page.answer("frame", type="seek", to="decision", jump=1)
        assert frame["step"] == frame["decisionStep"] == expected.decision_step[0] > 0
        page.open(changes={"run.steps": 30}, step=17)
        page.say(type="seek", to="decision", jump=1)
        undecided, frame = messages_until_frame(page)
        assert undecided == {"type": "undecided", "lane": 0, "last": 30}
        assert frame["step"] == 17


def test_two_strategies_are_in_one_world_and_in_step(port):
    strategies = ("dmmd", "census")
    with Page(port) as page:
        first, second, tasks, *frames = opened(page, against="census", seed="5", run="2", step=40)
        assert [each["strategy"] for each in (first, second)] == list(strategies)
        assert first["swarms"] == second["swarms"] == 2
        swarms = [Swarm(Scenario(decision={"strategy": each}), 5, 2) for each in strategies]
        assert np.abs(np.stack([tasks["x"], tasks["y"]], 1) * (20 / 65536) - swarms[1].tasks).max() < 1e-3
        for step in (40, 41, 300, 120):
            if step == 41:
                page.say(type="advance", steps=1)
            elif step != 40:
                page.say(type="seek", to=step, jump=step % 256)
            frames = frames if step == 40 else messages_until_frame(page)
            assert [each["lane"] for each in frames] == [1, 0]
            for frame in frames:
                swarm = swarm_at(step, Scenario(decision={"strategy": strategies[frame["lane"]]}), 5, 2)
                assert frame["step"] == step
                assert (frame["firstDecision"], frame["decisionStep"]) == swarm.first_decision
                assert frame["flags"].tolist() == swarm.snapshot().flags.tolist()
            assert (frames[0]["x"] == frames[1]["x"]).all()  # they walk alike
        page.say(type="seek", to="decision", lane=1, jump=9)
        frames = messages_until_frame(page)
        assert frames[0]["step"] == frames[0]["decisionStep"] > 0
        assert len(opened(page)) == 3  # one swarm again: opened, tasks, frame


@pytest.mark.parametrize("against", ["nothing", "/tmp/evil.py", "", "turns"])
def test_a_strategy_that_cannot_stand_beside_is_told_there(port, against):
    with Page(port) as page:
        page.open()
        assert page.problems(type="open", against=against)[0] in ("against", "robots.know_count")
        assert page.answer("frame", type="advance", steps=2)["step"] == 2


def test_parameters_belong_to_their_strategy(port):
    changes = {"decision.strategy": "bayes", "decision.parameters": {"credence": 0.8}}
    with Page(port) as page:
        first, second, *_ = opened(page, changes=changes, against="dmmd")
        assert "credence = 0.8" in first["toml"]
        assert "credence" not in second["toml"]
        first, second, *_ = opened(page, changes=changes, against="bayes")
        assert first["toml"] == second["toml"]


def test_a_users_own_strategy_stands_on_either_side(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("PARAMETERS = {'x': 0.25}\ndef decide(mind, inbox):\n    return mind.opinion\n")
    own = Scenario(decision={"strategy": str(file), "parameters": {"x": 0.5}})
    with serving_at(Catalogue(own)) as port, Page(port) as page:
        changes = {"tasks.count": 17, "decision.strategy": "bayes", "decision.parameters": "{credence = 0.8}"}
        first, second, *_ = opened(page, against="dmmd", changes={"tasks.count": 17})
        assert ("x = 0.5" in first["toml"], second["strategy"]) == (True, "dmmd")
        first, second, *_ = opened(page, against=str(file), changes=changes)
        assert [each["strategy"] for each in (first, second)] == ["bayes", str(file)]
        assert [each["tasks"] for each in (first, second)] == [17, 17]
        assert "credence = 0.8" in first["toml"]
        assert "x = 0.5" in second["toml"]


def test_a_robot_is_told_with_each_frame(port):
    swarms = [Swarm(Scenario(decision={"strategy": each}), 1) for each in ("dmmd", "tally")]
    with Page(port) as page:
        opened(page, against="tally")
        page.say(type="inspect", robot=7)
        for jump, step in enumerate((30, 80, 50), 1):
            page.say(type="seek", to=step, jump=jump)
            *told, _, frame = messages_until_frame(page)
            assert [each["lane"] for each in told] == [0, 1]
            for each in told:
                swarm = swarms[each["lane"]] = Swarm(swarms[each["lane"]].scenario, 1)
                swarm.advance(step)
                expected = reasons_of(swarm, 7)
                assert (each["robot"], each["step"], each["jump"]) == (7, step, frame["jump"])
                assert each["reasons"] == expected
        page.say(type="inspect", robot=None)
        page.say(type="advance", steps=1)
        assert len(messages_until_frame(page)) == 2


def test_what_lies_ahead_is_found_piece_by_piece(port):
    with Page(port) as page:
        opened(page, against="census")
        for lane, strategy in enumerate(("dmmd", "census")):
            expected = simulate(Scenario(decision={"strategy": strategy}), 1, 1)
            changes, done = [], False
            while not done:
                found = page.answer("outlook", type="look", robot=5, lane=lane, first=len(changes))
                assert (found["first"], found["lane"], found["robot"]) == (len(changes), lane, 5)
                changes += found["changes"]
                done = found["done"]
            assert found["decision"] == expected.decision_step[0]
            assert len(changes) > 50
            assert [step for step, _ in changes] == sorted({step for step, _ in changes})
        assert page.answer("frame", type="advance", steps=2)["step"] == 2  # the page's own swarms stay


def test_a_field_is_typed_as_toml(port):
    changes = {
        "arena.side": "[30, 18]",
        "decision.listen": "{last = 3}",
        "decision.declare": "{quorum = 0.8}",
        "tasks.points": "[[1, 2], [3.5, 4]]",
        "tasks.placement": "points",
        "sensing.count_self": True,
        "radio.id_bits": 8,
        "preset": "valentini-2016",
    }
    with Page(port) as page:
        (told, *_) = opened(page, changes=changes)
        scenario = Scenario.from_toml(told["toml"])
        assert scenario.arena.size == (30.0, 18.0)
        assert scenario.decision.listen == {"last": 3}
        assert scenario.decision.declare.quorum == 0.8
        assert scenario.tasks.points == ((1.0, 2.0), (3.5, 4.0))
        assert scenario.run.steps == PRESETS["valentini-2016"]["run"]["steps"]
        assert told["fields"]["decision.listen"] == "{last = 3}"
        assert told["fields"]["tasks.points"] == "[[1.0, 2.0], [3.5, 4.0]]"
        (told, *_) = opened(page, changes={"decision.declare": None, "radio.id_bits": None})
        assert "decision.declare" not in told["fields"]


def test_two_swarms_share_the_room_of_a_page(port, monkeypatch):
    from feasibee.live import session

    monkeypatch.setattr(session, "ROOM", 3 * 2**20)
    changes = {"robots.count": 300, "decision.strategy": "tally"}
    with Page(port) as page:
        assert page.open(changes=changes)["step"] == 0
        assert page.problems(type="open", changes=changes, against="dmmd") == [""]
        found = page.answer("outlook", type="look", robot=None)
        assert "MiB, above the limit" in found["problem"]  # a look ahead needs a swarm more
        assert found["done"]
        assert page.answer("frame", type="advance", steps=1)["step"] == 1
