"""A scenario with comments is the same scenario, and every field of it is explained."""

from __future__ import annotations

import re

import pytest

from feasibee import Scenario
from feasibee.scenario.comments import commented_toml, meaning_of
from feasibee.scenario.fields import fields

CLASSES = {
    "robots": {"classes": [{"name": "a", "count": 3, "skills": ["x"]}, {"name": "b", "count": 2}]},
    "tasks": {"classes": [{"name": "t", "count": 2, "needs": {"x": 1}}]},
}
SCENARIOS = [
    {},
    CLASSES,
    {"preset": "valentini-2016"},
    {"decision": {"commit": {}, "listen": {"last": 3}, "strategy": "bayes"}},
    {"robots": {"placement": "points", "points": [[1.0, 2.0], [3.0, 4.0]]}},
    {"arena": {"side": [30.0, 12.0]}, "radio": {"id_bits": 7}},
]


@pytest.mark.parametrize("tables", SCENARIOS)
def test_a_commented_scenario_reads_back_as_the_same(tables):
    scenario = Scenario(**tables)
    text = commented_toml(scenario)
    assert Scenario.from_toml(text) == scenario
    assert Scenario.from_toml(text).hash == scenario.hash
    assert re.sub(r"(?m)^#.*\n", "", text) == scenario.to_toml()
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize("tables", SCENARIOS)
def test_each_key_and_table_has_a_comment_above_it_once(tables):
    lines = commented_toml(Scenario(**tables)).splitlines()
    for before, line in zip(["", *lines], lines, strict=False):
        if re.match(r"\[|\w+ = ", line):
            own = any(
                part in line for part in ("name =", "count =", "skills =", "credence", "positive", "last =")
            )
            assert before.startswith("# ") or own or line == "[[robots.classes]]", line


def test_each_field_has_a_meaning():
    for path in fields():
        assert meaning_of(path).endswith("."), path
    assert meaning_of("robots.classes.skills") == "Skills that each robot of this class has."
    assert meaning_of("decision.parameters.exploration") == ""
