"""The fast path is taken only if each field that it does not implement has its default.

That it gives the outcomes of the reference, the conformance suite says.
"""

from __future__ import annotations

import pytest
from pydantic import TypeAdapter

from feasibee import Scenario
from feasibee.scenario import fields as sections
from feasibee.scenario.fields import SECTIONS, Sensing, fields
from feasibee.scenario.supported import FAST_PATH, FAST_PATH_LIMITS, takes_fast_path
from feasibee.strategies import STRATEGIES
from tests.other_values import OTHER_VALUES

GENERAL_ONLY = {
    "arena.side": [(20.0, 10.0)],
    "decision.listen": [{"last": 3}],
    "decision.strategy": [name for name, each in STRATEGIES.items() if each.knowledge],
    "run.steps": [2**31 // 20 + 1],
}
"""Values that need the general engine, of fields that the fast path implements."""


def changed(path, value):
    """Return the default scenario with another value in this field alone, whether or not that is valid."""
    scenario, (section, key) = Scenario(), path.split(".")
    given = TypeAdapter(SECTIONS[section].model_fields[key].annotation).validate_python(value)
    return scenario.model_copy(update={section: getattr(scenario, section).model_copy(update={key: given})})


def test_every_field_is_tested_with_another_value():
    assert sorted(OTHER_VALUES) == sorted(fields())
    for path, value in OTHER_VALUES.items():
        section, key = path.split(".")
        assert getattr(getattr(Scenario(), section), key) != value, path


def test_the_list_names_fields_of_a_scenario():
    assert set(fields()) >= FAST_PATH >= set(FAST_PATH_LIMITS)


def test_the_default_scenario_takes_the_fast_path():
    assert takes_fast_path(Scenario())


@pytest.mark.parametrize("path", sorted(set(OTHER_VALUES) - FAST_PATH))
def test_a_field_outside_the_list_needs_the_general_engine(path):
    assert not takes_fast_path(changed(path, OTHER_VALUES[path]))


@pytest.mark.parametrize(
    ("path", "value"), [(path, each) for path in GENERAL_ONLY for each in GENERAL_ONLY[path]]
)
def test_some_values_of_fields_on_the_list_need_the_general_engine(path, value):
    assert not takes_fast_path(Scenario().replace({path: value, "robots.know_count": True}))


def test_every_condition_is_tested():
    assert set(GENERAL_ONLY) == set(FAST_PATH_LIMITS)
    assert all(GENERAL_ONLY.values())


def test_a_new_field_needs_the_general_engine_until_it_is_listed(monkeypatch):
    class MoreSensing(Sensing):
        fog: float = 0.0

    monkeypatch.setitem(sections.SECTIONS, "sensing", MoreSensing)
    assert SECTIONS["sensing"] is MoreSensing
    assert takes_fast_path(Scenario().model_copy(update={"sensing": MoreSensing()}))
    assert not takes_fast_path(Scenario().model_copy(update={"sensing": MoreSensing(fog=0.5)}))
