"""The hash of a scenario: fields of lists and tables, and fields that need others, change it, too."""

from __future__ import annotations

from itertools import combinations

import pytest

from feasibee import Scenario
from feasibee.scenario.fields import Commit, Event, Response, RobotClass, TaskClass

LIFT = {"name": "lift", "count": 12, "skills": ["arm"]}
CRATE = {"name": "crate", "count": 9, "needs": {"arm": 1}}
EVENT = {"step": 50, "tasks": 3, "robots": 2, "sensing": {"miss": 0.1}, "radio": {"loss": 0.1}}
COMMIT = {"quorum": 0.8, "rounds": 2, "heard": 1}
RESPONSE = {"patience": 5, "delay": 10, "release": False, "margin": 1}
"""Tables in which each field can have several values."""


def with_classes(robots=LIFT, tasks=CRATE):
    return {"robots": {"classes": [robots]}, "tasks": {"classes": [tasks]}}


def with_decision(**fields):
    return {"decision": {"strategy": "quiet-census", **fields}}


OTHERS = {
    "classes of robots": [
        with_classes(),
        *(
            with_classes({**LIFT, **new})
            for new in ({"name": "haul"}, {"count": 13}, {"skills": ["arm", "eye"]})
        ),
        {
            **with_classes(),
            "robots": {"classes": [{**LIFT, "count": 6}, {**LIFT, "name": "haul", "count": 6}]},
        },
    ],
    "classes of tasks": [
        with_classes(),
        *(
            with_classes(tasks={**CRATE, **new})
            for new in ({"name": "box"}, {"count": 8}, {"needs": {"arm": 2}})
        ),
    ],
    "events": [
        {"events": [EVENT]},
        *(
            {"events": [{**EVENT, name: value}]}
            for name, value in (("step", 51), ("tasks", -3), ("robots", 1))
        ),
        {"events": [{**EVENT, "sensing": {"miss": 0.2}}]},
        {"events": [{**EVENT, "radio": {"loss": 0.2}}]},
        {"events": [EVENT, EVENT]},
        {"events": [EVENT, {**EVENT, "step": 90}]},
    ],
    "commitment": [
        {"decision": {"commit": {**COMMIT, **new}}}
        for new in ({}, {"quorum": 0.7}, {"rounds": 1}, {"heard": 2})
    ],
    "response": [
        {"response": {**RESPONSE, **new}} for new in ({}, {"patience": 6}, {"delay": 11}, {"margin": 0})
    ],
    "release": [
        {"decision": {"strategy": "fading"}, "response": {**RESPONSE, "release": release}}
        for release in (True, False)
    ],
    "contact": [
        {"robots": {"avoid_collisions": True, "contact": contact}} for contact in ("stand", "deflect")
    ],
    "parameters": [
        with_decision(),
        with_decision(parameters={"quiet": 50.0}),
        with_decision(parameters={"quiet": 51.0}),
    ],
    "points": [
        {part: {"placement": "points", "points": points}}
        for part in ("robots", "tasks")
        for points in ([[1, 2], [3, 4]], [[3, 4], [1, 2]], [[1, 2], [3, 5]], [[1, 2]])
    ],
}


@pytest.mark.parametrize("what", OTHERS)
def test_scenarios_that_differ_have_different_hashes(what):
    for one, other in combinations([Scenario(**tables) for tables in OTHERS[what]], 2):
        assert one.hash != other.hash


def test_all_fields_of_these_tables_are_tried():
    """A new field needs another value above."""
    assert set(RobotClass.model_fields) == set(LIFT)
    assert set(TaskClass.model_fields) == set(CRATE)
    assert set(Event.model_fields) == set(EVENT)
    assert set(Commit.model_fields) == set(COMMIT)
    assert set(Response.model_fields) == set(RESPONSE)


def test_the_same_event_with_its_defaults_has_the_same_hash():
    short, long = ({"step": 9, "tasks": 1}, {"step": 9, "tasks": 1, "robots": 0, "sensing": {}, "radio": {}})
    assert Scenario(events=[short]).hash == Scenario(events=[long]).hash
