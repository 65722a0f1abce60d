"""A scenario with comments is the same scenario, and every field of it is explained."""

from __future__ import annotations

import re

import pytest

from feasibee import Scenario
from feasibee.scenario.comments import commented_toml, meaning_of
from feasibee.scenario.fields import SECTIONS, fields

CLASSES = {
    "robots": {"classes": [{"name": "a", "count": 3, "skills": ["x"]}, {"name": "b", "count": 2}]},
    "tasks": {"classes": [{"name": "t", "count": 2, "needs": {"x": 1}}]},
}
SCENARIOS = [
    {},
    CLASSES,
    {"preset": "valentini-2016"},
    {"decision": {"declare": {}, "listen": {"last": 3}, "strategy": "bayes"}},
    {"robots": {"placement": "points", "points": [[1.0, 2.0], [3.0, 4.0]]}},
    {"arena": {"side": [30.0, 12.0]}, "radio": {"id_bits": 7}},
]


@pytest.mark.parametrize("tables", SCENARIOS)
def test_a_commented_scenario_reads_back_as_the_same(tables):
    scenario = Scenario(**tables)
    text = commented_toml(scenario)
    assert Scenario.from_toml(text) == scenario
    assert Scenario.from_toml(text).hash == scenario.hash
    assert re.sub(r"(?m)^#.*\n", "", text).strip() == scenario.to_toml().strip()
    lines = text.splitlines()
    assert max(map(len, lines)) <= 100
    own = ("name =", "count =", "skills =", "credence", "positive", "last =", "[[robots.classes]]")
    for before, line in zip(["", *lines], lines, strict=False):
        commented = before.startswith("# ") or any(part in line for part in own)
        assert commented or not re.match(r"\[|\w+ = ", line), line


@pytest.mark.parametrize("tables", [*SCENARIOS, {"events": [{"step": 5, "tasks": 2}]}])
def test_each_field_of_each_section_is_printed_once_with_a_value_or_as_a_comment(tables):
    """The text had 40 of 61 fields: what is off, or changes nothing, was left out."""
    found, table = [], ""
    for line in commented_toml(Scenario(**tables)).splitlines():
        if header := re.match(r"(?:# )?\[+([\w.]+)\]", line):
            table = header[1]
            found += [table] if table.count(".") == 1 else []
        elif key := re.match(r"(?:# )?(\w+) = ", line):
            found += [f"{table}.{key[1]}"] if table in SECTIONS else []
    assert sorted(set(found)) == sorted(fields())
    assert len([path for path in found if path in ("robots.count", "units.metres", "radio.id_bits")]) == 3


@pytest.mark.parametrize("name", ["id_bits", "metres", "lifetime", "declare", "most", "classes"])
def test_a_field_that_is_off_is_on_without_its_hash_sign(name):
    lines = commented_toml(Scenario()).splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(f"# {name} = "))
    lines[at] = lines[at].removeprefix("# ")
    if name == "classes":  # which have counts of their own
        lines.remove("count = 20")
    assert Scenario.from_toml("\n".join(lines)) != Scenario()


def test_the_event_at_the_end_happens_without_its_hash_signs():
    text, _, event = commented_toml(Scenario()).rpartition("# [[events]]\n")
    scenario = Scenario.from_toml(text + "[[events]]\n" + event.replace("# ", ""))
    assert [(each.step, each.tasks) for each in scenario.events] == [(500, 15)]


def test_each_field_has_a_meaning():
    for path in fields():
        assert meaning_of(path).endswith("."), path
    assert meaning_of("robots.classes.skills") == "Skills that each robot of this class has."
    assert meaning_of("decision.parameters.exploration") == ""
