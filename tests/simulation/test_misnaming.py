"""Tasks under wrong names (model.md 6.3): the engine equals the reference, and a task has one wrong name."""

from __future__ import annotations

import pytest

from feasibee import Scenario, ScenarioError, reference
from feasibee.results.statistics import wilson
from feasibee.strategies import STRATEGIES
from tests.equal import assert_equal

NAMING = {
    name: {"decision.strategy": name, "robots.know_count": True}
    for name, strategy in STRATEGIES.items()
    if strategy.needs_names
}


def named(misname, steps=30):
    """Return the names of ten tasks that a standing robot beside them all sees in so many steps."""
    scenario = Scenario().replace(
        {
            "robots.count": 1,
            "robots.speed": 0.0,
            "robots.placement": "points",
            "robots.points": [[5.0, 5.0]],
            "tasks.placement": "points",
            "tasks.points": [[5.0 + 0.1 * k, 5.0] for k in range(10)],
            "decision.strategy": "census",
            "decision.exploration": 1e6,
            "sensing.misname": misname,
        }
    )
    swarm, seen = reference.Swarm(scenario, 3, 0), []
    for _ in range(steps):
        swarm.step()
        seen.append([(thing.id, thing.x, thing.hash) for thing, _ in swarm.sightings(swarm.robots[0])])
    return seen


def test_each_task_has_one_wrong_name_with_a_position_and_a_hash_of_its_own():
    right, wrong = named(0.0)[0], named(1.0)
    assert [name for name, _, _ in wrong[0]] == [10 + name for name, _, _ in right]
    assert [x for _, x, _ in wrong[0]] == [x + 10.0 for _, x, _ in right]
    assert {mark for *_, mark in wrong[0]}.isdisjoint(mark for *_, mark in right)
    assert all(each == wrong[0] for each in wrong)


def test_wrong_names_come_at_their_rate_anew_in_each_step():
    names = [name for step in named(0.2, 400) for name, _, _ in step]
    assert set(names) == set(range(20))
    wrong = sum(name >= 10 for name in names)
    low, high = wilson(wrong, len(names), 1 - 1e-7)[1:]
    assert low < 0.2 < high


def test_with_wrong_names_a_quiet_census_declares_infeasible_what_is_feasible():
    scenario = Scenario().replace({**NAMING["quiet-census"], "robots.count": 10, "tasks.count": 10})
    found = [
        assert_equal(scenario.replace({"arena.side": 10.0, "run.steps": 200, "sensing.misname": rate}), 7, 2)
        for rate in (0.0, 0.01)
    ]
    assert [each.declared_infeasible.max() > 0 for each in found] == [False, True]


@pytest.mark.parametrize("name", [name for name in STRATEGIES if name not in NAMING])
def test_a_strategy_that_has_no_names_of_tasks_refuses_wrong_ones(name):
    with pytest.raises(ScenarioError) as caught:
        Scenario(decision={"strategy": name}, sensing={"misname": 0.1}, robots={"know_count": True})
    (problem,) = caught.value.problems
    assert (problem.path, problem.value) == ("sensing.misname", 0.1)
    assert "name" in problem.rule
