"""The hash of a scenario: fields of lists and tables, and fields that need others, change it, too."""

from __future__ import annotations

from itertools import combinations

import pytest

from feasibee import Scenario
from feasibee.scenario.fields import Declare, Event, RobotClass, TaskClass

ROBOTS = {"name": "lift", "count": 12, "skills": ["arm"]}
TASKS = {"name": "crate", "count": 9, "needs": {"arm": 1}}
EVENT = {"step": 50, "tasks": 3, "robots": 2, "sensing": {"miss": 0.1}, "radio": {"loss": 0.1}}
NAMED = {"step": 50, "task": 1, "at": [1.0, 2.0]}
RULE = {"quorum": 0.8, "rounds": 2, "heard": 1}


def varied(table, **others):
    """Return a table, and the same with each of these values in place of its own."""
    return [table, *({**table, name: value} for name, value in others.items())]


def classes(robots, tasks):
    return {"robots": {"classes": robots}, "tasks": {"classes": tasks}}


HALVES = [{**ROBOTS, "count": 6}, {**ROBOTS, "name": "haul", "count": 6}]
EVENTS = varied(EVENT, step=51, tasks=-3, robots=1, sensing={"miss": 0.2}, radio={"loss": 0.2})
NAMING = [
    *varied(NAMED, task=2, at=[1.0, 3.0]),
    {"step": 50, "robot": 1, "at": [1.0, 2.0]},
    {"step": 50, "robot": 1},
]
OTHERS = {
    "classes": [
        *(classes([each], [TASKS]) for each in varied(ROBOTS, name="haul", count=13, skills=["arm", "eye"])),
        *(classes([ROBOTS], [each]) for each in varied(TASKS, name="box", count=8, needs={"arm": 2})[1:]),
        classes(HALVES, [TASKS]),
    ],
    "events": [
        {"events": each} for each in (*([event] for event in EVENTS + NAMING), EVENTS[:1] * 2, EVENTS[:2])
    ],
    "declaring by votes": [
        {"decision": {"declare": each}} for each in varied(RULE, quorum=0.7, rounds=1, heard=2)
    ],
    "contact": [{"robots": {"avoid_collisions": True, "contact": each}} for each in ("stand", "deflect")],
    "parameters": [
        {"decision": {"strategy": "quiet-census", "parameters": each}} for each in ({}, {"quiet": 50.0})
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
    tables = {
        RobotClass: ROBOTS,
        TaskClass: TASKS,
        Event: {**EVENT, **NAMED, "robot": 1},
        Declare: RULE,
    }
    assert all(set(section.model_fields) == set(table) for section, table in tables.items())
