"""Any value in any field is a scenario, or problems with path, value, rule and a remedy that helps."""

from __future__ import annotations

import json
import math
from datetime import date, time

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from places import bitmap, random_cells, rectangle
from pydantic import ValidationError
from remedies import check_remedies, problems_of

from feasibee import Scenario, truth
from feasibee.base.errors import quoted
from feasibee.scenario.fields import SECTIONS, Event, fields
from feasibee.scenario.paths import with_changes
from tests.other_values import OTHER_VALUES

RANGES = {
    "> 0, ≤ 1000000": "arena.side place.cell robots.spread robots.diameter tasks.spread walk.mean_run "
    "sensing.range sensing.gate radio.range decision.exploration decision.gain acting.reach",
    "≥ 0, ≤ 1000000": "robots.speed sensing.position_error",
    "≥ 0, ≤ 10": "robots.arrival_rate robots.failure_rate tasks.arrival_rate",
    "> 0, ≤ 1000000000": "tasks.lifetime",
    "≥ 0, ≤ 1": "sensing.miss sensing.misname radio.loss radio.walls decision.declare.quorum "
    "events.sensing.miss events.radio.loss",
    "≥ 0, ≤ 50": "sensing.false_robots sensing.false_tasks",
    "> 0, ≤ 360": "sensing.view",
    "≥ 0.5, < 1": "decision.threshold",
    "≥ 0, < 1": "faults.stopped faults.byzantine faults.stubborn",
    "≥ 0.000000001, ≤ 1000000000": "units.metres units.seconds",
}
WHOLE_RANGES = {
    "≥ 1, ≤ 1000": "robots.clusters tasks.clusters",
    "≥ 1, ≤ 1000000": "robots.count robots.most decision.inbox_size decision.listen.last "
    "decision.declare.rounds decision.declare.heard",
    "≥ 0, ≤ 1000000": "decision.dissemination_floor decision.quality_floor faults.stubborn.count",
    "≥ 0, ≤ 10000000": "tasks.count",
    "≥ 1, ≤ 1000000000": "robots.work robots.charge tasks.work run.steps",
    "≥ 0, ≤ 1000000000": "faults.stop_step acting.start events.step",
    "≥ 0, ≤ 1000": "radio.delay",
    "≥ 1, ≤ 32": "radio.id_bits",
    "≥ -10000000, ≤ 10000000": "events.tasks",
    "≥ -1000000, ≤ 1000000": "events.robots",
    "≥ 0": "events.task events.robot",
}
BOUNDS = [
    (path, kind, bound)
    for kind, ranges in ((float, RANGES), (int, WHOLE_RANGES))
    for bounds, paths in ranges.items()
    for path in paths.split()
    for bound in bounds.split(", ")
]


def table_of(path, value):
    """Return the tables of a scenario with one value."""
    section, *way, key = path.split(".") if "." in path else (path, "")
    table = {key: value} if key else value
    for each in reversed(way):
        table = {each: table}
    return {section: [{"step": 1, **table}] if section == "events" and key else table}


def is_valid_alone(path, value):
    """Return whether a section accepts a value in one of its fields."""
    (name, table), *_ = table_of(path, value).items()
    try:
        Event.model_validate(table[0]) if name == "events" else SECTIONS[name].model_validate(table)
    except ValidationError:
        return False
    return True


@pytest.mark.parametrize(("path", "kind", "bound"), BOUNDS)
def test_the_edge_of_a_range_is_valid_and_what_is_just_beyond_it_is_an_error(path, kind, bound):
    sign, number = bound[0], kind(bound[2:])
    inside = 1 if sign in "≥>" else -1
    within, beyond = (
        number + way if kind is int else math.nextafter(number, way * math.inf) for way in (inside, -inside)
    )
    valid, invalid = (number, beyond) if sign in "≥≤" else (within, number)
    assert is_valid_alone(path, valid)
    assert not is_valid_alone(path, invalid)
    where = path.replace("events.", "events.0.")
    (problem,) = (each for each in problems_of(table_of(path, invalid)) if where.startswith(each.path))
    assert bound in problem.rule or path in ("acting.start", "decision.listen.last", "faults.stubborn.count")


def test_each_field_with_a_range_is_tried():
    """A new field needs a row above."""
    schema, ranged = Scenario.model_json_schema(), set()
    for name, section in SECTIONS.items():
        properties = schema["$defs"][section.__name__]["properties"]
        ranged |= {f"{name}.{key}" for key, each in properties.items() if "imum" in json.dumps(each)}
    assert ranged <= {".".join(path.split(".")[:2]) for path, *_ in BOUNDS}


VALUES = (
    *(None, True, -1, 0, 1, 7.5, 20.0, 1e-10, 5e-324, 10**400, math.nan, -math.inf),
    *(date(1979, 5, 27), time(7, 32)),
    *("", "nope", "20", "\x1b", "6 m", "6 s", "0 s", "6 feet", "-1e999 km/h", "x" * 50_000, b"x", object()),
    *([], [3.0], [3.0, 0.0], [True, 1.0], [[1, 2]], [[1, 2, 3]], [[True, 2]], [[[[[[]]]]]], [1] * 2000),
    *([5], [{"name": "a", "count": 1}], {}, {"last": 0}, {"last": True}, {"last": 3, "first": 3}),
    *({"count": -1}, {"k": "x"}, {"a": {"b": {"c": {}}}}),
)
"""Values of all kinds. Each is wrong for nearly every field."""


@pytest.mark.parametrize("path", [*fields(), *SECTIONS, "preset", "events", "extra", "tasks.cuont"])
def test_any_value_is_a_scenario_or_problems_whose_remedies_help(path):
    said = set()
    for value in VALUES:
        tables = table_of(path, value)
        problems = problems_of(tables)
        if not problems:
            scenario = Scenario(**tables)
            assert Scenario.from_toml(scenario.to_toml()) == scenario
        assert len({each.path for each in problems}) == len(problems)
        for problem in problems:
            assert str(problem).isprintable()
            if problem.path == path:
                assert (type(problem.value), quoted(problem.value)) == (type(value), quoted(value))
                assert str(problem).startswith(f"{path} = {quoted(value)}: ")
            if (problem.rule, problem.remedy) not in said:
                check_remedies(problem, tables)
            said.add((problem.rule, problem.remedy))


WALLS = {"arena.boundary": "walls"}
BOXES = [rectangle(3.0, 0.0, 3.3, 3.6), rectangle(0.0, 0.0, 4.0, 3.5), rectangle(1.0, 1.0, 1.7, 5.5)]
CELLS = [bitmap(random_cells(np.random.default_rng(n), n, n, 3), 1.0) for n in (4, 6, 7)]
POINTS = ([], [[3.5, 1.3]], [[3.5, 1.3], [2.0, 2.0], [9.9, 9.9]])
TOGETHER = {
    # what fits together at times
    "arena.side": (4.0, 6.0, 10.0),
    "place.cell": (0.25, 0.5, 1.0, 0.3, 1e-9),
    "place.walls": ([], BOXES[:1], BOXES[:2], [*BOXES[:1], rectangle(0.0, 0.0, 9.0, 9.0)]),
    "place.zones": ({}, {"dock": BOXES[2]}, {"dock": BOXES[1], "far": rectangle(8.0, 8.0, 9.0, 9.0)}),
    "place.map": (None, None, *CELLS),
    "place.keepout": (None, None, *CELLS),
    "robots.count": (1, 3, 7, 1000),
    "robots.diameter": (0.2, 0.5, 1.5, 7.0),
    "robots.speed": (0.0, 0.1, 1.0, 3.0, 1e5),
    "robots.zone": (None, "dock", "far"),
    "tasks.zone": (None, "dock", "far"),
    "robots.placement": ("uniform", "uniform", "points", "clusters"),
    "tasks.placement": ("uniform", "uniform", "points", "clusters"),
    "robots.points": POINTS,
    "tasks.points": POINTS,
    "decision.strategy": ("map", "roster", "quiet-census", "turns", "census", "dmmd"),
    "events": ([], [], [{"step": 5, "tasks": 1, "at": [3.1, 1.0]}]),
    "acting.start": (None, None, "search", "safe", "declared"),
    "sensing.range": (2.0, 0.01, 1e6),
}


@pytest.mark.parametrize("part", range(4))
def test_any_values_together_are_a_scenario_or_problems_whose_remedies_help(part):
    draw, outcomes, paths = np.random.default_rng(part), set(), set()
    for _ in range(40):
        others = draw.choice([*OTHER_VALUES], 3) if part else ()
        changes = {path: OTHER_VALUES[path] for path in others} | WALLS
        for path in draw.choice([*TOGETHER], draw.integers(3, len(TOGETHER)), replace=False):
            changes[path] = TOGETHER[path][draw.integers(len(TOGETHER[path]))]
        tables = with_changes({}, changes)[0]
        problems = problems_of(tables)
        paths |= {problem.path for problem in problems}
        outcomes.add(None if problems else truth(Scenario(**tables)))
        for problem in problems:
            check_remedies(problem, tables)
    assert None in outcomes
    assert len(outcomes) > 1
    assert len(paths) > 10


def test_wrong_values_of_all_fields_are_told_at_once():
    tables = {name: dict.fromkeys(section.model_fields, b"x") for name, section in SECTIONS.items()}
    assert sorted(each.path for each in problems_of(tables)) == sorted(fields())


def test_the_schema_accepts_what_a_scenario_does_and_only_files_and_units_in_addition():
    """JSON has one kind of number, so 20.0 is a whole one."""
    checker = Draft202012Validator(Scenario.model_json_schema())
    for path in fields():
        for value in (*VALUES, OTHER_VALUES[path]):
            try:
                table = json.loads(json.dumps(table_of(path, value), allow_nan=False))
            except (TypeError, ValueError):
                continue
            more = isinstance(value, str) or value in (20.0, 1e-10, 5e-324) or path.startswith("place.")
            assert checker.is_valid(table) in (is_valid_alone(path, value), more), (path, value)
