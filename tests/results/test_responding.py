"""How well swarms are served that call for robots: by hand, and against what they are compared with."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.model.record import Record
from feasibee.results.responding import fixed_number, fixed_service, judgement, oracle_service

TASKS = np.array([[3, 3, 5, 6, 6, 6, 2, 2], [3, 4, 4, 4, 4, 4, 4, 4]])
SCENARIO = Scenario(robots={"count": 3}, response={"patience": 2, "delay": 2, "margin": 1}, run={"steps": 7})


def test_a_fixed_number_is_idle_or_missing():
    found = fixed_service(TASKS, 4)
    assert found.feasible_share.estimate == pytest.approx((3 / 7 + 7 / 7) / 2)
    assert found.idle.estimate == pytest.approx((1 + 2 + 2) / 7 / 2)
    assert (found.calls.estimate, found.too_many_per_call, found.too_few_per_call) == (0, 0, 0)


@pytest.mark.parametrize(("share", "number"), [(0.0, 2), (0.6, 4), (10 / 14, 4), (0.72, 5), (1.0, 6)])
def test_the_least_fixed_number_is_enough_that_often(share, number):
    """From step 1 on: 2, 2, 3, seven times 4, 5, and three times 6."""
    assert fixed_number(TASKS, share) == number
    assert fixed_service(TASKS, number).feasible_share.estimate >= share


def test_floats_just_above_a_share_of_the_steps_dont_ask_for_more():
    """0.07 of 100 steps is 7.000000000000001 in floats."""
    assert fixed_number(np.arange(101)[None], 0.07) == 7


def test_the_oracle_keeps_one_robot_and_calls_no_more_than_there_may_be():
    """Of the first 50 tasks 47 are missing; 7 come at step 4, so that 40 are. Two of three robots may go."""
    scenario = SCENARIO.replace({"robots.most": 10, "response.margin": 0, "run.steps": 4})
    found = oracle_service(np.array([[3, 50, 50, 50, 50]]), scenario)
    assert (found.calls.estimate, found.too_many_per_call, found.too_few_per_call) == (1, 0, 40)
    assert oracle_service(np.array([[3, 0, 0, 0, 0]]), scenario).idle.estimate == (3 + 1 + 1 + 1) / 4


def test_the_oracle_calls_what_is_missing_and_the_margin():
    """Of the first run: 2 missing are seen at step 3, and 3 come at 5; 6 robots, so that 3 leave at 7.

    Of the second: 1 missing is seen at step 2, and 2 come at 4.
    """
    found = oracle_service(TASKS, SCENARIO)
    first, second = [3, 3, 3, 3, 6, 6, 3], [3, 3, 3, 5, 5, 5, 5]
    spare = np.array([first, second]) - TASKS[:, 1:]
    assert found.feasible_share.estimate == pytest.approx((spare >= 0).mean())
    assert found.idle.estimate == pytest.approx(np.maximum(spare, 0).mean())
    assert found.calls.estimate == 1
    assert (found.too_many_per_call, found.too_few_per_call) == (0, 0)


def test_a_swarm_is_compared_with_the_number_that_has_enough_as_often():
    """Five come at step 3 of the first run, one too many, and four leave at step 6.

    One comes at step 4 of the second run, and one still lacks.
    """
    record = Record.empty(0, 2, 0, 8)
    record.robots_present[:] = [[3, 3, 3, 8, 8, 8, 4, 4], [2, 2, 2, 2, 3, 3, 4, 4]]
    record.tasks_present[:] = TASKS
    record.calls[:] = 1, 2
    found = judgement(record, SCENARIO)
    assert found.own.feasible_share.estimate == pytest.approx((6 / 7 + 2 / 7) / 2)
    assert found.own.calls.estimate == 1.5
    assert found.own.too_many_per_call == pytest.approx(1 / 3)
    assert found.own.too_few_per_call == pytest.approx(1 / 3)
    assert found.robots == 4
    assert found.as_often.feasible_share.estimate >= found.own.feasible_share.estimate
    assert list(found.fixed) == [3, 4, 6]
    assert set(found.to_dict()) == {*found.own._fields, "oracle", "fixed"}
    assert judgement(record, Scenario()) is None
