"""Races of changes against the swarm as it is: their numbers of runs, and what differences promise."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.results.statistics import Interval, mean_difference
from feasibee.simulation.sequential import Finding, looks
from feasibee.studies.assess import AS_IT_IS, Race, is_clear
from feasibee.studies.comparison import difference
from feasibee.studies.report import is_none


@dataclass(frozen=True)
class Drawn(Race):
    """A race whose runs were drawn before."""

    shares: dict[str, np.ndarray] = field(default_factory=dict)
    asked: list[tuple[set[str], int]] = field(default_factory=list)

    def outcomes(self, kinds, runs):
        self.asked.append((set(kinds), runs))
        return {name: SimpleNamespace(shares=self.shares[name][:runs], runs=runs) for name in kinds}


def race(shares, differences=1):
    tests = differences * len(looks(100, 400))
    return Drawn(SimpleNamespace(), 400, 0, tests, {name: np.array(each) for name, each in shares.items()})


def test_a_change_runs_on_until_its_difference_is_clear_or_surely_small():
    base = np.arange(400) % 2
    shares = {AS_IT_IS: base, "clear": np.ones(400), "none": base, "open": np.roll(base, 1)}
    raced = race(shares, 36)
    found = raced.against(Scenario(), dict.fromkeys(shares.keys() - {AS_IT_IS}, Scenario()))
    assert {name: outcome.runs for name, (outcome, _) in found.items()} == {
        "clear": 100,
        "none": 225,
        "open": 400,
    }
    assert [runs for _, runs in raced.asked] == [100, 150, 225, 338, 400]
    assert raced.asked[2][0] == {AS_IT_IS, "none", "open"}
    assert is_clear(found["clear"][1])
    assert is_none(found["none"][1])


def test_all_differences_of_a_report_hold_together():
    """36 changes share a baseline, and half of them change nothing; 95 % would be 6 misses of 120."""
    draw = np.random.default_rng(5)
    rates = {str(place): rate for place, rate in enumerate([0.54] * 18 + list(np.linspace(0.4, 0.99, 18)))}
    missed, alone = 0, 0
    for _ in range(120):
        same = draw.random(400)
        shares = {
            name: np.where(draw.random(400) < 0.5, same, draw.random(400)) < rate
            for name, rate in rates.items()
        }
        raced = race({AS_IT_IS: same < 0.54, **shares}, 36)
        found = raced.against(Scenario(), dict.fromkeys(rates, Scenario()))
        missed += any(not each.low <= rates[name] - 0.54 <= each.high for name, (_, each) in found.items())
        each_alone = {name: mean_difference(shares[name][:100], (same < 0.54)[:100]) for name in rates}
        alone += any(not each.low <= rates[name] - 0.54 <= each.high for name, each in each_alone.items())
    assert missed <= 3
    assert alone > 30  # what intervals of one difference each would promise


def test_outcomes_of_different_length_are_paired_by_their_first_runs():
    one = SimpleNamespace(shares=np.array([1.0, 0.0] * 15), runs=30)
    other = SimpleNamespace(shares=np.array([1.0, 0.0] * 15 + [0.0] * 50), runs=80)
    assert difference(one, other) == mean_difference(one.shares, other.shares[:30])
    assert difference(other, one).estimate == 0.0


@pytest.mark.parametrize(
    ("interval", "more"),
    [
        (Interval(0.97, 0.93, 0.99), 300),  # half as wide with 400
        (Interval(0.93, 0.90, 0.95), 100),
        (Interval(0.9501, 0.90, 0.98), None),
        (Interval(0.95, 0.90, 0.98), None),
    ],
)
def test_how_many_more_runs_would_settle_a_test_follows_from_the_width_of_its_interval(interval, more):
    assert Finding(0, 97, 100, interval, "open").more_trials(0.95) == more
