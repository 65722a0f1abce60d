"""Robots that act (model.md 6.25): their ranks, what they can take, when they start, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from feasibee import Scenario
from feasibee.scenario.feasibility import can_do, kinds_of, most_taken, ranks_of, status_bits
from feasibee.scenario.supported import FAST_PATH, THEORY, takes_fast_path, unsupported
from feasibee.strategies.certified import NEVER

SKILLED = [
    {"name": "both", "count": 8, "skills": ["arm", "eye"]},
    {"name": "arms", "count": 8, "skills": ["arm"]},
]
NEEDING = [
    {"name": "lift", "count": 12, "needs": {"arm": 1}},
    {"name": "look", "count": 8, "needs": {"eye": 1}},
]
TEAM = {"robots": {"classes": [*SKILLED, {"name": "none", "count": 4}]}, "tasks": {"classes": NEEDING}}


def acting(changes):
    return Scenario(acting={"start": 40}).replace(changes)


SETS = st.sets(st.sampled_from(("arm", "eye", "leg")))
ROBOTS = st.lists(st.tuples(st.integers(1, 2), SETS), min_size=1, max_size=3)
TASKS = st.lists(st.tuples(st.integers(0, 3), st.sampled_from(("arm", "eye", "leg"))), min_size=1, max_size=3)


def matching(scenario):
    """Return the size of a largest matching of single robots and tasks, from scipy."""
    counts = [[each.count for each in part.classes] for part in (scenario.robots, scenario.tasks)]
    does = np.array(can_do(scenario.robots, scenario.tasks), dtype=np.int8)
    edges = does.repeat(counts[0], axis=0).repeat(counts[1], axis=1)
    return int((maximum_bipartite_matching(csr_array(edges)) >= 0).sum()) if edges.size else 0


@given(ROBOTS, TASKS)
def test_robots_can_take_as_many_tasks_as_a_largest_matching_has(robots, tasks):
    robots = [
        {"name": f"{k}", "count": count, "skills": sorted(own)} for k, (count, own) in enumerate(robots)
    ]
    tasks = [{"name": f"{k}", "count": count, "needs": {own: 1}} for k, (count, own) in enumerate(tasks)]
    scenario = Scenario(robots={"classes": robots}, tasks={"classes": tasks}, acting={"start": 1})
    assert most_taken(scenario, kinds_of(scenario.robots)) == matching(scenario)


@given(st.integers(1, 30), st.integers(0, 30))
def test_without_classes_each_robot_can_take_a_task(robots, tasks):
    scenario = Scenario(tasks={"count": tasks})
    assert most_taken(scenario, [0] * robots) == min(robots, tasks)


def test_robots_with_most_skills_have_rank_1():
    team = Scenario(**TEAM, acting={"start": 1})
    assert ranks_of(team.robots) == [1, 2, 3]
    assert can_do(team.robots, team.tasks) == [[True, True], [True, False], [False, False]]
    alike = team.replace(
        {"robots.classes": [*team.to_dict()["robots"]["classes"], SKILLED[1] | {"name": "more"}]}
    )
    assert ranks_of(alike.robots) == [1, 2, 3, 2]
    assert ranks_of(Scenario().robots) == [1]
    assert can_do(Scenario().robots, Scenario().tasks) == [[True]]


@pytest.mark.parametrize(
    ("scenario", "bits", "may_come_free"),
    [
        (acting({}), 1, False),
        (Scenario(**TEAM, acting={"start": 1}), 2, False),
        (acting({"faults.stopped": 0.1}), 9, True),
        (acting({"tasks.lifetime": 100.0}), 9, True),
        (acting({"faults.byzantine": 0.1}), 1, False),
    ],
)
def test_a_status_is_as_long_as_ranks_and_tasks_that_come_free_need(scenario, bits, may_come_free):
    assert (status_bits(scenario), scenario.may_come_free) == (bits, may_come_free)


@pytest.mark.parametrize(
    ("start", "count", "side", "step"),
    [
        (7, 20, 20.0, 7),
        (0, 20, 20.0, 0),
        ("search", 20, 20.0, 40),
        ("safe", 20, 20.0, 100),
        ("search", 50, 31.62, 50),
        ("safe", 50, 31.62, 115),
    ],
)
def test_robots_act_from_the_step_of_the_rule_on(start, count, side, step):
    """The prototype of these rules had 40 and 100 with 20 robots, and 49 and 115 with 50."""
    scenario = Scenario(robots={"count": count}, arena={"side": side}, acting={"start": start})
    assert (scenario.acts, scenario.acts_from) == (True, step)
    declaring = scenario.replace({"decision.strategy": "quiet-census", "acting.start": "declared"})
    assert (declaring.acts, declaring.acts_from) == (True, NEVER)
    assert (Scenario().acts, Scenario().acts_from) == (False, NEVER)


@pytest.mark.parametrize(
    ("start", "flooding", "first", "last"),
    [("safe", 500, 750, 750), ("search", 500, 300, 301), ("safe", NEVER, NEVER, NEVER)],
)
def test_in_a_place_robots_wait_for_the_time_of_flooding(start, flooding, first, last):
    """With 20 robots, search is (ln 20 + 1)/(5.2 + 1.6 ln 20) = 0.40 of safe, which is 1.5 times flooding."""
    place = {"walls": [[[9.9, 0.0], [10.1, 0.0], [10.1, 9.0], [9.9, 9.0]]]}
    scenario = Scenario(arena={"boundary": "walls"}, place=place, acting={"start": start})
    assert (scenario.waits_for_names, scenario.flooding) == (True, None)
    assert scenario.acts_from > NEVER / 2
    assert first <= scenario.with_flooding(flooding).acts_from <= last


@pytest.mark.parametrize("supported", [FAST_PATH, THEORY])
def test_the_fast_path_and_the_theory_have_no_robots_that_act(supported):
    (problem,) = unsupported(acting({}), supported, "isn't simulated here")
    assert str(problem) == "acting.start = 40: isn't simulated here; leave out acting.start"
    assert not takes_fast_path(acting({}))
