"""The arena in notebooks: what the kernel answers, and what the page's modules become."""

from __future__ import annotations

import importlib
import re
import sys

import pytest
from playing import swarm_at

from feasibee import FeasibeeError, Scenario, Swarm
from feasibee.live.catalogue import Catalogue
from feasibee.live.lane import ROOM, Lane
from feasibee.live.messages import Open, encode_frame, encode_tasks
from feasibee.live.page import joined
from feasibee.live.reasons import sentence_of
from feasibee.live.session import Session
from feasibee.live.widget import SWARMS_LIMIT, Arena

SCENARIO = Scenario(tasks={"count": 12}, run={"steps": 50})


@pytest.fixture
def asked(monkeypatch):
    """Give a function that sends an arena what a view would, and returns what goes back."""

    def ask(arena, content):
        answers = []
        monkeypatch.setattr(arena, "send", lambda *answer: answers.append(answer))
        arena._handle_custom_msg(content, [])
        (answer,) = answers
        return answer

    return ask


def frame_at(step, seed=3, run=5):
    swarm = swarm_at(step, SCENARIO, seed, run)
    return encode_frame(swarm, 0, step + 1)


def test_a_view_gets_the_steps_that_it_asks_for(asked):
    arena = Arena(SCENARIO, seed=3, run=5)
    first = {"world": Lane(0, SCENARIO, 3, 5, ROOM).opened() | {"step": 0}}
    tasks = [encode_tasks(Swarm(SCENARIO, 3, 5), 0)]
    for step in (0, 1, 7, 50, 4):  # also back
        message = {"step": step, "robot": -1}
        assert asked(arena, {"swarm": "a", **message}) == ({"swarm": "a", **first}, [frame_at(step), *tasks])
        first, tasks = {}, []
    ((answer, buffers),) = [asked(arena, {"swarm": "b", "step": 2, "robot": 3})]
    assert answer["why"] == [3, sentence_at(2, 3)]
    assert buffers[0] == frame_at(2)


def sentence_at(step, robot):
    lane = Lane(0, SCENARIO, 3, 5, ROOM)
    lane.timeline.advance(step)
    return sentence_of(lane.swarm, robot, lane.history)


def test_a_view_gets_the_swarm_that_its_sliders_make(asked):
    arena = Arena(SCENARIO, seed=3, run=5)
    changes = {"robots.count": 30, "events": [{"step": 4, "tasks": 5}]}
    answer, (frame, _) = asked(arena, {"swarm": "a", "step": 9, "robot": -1, "changes": changes})
    changed = SCENARIO.replace(changes)
    assert frame == encode_frame(swarm_at(9, changed, 3, 5), 0, 10)
    assert Scenario.from_toml(answer["world"]["toml"]) == changed
    changes["events"][0]["tasks"] = -13
    (answer,) = asked(arena, {"swarm": "b", "step": 9, "robot": -1, "changes": changes})
    assert answer["swarm"] == "b"
    assert answer["problems"][0]["path"] == "events.0.tasks"


def test_old_swarms_are_let_go_and_played_again(asked):
    arena = Arena(SCENARIO, seed=3, run=5)
    for name in range(3 * SWARMS_LIMIT):
        asked(arena, {"swarm": str(name), "step": 1, "robot": -1})
    assert len(arena._lanes) == SWARMS_LIMIT
    assert asked(arena, {"swarm": "0", "step": 9, "robot": -1})[1][0] == frame_at(9)


@pytest.mark.parametrize(
    "content",
    [
        {},
        [],
        None,
        {"swarm": "a"},
        *({"swarm": "a", "step": step, "robot": 0} for step in (-1, 51, 1.0, "1", None)),
    ],
)
def test_what_is_no_message_gets_an_error_and_no_frame(asked, content):
    (answer,) = asked(Arena(SCENARIO), content)
    assert answer["problem"].startswith("message = ")
    assert "step: 0 to 50" in answer["problem"]
    assert "run this cell again" in answer["problem"]


def test_the_world_is_told_as_to_the_page():
    scenario = Scenario(arena={"side": (30.0, 20.0), "boundary": "walls"})
    session = Session(Catalogue(scenario))
    session.begin(Open(type="open"))
    opened, world = session.lane(0).opened(), Arena(scenario)._world
    assert world == {name: opened[name] for name in world}


def test_a_run_that_there_is_not_is_refused():
    with pytest.raises(FeasibeeError, match="seed = -1"):
        Arena(seed=-1)


@pytest.mark.parametrize(
    ("name", "exports", "first"),
    [("widget", ["export default { render };"], "render"), ("simulator", [], "World")],
)
def test_the_modules_become_one(name, exports, first):
    text = joined(name)
    assert not re.search(r"^\s*import\b", text, re.MULTILINE)
    assert re.findall(r"^export.*", text, re.MULTILINE) == exports
    names = re.findall(r"^(?:async )?(?:function|class) (\w+)", text, re.MULTILINE)
    for each in re.findall(r"^(?:const|let) ([^;]+);", text, re.MULTILINE):
        names += re.findall(r"(?:^|,\s)\s*(\w+) = ", each)
    assert {"Crowd", "Arena", "Player", "SPEEDS", "DISSEMINATING", first} <= set(names)
    assert len(names) == len(set(names))
    assert text.index("class Crowd") < text.index("class Arena")


def test_without_anywidget_it_says_what_to_install(monkeypatch):
    monkeypatch.delitem(sys.modules, "feasibee.live.widget")
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(FeasibeeError, match=r"pip install \"\.\[widget\]\""):
        importlib.import_module("feasibee.live.widget")
