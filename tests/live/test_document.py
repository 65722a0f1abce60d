"""The file that `feasibee page` writes, and what it can't simulate."""

from __future__ import annotations

import json
import re

import pytest
from commands import invoke, refused

from feasibee import Scenario, ScenarioError
from feasibee.live.page import page_of
from feasibee.live.prediction import prediction_of
from feasibee.live.world.lowering import check_scenario, variants_of
from feasibee.scenario.fields import Event, fields
from feasibee.scenario.supported import PAGE
from feasibee.strategies import STRATEGIES


def given(text):
    (found,) = re.findall(r'<script type="application/json" id="given">(.*?)</script>', text, re.DOTALL)
    return json.loads(found)


def test_the_page_is_small_and_loads_nothing():
    text = page_of(Scenario(tasks={"count": 50}))
    assert len(text.encode()) < 400_000
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", text)
    assert not re.search(r"(?m)^\s*(import|export)\b|https?:(?!//www\.w3\.org)", text)


def test_the_page_begins_with_the_scenario(tmp_path):
    file, out = tmp_path / "mine.toml", tmp_path / "mine.html"
    file.write_text("[robots]\ncount = 7\n[decision]\nstrategy = 'voter'\nthreshold = 0.8\n")
    said = invoke("page", str(file), "--set", "tasks.count=9", "--seed", str(2**64 - 1), "--out", str(out))
    assert (said.exit_code, said.stdout) == (0, f"Wrote {out}\n")
    found = given(out.read_text("utf-8"))
    assert found["name"] == "mine.toml"
    assert found["threshold"] == 0.8
    assert found["settings"] == {
        "robots": 7,
        "tasks": 9,
        "strategy": list(STRATEGIES).index("voter"),
        "seed": str(2**64 - 1),
        "run": 0,
        "events": [],
    }
    assert Scenario.from_toml(found["toml"]).tasks.count == 9


def test_the_page_has_what_the_theory_says_of_the_scenario():
    scenario = Scenario(tasks={"count": 10})
    assert given(page_of(scenario))["prediction"] == prediction_of(scenario)


def test_no_name_can_end_the_data():
    name = "</script><script>alert(1)</script>$style"
    assert given(page_of(Scenario(), name=name))["name"] == name


def test_all_that_a_page_cannot_simulate_is_told_at_once(tmp_path):
    out = tmp_path / "run.html"
    out.write_text("before")
    said = refused(
        *("page", "--out", str(out), "--set", "robots.placement=clusters", "--set", "faults.byzantine=0.1"),
        *("--set", "tasks.count=401", "--set", "decision.strategy=roster"),
        *("--set", "decision.parameters.tolerates=9"),
    )
    assert [line.split(" = ")[0] for line in said] == [
        f"feasibee: {path}"
        for path in ("robots.placement", "faults.byzantine", "tasks.count", "decision.strategy")
    ]
    assert "feasibee: tasks.count = 401: must be at most 400 in a page; use 400 or less" in said
    assert said[0].endswith('; set robots.placement = "uniform", or use feasibee watch')
    assert out.read_text() == "before"


def test_a_remedy_is_a_value_as_in_a_file():
    changes = {"robots.avoid_collisions": True, "robots.classes": [{"name": "eye", "count": 3}]}
    with pytest.raises(ScenarioError) as told:
        check_scenario(Scenario().replace(changes))
    assert [(problem.path, problem.remedy) for problem in told.value.problems] == [
        ("robots.avoid_collisions", "set robots.avoid_collisions = false, or use feasibee watch"),
        ("robots.classes", "leave out robots.classes, or use feasibee watch"),
    ]


@pytest.mark.parametrize(
    ("changes", "paths"),
    [
        ({"robots.count": 201, "run.steps": 10_001}, ["robots.count", "run.steps"]),
        ({"events": [{"step": 5, "sensing": {"miss": 0.1}}]}, ["events"]),
        ({"events": [{"step": 5, "robots": 181, "tasks": 381}]}, ["robots.count", "tasks.count"]),
        ({"decision.inbox": "every-message", "decision.strategy": "dc"}, ["decision.inbox"]),
        ({"decision.inbox": "every-message", "decision.gain": 100.0}, ["decision.inbox"]),
        ({"decision.declare": {"quorum": 0.123457}}, ["decision.declare.quorum"]),
        ({"decision.declare": {"rounds": 65_536}}, ["decision.declare.rounds"]),
        ({"robots.placement": "clusters"}, ["robots.placement"]),
    ],
)
def test_what_a_page_cannot_simulate(changes, paths):
    with pytest.raises(ScenarioError) as told:
        check_scenario(Scenario().replace(changes))
    assert [problem.path for problem in told.value.problems] == paths


@pytest.mark.parametrize("preset", ["valentini-2016", "minimize-surprise", "ros2swarm-majority"])
def test_a_page_simulates_the_presets(preset):
    check_scenario(Scenario(preset=preset))


def test_the_pages_fields_are_fields():
    assert {*fields(), *(f"events.{name}" for name in Event.model_fields)} >= PAGE


def test_a_page_offers_all_strategies_that_go_with_its_scenario():
    def offered(**tables):
        return [each.decision.strategy for each in variants_of(Scenario(**tables))]

    assert offered() == list(STRATEGIES)
    assert offered(decision={"start": "first-sight"}) == [
        name for name, each in STRATEGIES.items() if not (each.knowledge or each.starts_neutral)
    ]
    strategies = given(page_of(Scenario()))["strategies"]
    assert [each["numbers"]["given_knows_count"] for each in strategies] == [
        each.needs_count for each in STRATEGIES.values()
    ]
    assert [each["declares"] for each in strategies] == [each.declares for each in STRATEGIES.values()]


def test_the_file_must_be_html(tmp_path):
    (said,) = refused("page", "--out", str(tmp_path / "run.gif"))
    assert said.endswith("end the name with .html")
