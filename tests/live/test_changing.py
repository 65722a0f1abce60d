"""The live arena in a world that changes, without a browser: frames, the outlook, the form's preset."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from playing import looked, swarm_at, swept
from serving import Page, serving_at

from feasibee import Scenario, Swarm
from feasibee.live.catalogue import STREAM, Catalogue, read_catalogue
from feasibee.live.reasons import reasons_of
from feasibee.live.timeline import Outlook
from feasibee.simulation.snapshot import FLAGS

EXAMPLE = Path(__file__).parents[2] / "examples" / "changing.toml"
EVENTS = [{"step": 20, "tasks": 6}, {"step": 40, "robots": -8}, {"step": 70, "tasks": -20, "robots": 3}]
SCENARIO = Scenario(
    events=EVENTS,
    tasks={"arrival_rate": 0.05, "lifetime": 300.0},
    robots={"failure_rate": 0.002},
    decision={"strategy": "census"},
    run={"steps": 120},
)

GONE = [["Phase", "no robot has this number at this step"]]

pytestmark = pytest.mark.usefixtures("patient")


@pytest.fixture(scope="module")
def port():
    with serving_at(Catalogue(SCENARIO, 5, 2)) as at:
        yield at


def test_each_frame_has_what_is_there_at_its_step(port):
    swarm = Swarm(SCENARIO, seed=5, run=2)
    with Page(port) as page:
        frame = page.open()
        truths = frame["truths"].tolist()
        for step in (15, 25, 60, 90, 120):
            frame = page.answer("frame", type="advance", steps=step - swarm.step)
            swarm.advance(step - swarm.step)
            there = frame["flags"] >> FLAGS.index("there") & 1
            assert (there == swarm.present).all()
            assert (frame["there"], frame["tasks"]) == (swarm.present.sum(), len(swarm.tasks))
            np.testing.assert_array_equal([frame["taskX"], frame["taskY"]], swarm.task_places())
            assert frame["truth"] == swarm.truth
            assert frame["robotSteps"] == swarm.robot_counts[1:].sum()
            assert frame["countedCounts"][-1] == swarm.counted.sum()
            truths += frame["truths"].tolist()
    assert truths == swarm.truths.tolist()


def test_what_is_opened_says_whether_the_world_changes(port):
    with Page(port) as page:
        opened = page.answer("opened", type="open")
        assert (opened["changes"], opened["numbers"]) == (True, SCENARIO.most.robots)
        assert opened["fields"]["events"].startswith("[{step = 20, tasks = 6")
        assert opened["fields"]["tasks.lifetime"] == 300.0


def test_events_are_typed_as_toml_and_problems_are_told_at_them(port):
    with Page(port) as page:
        frame = page.open(changes={"events": "[{ step = 0, tasks = -3 }]", "tasks.arrival_rate": None})
        assert frame["tasks"] == 17
        assert page.problems(type="open", changes={"events": "[{ step = 500, tasks = 1 }]"}) == [
            "events.0.step"
        ]
        assert page.problems(type="open", changes={"events": "soon"}) == ["events"]
        assert page.problems(type="open", changes={"events": "[{ step = 3, tasks = 30000 }]"}) == ["events"]


def test_robots_that_joined_say_what_they_know():
    joined = swarm_at(75, SCENARIO, seed=5, run=2)
    for robot in np.flatnonzero(joined.present).tolist():
        assert dict(reasons_of(joined, robot))["Knows"]


def test_a_robot_is_inspected_while_it_is_there_and_after(port):
    swarm = swarm_at(41, SCENARIO, seed=5, run=2)
    gone = int(np.flatnonzero(~swarm.present)[0])
    with Page(port) as page:
        page.open(step=30)
        page.say(type="inspect", robot=gone)
        said = page.answer("robot", type="advance", steps=1)
        assert said["reasons"] != GONE
        page.receive()
        while said["step"] < 41:
            said = page.answer("robot", type="advance", steps=41 - said["step"])
        assert said["reasons"] == GONE
        page.receive()
        assert "robot = 9999" in page.answer("error", type="inspect", robot=9999)["problems"][0]["text"]


@pytest.mark.parametrize("robot", [None, 3])
def test_the_outlook_finds_each_change_once(robot):
    swarm = swarm_at(120, SCENARIO, seed=5, run=2)
    curves = np.stack([swarm.robot_counts, swarm.task_counts, swarm.truths], axis=1)
    at = [0, *(np.flatnonzero((np.diff(curves, axis=0) != 0).any(axis=1)) + 1)]
    outlook = Outlook(Swarm(SCENARIO, seed=5, run=2), 120)
    found = []
    while not outlook.look(0.0005):
        found += outlook.to_dict(0, len(found))["world"]
    found += looked(outlook, robot)["world"][len(found) :]
    assert found == [(step, *curves[step].tolist()) for step in map(int, at)]
    assert len({truth for *_, truth in found}) == 2


def test_the_outlook_of_a_robot_says_when_it_is_there():
    swarm = swarm_at(41, SCENARIO, seed=5, run=2)
    robot = int(np.flatnonzero(~swarm.present)[0])
    changes = looked(Outlook(Swarm(SCENARIO, seed=5, run=2), 120), robot)["changes"]
    again = Swarm(SCENARIO, seed=5, run=2)
    there = []
    for step in range(121):
        again.advance(step - again.step)
        there.append(bool(again.present[robot]))
    for step, flags in changes:
        assert there[step] == bool(flags >> FLAGS.index("there") & 1)
    assert not all(there)


def test_the_preset_of_the_form_is_the_example(port):
    example = Scenario.read(EXAMPLE)
    assert Scenario().replace(STREAM) == example
    with Page(port) as page:
        assert page.welcome["stream"] == dict(STREAM)


def test_a_world_that_stays_sends_no_tasks_with_its_frames():
    with serving_at(Catalogue(Scenario(run={"steps": 20}))) as at, Page(at) as page:
        frame = page.open()
        assert (frame["taskX"].size, frame["tasks"], frame["there"], frame["truth"]) == (0, 20, 20, 1)
        frame = page.answer("frame", type="advance", steps=5)
        assert frame["robotSteps"] == 100
        found = page.answer("outlook", type="look")
        assert found["world"] == []


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    tables = {
        "runs": 40,
        "seed": 5,
        "scenario": {"run": {"steps": 130}, "events": [{"step": 40, "tasks": 6}, {"step": 90, "tasks": -9}]},
        "sweep": {"tasks.count": [16, 20]},
    }
    return swept(tables, folder)


def test_a_sweeps_runs_are_right_or_wrong_by_the_truth_of_their_decisions_step(results):
    found = {pick: read_catalogue(results, pick) for pick in ("right", "wrong", "all")}
    decided = [each for each in found["all"].replays if each.decision != -1]
    assert found["right"].found + found["wrong"].found == len(decided)
    with serving_at(found["wrong"]) as at, Page(at) as page:
        listed = page.welcome["replays"]
        assert len(listed) == found["wrong"].found > 3
        for each in listed[:8]:
            frame = page.open(
                point=each["point"], seed=each["seed"], run=each["run"], step=each["decision_step"]
            )
            assert frame["firstDecision"] == frame["decision"] == 1 - frame["truth"]
