"""The form has all fields of a scenario, and what it shows is what it takes."""

from __future__ import annotations

import pytest

from feasibee import Scenario
from feasibee.live.form import form, shown, typed
from feasibee.scenario.fields import fields
from feasibee.scenario.tables import PRESETS

VALUES = {
    "arena.side": [30.0, 18.0],
    "robots.classes": [{"name": 'a "b" c', "count": 9, "skills": ["lift", "é"]}, {"name": "eye", "count": 4}],
    "tasks.classes": [{"name": "carry", "count": 3, "needs": {"lift": 2, "see it": 1}}],
    "tasks.points": [[1.0, 2.5], [3.0, 4.0]],
    "decision.listen": {"last": 3},
    "decision.declare": {"quorum": 0.8, "rounds": 2, "heard": 1},
    "decision.parameters": {"credence": 0.9},
}


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
    assert (kinds["radio.loss"]["min"], kinds["radio.loss"]["max"]) == (0, 1)
    assert all(field["note"] for field in kinds.values())
    assert {path for path, field in kinds.items() if field["kind"] == "value"} >= VALUES.keys()


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
