"""Calibration: what probability a swarm gives to feasible, its score and its curve."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.results.calibration import BINS, calibration, held_feasible, said_feasible
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.swarm import Swarm


def forecasts(number, seed=0):
    """Return probabilities in twentieths, and truths that come as often as these say."""
    rng = np.random.default_rng(seed)
    said = rng.integers(0, 21, number) / 20
    return said, rng.random(number) < said


def test_calibrated_probabilities_are_on_the_diagonal_and_others_are_not():
    said, true = forecasts(20_000)
    found = calibration(said, true)
    assert found.brier.low < (said * (1 - said)).mean() < found.brier.high
    assert sum(each.runs for each in found.bins) == said.size
    assert len(found.bins) == BINS
    assert all(abs(each.said - each.feasible.estimate) < 0.03 for each in found.bins)
    assert calibration(1 - said, true).brier.low > 0.4


def test_known_scores():
    assert calibration([1.0, 0.5], [True, False]).brier.estimate == 0.125
    assert calibration([], []) is None
    assert calibration([0.5, 0.9], [True, True]) is None  # a swarm that always says the same would be best
    assert calibration([0.5] * 4, [True, False] * 2).brier.estimate == 0.25
    assert calibration([0.5] * 4, [True, False] * 2).sure is None
    found = calibration([1.0, 0.9, 0.1, 0.0, 0.8], [True, False, False, False, True])
    assert (found.sure.estimate, found.brier.estimate) == (0.75, pytest.approx(0.172))


@pytest.mark.parametrize("seed", range(5))
def test_the_score_is_the_sum_of_murphys_parts(seed):
    """Also of probabilities that differ in a bin, and of those that are far from calibrated."""
    rng = np.random.default_rng(seed)
    said, true = rng.random(300), rng.random(300) < 0.3
    found = calibration(said, true)
    parts = found.reliability - found.resolution + found.uncertainty
    assert parts == pytest.approx(found.brier.estimate, abs=1e-12)
    assert found.uncertainty == pytest.approx(true.mean() * (1 - true.mean()), abs=1e-12)
    assert found.reliability > 0.05 > abs(found.resolution)


def test_parts_tell_a_swarm_that_knows_nothing_from_one_that_says_the_opposite():
    true = [True, True, False, False]
    parts = ("reliability", "resolution", "uncertainty")
    for said, expected in (
        ([1, 1, 0, 0], (0, 0.25, 0.25)),
        ([0.5] * 4, (0, 0, 0.25)),
        ([0, 0, 1, 1], (1, 0.25, 0.25)),
        ([0.9, 0.9, 0.5, 0.5], (0.13, 0.25, 0.25)),
    ):
        found = calibration(said, true)
        assert [getattr(found, each) for each in parts] == pytest.approx(expected)


def test_calibrated_probabilities_have_no_reliability_term_and_resolve_what_they_tell_apart():
    said, true = forecasts(20_000, 1)
    found = calibration(said, true)
    assert found.reliability < 0.001
    assert found.resolution == pytest.approx(said.var(), abs=0.004)


def test_a_share_on_an_edge_is_in_the_bin_above():
    said = [0.5 + 0.5 * lead / 10 for lead in (-10, -8, -4, 2, 4, 10)]  # the second is below 0.1
    found = calibration(said, [True, False] * 3)
    assert [each.said for each in found.bins] == said


@pytest.mark.parametrize("strategy", ["bayes", "dmmd"])
def test_the_share_of_a_swarm_is_of_what_its_counted_robots_hold(strategy):
    scenario = Scenario(
        decision={"strategy": strategy}, faults={"byzantine": 0.2, "stopped": 0.1}, run={"steps": 120}
    )
    swarm = Swarm(scenario, seed=3)
    swarm.advance(120)
    held = swarm.opinions[swarm.counted]
    share = np.where(held < 0, 0.5, held).mean()
    record = simulate_record(scenario.replace({"run.stop_at_decision": False}), Runs(1, 3))
    assert 0 < share < 1
    assert held_feasible(record, scenario)[0] == pytest.approx(share, abs=1e-12)
    by_share = strategy != "bayes"
    assert (said_feasible(record, scenario)[0] == held_feasible(record, scenario)[0]) == by_share


def test_swarms_in_a_world_that_changes_have_no_probability():
    scenario = Scenario(tasks={"arrival_rate": 0.01}, run={"steps": 5})
    assert said_feasible(simulate_record(scenario, Runs(2, 0)), scenario).size == 0
