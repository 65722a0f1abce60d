"""Faulty robots as a share or a count, and what is wrong with them (model.md 6.6)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from remedies import check_remedies, problems_of, ways

from feasibee import Scenario, ScenarioError, reference
from feasibee.scenario.runs import Runs
from feasibee.scenario.sections import KINDS
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import params_of
from feasibee.simulation.plan import study_of
from tests.commands import invoke

HALVES = [
    (1, 0.5, 1),
    (3, 0.5, 2),
    (5, 0.0999, 0),
    (5, 0.3, 2),
    (25, 0.1, 3),
    (45, 0.7, 32),  # 31.5, which is 31.499999999999996 in floats
    (5, {"count": 4}, 4),
]
"""Numbers of robots, what is given, and how many are faulty."""


@pytest.mark.parametrize(("robots", "given_", "faulty"), HALVES)
def test_reference_and_engine_round_exact_halves_up(robots, given_, faulty):
    """Catches a half rounded down, or to the even number, and a product of floats that isn't a half."""
    scenario = Scenario(robots={"count": robots}, faults={"stubborn": given_}, run={"steps": 5})
    swarm = reference.Swarm(scenario, seed=1, run=0)
    assert [robot.fault for robot in swarm.robots].count("stubborn") == faulty
    assert params_of(scenario, 1, fast=False).faults.stubborn == faulty
    counts = [
        simulate_record(scenario, Runs(3, 1), curves=True, backend=each).feasible_count
        for each in ("engine", "reference")
    ]
    np.testing.assert_array_equal(*counts)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("value", [1, 1.0, {"count": 1.0}, {"share": 1}])
def test_what_is_neither_a_share_nor_a_count_is_an_error_with_a_remedy(kind, value):
    """1 could be meant as one robot or as all of them."""
    (problem,) = problems_of({"faults": {kind: value}})
    assert (problem.path, problem.remedy) == (f"faults.{kind}", "use {count = 1} for one robot")


FAULTY = st.one_of(
    st.sampled_from([0, 0.1, 0.25, 1 / 3, 0.34, 0.5, 0.625, 0.999]),
    st.builds(lambda count: {"count": count}, st.integers(0, 12)),
)


@given(st.integers(2, 12), st.lists(FAULTY, min_size=3, max_size=3))
def test_faults_leave_an_honest_robot_or_are_an_error_with_a_remedy_that_holds(robots, given_):
    numbers = [each["count"] if isinstance(each, dict) else int(each * robots + 0.5) for each in given_]
    fits = sum(numbers) <= robots and numbers[0] + numbers[1] < robots
    tables = {"robots": {"count": robots}, "faults": dict(zip(KINDS, given_, strict=True))}
    try:
        scenario = Scenario(**tables)
    except ScenarioError as error:
        assert not fits
        (problem,) = error.problems
        check_remedies(problem, tables)
        for other in ways(problem, tables):
            assert sum(Scenario(**other).faulty) >= robots - 1
    else:
        assert fits
        assert list(scenario.faulty) == numbers
        assert Scenario.from_toml(scenario.to_toml()) == scenario


def test_a_count_of_faulty_robots_can_be_set_and_swept(tmp_path):
    by_path = Scenario().replace({"faults.byzantine.count": 1})
    assert by_path == Scenario(faults={"byzantine": {"count": 1}})
    assert by_path.get("faults.byzantine.count") == 1
    assert by_path.replace({"faults.byzantine.count": np.int64(2)}).faulty == (0, 2, 0)
    for given_ in ("faults.byzantine={count = 3}", "faults.byzantine.count=3"):
        result = invoke("show", "scenario", "--set", given_)
        assert Scenario.from_toml(result.stdout).faulty == (0, 3, 0)
    sweep = {"scenario": {"run": {"steps": 5}}, "sweep": {"faults.byzantine.count": [0, 1, 2]}}
    points = study_of({"runs": 2, **sweep}, tmp_path).points
    assert [point.scenario.faulty[1] for point in points] == [0, 1, 2]
