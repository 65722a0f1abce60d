"""What pages may ask of `feasibee watch`: a scenario with changes, by its form, and runs of a sweep."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from commands import invoke
from playing import swept

from feasibee import FeasibeeError, Scenario, Swarm
from feasibee.cli.watch import PICKS as OFFERED
from feasibee.live.catalogue import PICKS, Catalogue, Request, read_catalogue
from feasibee.live.form import STRATEGY, form, shown, typed
from feasibee.scenario.fields import fields
from feasibee.scenario.plugins import registered
from feasibee.scenario.tables import PRESETS

FILE = str(next((Path(__file__).parents[2] / "examples" / "strategies").glob("*.py")))
"""A strategy that would run."""
REFUSED = {
    "robots.count": [0, -1, 1.5, "many", None, 10**9, 20_001, 10**30, float("nan"), float("inf"), [], {}],
    "tasks.count": [-1, 20_001, True],
    "run.steps": [10_001],
    "radio.loss": [1.01, float("nan"), "a lot"],
    "robots.points": ["/etc/passwd", "points.csv"],
    "tasks.points": ["/dev/zero", "points.csv", '"/etc/passwd"', "[[1]]", "[[1, 2], 3]"],
    "place.map": ["/etc/passwd", "hall.yaml"],
    "place.keepout": ["/dev/zero"],
    "place.zones": [{"dock": "/etc/passwd"}],
    "place.zones.dock": ["/etc/passwd"],
    "decision.strategy": [FILE, "../mine.py", "os", "", 3, ["dmmd"]],
    "decision.listen": ["{last = 0}", "{last = ", "[1]", "never"],
    "decision.parameters": ["{nothing = 1}", "x"],
    "arena.side": ["[1, 2, 3]", "wide", "-1"],
    "robots": [{"points": "/etc/passwd"}],
    "decision": [{"strategy": FILE}],
    "a": [1],
    "tasks.": [1],
    "robots.classes": [2, "x", "3", '[{name = "x"}]', "[" * 500],
    "events": ["soon", "[{ step = 5000, tasks = 1 }]"],
    "preset": ["none", 3, "mine"],
}

VALUES = {
    "arena.side": [30.0, 18.0],
    "robots.classes": [{"name": 'a "b" c', "count": 9, "skills": ["lift", "é"]}, {"name": "eye", "count": 4}],
    "tasks.classes": [{"name": "carry", "count": 3, "needs": {"lift": 2, "see it": 1}}],
    "tasks.points": [[1.0, 2.5], [3.0, 4.0]],
    "decision.listen": {"last": 3},
    "decision.declare": {"quorum": 0.8, "rounds": 2, "heard": 1},
    "decision.parameters": {"credence": 0.9},
}
"""What the form shows as TOML, by path."""


@pytest.mark.parametrize("path", REFUSED)
def test_a_wrong_value_is_refused_at_its_path(path):
    for value in REFUSED[path]:
        with pytest.raises(FeasibeeError) as told:
            Catalogue(Scenario()).chosen(Request(changes={path: value}))
        first, *_ = told.value.problems
        assert first.path.startswith(path), (value, first)
        if path.startswith("place.") or str(value).endswith((".csv", "/zero")):
            assert "can't be a file on this page" in str(first), value


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    tables = {
        "runs": 30,
        "seed": 5,
        "scenario": {"run": {"steps": 130}, "events": [{"step": 40, "tasks": 6}, {"step": 90, "tasks": -9}]},
        "sweep": {"tasks.count": [16, 24], "radio.loss": [0.0, 0.2]},
    }
    return swept(tables, tmp_path_factory.mktemp("sweep"))


def test_the_runs_that_decided_wrong_are_listed_as_they_were(results):
    catalogue = read_catalogue(results, "wrong")
    listed = catalogue.replays["replays"]
    assert catalogue.replays["found"] == len(listed) > 5
    assert (str(catalogue.seed), str(catalogue.run)) == (listed[0]["seed"], listed[0]["run"])
    assert catalogue.point == listed[0]["point"]
    for each in listed[:: len(listed) // 5]:
        asked = Request(point=each["point"], seed=each["seed"], run=each["run"])
        scenario, runs = catalogue.chosen(asked)
        assert each["values"] == {path: str(scenario.get(path)) for path in each["values"]}
        swarm = Swarm(scenario, runs.seed, runs.first)
        swarm.advance(each["decision_step"])
        decided = {1: "feasible", 0: "infeasible"}[swarm.decision]
        assert (decided, swarm.decision) == (each["decision"], 1 - swarm.truth)
        assert swarm.first_decision[1] == each["decision_step"]


def test_every_pick_is_offered_and_they_share_out_the_runs(results, monkeypatch):
    assert OFFERED == PICKS
    found = {}
    for pick in PICKS:
        try:
            found[pick] = read_catalogue(results, pick).replays["found"]
        except FeasibeeError as error:
            assert f"has no runs that are {pick}; use another --pick" in str(error)  # noqa: PT017
            found[pick] = 0
    assert found["all"] == 120 == found["wrong"] + found["right"] + found["undecided"]
    assert found["all"] == found["feasible"] + found["infeasible"] + found["undecided"]
    monkeypatch.setattr("feasibee.live.catalogue.LISTED", 10)
    few = read_catalogue(results, "all").replays
    assert few["found"] == 120
    points = [each["point"] for each in few["replays"]]
    assert np.unique(points, return_counts=True)[1].tolist() == [2, 2, 2, 2]
    assert [each["run"] for each in few["replays"]] == ["0", "1"] * 4


def test_the_values_of_a_sweep_have_metres_and_seconds_if_its_scenario_has_them(tmp_path):
    scenario = {"units": {"metres": 0.5, "seconds": 2.0}, "tasks": {"count": 3}}
    fields = {"sensing.range": ["1.5 m"], "run.steps": [30], "radio.loss": [0.5]}
    folder = swept({"runs": 1, "scenario": scenario, "sweep": fields}, tmp_path)
    (replay,) = read_catalogue(folder, "all").replays["replays"]
    wanted = {"sensing.range": "3.0 (1.5 m)", "run.steps": "30 (1 min)", "radio.loss": "0.5"}
    assert replay["values"] == wanted


def test_a_strategys_text_of_a_folder_runs_if_it_is_the_users_own_or_trusted(tmp_path):
    text, file = "def decide(mind, inbox):\n    return mind.opinion\n", tmp_path / "mine.py"
    file.write_text(text)
    strategies = {"decision.strategy": ["mine.py", "dmmd"]}
    folder = swept({"runs": 3, "scenario": {"run": {"steps": 10}}, "sweep": strategies}, tmp_path)
    catalogue = read_catalogue(folder, "all")
    assert catalogue.scenario.manifest.name == str(file)
    file.write_text(f"X = 1 / 0\n{text}")
    catalogue = read_catalogue(folder, "all")
    assert catalogue.scenario.manifest.name == "dmmd"  # the first that may run
    own = next(point for point, row in catalogue.points.items() if row.scenario.manifest.source)
    with pytest.raises(FeasibeeError, match=r"isn't that of a file of yours.*--trust"):
        catalogue.chosen(Request(point=own))[0].strategy.memory  # noqa: B018
    asked = Request(point=own, changes={"decision.strategy": str(file), "tasks.count": 30})
    scenario, _ = read_catalogue(folder, "all", trust=True).chosen(asked)
    assert scenario.strategy.source == text
    for trust, what in (
        ((), "isn't replayed without --trust"),
        (("--trust",), "runs from the text in the folder"),
    ):
        line = f"feasibee: {file}, SHA-256 {sha256(text.encode()).hexdigest()}: {what}\n"
        assert line in invoke("watch", folder, "--pick", "all", "--host", "203.0.113.7", *trust).stderr


def test_the_form_has_every_field_once():
    found = [field["path"] for part in form() for field in part["fields"]]
    assert found == ["preset", "events", *fields()]
    kinds = {field["path"]: field for part in form() for field in part["fields"]}
    assert kinds["preset"]["choices"] == list(PRESETS)
    assert kinds["sensing.count_self"]["kind"] == "boolean"
    assert kinds["robots.placement"]["choices"] == ["uniform", "clusters", "points"]
    assert (kinds["radio.id_bits"]["kind"], kinds["radio.id_bits"]["nullable"]) == ("integer", True)
    assert {kinds[path]["kind"] for path in ("radio.range", "run.steps", "tasks.arrival_rate")} == {
        "quantity"
    }
    assert kinds["radio.loss"]["kind"] == "number"
    assert all(field["note"] for field in kinds.values())
    assert {path for path, field in kinds.items() if field["kind"] == "value"} >= VALUES.keys()
    assert (kinds[STRATEGY]["kind"], kinds[STRATEGY]["choices"]) == ("choice", registered())


@pytest.mark.parametrize("path", VALUES)
def test_what_is_shown_is_what_is_taken(path):
    text = shown(VALUES[path])
    assert "\n" not in text
    assert typed(path, text) == VALUES[path]


def test_text_that_is_no_toml_stays_text():
    assert typed("decision.listen", "always") == "always"
    assert typed("decision.listen", "{last = ") == "{last ="
    assert typed("tasks.count", "3") == "3"
    assert typed("arena.side", " 30 ") == 30
    assert [typed("run.steps", each) for each in ("30", "10 min", 30)] == [30, "10 min", 30]
    assert Scenario().replace({"arena.side": typed("arena.side", "[30, 18.5]")}).arena.size == (30.0, 18.5)
