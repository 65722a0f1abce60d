"""Scenarios whose world changes: their fields, limits and conflicts (model.md 6.17)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.scenario.comments import commented_toml
from feasibee.scenario.feasibility import explain_kinds
from feasibee.scenario.sections import surely_above

EVENT = {"step": 500, "tasks": 15}


def test_events_and_rates_make_a_scenario_change():
    assert not Scenario().dynamic
    assert not Scenario(robots={"arrival_rate": 0.0, "most": 30}, tasks={"arrival_rate": 0.0}).dynamic
    assert "events" not in Scenario().to_dict()
    rates = ("robots.arrival_rate", "robots.failure_rate", "tasks.arrival_rate", "tasks.lifetime")
    for change in ({"events": [EVENT]}, *({path: 0.1} for path in rates)):
        assert Scenario().replace(change).dynamic


def test_toml_keeps_events_in_their_order():
    text = "[[events]]\nstep = 9\nradio.loss = 0.5\n[[events]]\nstep = 4\nrobots = -3\nsensing.miss = 0.0\n"
    scenario = Scenario.from_toml(text)
    assert [event.step for event in scenario.events] == [9, 4]
    assert (scenario.events[0].radio.loss, scenario.events[1].sensing.miss) == (0.5, 0.0)
    assert Scenario.from_toml(scenario.to_toml()) == Scenario.from_toml(commented_toml(scenario)) == scenario
    assert scenario.get("events.1.robots") == -3
    assert scenario.replace({"events": []}) == Scenario()


def test_numbers_of_robots_and_tasks_have_a_limit():
    events = [{"step": 5, "tasks": 4, "robots": 3}, {"step": 6, "tasks": -9, "robots": -2}]
    assert Scenario(events=events).most == (23, 24)
    assert Scenario(robots={"arrival_rate": 0.1}).most == (40, 20)
    assert Scenario(robots={"arrival_rate": 0.1}, events=[{"step": 5, "robots": 30}]).most == (50, 20)
    assert Scenario(robots={"arrival_rate": 0.1, "most": 25}).most == (25, 20)
    assert Scenario(robots={"most": 25}).most == (20, 20)  # none joins
    stream = Scenario(tasks={"arrival_rate": 0.1}, run={"steps": 1000})
    assert stream.most == (20, 20 + 100 + 80 + 16)
    assert stream.setting.tasks == 216
    assert Scenario(events=events).setting.count == 20


@pytest.mark.parametrize("mean", [0.01, 1.0, 28.5, 400.0])
def test_a_poisson_number_is_hardly_ever_above_the_limit(mean):
    """The tail, summed in logarithms; a limit of 6 deviations would fail at 400."""
    most = surely_above(mean)
    terms = [k * math.log(mean) - mean - math.lgamma(k + 1) for k in range(most + 1, most + 400)]
    assert np.exp(terms).sum() < 1e-12


def test_where_tasks_come_and_go_at_random_an_event_may_ask_for_more_than_there_are():
    Scenario(events=[{"step": 5, "tasks": -50}], tasks={"lifetime": 100.0})
    Scenario(events=[{"step": 5, "robots": -50}], robots={"failure_rate": 0.01})


def test_truth_follows_from_the_numbers_of_each_class():
    scenario = Scenario(
        robots={"classes": [{"name": "arm", "count": 5, "skills": ["lift"]}]},
        tasks={"classes": [{"name": "carry", "count": 2, "needs": {"lift": 2}}]},
    )
    assert explain_kinds(scenario, [0] * 4, [0] * 2).feasible
    assert explain_kinds(scenario, [0] * 3, [0] * 2).violator == (("lift",), 4, 3)
    assert explain_kinds(Scenario(), [], []).feasible
    assert not explain_kinds(Scenario(), [], [0]).feasible
