"""The verdicts of docs/argos.md: equivalent within margins, different, or not shown."""

from __future__ import annotations

import numpy as np
import pytest

import feasibee
from claims.measure import equivalence
from claims.measure.argos import (
    FIGURES,
    PLAN,
    ROOMS,
    Row,
    figures,
    first_seed,
    hidden,
    motion,
    our_seeds,
    read,
)
from claims.measure.equivalence import RATE, RATIO, Mean, difference, mean_of, power, ratio, verdict
from feasibee.results.statistics import Interval

TRIALS = 2000


def shares(rng, one, other, runs):
    """Draw how often each of two events happens in a number of runs, in many trials."""
    return (
        zip(rng.binomial(runs, share, TRIALS).tolist(), [runs] * TRIALS, strict=True)
        for share in (one, other)
    )


def found_equivalent(one, other, runs):
    """Return how often two shares are found equivalent."""
    pairs = zip(*shares(np.random.default_rng(7), one, other, runs), strict=True)
    return np.mean([verdict(difference(*pair), RATE) == "equivalent" for pair in pairs])


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (-0.04, 0.049, "equivalent"),
        (-0.04, 0.05, "not shown"),
        (-0.06, 0.06, "not shown"),
        (-0.05, 0.01, "not shown"),
        (0.01, 0.06, "not shown"),
        (0.051, 0.07, "different"),
        (-0.09, -0.051, "different"),
    ],
)
def test_a_verdict_depends_on_where_the_whole_interval_lies(low, high, said):
    assert verdict(Interval((low + high) / 2, low, high), RATE) == said


def test_the_interval_of_a_difference_is_that_of_the_publication(monkeypatch):
    monkeypatch.setattr(equivalence, "CONFIDENCE", 0.95)
    assert difference((56, 70), (48, 80)) == pytest.approx((0.2, 0.0524, 0.3339), abs=5e-5)


def test_swarms_of_the_same_world_are_equivalent_and_those_of_others_different():
    def simulated(seed, **changes):
        scenario = feasibee.Scenario().replace({"run.stop_at_decision": True, **changes})
        swarms = feasibee.simulate(scenario, runs=4000, seed=seed)
        return (int((swarms.decision.values == 1).sum()), 4000), mean_of(swarms.decision_step.values)

    share, steps = simulated(1)
    same_share, same_steps = simulated(2)
    assert verdict(difference(share, same_share), RATE) == "equivalent"
    assert verdict(ratio(steps, same_steps), RATIO) == "equivalent"
    fewer_share, _ = simulated(2, **{"tasks.count": 16})
    _, walled_steps = simulated(2, **{"arena.boundary": "walls"})
    assert verdict(difference(share, fewer_share), RATE) == "different"
    assert verdict(ratio(steps, walled_steps), RATIO) == "different"


def test_overlapping_intervals_show_no_equivalence():
    few = (20, 40), (22, 40)
    one, other = (feasibee.wilson(*each) for each in few)
    assert one.low < other.high
    assert other.low < one.high
    assert verdict(difference(*few), RATE) == "not shown"


@pytest.mark.parametrize(("one", "other"), [(0.50, 0.45), (0.20, 0.25), (0.90, 0.85)])
def test_shares_that_differ_by_the_margin_are_found_equivalent_once_in_twenty_times(one, other):
    assert found_equivalent(one, other, 4000) == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize("runs", [2000, 3000])
def test_the_power_that_is_computed_is_that_which_is_drawn(runs):
    assert found_equivalent(0.5, 0.5, runs) == pytest.approx(power([(0.5, (runs, runs))]), abs=0.03)


def test_means_whose_ratio_is_the_margin_are_found_equivalent_once_in_twenty_times():
    rng = np.random.default_rng(7)
    drawn = rng.gamma(4.0, (25.0 * RATIO[1], 25.0), (TRIALS, 500, 2)).transpose(0, 2, 1)
    found = [verdict(ratio(*(mean_of(each) for each in pair)), RATIO) for pair in drawn]
    assert found.count("equivalent") / TRIALS == pytest.approx(0.05, abs=0.015)


def test_the_mean_of_differences_has_the_interval_of_independent_ones():
    found = equivalence.mean_difference([Interval(0.1, 0.06, 0.13), Interval(-0.02, -0.05, 0.02)])
    assert found == pytest.approx((0.04, 0.04 - 0.025, 0.04 + 0.025))


def test_a_world_is_equivalent_if_all_rows_are_and_different_if_one_is():
    assert equivalence.overall(["equivalent"] * 3) == "equivalent"
    assert equivalence.overall(["equivalent", "not shown"]) == "not shown"
    assert equivalence.overall(["equivalent", "different", "not shown"]) == "different"


def test_a_mean_weighted_by_lengths_has_the_error_that_a_jackknife_finds():
    rng = np.random.default_rng(7)
    lengths = rng.geometric(0.01, 300).astype(float)
    values = rng.normal(1.0, 0.2, 300) + 0.001 * lengths
    found = mean_of(values, lengths)
    left = np.delete(np.arange(300)[None].repeat(300, 0).ravel(), np.arange(300) * 301).reshape(300, 299)
    without = (values[left] * lengths[left]).sum(axis=1) / lengths[left].sum(axis=1)
    assert found.mean == pytest.approx(np.average(values, weights=lengths))
    assert found.error == pytest.approx(
        np.sqrt(299 / 300 * ((without - without.mean()) ** 2).sum()), rel=0.02
    )
    assert mean_of(values) == pytest.approx(Mean(values.mean(), values.std(ddof=1) / np.sqrt(300)))


def test_way_contacts_and_sightings_are_those_of_robots_that_are_followed_by_hand():
    scenario = feasibee.Scenario().replace({"run.steps": 3, "arena.side": 8, "tasks.count": 5})
    swarm = feasibee.Swarm(scenario, 1, 0)
    steps, way, contacts, robots, tasks = motion(feasibee.Swarm(scenario, 1, 0))

    def sees(one, other):
        return np.hypot(*(min(abs(a - b), 8 - abs(a - b)) for a, b in zip(one, other, strict=True))) <= 2

    def pairs():
        places = swarm.positions
        return {(i, j) for i in range(20) for j in range(20) if i != j and sees(places[i], places[j])}

    before, found = pairs(), np.zeros(3)
    for _ in range(steps):
        swarm.advance()
        after = pairs()
        found += (
            len(after - before),
            len(after),
            sum(sees(a, b) for a in swarm.positions for b in swarm.tasks),
        )
        before = after
    assert (steps, way) == (3, pytest.approx(1.0, abs=1e-6))
    assert (contacts, robots, tasks) == pytest.approx(tuple(found / 60))


def test_a_way_is_hidden_where_it_meets_a_box():
    row = next(row for row in PLAN if row.world == ROOMS[0])
    boxes = np.array([(each[0], each[2]) for each in row.scenario().place.walls])
    starts = [[9.0, 5.0], [9.0, 10.0], [9.0, 8.5], [9.5, 9.4], [9.5, 9.4], [9.0, 8.0], [9.0, 8.0], [9.0, 5.0]]
    ends = [
        [11.0, 5.0],
        [11.0, 10.0],
        [10.5, 9.5],
        [10.5, 8.8],
        [10.5, 8.7],
        [10.5, 9.5],
        [9.8, 8.0],
        [9.0, 6.0],
    ]
    found = [True, False, False, False, True, True, False, False]
    assert hidden(np.array(starts), np.array(ends), boxes).tolist() == found
    assert hidden(np.array(ends), np.array(starts), boxes).tolist() == found


def test_an_undecided_run_counts_as_undecided_and_with_all_its_steps():
    found = figures(np.array([1, 0, -1, 1]), np.array([10, 20, 1000, 30]), np.ones(4), [np.ones(4)] * 4)
    assert (found["runs"], found["feasible"], found["undecided"]) == (4, 2, 1)
    assert found["steps"] == 265.0


def test_no_two_rows_of_the_plan_share_a_seed():
    ours = [seed for row in PLAN for seed in our_seeds(row)]
    argos = [seed for row, runs in PLAN.items() for seed in range(first_seed(row), first_seed(row) + runs)]
    assert len(set(ours)) == len(ours)
    assert len(set(argos)) == len(argos)
    assert min(argos) > 10_000
    assert min(ours) > 1


def test_the_kept_figures_are_those_of_the_plan():
    found = dict(read(FIGURES))
    assert list(found) == list(PLAN)
    assert all(100 <= found[row]["runs"] <= runs for row, runs in PLAN.items())
    assert isinstance(next(iter(found)), Row)
