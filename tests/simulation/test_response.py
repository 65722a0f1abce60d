"""Swarms that call for robots and release them (model.md 6.19), in engine and reference."""

from __future__ import annotations

import re

import numpy as np
import pytest
from following import SIGHTINGS
from hypothesis import assume, given
from hypothesis import strategies as st
from test_equivalence import assert_equal, beyond, events

from feasibee import Scenario, ScenarioError, reference

SEEING = (
    '''\
"""Robots that know which tasks they saw or heard of lately, and how many robots there were at the start."""

BY_NAME = True
PARAMETERS = {"lasts": 20.0, "said": 9.0}


'''
    + SIGHTINGS
    + """\


def count(known, counts, me):
    counts[0], counts[me.setting.robot_classes] = me.setting.count, present(known)


def judge(known, me):
    for k in range(len(known)):
        known[k] = max(known[k] - 1, 0)
    return 1 if present(known) <= me.setting.count else 0


def gap(known, me):
    return present(known) - me.setting.count
"""
)
SAYING = SEEING.replace(
    "return 1 if present(known) <= me.setting.count else 0",
    "if me.setting.parameters[1] == 3.0:\n        return -1 if me.step % 5 else me.step // 5 % 2"
    "\n    return 1 if me.setting.parameters[1] < 0.0 else 0",
).replace(
    "return present(known) - me.setting.count", "return int(me.setting.parameters[1]) + (7 * me.id) % 5 - 2"
)
"""What robots say doesn't depend on what they see: all hold one opinion, and their gaps are said -2 to +2."""


@pytest.fixture(scope="module")
def seeing(tmp_path_factory):
    """Return the path of a strategy whose robots see how many tasks there are."""
    path = tmp_path_factory.mktemp("seeing") / "seeing.py"
    path.write_text(SEEING, encoding="utf-8")
    return str(path)


@pytest.fixture(scope="module")
def saying(tmp_path_factory):
    """Return the path of a strategy whose robots all hold one opinion from step 1 on."""
    path = tmp_path_factory.mktemp("saying") / "saying.py"
    path.write_text(SAYING, encoding="utf-8")
    return str(path)


def steady(path, said, **changes):
    """Return a scenario whose five robots say so many, or hold *feasible* if that is negative."""
    base = {
        "robots.count": 5,
        "tasks.count": 3,
        "run.steps": 20,
        "response.patience": 4,
        "response.delay": 3,
        "response.margin": 0,
        "decision.strategy": str(path),
        "decision.parameters": {"said": float(said)},
    }
    return Scenario().replace({**base, **changes})


def joined(record):
    """Return by how many the number of robots changes, by step."""
    changes = np.diff(record.robots_present[0])
    return {int(step) + 1: int(changes[step]) for step in np.flatnonzero(changes)}


# --- Tiny cases, by hand ---


CASES = {
    # Held from step 1 to 4, called at 5, there at 8; held from 8 to 11, called at 12, there at 15; then on.
    # Robots 0 to 4 say 2 + (-2, 0, 2, -1, 1): sorted 0, 1, 2, 3, 4, whose median is 2. Of seven robots, 5 and
    # 6 say 2 + (-2, 0), and the lower median of 0, 0, 1, 2, 2, 3, 4 is 2 again. The third call is at step 19.
    "after patience and delay": (2, {"robots.most": 50}, {8: 2, 15: 2}, (3, 6, 0)),
    "margin": (2, {"run.steps": 10, "response.margin": 3, "robots.most": 50}, {8: 5}, (1, 5, 0)),
    # Robots 0 to 3 say 9 + (-2, 0, 2, -1): 7, 8, 9, 11, whose lower median is 8.
    "even number": (9, {"robots.count": 4, "run.steps": 10, "robots.most": 50}, {8: 8}, (1, 8, 0)),
    "one at least": (0, {"run.steps": 10}, {8: 1}, (1, 1, 0)),
    "all numbers at most": (40, {"run.steps": 10, "robots.most": 8}, {8: 3}, (1, 8, 0)),
    "without delay": (2, {"response.delay": 0, "run.steps": 9}, {5: 2, 9: 2}, (2, 4, 0)),
    # Median -4, margin 1: three of five leave at step 5. Those that are left say -4 or so, but one stays.
    "surplus": (-4, {"response.margin": 1, "run.steps": 12}, {5: -3, 9: -1}, (0, 0, 4)),
    "surplus within the margin": (-4, {"response.margin": 4}, {}, (0, 0, 0)),
}


@pytest.mark.parametrize("case", CASES)
def test_the_operator_calls_and_releases_by_the_lower_median(saying, case):
    said, changes, expected, (calls, called, released) = CASES[case]
    record = assert_equal(steady(saying, said, **changes), 4)
    assert record.held[0].tolist()[1:5] == [int(said < 0)] * 4
    assert joined(record) == expected
    assert (record.calls[0], record.robots_called[0], record.robots_released[0]) == (calls, called, released)


def test_what_holds_for_less_than_the_patience_causes_nothing(saying):
    """All hold 0 and 1 by turns, for five steps each, from step 1 on."""
    record = assert_equal(steady(saying, 3, **{"response.patience": 6, "run.steps": 40}), 4)
    assert set(record.held[0].tolist()[1:]) == {0, 1}
    assert joined(record) == {}
    record = assert_equal(steady(saying, 3, **{"response.patience": 5, "run.steps": 40}), 4)
    assert record.calls[0] == 4


def test_a_strategy_without_a_gap_calls_one_by_one_and_releases_none():
    changes = {
        "robots.count": 4,
        "tasks.count": 30,
        "arena.side": 6.0,
        "response.patience": 10,
        "response.delay": 5,
    }
    short = Scenario().replace({**changes, "run.steps": 300})
    record = assert_equal(short, 4)
    assert set(joined(record).values()) == {1}
    assert record.calls[0] == record.robots_called[0] > 2
    idle = assert_equal(short.replace({"tasks.count": 0}), 4)
    assert (idle.held[0] == 1).mean() > 0.5
    assert idle.robots_released[0] == 0


def test_liars_and_stopped_robots_are_not_asked(saying):
    """Two of five lie and one stops at step 5, when the call comes: the lower median is that of two."""
    faults = {"faults.byzantine": 0.4, "faults.stopped": 0.2, "faults.stop_step": 5, "run.steps": 8}
    scenario = steady(saying, 9, **{**faults, "robots.most": 50})
    record = assert_equal(scenario, 4)
    swarm = reference.Swarm(scenario, 4, 0)
    honest = [robot.number for robot in swarm.robots if robot.fault == "honest"]
    said = sorted(9 + (7 * number) % 5 - 2 for number in honest)
    assert len(said) == 2
    assert joined(record) == {8: said[0]}


def test_a_swarm_gets_the_robots_that_it_lacks(seeing):
    """Three more tasks than robots from step 100 to 160; called at about 120, they come at about 180."""
    scenario = Scenario().replace(
        {
            "decision.strategy": seeing,
            "decision.gain": 5.0,
            "arena.side": 8.0,
            "robots.count": 6,
            "tasks.count": 3,
            "events": [{"step": 100, "tasks": 6}, {"step": 160, "tasks": -6}],
            "response.patience": 15,
            "response.delay": 60,
            "response.margin": 6,
            "robots.most": 30,
            "run.steps": 400,
        }
    )
    record = assert_equal(scenario, 4)
    (first,) = joined(record)
    assert 175 < first < 230
    assert joined(record)[first] == 9
    assert (record.calls[0], record.robots_called[0]) == (1, 9)


@pytest.mark.parametrize(("name", "off"), [("census", 0), ("estimate", 3)])
def test_strategies_that_count_know_the_gap(name, off):
    changes = {"robots.count": 12, "tasks.count": 17, "arena.side": 7.0, "decision.strategy": name}
    swarm = reference.Swarm(Scenario().replace(changes), 1, 0)
    for _ in range(300):
        swarm.step()
    gaps = [robot.mind.knowledge.gap() for robot in swarm.robots]
    assert all(abs(each - 5) <= off for each in gaps), gaps


# --- Engine and reference ---


@st.composite
def responding(draw, path):
    """Scenarios beyond the paper in which robots are called and released (model.md 6.19)."""
    scenario = draw(beyond())
    assume(not scenario.manifest.declares)
    known = draw(st.sampled_from(["", "seeing"]))
    classes = scenario.robots.classes or scenario.tasks.classes
    changes = {
        "decision.declare": None,
        "run.stop_at_decision": False,
        "events": draw(st.lists(events(scenario), max_size=2)),
        "tasks.arrival_rate": draw(st.sampled_from([None, 0.3])),
        "robots.failure_rate": draw(st.sampled_from([None, 0.05])),
        "robots.most": scenario.robots.count + draw(st.integers(1, 40)),
        "response.patience": draw(st.integers(1, 5)),
        "response.delay": draw(st.integers(0, 6)),
        "response.margin": draw(st.integers(0, 3)),
    }
    if known and not classes:
        own = {"lasts": draw(st.floats(1, 30)), "said": 0.0}
        changes |= {"decision.strategy": path, "decision.parameters": own, "decision.quality_floor": 0}
        changes |= {"sensing.false_robots": 0.0, "sensing.false_tasks": 0.0}
    try:
        return scenario.replace(changes)
    except ScenarioError:  # such as a patience longer than the run
        assume(False)
        raise AssertionError from None


@given(st.data(), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 3))
def test_engine_equals_reference_with_responses(seeing, data, seed, first_run):
    assert_equal(data.draw(responding(seeing)), seed, runs=2, first_run=first_run)


# --- The scenario ---


def test_a_response_is_part_of_the_text(seeing):
    assert Scenario().to_dict()["response"] == {"delay": 100, "margin": 2}
    scenario = Scenario(response={"patience": 60})
    assert scenario.dynamic
    assert scenario.to_dict()["response"] == {"patience": 60, "delay": 100, "margin": 2}
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert scenario.most.robots == 40
    others = {"patience": 61, "delay": 99, "margin": 3}
    changed = [{"decision.strategy": seeing, f"response.{name}": others[name]} for name in others]
    known = {scenario.replace(each).hash for each in [{}, {"decision.strategy": seeing}, *changed]}
    assert len(known) == len(changed) + 2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"response.delay": 5},
            "response.delay = 5: needs response.patience: .*; set response.patience = 100",
        ),
        ({"response.release": True}, "response.release = True: unknown key; .*if the strategy defines gap"),
        ({"response.patience": 0}, "response.patience = 0: must be ≥ 1"),
        ({"response.patience": 9, "response.delay": -1}, "response.delay = -1: must be ≥ 0"),
        ({"response.patience": 1001}, "response.patience = 1001: is longer than a run, run.steps = 1000"),
        (
            {"response.patience": 9, "robots.most": 20},
            "robots.most = 20: lets none join: 20 robots are there, and none leaves; set it to 21 or more",
        ),
        (
            {"response.patience": 9, "decision.declare": {}},
            "decision.declare = .*is for good, but the world of this scenario changes",
        ),
    ],
)
def test_a_response_that_can_not_be_is_told_with_a_remedy(changes, words):
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace(changes)
    assert re.search(words, str(caught.value)), caught.value


def test_robots_that_are_released_make_room_for_those_called(seeing):
    full = {"response.patience": 9, "robots.most": 20, "decision.strategy": seeing}
    assert Scenario().replace(full).most.robots == 20
    with pytest.raises(ScenarioError, match="lets none join"):
        Scenario().replace({**full, "decision.strategy": "dmmd"})


def test_robots_know_what_they_are_asked_for_from_the_first_step_on():
    """A census knows its own robot from the start, and of two robots one is to spare without tasks."""
    scenario = Scenario(
        robots={"count": 2, "most": 3},
        tasks={"count": 0},
        decision={"strategy": "census", "threshold": 0.5},
        run={"steps": 3},
        response={"patience": 1, "delay": 0, "margin": 0},
    )
    assert_equal(scenario, seed=0, runs=40)
