"""Whether asking first pays: weights, worlds of missions, costs by hand, and the command."""

from __future__ import annotations

import math

import numpy as np
import pytest
from commands import invoke, json_of

from feasibee import Scenario, ScenarioError
from feasibee.errors import FeasibeeError
from feasibee.studies import flooding as module
from feasibee.studies.pays import (
    POLICIES,
    RATIOS,
    WITHOUT_TAGS,
    Costs,
    Missions,
    Pays,
    mission,
    pays,
    poisson_weights,
    sentences,
    task_numbers,
)
from tests.places import rectangle

SMALL = ("--set", "arena.side=10", "--set", "robots.count=4", "--set", "tasks.count=4", "--workers", 1)


def missions(steps, vain=0.0, calls=0.0):
    runs = np.array(steps, float)
    return Missions(runs, np.full(runs.size, vain), np.full(runs.size, calls), np.ones(runs.size, bool))


def made(**by_policy):
    """Return missions of 20 robots, with the same runs for all numbers of tasks that are feasible, or not."""
    numbers = task_numbers(20)
    found = {
        name.replace("_", " "): {m: feasible if m <= 20 else infeasible for m in numbers}
        for name, (feasible, infeasible) in by_policy.items()
    }
    every = {name: found.get(name, found["start at once"]) for name in POLICIES}
    return Pays(Scenario(), Costs(), 500, 1, every)


def test_weights_are_the_poisson_probabilities():
    weights = poisson_weights(10.0, range(1, 60))
    assert weights[10] == pytest.approx(10.0**10 * math.exp(-10) / math.factorial(10))
    assert weights[1] == pytest.approx(11 * math.exp(-10))  # with those of no task
    assert sum(weights.values()) == pytest.approx(1)


def test_numbers_that_are_left_out_share_their_weight():
    few = poisson_weights(10.0, [1, 8, 12, 40])
    assert sum(few.values()) == pytest.approx(1)
    assert sum(number * weight for number, weight in few.items()) == pytest.approx(10, abs=0.001)


def test_costs_are_sums_over_steps_starts_and_calls():
    found = made(start_at_once=(missions([100, 120]), missions([600, 640], vain=20, calls=1)))
    costs = Costs(step=2.0, vain=5.0, call=7.0)
    infeasible = sum(weight for m, weight in poisson_weights(20.0, task_numbers(20)).items() if m > 20)
    expected = (1 - infeasible) * 220 + infeasible * (1240 + 100 + 7)
    cost = found.cost("start at once", 1.0, costs)
    assert cost.estimate == pytest.approx(expected)
    assert cost.low < expected < cost.high


def test_the_cheapest_is_sure_only_if_no_other_is_as_cheap():
    dear, cheap = missions([600, 640], vain=20), missions([210, 230])
    found = made(start_at_once=(missions([20, 30]), dear), ask_first=(missions([110, 112]), cheap))
    names = ("start at once", "ask first")
    assert found.best(3.0, Costs(), names) == ("start at once", True)
    assert found.best(0.5, Costs(), names) == ("ask first", True)
    close = made(start_at_once=(missions([20, 90]), dear), ask_first=(missions([90, 25]), dear))
    assert close.best(3.0, Costs(), names)[1] is False
    assert [name for name, *_ in found.regions(10.0, names)] == ["ask first", "start at once"]
    assert found.regions(10.0, names)[0][1] == RATIOS[0]
    assert found.regions(10.0, names)[-1][2] == RATIOS[-1]


def test_a_mission_has_an_operator_who_helps_in_any_case():
    scenario = mission(Scenario(), "ask first", 23, 500)
    (event,) = scenario.events
    assert (event.step, event.robots) == (600, 3)
    assert (scenario.acts_from, scenario.tasks.count, scenario.responds) == (100, 23, True)
    assert scenario.manifest.knows_gap
    assert mission(Scenario(), "start at once", 20, 500).events == ()
    faulty = Scenario(faults={"byzantine": {"count": 2}})
    assert mission(faulty, "start at once", 20, 500).events[0].robots == 2
    own = mission(Scenario(decision={"strategy": "census"}), "tag, then ask", 20, 500)
    assert (own.decision.strategy, own.acting.hold) == ("census", "tag")


@pytest.mark.parametrize(
    "tables",
    [
        {"tasks": {"classes": [{"name": "a", "count": 2, "needs": {"x": 1}}]}},
        {"tasks": {"arrival_rate": 0.1}},
        {"decision": {"declare": {}}},
    ],
)
def test_worlds_that_it_cannot_ask_are_errors(tables):
    with pytest.raises((FeasibeeError, ScenarioError)):
        pays(Scenario(**tables), runs=2)


@pytest.fixture(scope="module")
def small():
    return pays(Scenario(arena={"side": 10.0}, robots={"count": 4}, tasks={"count": 4}), runs=6, seed=1)


def test_in_a_place_robots_search_and_ask_until_names_flood_it(monkeypatch):
    monkeypatch.setattr(module, "RUNS", 20)
    place = {"walls": [rectangle(2.4, 0.0, 2.6, 2.0)]}
    arena = {"side": 5.0, "boundary": "walls"}
    found = pays(Scenario(arena=arena, place=place, robots={"count": 2}), runs=2, seed=1)
    assert found.scenario.place.flooding is None
    assert all(each[2].ended.all() for each in found.missions.values())
    starts = [found.missions[name][2].steps.mean() for name in WITHOUT_TAGS]
    assert starts == sorted(starts)


def test_help_comes_in_all_missions(small):
    """All tasks are taken in the end, also those that robots were missing for."""
    for found in small.missions.values():
        assert sum(each.ended.sum() for each in found.values()) >= 0.98 * 6 * len(found)
    late = small.missions["start at once"][8]
    assert (late.steps > 100).all()
    assert (small.missions["ask first"][8].calls >= 1).all()


def test_the_answer_names_all_policies_and_regions(small):
    answer = " ".join(sentences(small))
    assert all(name in answer.lower() for name in POLICIES)
    assert "Without tags" in answer
    assert {name for name, *_ in small.regions(10.0)} <= set(WITHOUT_TAGS)


@pytest.mark.slow
def test_the_command_prints_json_and_draws(tmp_path):
    plot = tmp_path / "pays.svg"
    found = json_of("pays", *SMALL, "--runs", 2, "--vain", 3, "--out", plot)
    assert set(found["own"]) == set(POLICIES)
    assert found["costs"] == {"step": 1.0, "vain": 3.0, "call": 0.0}
    assert len(found["diagram"]) == len(RATIOS) * len(found["regions"])
    assert "robots per task" in plot.read_text()
    result = invoke("pays", *SMALL, "--runs", 2)
    assert "a mission costs" in " ".join(result.output.split())
