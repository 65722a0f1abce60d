"""Scenarios: the paper's by default, whole in TOML, frozen, and every problem told at once."""

from __future__ import annotations

import copy
import json
import math
import pickle
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from pydantic import ValidationError

from feasibee import FeasibeeError, Scenario, ScenarioError
from feasibee.errors import UnknownFieldError
from feasibee.model.codes import MODEL_VERSION
from feasibee.scenario.fields import Arena, Decision, Radio, Robots, Run, Sensing, Tasks
from feasibee.scenario.tables import hash_of
from tests.other_values import NEEDS, OTHER_VALUES

PLACED = {"placement": "uniform", "clusters": 3, "spread": 1.5}
PAPER = {
    "arena": {"side": 20.0, "boundary": "torus"},
    "place": {"cell": 0.1},
    "robots": {
        **PLACED,
        "count": 20,
        "speed": 1.0,
        "diameter": 1.0,
        "avoid_collisions": False,
        "contact": "stand",
        "know_count": False,
        "away": "counted",
    },
    "tasks": {**PLACED, "count": 20},
    "walk": {"mean_run": 10.0},
    "sensing": {
        "range": 2.0,
        "observation": "repeated",
        "count_self": False,
        "miss": 0.0,
        "false_robots": 0.0,
        "false_tasks": 0.0,
        "misname": 0.0,
        "position_error": 0.0,
        "view": 360.0,
    },
    "radio": {"range": 2.0, "loss": 0.0, "delay": 0, "walls": 0.0},
    "decision": {
        "strategy": "dmmd",
        "exploration": 10.0,
        "gain": 10.0,
        "dissemination_floor": 0,
        "quality_floor": 0,
        "listen": "always",
        "inbox": "latest-per-robot",
        "own_vote": True,
        "ties": "keep",
        "start": "coin",
        "threshold": 0.9,
    },
    "faults": {
        "stopped": 0.0,
        "stop_step": 0,
        "byzantine": 0.0,
        "byzantine_says": "opposite",
        "stubborn": 0.0,
    },
    "run": {
        "steps": 1000,
        "stop_at_decision": False,
        "stop_at_declarations": False,
        "stop_when_taken": False,
    },
    "acting": {
        "choose": "nearest",
        "hold": "stand",
        "reach": 1.0,
    },
    "units": {},
}
"""The names and defaults of issues 2 to 4, on which other tools rely."""

ALONE = {path: value for path, value in OTHER_VALUES.items() if path not in NEEDS and "classes" not in path}
"""Values that are valid by themselves, and change nothing else."""
PATHS = [f"{name}.{key}" for name, table in PAPER.items() for key in table if f"{name}.{key}" in ALONE]


def at(tables, path):
    section, key = path.split(".")
    return tables[section][key]


def table_of(path, value):
    section, key = path.split(".")
    return {section: {key: value}}


def problems_of(tables):
    with pytest.raises(ScenarioError) as caught:
        Scenario(**tables)
    return caught.value.problems


# --- The paper's, and the complete form ---


def test_the_defaults_are_the_papers_to_the_type():
    assert json.dumps(Scenario().to_dict()) == json.dumps(PAPER)


def test_the_papers_values_written_out_are_the_default_scenario():
    written = Scenario(**PAPER)
    assert written == Scenario()
    assert written.hash == Scenario().hash


@given(st.floats(20, 1e6), st.floats(1e-9, 0.2), st.sets(st.sampled_from(PATHS)))
def test_toml_brings_back_an_equal_scenario(side, share, others):
    changes = {path: ALONE[path] for path in others}
    changes |= {"arena.side": side, "robots.speed": side * share, "walk.mean_run": share}
    scenario = Scenario().replace(changes)
    again = Scenario.from_toml(scenario.to_toml())
    assert (again, again.hash) == (scenario, scenario.hash)
    assert json.dumps(again.to_dict()) == json.dumps(scenario.to_dict())
    assert {path: at(scenario.to_dict(), path) for path in changes} == changes


def test_a_scenario_is_read_from_its_file(tmp_path):
    path = tmp_path / "écho.toml"
    path.write_text('[tasks]\ncount = 7  # sept "tâches"\n', encoding="utf-8")
    assert Scenario.read(path) == Scenario.read(str(path)) == Scenario(tasks={"count": 7})


# --- The hash ---


def test_every_field_changes_the_hash():
    others = {path: value for path, value in OTHER_VALUES.items() if not path.startswith("units.")}
    hashes = {Scenario().replace({**NEEDS.get(path, {}), path: others[path]}).hash for path in others}
    assert len(hashes | {Scenario().hash}) == len(others) + 1
    assert all(re.fullmatch("[0-9a-f]{64}", text) for text in hashes)


def test_a_short_text_has_the_hash_of_its_complete_form():
    short = Scenario.from_toml("[sensing]\nrange = 3")
    assert Scenario.from_toml(short.to_toml()).hash == short.hash
    assert Scenario.from_toml("[radio]\nrange = 3.0\n[sensing]\nrange = 3.0\n").hash == short.hash


def test_the_hash_is_that_of_what_differs_from_the_defaults_and_of_the_models_version(monkeypatch):
    """So a new field whose default changes nothing keeps all hashes."""
    scenario = Scenario(tasks={"count": 7}, faults={"stubborn": {"count": 1}})
    differing = {"radio": {"range": 2.0}, "tasks": {"count": 7}, "faults": {"stubborn": {"count": 1}}}
    assert hash_of(differing) == hash_of(scenario.to_dict()) == scenario.hash
    monkeypatch.setattr("feasibee.scenario.tables.MODEL_VERSION", MODEL_VERSION + 1)
    assert hash_of(differing) != scenario.hash


@pytest.mark.parametrize(("path", "one", "other"), [("arena.side", 20, 20.0), ("robots.speed", -0.0, 0.0)])
def test_a_number_that_is_written_otherwise_is_the_same_scenario(path, one, other):
    first, second = Scenario().replace({path: one}), Scenario().replace({path: other})
    assert (first, first.hash, first.to_toml()) == (second, second.hash, second.to_toml())


def test_the_hash_is_computed_once(monkeypatch):
    computed = []
    monkeypatch.setattr(
        "feasibee.scenario.scenario.hash_of", lambda *given: computed.append(given) or str(len(computed))
    )
    scenario = Scenario(tasks={"count": 7})
    assert [scenario.hash, scenario.hash, hash(scenario)] == ["1", "1", hash("1")]
    assert len(computed) == 1


def test_a_computed_hash_is_no_part_of_the_scenario():
    fresh, hashed = Scenario(tasks={"count": 7}), Scenario(tasks={"count": 7})
    before = hashed.model_dump(), dict(hashed), repr(hashed), pickle.dumps(hashed)
    assert hashed.hash
    assert hashed == fresh
    assert fresh == hashed
    assert before == (hashed.model_dump(), dict(hashed), repr(hashed), pickle.dumps(hashed))


def test_copies_are_equal_and_have_the_right_hash_also_those_of_a_hashed_scenario():
    scenario, other = Scenario(sensing={"range": 3.0}), Scenario(sensing={"range": 3.0}, tasks={"count": 7})

    def copies():
        return [
            Scenario.model_validate_json(scenario.model_dump_json()),
            Scenario.model_validate(scenario),
            copy.copy(scenario),
            copy.deepcopy(scenario),
            scenario.model_copy(),
            scenario.with_trust(),
            pickle.loads(pickle.dumps(scenario)),
            scenario.replace({}),
        ]

    same = copies()
    assert scenario.hash != other.hash
    same += copies()
    assert all(each == scenario and each.hash == scenario.hash for each in same)
    assert scenario.model_copy(update={"tasks": other.tasks}).hash == other.hash
    assert scenario.replace({"tasks.count": 7}).hash == other.hash


# --- Fields by their paths ---


def test_get_returns_the_value_of_every_field():
    scenario = Scenario()
    assert {path: scenario.get(path) for path in PATHS} == {path: at(PAPER, path) for path in PATHS}
    assert not any(scenario.get(path) for path in ALONE.keys() - set(PATHS))
    for path in PATHS:
        assert Scenario(**table_of(path, ALONE[path])).get(path) == ALONE[path], path


def test_get_finds_sections_classes_and_tables():
    classes = [{"name": "arm", "count": 3, "skills": ["lift"]}]
    needs = [{"name": "carry", "count": 1, "needs": {"lift": 2}}]
    scenario = Scenario(robots={"classes": classes}, tasks={"classes": needs})
    assert scenario.get("tasks") is scenario.tasks
    assert scenario.get("robots.classes.0.skills.0") == "lift"
    assert scenario.get("tasks.classes.0.needs.lift") == 2


@pytest.mark.parametrize(
    ("path", "remedy"),
    [
        ("tasks.cuont", "did you mean tasks.count?"),
        ("hash", "the sections are arena, "),
        ("tasks.model_fields", "the fields of [tasks] are placement, "),
        ("robots.k0", "the fields of [robots] are placement, "),
        ("robots.range", "did you mean sensing.range or radio.range?"),
        ("strategy", "did you mean decision.strategy?"),
        ("robotss.count", "did you mean robots.count?"),
        ("robots.classes.0.count", "did you mean robots.classes?"),
        ("robots.count.real", "did you mean robots.count?"),
        ("", "the sections are arena, "),
        (3, "the sections are arena, "),
    ],
)
def test_get_names_a_field_that_there_is(path, remedy):
    with pytest.raises(UnknownFieldError) as caught:
        Scenario().get(path)
    assert str(caught.value).startswith(f"{path!r}: isn't the path of a field; {remedy}")
    assert isinstance(caught.value, LookupError)


# --- Defaults that depend, and changes ---


def test_an_unset_radio_reaches_as_far_as_the_sensor_and_one_that_was_set_stays():
    for unset in (Scenario(tasks={"count": 4}), Scenario(radio=Radio()), Scenario.from_toml("[radio]\n")):
        first = unset.replace({"sensing.range": 3.0})
        second = first.replace({"sensing.range": 4.0})
        assert (first.radio.range, second.radio.range, second.tasks) == (3.0, 4.0, unset.tasks)
    assert Scenario(sensing=Sensing(range=3.0), radio=Radio()).radio.range == 3.0
    assert Scenario.from_toml("[sensing]\nrange = 3.0\n[radio]\n").radio.range == 3.0
    for there in (Scenario(radio={"range": 2.0}), Scenario().replace({"radio.range": 5.0})):
        assert there.sensing.range == 2.0
        assert there.replace({"sensing.range": 3.0}).radio == there.radio


@pytest.mark.parametrize(("path", "value"), ALONE.items())
def test_replace_changes_one_field_and_leaves_the_original(path, value):
    original = Scenario()
    changed = original.replace({path: value}).to_dict()
    assert original.to_dict() == PAPER
    expected = {name: dict(table) for name, table in PAPER.items()}
    expected.setdefault(path.split(".")[0], {})[path.split(".")[1]] = value
    if path == "sensing.range":
        expected["radio"]["range"] = value
    assert changed == expected


def test_replace_tells_all_problems_of_the_new_values():
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace({"walk": 5, "tasks.cuont": 3, "robots.count": 0, "sensing.range": 30.0})
    paths = sorted(problem.path for problem in caught.value.problems)
    assert paths == ["robots.count", "sensing.range", "tasks.cuont", "walk"]


def test_sections_may_be_given_as_objects():
    scenario = Scenario(tasks=Tasks(count=50), arena=Arena(side=30.0))
    assert scenario == Scenario(tasks={"count": 50}, arena={"side": 30.0})


# --- Frozen ---


def test_nothing_can_be_changed_afterwards():
    scenario = Scenario()
    with pytest.raises(ValidationError, match="frozen"):
        scenario.tasks = Tasks(count=3)
    with pytest.raises(ValidationError, match="frozen"):
        del scenario.tasks
    for path in PATHS:
        section, key = path.split(".")
        with pytest.raises(ValidationError, match="frozen"):
            setattr(getattr(scenario, section), key, at(PAPER, path))
    assert scenario.to_dict() == PAPER


# --- What is wrong, where, and what to do ---

WRONG = [
    # path, value, words of the rule, words of the remedy
    ("arena.side", 0.0, "> 0", "20.0"),
    ("arena.side", math.inf, "1000000", "20.0"),
    ("arena.side", [3.0], "[width, height]", "20.0"),
    ("arena.side", [3.0, 0.0], "[width, height]", "20.0"),
    ("arena.side", [True, 1.0], "[width, height]", "20.0"),
    ("arena.side", 2e6, "1000000", "20.0"),
    ("arena.side", "20", "numbers", "20.0"),
    ("arena.boundary", "wall", "'torus' or 'walls'", "torus"),
    ("robots.count", 0, "≥ 1", "20"),
    ("robots.count", 1_000_001, "1000000", "20"),
    ("robots.count", True, "whole number", "20"),
    ("robots.count", 20.0, "whole number", "20"),
    ("robots.count", "20", "whole number", "20"),
    ("robots.count", None, "whole number", "20"),
    ("robots.speed", -0.1, "≥ 0", "1.0"),
    ("tasks.count", -1, "≥ 0", "20"),
    ("tasks.count", 10_000_001, "10000000", "20"),
    ("walk.mean_run", 0.0, "> 0", "10.0"),
    ("walk.mean_run", -math.inf, "finite", "10.0"),
    ("sensing.range", 0.0, "> 0", "2.0"),
    ("sensing.observation", "once", "'repeated' or 'unique'", "repeated"),
    ("sensing.memory", "life", "unknown key", "each exploration counts anew"),
    ("sensing.miss", 1.1, "≤ 1", "0.0"),
    ("sensing.false_robots", 51.0, "≤ 50", "0.0"),
    ("sensing.false_tasks", -1.0, "≥ 0", "0.0"),
    ("radio.loss", 1.1, "≤ 1", "0.0"),
    ("faults.stopped", 1.1, "< 1", "{count = 1}"),
    ("faults.byzantine", -0.1, "≥ 0", "{count = 1}"),
    ("faults.stubborn", "all", "number", "{count = 1}"),
    ("faults.stop_step", -1, "≥ 0", "0"),
    ("faults.byzantine_says", "lies", "'opposite'", "opposite"),
    ("robots.diameter", 0.0, "> 0", "1.0"),
    ("robots.avoid_collisions", 1, "true or false", "false"),
    ("robots.placement", "middle", "'clusters'", "uniform"),
    ("tasks.clusters", 0, "≥ 1", "3"),
    ("robots.clusters", 1001, "1000", "3"),
    ("tasks.spread", 0.0, "> 0", "1.5"),
    ("robots.spread", -1.0, "> 0", "1.5"),
    ("sensing.count_self", 1, "true or false", "false"),
    ("radio.range", -2.0, "> 0", "default"),
    ("radio.range", "far", "number", "default"),
    ("decision.strategy", "dmdm", "one of dmmd, dmvd, dc, voter, majority, k-unanimity,", "dmmd"),
    ("decision.strategy", "none.py", "can't be read", "dmmd"),
    ("decision.strategy", 5, "string", "dmmd"),
    ("decision.parameters", 5, "table", "[decision.parameters]"),
    ("decision.dissemination_floor", -1, "≥ 0", "0"),
    ("decision.quality_floor", -1, "≥ 0", "0"),
    ("decision.inbox_size", 0, "≥ 1", "default"),
    ("decision.declare", True, "table", "[decision.declare]"),
    ("radio.id_bits", 0, "≥ 1", "default"),
    ("radio.id_bits", 33, "≤ 32", "default"),
    ("decision.listen", {"last": 0}, "{last = 3}", "always"),
    ("decision.listen", {"last": True}, "{last = 3}", "always"),
    ("decision.listen", {"first": 3}, "{last = 3}", "always"),
    ("decision.listen", {"last": 3, "first": 3}, "{last = 3}", "always"),
    ("decision.listen", 3, "{last = 3}", "always"),
    ("decision.exploration", 0.0, "> 0", "10.0"),
    ("decision.gain", -1.0, "> 0", "10.0"),
    ("decision.listen", "never", "'always', 'dissemination', or {last = 3}", "always"),
    ("decision.inbox", "latest", "'latest-per-robot' or 'every-message'", "latest-per-robot"),
    ("decision.threshold", 0.49, "≥ 0.5", "0.9"),
    ("decision.threshold", 1.0, "< 1", "0.9"),
    ("run.steps", 0, "≥ 1", "1000"),
    ("tasks.cuont", 5, "unknown key", "did you mean tasks.count?"),
    ("decision.treshold", 0.9, "unknown key", "did you mean decision.threshold?"),
    ("walk.zzz", 1.0, "unknown key", "mean_run"),
]


@pytest.mark.parametrize(("path", "value", "rule", "remedy"), WRONG)
def test_a_wrong_value_is_told_with_path_value_rule_and_remedy(path, value, rule, remedy):
    (problem,) = problems_of(table_of(path, value))
    assert problem.path == path
    assert problem.value == value
    assert type(problem.value) is type(value)
    assert rule in problem.rule
    assert remedy in problem.remedy
    assert str(problem) == f"{path} = {value!r}: {problem.rule}; {problem.remedy}"


@pytest.mark.parametrize("path", [path for path in PATHS if isinstance(at(PAPER, path), float)])
def test_nan_is_refused_everywhere(path):
    (problem,) = problems_of(table_of(path, math.nan))
    assert problem.path == path
    assert math.isnan(problem.value)
    assert "finite" in problem.rule or path == "arena.side"


@pytest.mark.parametrize("given_", [[1], "text", 5, None])
def test_what_is_no_scenario_at_all_is_told(given_):
    with pytest.raises(ScenarioError, match="table of sections"):
        Scenario.model_validate(given_)


EVERYTHING_WRONG = """
extra = 1
run = 5
[arena]
side = -1.0
[robots]
count = 0
sped = 1.0
[tasks]
count = "5"
[sensing]
range = nan
[radio]
range = 11.0
[decision]
threshold = 0.49
own_vote = 1
listen = "never"
gain = inf
"""


def test_all_problems_are_told_at_once_with_their_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(EVERYTHING_WRONG)
    with pytest.raises(ScenarioError) as caught:
        Scenario.read(path)
    assert caught.value.source == str(path)
    problems = caught.value.problems
    assert sorted(problem.path for problem in problems) == [
        "arena.side",
        "decision.gain",
        "decision.listen",
        "decision.own_vote",
        "decision.threshold",
        "extra",
        "robots.count",
        "robots.sped",
        "run",
        "sensing.range",
        "tasks.count",
    ]
    assert all(problem.rule and problem.remedy for problem in problems)
    lines = str(caught.value).splitlines()
    assert lines == [f"{path}: {problem}" for problem in problems]


@given(
    st.dictionaries(
        st.sampled_from([*PAPER, "extra"]),
        st.dictionaries(
            st.sampled_from(["count", "range", "side", "speed", "listen", "threshold", "x y"]),
            st.one_of(
                st.none(),
                st.booleans(),
                st.integers(),
                st.floats(),
                st.text(),
                st.lists(st.integers(), max_size=2),
                st.dictionaries(st.text(), st.integers(), max_size=2),
            ),
        )
        | st.none()
        | st.integers()
        | st.text(),
    )
)
def test_whatever_is_given_is_a_scenario_or_a_scenario_error(given_tables):
    scenario, problems = None, ()
    try:
        scenario = Scenario(**given_tables)
    except ScenarioError as error:
        problems = error.problems
    assert (scenario is None) == bool(problems)
    assert len({problem.path for problem in problems}) == len(problems)
    if scenario is not None:
        assert Scenario.from_toml(scenario.to_toml()) == scenario


# --- Beyond the paper: what is wrong, with classes, points, discs and faults ---

LIFTERS = {"name": "a", "count": 4, "skills": ["lift"]}
HEAPS = {"name": "x", "count": 3, "needs": {"lift": 2, "scan": 1}}


def told(tables):
    """Return all problems as lines."""
    return "\n".join(str(problem) for problem in problems_of(tables))


BEYOND_WRONG = [
    ({"taks": {"count": 5}}, ["taks = {'count': 5}: unknown key; did you mean tasks?"]),
    ({"zzz": 1}, ["zzz = 1: unknown key; the sections are " + ", ".join([*PAPER, "and events"])]),
    *(
        ({"tasks": value}, [f"tasks = {value!r}: must be a table; write [tasks] and its fields below"])
        for value in (5, "five", None, [1], True)
    ),
    ({"events": [{"step": -1, "tasks": 1}]}, ["events.0.step = -1: must be ≥ 0"]),
    ({"events": [{"tasks": 1}]}, ["events.0.step = {'tasks': 1}: is missing"]),
    ({"events": [{"step": 5, "job": 3}]}, ["events.0.job = 3: unknown key; the fields of an event are "]),
    ({"events": [{"step": 5, "radio": {"miss": 0.1}}]}, ["events.0.radio.miss = 0.1: unknown key"]),
    ({"events": [{"step": 5, "radio": {"loss": 1.5}}]}, ["events.0.radio.loss = 1.5: must be ≤ 1"]),
    ({"events": 3}, ["events = 3: "]),
    ({"events": [3]}, ["events.0 = 3: must be a table"]),
    ({"robots": {"failure_rate": -0.1}}, ["robots.failure_rate = -0.1: must be ≥ 0"]),
    ({"robots": {"failure_rate": 1e-12}}, ["robots.failure_rate = 1e-12: "]),
    ({"robots": {"arrival_rate": 11.0}}, ["robots.arrival_rate = 11.0: must be ≤ 10"]),
    ({"tasks": {"lifetime": 0.0}}, ["tasks.lifetime = 0.0: must be > 0"]),
    ({"tasks": Robots(count=3)}, ["tasks = "]),
    # a range that only the default radio shares is one problem
    ({"sensing": {"range": 11.0}}, ["sensing.range = 11.0: must be at most half"]),
    ({"sensing": {"range": 11.0}, "radio": {"range": 12.0}}, ["sensing.range = 11.0", "radio.range = 12.0"]),
    ({"arena": {"side": 3.0}}, ["sensing.range = 2.0: must be at most half the side of the torus, 1.5"]),
    ({"decision": {"declare": {"quorum": 1.5}}}, ["decision.declare.quorum = 1.5: must be ≤ 1"]),
    ({"decision": {"declare": {"quorum": 0.1234567891}}}, ["decision.declare.quorum = 0.12345"]),
    ({"decision": {"declare": {"rounds": 0}}}, ["decision.declare.rounds = 0: must be ≥ 1"]),
    ({"decision": {"declare": {"heard": 0}}}, ["decision.declare.heard = 0: must be ≥ 1"]),
    ({"preset": "valentini"}, ["preset = 'valentini': must be 'valentini-2016', 'minimize-surprise', 'r"]),
    ({"preset": "minimize-surprise", "decision": 5}, ["decision = 5: must be a table; write [decision]"]),
    ({"decision": {"parameters": {"k": "x"}}}, ["decision.parameters.k = 'x': must be a number"]),
    ({"decision": {"strategy": "census", "quality_floor": -1}}, ["decision.quality_floor = -1: must be ≥ 0"]),
    (
        {"tasks": {"classes": [{**HEAPS, "needs": {"lift": 0}}]}},
        ["tasks.classes.0.needs.lift = 0: must be ≥ 1"],
    ),
    ({"tasks": {"classes": [{**HEAPS, "needs": {}}]}}, ["tasks.classes.0.needs = {}: "]),
    (
        {"tasks": {"classes": [{}]}},
        [
            f"tasks.classes.0.{key} = {{}}: is missing; add {key} to this table"
            for key in ("name", "count", "needs")
        ],
    ),
    ({"tasks": {"classes": 5}}, ["tasks.classes = 5: "]),
    ({"robots": {"classes": [5]}}, ["robots.classes.0 = 5: must be a table"]),
    (
        {"robots": {"classes": [{**LIFTERS, "count": "4"}]}},
        ["robots.classes.0.count = '4': must be a whole number"],
    ),
    ({"robots": {"classes": [{**LIFTERS, "count": -4}]}}, ["robots.classes.0.count = -4: must be ≥ 0"]),
    ({"robots": {"classes": [{**LIFTERS, "name": str(k)} for k in range(17)]}}, ["robots.classes = "]),
    ({"tasks": {"classes": [{**HEAPS, "name": str(k)} for k in range(17)]}}, ["tasks.classes = "]),
    ({"tasks": {"points": [[1, 2, 3]]}}, ["tasks.points = [[1, 2, 3]]: must be the name"]),
    ({"tasks": {"points": [[True, 2]]}}, ["tasks.points = [[True, 2]]: must be the name"]),
    (
        {
            "tasks": {"classes": [{**HEAPS, "needs": {"lift": 0}}], "spread": -1.0},
            "robots": {"count": 3, "classes": [LIFTERS]},
            "faults": {"stopped": 0.7, "stubborn": 0.7},
            "radio": {"loss": 2.0},
        },
        [
            "tasks.classes.0.needs.lift",
            "tasks.spread",
            "robots.count = 3",
            "faults = '6 robots'",
            "radio.loss = 2.0",
        ],
    ),
]


@pytest.mark.parametrize(("tables_", "lines"), BEYOND_WRONG)
def test_what_is_wrong_beyond_the_paper_is_all_told(tables_, lines):
    text = told(tables_)
    assert len(text.splitlines()) == len(lines), text
    assert all(any(each.startswith(line) for each in text.splitlines()) for line in lines), text
    assert all(problem.rule and problem.remedy for problem in problems_of(tables_))


def test_classes_make_the_counts():
    mixed = Scenario(robots={"classes": [LIFTERS, {"name": "b", "count": 7}]}, tasks={"classes": [HEAPS]})
    assert (mixed.robots.count, mixed.tasks.count) == (11, 3)


MIXED = {
    "arena": {"side": [30, 12.5], "boundary": "walls"},
    "robots": {"classes": [LIFTERS, {"name": "b", "count": 1}], "placement": "clusters"},
    "tasks": {"classes": [HEAPS], "placement": "points", "points": [[1, 2.5], [3.0, 4.0], [30.0, 12.5]]},
}


def test_toml_brings_back_classes_and_points():
    scenario = Scenario(**MIXED)
    again = Scenario.from_toml(scenario.to_toml())
    assert again == scenario
    assert again.hash == scenario.hash
    assert again.to_toml() == scenario.to_toml()
    assert Scenario.model_validate_json(scenario.model_dump_json(exclude_unset=True)) == scenario


def test_points_are_read_from_the_scenarios_folder(tmp_path, monkeypatch):
    """The complete form holds the points themselves, so that it runs anywhere."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "sites.csv").write_text("x,y\n1,2\n\n 3.5 , 4\n")
    (tmp_path / "mine" / "field.toml").write_text('[tasks]\nplacement = "points"\npoints = "sites.csv"\n')
    monkeypatch.chdir(tmp_path)
    scenario = Scenario.read("mine/field.toml")
    assert scenario.tasks.points == ((1.0, 2.0), (3.5, 4.0))
    assert scenario.tasks.count == 2
    assert scenario.hash == Scenario(tasks={"placement": "points", "points": [[1, 2], [3.5, 4]]}).hash
    assert Scenario.from_toml(scenario.to_toml()) == scenario


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (
            "x,y\n1,2\n1\n1,2,3\nnan,1\na,b\n4,5\n",
            [f"tasks.points = 'sites.csv': line {number} must be two numbers" for number in (3, 4, 5, 6)],
        ),
        ("x,y\n1,2\n\n30,4\n", ["tasks.points = (30.0, 4.0): sites.csv, line 4: must be inside the arena"]),
        (None, ["tasks.points = 'sites.csv': can't be read: No such file"]),
    ],
)
def test_what_is_wrong_with_a_csv_is_all_told_by_line(tmp_path, monkeypatch, text, lines):
    monkeypatch.chdir(tmp_path)
    if text is not None:
        Path("sites.csv").write_text(text)
    found = told({"tasks": {"placement": "points", "points": "sites.csv"}}).splitlines()
    assert len(found) == len(lines)
    assert all(line.startswith(start) for line, start in zip(found, lines, strict=True)), found


# --- Strategies, their parameters, commitment, and the field's presets ---

CLASSES = {"classes": [LIFTERS, {"name": "b", "count": 7}]}


@pytest.mark.parametrize(
    "tables_",
    [
        {"decision": {"strategy": "census"}, "radio": {"id_bits": 8}},
        {"decision": {"strategy": "tally"}, "radio": {"id_bits": 8}, "robots": CLASSES},
        {"decision": {"strategy": "tally"}, "sensing": {"false_robots": 0.5}},
        {"decision": {"strategy": "k-unanimity", "inbox": "every-message"}},
        {"decision": {"strategy": "dc", "quality_floor": 1, "inbox_size": 3}},
        {"decision": {"strategy": "tally"}, "robots": {"count": 16_000}},
    ],
)
def test_what_strategies_have_a_use_for_is_not_refused(tables_):
    assert Scenario(**tables_).strategy.name == tables_["decision"]["strategy"]


def test_parameters_have_the_strategys_order_and_defaults():
    """So that the functions find them by their place."""
    turned = {"positive_feedback": 0, "credence": 0.9}
    scenario = Scenario(decision={"strategy": "bayes", "parameters": turned})
    assert list(scenario.decision.parameters.items()) == [("credence", 0.9), ("positive_feedback", 0.0)]
    whole = Scenario(decision={"strategy": "bayes"})
    assert whole.decision.parameters == {"credence": 0.95, "positive_feedback": 1.0}
    assert whole.replace({"decision.strategy": "dmmd"}).decision.parameters == {}
    assert tomllib.loads(whole.to_toml())["decision"]["parameters"] == whole.decision.parameters
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    written = Scenario(decision={"strategy": "bayes", "parameters": dict(whole.decision.parameters)})
    assert (written, written.hash) == (whole, whole.hash)


def test_declaring_has_defaults_and_comes_back_from_toml():
    scenario = Scenario(decision={"declare": {}, "listen": {"last": 3}})
    declare = scenario.decision.declare
    assert (declare.quorum, declare.rounds, declare.heard) == (0.9, 3, 3)
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert Scenario.from_toml("[decision]\nlisten = {last = 3}\n[decision.declare]\n") == scenario


LONG = {"decision.exploration": 100.0, "decision.gain": 100.0, "run.steps": 10_000}
WINDOW = {**LONG, "decision.dissemination_floor": 30, "decision.listen": {"last": 30}}
BRIEF = {"decision.gain": 0.001, "decision.own_vote": False, "run.steps": 10_000}
PRESETS = {  # model.md 7, at ten ticks a second: 10 s are 100 steps, 3 s are 30
    "valentini-2016": {**WINDOW, "decision.inbox_size": 2},
    "minimize-surprise": {**WINDOW, "decision.inbox_size": 4},
    "ros2swarm-majority": {
        **BRIEF,
        "decision.strategy": "majority",
        "decision.exploration": 49.0,
        "decision.ties": "random-message",
    },
    "ros2swarm-voter": {**BRIEF, "decision.strategy": "voter", "decision.exploration": 19.0},
    "first-sight": {"decision.start": "first-sight"},
}


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_what_that_controller_does_and_the_paper_elsewhere(name):
    scenario = Scenario(preset=name)
    assert scenario == Scenario().replace(PRESETS[name])
    assert scenario.hash == Scenario().replace(PRESETS[name]).hash
    assert scenario.decision.inbox == "latest-per-robot"
    assert Scenario.from_toml(f'preset = "{name}"') == scenario
    again = Scenario.from_toml(scenario.to_toml())  # which holds the values, so that nobody needs the name
    assert (again, again.hash, "preset" in scenario.to_toml()) == (scenario, scenario.hash, False)
    assert len({scenario, again}) == 1


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_lies_under_what_is_given(name):
    given_tables = {"decision": {"gain": 7.0, "strategy": "dmvd"}, "tasks": {"count": 3}, "run": {"steps": 9}}
    changes = {f"{section}.{key}": v for section, table in given_tables.items() for key, v in table.items()}
    scenario = Scenario(preset=name, **given_tables)
    assert scenario == Scenario().replace({**PRESETS[name], **changes})
    sections = {"decision": Decision(gain=7.0, strategy="dmvd"), "tasks": Tasks(count=3), "run": Run(steps=9)}
    assert Scenario(preset=name, **sections) == scenario
    assert Scenario(preset=name).replace(changes) == scenario


# --- Changes deep inside ---


def test_replace_reaches_into_lists_and_tables():
    mixed = Scenario(**MIXED)
    changed = mixed.replace({"robots.classes.0.count": 9, "robots.classes.1.skills": ["scan"]})
    assert [each.count for each in changed.robots.classes] == [9, 1]
    assert changed.robots.classes[1].skills == ("scan",)
    assert changed.robots.count == 10
    assert mixed.robots.classes[0].count == 4
    assert mixed.replace({"tasks.classes.0.needs.push": 2}).tasks.classes[0].needs["push"] == 2
    moved = mixed.replace({"tasks.points.1": [5.0, 6.0]})
    assert moved.tasks.points == ((1.0, 2.5), (5.0, 6.0), (30.0, 12.5))


def test_replace_leaves_the_values_that_it_is_given():
    events = [{"step": 5, "tasks": 1}]
    assert Scenario().replace({"events": events, "events.0.tasks": 3}).events[0].tasks == 3
    assert events == [{"step": 5, "tasks": 1}]


def test_replace_makes_the_tables_on_its_way():
    declare = Scenario().replace({"decision.declare.quorum": 0.7}).decision.declare
    assert (declare.quorum, declare.rounds) == (0.7, 3)
    first = Scenario(decision={"declare": {"rounds": 5}})
    assert first.replace({"decision.declare.quorum": 0.7}).decision.declare.rounds == 5
    assert first.replace({"decision.declare": None}).decision.declare is None
    assert Scenario().replace({"decision.listen.last": 4}).decision.listen == {"last": 4}
    bayes = Scenario().replace({"decision.strategy": "bayes", "decision.parameters.credence": 0.8})
    assert bayes.decision.parameters == {"credence": 0.8, "positive_feedback": 1.0}


@pytest.mark.parametrize(
    ("path", "rule"),
    [
        ("robots.classes.7.count", "can't be set: robots.classes.7 is missing or has no such field"),
        ("robots.classes.x.count", "can't be set: robots.classes.x is missing or has no such field"),
        ("robots.classes.7", "can't be set: robots.classes is missing or has no such field"),
        ("arena.boundary.x", "can't be set: arena.boundary is missing or has no such field"),
        *(
            (path, "isn't the path of a field; write section.field, such as tasks.count")
            for path in ("robots..count", "robots.classes.", "tasks", "", "count", ".count", "tasks.")
        ),
        ("robots.classes.0.cuont", "unknown key; "),
        ("robots.classes.0.name", "must be a string; "),
        ("decision.declare.quorm", "unknown key; "),
        ("decision.declare.quorum", "must be ≤ 1; "),
    ],
)
def test_replace_tells_of_paths_that_lead_nowhere(path, rule):
    with pytest.raises(ScenarioError) as caught:
        Scenario(**MIXED).replace({path: 3})
    (problem,) = caught.value.problems
    assert (problem.path, problem.value) == (path, 3)
    assert f"{problem.rule}; {problem.remedy}".startswith(rule)


# --- Files and texts that are no scenario ---


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *(
            (text, r"not TOML: .*\((at line|at end)")
            for text in ("tasks", "[tasks\n", "a = 1\na = 2", "\x00")
        ),
        ("[tasks]\ncount = \n", r"not TOML: .*\(at line"),
        ("[tasks]\ncount = " + "1" * 5000, "not TOML: "),
        ("[tasks]\ncount = 0x" + "f" * 5000, "tasks.count = a number too long to print: "),
        ("a = " + "[" * 5000 + "]" * 5000, "nested too deeply; use at most 8 levels"),
        ('"a\\nb" = 1', r"a\\nb = 1: unknown key; "),
    ],
)
def test_what_is_no_scenario_is_told_in_a_line_with_its_source(text, words):
    with pytest.raises(FeasibeeError, match=rf"^mine\.toml: {words}") as caught:
        Scenario.from_toml(text, "mine.toml")
    assert len(str(caught.value).splitlines()) == 1


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(FeasibeeError, match=r"missing\.toml: can't be read: .*No such file"):
        Scenario.read(tmp_path / "missing.toml")


# --- The JSON Schema ---


def accepts(schema, value, root=None):
    whole = {**schema, "$defs": (root or schema)["$defs"]}
    return Draft202012Validator(whole).is_valid(json.loads(json.dumps(value)))


def field_schemas():
    schema = Scenario.model_json_schema()
    sections = {name: each for name, each in schema["properties"].items() if "$ref" in each}
    for section, reference in sections.items():
        for key, field in schema["$defs"][reference["$ref"].rpartition("/")[2]]["properties"].items():
            yield f"{section}.{key}", field


def test_the_schema_lists_every_field_with_its_default_and_meaning():
    fields = dict(field_schemas())
    assert [path for path in fields if path in PATHS] == PATHS
    assert fields.keys() == OTHER_VALUES.keys()
    for path, field in fields.items():
        assert len(field["description"]) > 10
        if path in PATHS and path != "radio.range":  # depends on another
            assert json.dumps(field["default"]) == json.dumps(at(PAPER, path))


def test_the_schema_accepts_the_complete_form_an_empty_one_and_its_own_defaults():
    schema = Scenario.model_json_schema()
    assert accepts(schema, Scenario().to_dict())
    assert accepts(schema, {})
    for path, field in field_schemas():
        assert "default" not in field or accepts(field, field["default"], schema), path
        assert all(accepts(field, example, schema) for example in field.get("examples", ())), path
    for name, section in schema["properties"].items():
        assert "default" not in section or accepts(section, section["default"], schema), name


def test_the_schema_refuses_what_a_single_field_must_not_be():
    schema = Scenario.model_json_schema()
    for path, value, *_ in WRONG:
        # Strategies are found among files and packages, and JSON has one kind of number.
        takes_more_to_see = (path == "decision.strategy" and value != 5) or value == 20.0
        assert accepts(schema, table_of(path, value)) == takes_more_to_see, (path, value)
    for path, value in OTHER_VALUES.items():
        assert accepts(schema, table_of(path, value)), (path, value)


def test_a_change_within_what_another_change_made_no_table_is_told():
    with pytest.raises(ScenarioError, match=r"is missing or has no such field"):
        Scenario().replace({"robots.classes": 2, "robots.classes.0.count": 3})


def test_numbers_of_an_array_are_numbers():
    import numpy as np

    plain = Scenario(robots={"count": 7, "avoid_collisions": True}, sensing={"range": 2.5})
    arrays = {"count": np.arange(8)[7], "avoid_collisions": np.bool_(True)}
    assert Scenario(robots=arrays, sensing={"range": np.float32(2.5)}) == plain
    assert Scenario().replace({"tasks.count": np.int64(50)}) == Scenario(tasks={"count": 50})
    with pytest.raises(ScenarioError, match="must be a whole number"):
        Scenario(robots={"count": np.float64(7.5)})


@pytest.mark.parametrize(
    ("robots", "bits"),
    [({"count": 1}, 1), ({"count": 20}, 5), ({"count": 20, "failure_rate": 0.1, "most": 40}, 6)],
)
def test_ids_take_a_bit_at_least_and_tell_all_robots_at_a_time_apart(robots, bits):
    assert Scenario(robots=robots).setting.id_bits == bits
