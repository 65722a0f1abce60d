"""The fast path is taken only if each field that it does not implement has its default."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.engine import runner
from feasibee.model.record import Record
from feasibee.scenario import fields as sections
from feasibee.scenario.fields import SECTIONS, Declare, RobotClass, Sensing, TaskClass, fields
from feasibee.scenario.runs import Runs
from feasibee.scenario.supported import FAST_PATH, FAST_PATH_LIMITS, takes_fast_path
from feasibee.simulation.ensemble import load_engine, simulate_record
from feasibee.simulation.lowering import lower, params_of
from feasibee.strategies import STRATEGIES

OTHER_VALUES = {
    "arena.side": 17.0,
    "arena.boundary": "walls",
    "robots.placement": "clusters",
    "robots.clusters": 2,
    "robots.spread": 2.5,
    "robots.points": ((1.0, 2.0),),
    "robots.count": 40,
    "robots.speed": 0.7,
    "robots.diameter": 0.5,
    "robots.avoid_collisions": True,
    "robots.contact": "deflect",
    "robots.know_count": True,
    "robots.classes": (RobotClass(name="all", count=20),),
    "robots.arrival_rate": 0.1,
    "robots.failure_rate": 0.001,
    "robots.most": 30,
    "tasks.arrival_rate": 0.2,
    "tasks.lifetime": 100.0,
    "tasks.placement": "clusters",
    "tasks.clusters": 2,
    "tasks.spread": 2.5,
    "tasks.points": ((1.0, 2.0),),
    "tasks.count": 7,
    "tasks.classes": (TaskClass(name="all", count=20, needs={"lift": 1}),),
    "walk.mean_run": 3.0,
    "sensing.range": 3.0,
    "sensing.observation": "unique",
    "sensing.count_self": True,
    "sensing.miss": 0.1,
    "sensing.false_robots": 0.1,
    "sensing.false_tasks": 0.1,
    "sensing.misname": 0.1,
    "radio.range": 4.0,
    "radio.loss": 0.1,
    "radio.id_bits": 8,
    "decision.strategy": "voter",
    "decision.parameters": {"k": 2.0},
    "decision.exploration": 4.0,
    "decision.gain": 30.0,
    "decision.dissemination_floor": 3,
    "decision.quality_floor": 2,
    "decision.listen": "dissemination",
    "decision.inbox": "every-message",
    "decision.inbox_size": 3,
    "decision.own_vote": False,
    "decision.switching": 0.1,
    "decision.declare": Declare(),
    "decision.threshold": 0.6,
    "faults.stopped": 0.1,
    "faults.stop_step": 5,
    "faults.byzantine": 0.1,
    "faults.byzantine_says": "random",
    "faults.stubborn": 0.1,
    "run.steps": 50,
    "run.stop_at_decision": True,
    "response.patience": 50,
    "response.delay": 7,
    "response.margin": 0,
    "units.metres": 0.5,
    "units.seconds": 2.0,
}
"""A value for each field of a scenario, other than its default."""

GENERAL_ONLY = {
    "arena.side": [(20.0, 10.0)],
    "decision.listen": [{"last": 3}],
    "decision.strategy": [name for name, each in STRATEGIES.items() if each.knowledge],
}
"""Values that need the general engine, of fields that the fast path implements."""


def changed(path, value):
    """Return the default scenario with another value in this field alone, whether or not that is valid."""
    scenario, (section, key) = Scenario(), path.split(".")
    return scenario.model_copy(
        update={section: getattr(scenario, section).model_copy(update={key: value})},
    )


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


@pytest.mark.parametrize("path", sorted(FAST_PATH))
def test_a_field_on_the_list_takes_the_fast_path_with_the_same_outcome(path):
    changes = {path: OTHER_VALUES[path], "run.steps": 50, "arena.side": 12.0}
    if path == "decision.parameters":
        changes["decision.strategy"] = "k-unanimity"
    scenario = Scenario().replace(changes)
    assert takes_fast_path(scenario)
    by_fast_path = simulate_record(scenario, Runs(3, 1), curves=True)
    by_general_engine = general_record(scenario, 3, 1)
    for name in by_fast_path.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(by_fast_path, name), getattr(by_general_engine, name), name)


def general_record(scenario, runs, seed):
    """Simulate a scenario in the general engine, even if the fast path takes it."""
    load_engine(scenario.replace({"arena.boundary": "walls"}))
    lowered, params = lower(scenario, seed), params_of(scenario, seed, fast=False)
    record = Record.empty(0, runs, scenario.run.steps + 1)
    runner.simulate(lowered._replace(params=params, fast=False), record, threads=1)
    return record


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
