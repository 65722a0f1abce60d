"""Scenarios: the paper's by default, whole in TOML, frozen, and every problem told at once."""

from __future__ import annotations

import copy
import json
import pickle
import re
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from pydantic import ValidationError
from remedies import problems_of

from feasibee import FeasibeeError, Scenario, ScenarioError
from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import UnknownFieldError
from feasibee.scenario.fields import (
    Decision,
    Declare,
    Event,
    Radio,
    RobotClass,
    Robots,
    Run,
    Sensing,
    TaskClass,
)
from feasibee.scenario.tables import hash_of
from tests.other_values import NEEDS, OTHER_VALUES

PAPER_TEXT = Path(__file__).with_name("paper.toml").read_text(encoding="utf-8")
"""The complete form of the paper's scenario, on whose names and defaults other tools rely."""
PAPER = tomllib.loads(PAPER_TEXT)
ALONE = {path: value for path, value in OTHER_VALUES.items() if path not in NEEDS and "classes" not in path}
"""Values that are valid by themselves, and change nothing else."""
PATHS = [f"{name}.{key}" for name, table in PAPER.items() for key in table if f"{name}.{key}" in ALONE]


def at(tables, path):
    section, key = path.split(".")
    return tables[section][key]


def table_of(path, value):
    section, key = path.split(".")
    return {section: {key: value}}


# --- The paper's, and the complete form ---


def test_the_defaults_are_the_papers_to_the_type():
    assert Scenario().to_toml() == PAPER_TEXT.partition("\n")[2]
    assert json.dumps(Scenario().to_dict()) == json.dumps(PAPER)
    assert Scenario(**PAPER) == Scenario()


def test_a_scenario_is_read_from_its_file(tmp_path):
    path = tmp_path / "écho.toml"
    path.write_text('[tasks]\ncount = 7  # sept "tâches"\n', encoding="utf-8")
    assert Scenario.read(path) == Scenario.read(str(path)) == Scenario(tasks={"count": 7})


# --- The hash ---


LIFTERS = {"name": "a", "count": 4, "skills": ["lift"]}
HEAPS = {"name": "x", "count": 3, "needs": {"lift": 2, "scan": 1}}
NESTED = [
    # fields that hold lists and tables, and other values of what is within
    (
        {"robots.classes": [LIFTERS], "tasks.classes": [HEAPS]},
        {"robots.classes.0.name": "b", "robots.classes.0.count": 5, "robots.classes.0.skills": ["scan"]},
        {"tasks.classes.0.name": "y", "tasks.classes.0.count": 4, "tasks.classes.0.needs": {"lift": 1}},
    ),
    (
        {"decision.declare": {"quorum": 0.75, "rounds": 2, "heard": 1}},
        {"decision.declare.quorum": 0.7, "decision.declare.rounds": 1, "decision.declare.heard": 2},
    ),
    (
        {"events": [{"step": 50, "tasks": 3}, {"step": 50, "robots": 2}]},
        {"events.0.step": 51, "events.0.tasks": -3, "events.1.robots": 1, "events.0.at": [1.0, 2.0]},
        {"events.0.sensing.miss": 0.2, "events.0.radio.loss": 0.2, "events": [{"step": 50, "tasks": 3}]},
        {"events.1": {"step": 50, "robot": 1}, "events.0": {"step": 50, "task": 1}},
    ),
    (
        {"tasks.placement": "points", "tasks.points": [[1, 2], [3, 4]]},
        *({"tasks.points": points} for points in ([[3, 4], [1, 2]], [[1, 2], [3, 5]], [[1, 2]])),
    ),
]


def test_every_field_changes_the_hash_and_comes_back_from_toml():
    others = {path: value for path, value in OTHER_VALUES.items() if not path.startswith("units.")}
    scenarios = [Scenario().replace({**NEEDS.get(path, {}), path: others[path]}) for path in others]
    for base, *changes in NESTED:
        first = Scenario().replace(base)
        scenarios += [first, *(first.replace({path: each[path]}) for each in changes for path in each)]
    hashes = {each.hash for each in scenarios}
    assert len(hashes | {Scenario().hash}) == len(scenarios) + 1
    assert all(re.fullmatch("[0-9a-f]{64}", text) for text in hashes)
    for each in scenarios:
        again = Scenario.from_toml(each.to_toml())
        assert (again, again.hash, again.to_toml()) == (each, each.hash, each.to_toml())
        assert json.dumps(again.to_dict()) == json.dumps(each.to_dict())
        assert Scenario.model_validate_json(each.model_dump_json(exclude_unset=True)) == each


def test_all_fields_of_nested_tables_are_tried():
    """A new field needs another value above."""
    for kind in (RobotClass, TaskClass, Declare, Event):
        assert all(re.search(rf"\b{key}\b", str(NESTED)) for key in kind.model_fields)


def test_the_hash_is_that_of_what_differs_from_the_defaults_and_of_the_models_version(monkeypatch):
    """So a new field whose default changes nothing keeps all hashes."""
    scenario = Scenario(tasks={"count": 7}, faults={"stubborn": {"count": 1}})
    differing = {"radio": {"range": 2.0}, "tasks": {"count": 7}, "faults": {"stubborn": {"count": 1}}}
    assert hash_of(differing) == hash_of(scenario.to_dict()) == scenario.hash
    monkeypatch.setattr("feasibee.scenario.tables.MODEL_VERSION", MODEL_VERSION + 1)
    assert hash_of(differing) != scenario.hash


def test_a_scenario_that_is_written_otherwise_is_the_same():
    short = Scenario.from_toml("arena.side = 20\nrobots.speed = -0.0\nsensing.range = 3")
    long = Scenario.from_toml("arena.side = 20.0\nrobots.speed = 0.0\nradio.range = 3.0\nsensing.range = 3.0")
    assert (short.hash, short.to_toml()) == (long.hash, long.to_toml())


def test_the_hash_is_computed_once_and_no_part_of_the_scenario(monkeypatch):
    fresh, hashed, computed = Scenario(tasks={"count": 7}), Scenario(tasks={"count": 7}), []
    before = hashed.model_dump(), dict(hashed), repr(hashed), pickle.dumps(hashed)
    monkeypatch.setattr(
        "feasibee.scenario.scenario.hash_of", lambda *given: computed.append(given) or str(len(computed))
    )
    assert [hashed.hash, hashed.hash, hash(hashed)] == ["1", "1", hash("1")]
    assert len(computed) == 1
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
    scenario = Scenario(robots={"classes": [LIFTERS]}, tasks={"classes": [HEAPS]})
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
    wrong = {"walk": 5, "tasks.cuont": 3, "robots.count": 0, "sensing.range": 30.0}
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace(wrong)
    assert {problem.path for problem in caught.value.problems} == wrong.keys()


def test_nothing_can_be_changed_afterwards():
    scenario = Scenario()
    for part, name in ((scenario, "tasks"), (scenario.tasks, "count")):
        with pytest.raises(ValidationError, match="frozen"):
            setattr(part, name, 3)
    assert scenario.to_dict() == PAPER


# --- What is wrong, where, and what to do ---


@pytest.mark.parametrize("given_", [[1], "text", 5, None])
def test_what_is_no_scenario_at_all_is_told(given_):
    with pytest.raises(ScenarioError, match="table of sections"):
        Scenario.model_validate(given_)
    with pytest.raises(ScenarioError, match=r"tasks = .*: must be a table"):
        Scenario(tasks=given_ or Robots(count=3))


A, X = 'name = "a", count = 1', 'name = "x", count = 1'
WRONG = {
    # what isn't of one field alone: the texts of scenarios, and how the lines of their problems begin
    "taks.count = 5": ["taks = {'count': 5}: unknown key; did you mean tasks?"],
    "zzz = 1": [f"zzz = 1: unknown key; the sections are {', '.join([*PAPER, 'and events'])}"],
    "walk.zzz = 1": ["walk.zzz = 1: unknown key; the fields of [walk] are mean_run"],
    "decision.treshold = 0.9": ["decision.treshold = 0.9: unknown key; did you mean decision.threshold?"],
    "sensing.memory = 1": ['sensing.memory = 1: unknown key; leave it out: with observation "unique", each'],
    "tasks = 5": ["tasks = 5: must be a table; write [tasks] and its fields below"],
    "events = [3]": ["events.0 = 3: must be a table; such as { step = 500, tasks = 15 }"],
    "events = [{step = -1, tasks = 1}]": ["events.0.step = -1: must be ≥ 0; such as { step = 500, tasks"],
    "events = [{tasks = 1}]": ["events.0.step = {'tasks': 1}: is missing; add step to this table"],
    "events = [{step = 5, job = 3}]": ["events.0.job = 3: unknown key; the fields of an event are "],
    "events = [{step = 5, radio.mis = 1}]": ["events.0.radio.mis = 1: unknown key; the fields of events.0."],
    "events = [{step = 5, robot = -1}]": ["events.0.robot = -1: must be ≥ 0; such as { step = 500, robot"],
    "decision.declare.quorom = 1": ["decision.declare.quorom = 1: unknown key; did you mean decision.decl"],
    f"events = [{'{step = 5, tasks = 1}, ' * 1001}]": ["events = "],
    "robots.failure_rate = 1e-12": ["robots.failure_rate = 1e-12: must be 0, or at least 1e-9"],
    # a range that only the default radio shares is one problem
    "sensing.range = 11.0": ["sensing.range = 11.0: must be at most half"],
    "sensing.range = 11.0\nradio.range = 12.0": ["sensing.range = 11.0", "radio.range = 12.0"],
    "decision.declare.quorum = 0.1234567891": ["decision.declare.quorum = 0.1234567891: must have at most 9"],
    'preset = "minimize-surprise"\ndecision = 5': ["decision = 5: must be a table; write [decision]"],
    "decision.parameters.k = true": ["decision.parameters.k = True: must be a number"],
    'decision.strategy = "dmdm"': ["decision.strategy = 'dmdm': must be the path of a .py file, or one of "],
    'decision.strategy = "none.py"': ["decision.strategy = 'none.py': can't be read: No such file"],
    'decision = {strategy = "census", quality_floor = -1}': ["decision.quality_floor = -1: must be ≥ 0"],
    f"tasks.classes = [{{{X}, needs.lift = 0}}]": ["tasks.classes.0.needs.lift = 0: must be ≥ 1; such as"],
    f"tasks.classes = [{{{X}, needs.lift = 1001}}]": ["tasks.classes.0.needs.lift = 1001: must be ≤ 1000"],
    f"tasks.classes = [{{{X}, needs = {{}}}}]": ["tasks.classes.0.needs = {}: must name a skill"],
    "tasks.classes = [{}]": [f"tasks.classes.0.{key} = {{}}: is missing; add {key} to" for key in HEAPS],
    "robots.classes = [5]": ["robots.classes.0 = 5: must be a table"],
    'robots.classes = [{name = "", count = "4"}]': ["robots.classes.0.name = ", "robots.classes.0.count = "],
    f"robots.classes = [{f'{{{A}}}, ' * 17}]": ["robots.classes = "],
    f"tasks.classes = [{f'{{{X}, needs.lift = 1}}, ' * 17}]": ["tasks.classes = "],
    f"tasks = {{classes = [{{}}], spread = -1.0}}\nrobots = {{count = 3, classes = [{{{A}}}]}}\nx = 1": [
        *(f"tasks.classes.0.{key}" for key in HEAPS),
        *("tasks.spread = -1.0", "robots.count = 3", "x = 1: unknown key"),
    ],
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_all_told(text):
    with pytest.raises(ScenarioError) as caught:
        Scenario.from_toml(text)
    found = str(caught.value).splitlines()
    assert len(found) == len(WRONG[text]), found
    assert all(any(each.startswith(line) for each in found) for line in WRONG[text]), found


def test_problems_are_told_with_their_file(tmp_path):
    (path := tmp_path / "mine.toml").write_text("extra = 1\nrun = 5\ntasks.count = -1\n")
    with pytest.raises(ScenarioError) as caught:
        Scenario.read(path)
    assert caught.value.source == str(path)
    assert str(caught.value).splitlines() == [f"{path}: {problem}" for problem in caught.value.problems]
    assert len(caught.value.problems) == 3


MIXED = {
    "arena": {"side": [30, 12.5], "boundary": "walls"},
    "robots": {"classes": [LIFTERS, {"name": "b", "count": 1}], "placement": "clusters"},
    "tasks": {"classes": [HEAPS], "placement": "points", "points": [[1, 2.5], [3.0, 4.0], [30.0, 12.5]]},
}


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
            "x,y\n1,2\n1\n1,2,3\nnan,1\na,b\n4,5\nx,y\n",
            [f"tasks.points = 'sites.csv': line {number} must be two numbers" for number in (3, 4, 5, 6, 8)],
        ),
        ("x,y\n1,2\n\n30,4\n", ["tasks.points = (30.0, 4.0): sites.csv, line 4: must be inside the arena"]),
        (None, ["tasks.points = 'sites.csv': can't be read: No such file"]),
    ],
)
def test_what_is_wrong_with_a_csv_is_all_told_by_line(tmp_path, monkeypatch, text, lines):
    monkeypatch.chdir(tmp_path)
    if text is not None:
        Path("sites.csv").write_text(text)
    found = [str(each) for each in problems_of({"tasks": {"placement": "points", "points": "sites.csv"}})]
    assert len(found) == len(lines)
    assert all(line.startswith(start) for line, start in zip(found, lines, strict=True)), found


# --- Strategies, their parameters, commitment, and the field's presets ---


@pytest.mark.parametrize(
    ("strategy", "changes"),
    [
        ("census", {"radio.id_bits": 8}),
        ("tally", {"radio.id_bits": 8, "robots.classes": [LIFTERS]}),
        ("tally", {"sensing.false_robots": 0.5, "robots.count": 16_000}),
        ("k-unanimity", {"decision.inbox": "every-message"}),
        ("dc", {"decision.quality_floor": 1, "decision.inbox_size": 3}),
    ],
)
def test_what_strategies_have_a_use_for_is_not_refused(strategy, changes):
    assert Scenario().replace({"decision.strategy": strategy, **changes}).strategy.name == strategy


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


LONG = {"decision.exploration": 100.0, "decision.gain": 100.0, "run.steps": 10_000}
WINDOW = {**LONG, "decision.dissemination_floor": 30, "decision.listen": {"last": 30}}
BRIEF = {"decision.gain": 0.001, "decision.own_vote": False, "run.steps": 10_000}
MAJORITY = {"decision.strategy": "majority", "decision.ties": "random-message"}
PRESETS = {  # model.md 7, at ten ticks a second: 10 s are 100 steps, 3 s are 30
    "valentini-2016": {**WINDOW, "decision.inbox_size": 2},
    "minimize-surprise": {**WINDOW, "decision.inbox_size": 4},
    "ros2swarm-majority": {**BRIEF, **MAJORITY, "decision.exploration": 49.0},
    "ros2swarm-voter": {**BRIEF, "decision.strategy": "voter", "decision.exploration": 19.0},
    "first-sight": {"decision.start": "first-sight"},
}


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_what_that_controller_does_and_the_paper_elsewhere_under_what_is_given(name):
    scenario = Scenario(preset=name)
    assert scenario == Scenario().replace(PRESETS[name]) == Scenario.from_toml(f'preset = "{name}"')
    again = Scenario.from_toml(scenario.to_toml())  # which holds the values, so that nobody needs the name
    assert (again, again.hash, "preset" in scenario.to_toml()) == (scenario, scenario.hash, False)
    assert len({scenario, again}) == 1
    changes = {"decision.gain": 7.0, "decision.strategy": "dmvd", "tasks.count": 3, "run.steps": 9}
    changed = Scenario().replace({**PRESETS[name], **changes})
    sections = {"decision": Decision(gain=7.0, strategy="dmvd"), "tasks": {"count": 3}, "run": Run(steps=9)}
    assert Scenario(preset=name, **sections) == scenario.replace(changes) == changed


# --- Changes deep inside ---


def test_replace_reaches_into_lists_and_tables():
    mixed = Scenario(**MIXED)
    changed = mixed.replace({"robots.classes.0.count": 9, "robots.classes.1.skills": ["scan"]})
    assert [each.count for each in changed.robots.classes] == [9, 1]
    assert changed.robots.classes[1].skills == ("scan",)
    assert (changed.robots.count, changed.tasks.count) == (10, 3)
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
    assert (declare.quorum, declare.rounds, declare.heard) == (0.7, 3, 3)
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
        ("robots.classes.-1.count", "can't be set: robots.classes.-1 is missing or has no such field"),
        ("robots.classes.7", "can't be set: robots.classes is missing or has no such field"),
        ("arena.boundary.x", "can't be set: arena.boundary is missing or has no such field"),
        *(
            (path, "isn't the path of a field; write section.field, such as tasks.count")
            for path in ("robots..count", "tasks", "", "tasks.")
        ),
        ("robots.classes.0.cuont", "unknown key; "),
        ("decision.declare.quorum", "must be ≤ 1; "),
    ],
)
def test_replace_tells_of_paths_that_lead_nowhere(path, rule):
    with pytest.raises(ScenarioError) as caught:
        Scenario(**MIXED).replace({path: 3})
    (problem,) = caught.value.problems
    assert (problem.path, problem.value) == (path, 3)
    assert f"{problem.rule}; {problem.remedy}".startswith(rule)


def test_a_change_within_what_another_change_made_no_table_is_told():
    with pytest.raises(ScenarioError, match=r"is missing or has no such field"):
        Scenario().replace({"robots.classes": 2, "robots.classes.0.count": 3})


# --- Files and texts that are no scenario ---


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *((text, r"not TOML: .*\((at line|at end)") for text in ("tasks", "[a]\nb = \n")),
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


@pytest.mark.parametrize(
    ("file", "remedy"),
    [
        ("mine.py", "use it as --set decision.strategy=mine.py"),
        ("hall.yaml", "use it as --set place.map=hall.yaml"),
        ("mine.toml", "correct that line"),
    ],
)
def test_a_file_that_is_a_part_of_a_scenario_is_told_where_it_goes(file, remedy):
    with pytest.raises(FeasibeeError, match=rf"^{file}: not TOML: .*; {remedy}$"):
        Scenario.from_toml("tasks", file)


# --- The JSON Schema ---


SCHEMA = Scenario.model_json_schema()


def accepts(schema, value):
    whole = {**schema, "$defs": SCHEMA["$defs"]}
    return Draft202012Validator(whole).is_valid(json.loads(json.dumps(value)))


def field_schemas():
    for section, each in SCHEMA["properties"].items():
        name = each.get("$ref", "").rpartition("/")[2]
        for key, field in SCHEMA["$defs"][name]["properties"].items() if name else ():
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
    assert accepts(SCHEMA, Scenario().to_dict())
    assert accepts(SCHEMA, {})
    for path, field in (*field_schemas(), *SCHEMA["properties"].items()):
        assert "default" not in field or accepts(field, field["default"]), path
        assert all(accepts(field, example) for example in field.get("examples", ())), path


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
