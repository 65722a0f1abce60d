"""Rates with intervals, and times with undecided runs, against published numbers and by hand."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from feasibee import decision_counts, decision_rates, decision_times, wilson
from feasibee.stats import accuracy, confidence_sequence, opinion_quartiles

# --- Wilson's interval ---


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        # Newcombe, "Two-sided confidence intervals for the single proportion", Stat. Med. 17, 1998, table I.
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        # By hand: z**2 / (100 + z**2) with z = 1.95996.
        (0, 100, 0.0, 0.0370),
        (100, 100, 0.9630, 1.0),
        (15, 20, 0.5313, 0.8881),
        (50, 100, 0.4038, 0.5962),
    ],
)
def test_the_interval_is_the_published_one(successes, trials, low, high):
    interval = wilson(successes, trials)
    assert interval.estimate == successes / trials
    assert interval.low == pytest.approx(low, abs=5e-5)
    assert interval.high == pytest.approx(high, abs=5e-5)


@settings(derandomize=True)
@given(st.integers(1, 10**6).flatmap(lambda trials: st.tuples(st.integers(0, trials), st.just(trials))))
def test_the_interval_contains_the_estimate_and_has_a_width(case):
    interval = wilson(*case)
    assert 0 <= interval.low <= interval.estimate <= interval.high <= 1
    assert interval.high - interval.low > 1e-7


@settings(derandomize=True)
@given(st.integers(1, 10**6).flatmap(lambda trials: st.tuples(st.integers(0, trials), st.just(trials))))
def test_counting_failures_mirrors_the_interval(case):
    successes, trials = case
    one, other = wilson(successes, trials), wilson(trials - successes, trials)
    np.testing.assert_allclose(one, (1 - other.estimate, 1 - other.high, 1 - other.low), atol=1e-12)


def coverage(share, confidence, trials=100):
    """Return the probability that the interval contains a true share: a sum of binomial probabilities."""
    total = 0.0
    for successes in range(trials + 1):
        interval = wilson(successes, trials, confidence)
        if interval.low <= share <= interval.high:
            total += math.comb(trials, successes) * share**successes * (1 - share) ** (trials - successes)
    return total


@pytest.mark.parametrize("share", [0.02, 0.05, 0.1, 0.2, 0.25, 0.3, 0.5, 0.75, 0.9, 0.98])
def test_the_interval_covers_the_truth_as_often_as_it_says(share):
    assert coverage(share, 0.95) == pytest.approx(0.95, abs=0.02)


@pytest.mark.parametrize("confidence", [0.9, 0.95])
def test_the_interval_covers_the_truth_as_often_as_it_says_on_average(confidence):
    """Wald's interval would have 0.922 here instead of 0.95."""
    shares = (np.arange(100) + 0.5) / 100
    mean = np.mean([coverage(share, confidence) for share in shares])
    assert mean == pytest.approx(confidence, abs=0.004)


def test_more_confidence_and_fewer_trials_are_wider():
    def width(*arguments):
        interval = wilson(*arguments)
        return interval.high - interval.low

    assert width(30, 100, 0.5) < width(30, 100, 0.9) < width(30, 100) < width(30, 100, 0.99)
    assert width(30, 100) == width(30, 100, 0.95)
    assert width(300, 1000) < width(30, 100) < width(3, 10)


@pytest.mark.parametrize(("successes", "trials"), [(0, 0), (-1, 10), (11, 10), (0, -1), (math.nan, 10)])
def test_impossible_counts_are_refused(successes, trials):
    with pytest.raises(ValueError, match="successes <= trials"):
        wilson(successes, trials)


@pytest.mark.parametrize("confidence", [-0.1, 1.0, 1.5])
def test_an_impossible_confidence_is_refused(confidence):
    with pytest.raises(ValueError, match=r"\w"):
        wilson(1, 10, confidence)


# --- Counts and rates ---


def test_decisions_are_counted_by_name():
    decision = np.array([1, 1, 0, -1, 1, 0], np.int8)
    assert decision_counts(decision) == {"feasible": 3, "infeasible": 2, "undecided": 1}
    assert decision_counts([]) == {"feasible": 0, "infeasible": 0, "undecided": 0}
    assert all(type(count) is int for count in decision_counts(decision).values())


def test_rates_are_shares_of_all_runs_with_their_intervals():
    rates = decision_rates([1] * 15 + [0] * 4 + [-1])
    assert rates == {"feasible": wilson(15, 20), "infeasible": wilson(4, 20), "undecided": wilson(1, 20)}
    wider = decision_rates([1] * 15 + [0] * 4 + [-1], confidence=0.99)
    assert wider["feasible"] == wilson(15, 20, 0.99)


def test_no_runs_have_no_rates():
    with pytest.raises(ValueError, match="at least one"):
        decision_rates([])


# --- Decision times ---


@pytest.mark.parametrize(
    ("steps", "q25", "median", "q75"),
    [
        ([], None, None, None),
        ([7], 7, 7, 7),
        ([-1], None, None, None),
        ([0, 0, 0, 0], 0, 0, 0),
        ([-1, -1, -1, -1], None, None, None),
        ([10, 20, 30, 40], 10, 20, 30),
        ([40, 10, 30, 20], 10, 20, 30),
        ([10, 20, 30, 40, 50], 20, 30, 40),
        ([10, -1, -1, -1], 10, None, None),
        ([10, -1, -1, -1, -1], None, None, None),
        ([10, 20, -1, -1], 10, 20, None),
        ([10, -1, 20, 30], 10, 20, 30),
        ([10, 20], 10, 10, 20),
        ([10, -1], 10, 10, None),
    ],
)
def test_quartiles_of_times_by_hand(steps, q25, median, q75):
    times = decision_times(np.array(steps, np.int32))
    assert (times.q25, times.median, times.q75) == (q25, median, q75)
    assert all(step is None or type(step) is int for step in times)


@settings(derandomize=True)
@given(st.lists(st.integers(-1, 30), min_size=1, max_size=40))
def test_a_quartile_is_the_first_step_by_which_that_share_of_all_runs_had_decided(steps):
    def first(share):
        for step in range(31):
            if Fraction(sum(0 <= taken <= step for taken in steps), len(steps)) >= share:
                return step
        return None

    assert decision_times(steps) == tuple(first(Fraction(quarter, 4)) for quarter in (1, 2, 3))


# --- Quartiles of the opinions ---


def test_quartiles_of_opinions_by_hand():
    """Of 0, 1, 2, 3, 4 the quartiles are 1, 2, 3; of 0, 0, 0, 4, 4 they are 0, 0, 4; in per cent of 4."""
    counts = np.array([[0, 4], [1, 0], [2, 0], [3, 4], [4, 0]], np.int32)
    np.testing.assert_allclose(opinion_quartiles(counts, 4), [[25, 0], [50, 0], [75, 100]])


def test_between_two_runs_the_quartiles_are_interpolated():
    np.testing.assert_allclose(opinion_quartiles(np.array([[0], [10]]), 20), [[12.5], [25.0], [37.5]])


def test_a_run_that_has_ended_keeps_its_last_value():
    ended = np.array([[5, 6, 10, -1, -1], [5, 4, 3, 2, 1], [5, 0, -1, -1, -1]], np.int32)
    whole = np.array([[5, 6, 10, 10, 10], [5, 4, 3, 2, 1], [5, 0, 0, 0, 0]], np.int32)
    np.testing.assert_array_equal(opinion_quartiles(ended, 10), opinion_quartiles(whole, 10))
    np.testing.assert_allclose(opinion_quartiles(ended, 10)[1], [50, 40, 30, 20, 10])


def test_one_run_is_its_own_quartiles():
    np.testing.assert_allclose(opinion_quartiles(np.array([[10, 20, 0]]), 20), [[50, 100, 0]] * 3)


# --- Accuracy ---


@pytest.mark.parametrize(("feasible", "right"), [(True, 3), (False, 2)])
def test_accuracy_is_the_share_that_decides_as_the_truth(feasible, right):
    """An undecided run is wrong either way."""
    assert accuracy([1, 1, 1, 0, 0, -1, -1, -1], feasible) == wilson(right, 8)
    assert accuracy(np.full(5, -1, np.int8), feasible) == wilson(0, 5)
    assert accuracy([1, 0], feasible, confidence=0.5) == wilson(1, 2, 0.5)


def test_the_accuracy_of_no_runs_is_an_error():
    with pytest.raises(ValueError, match="at least one trial"):
        accuracy([], True)


# --- A rate that one keeps looking at ---


def evidence_against(rate, successes, trials, cells=200_000):
    """Integrate the likelihood ratio of other rates to this one over Beta(1/2, 1/2), numerically.

    With rate' = sin(angle)**2 that density is even in the angle, and the integral a mean.
    """
    angle = (np.arange(cells) + 0.5) / cells * np.pi / 2
    other = 2 * (successes * np.log(np.sin(angle)) + (trials - successes) * np.log(np.cos(angle)))
    own = successes * math.log(rate) + (trials - successes) * math.log1p(-rate)
    return np.exp(other - own).mean()


@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.999])
@pytest.mark.parametrize(
    ("successes", "trials"), [(1, 2), (3, 10), (10, 10), (0, 30), (80, 100), (997, 1000), (500, 1000)]
)
def test_a_rate_at_the_edge_has_just_so_much_evidence_against_it(successes, trials, confidence):
    interval = confidence_sequence(successes, trials, confidence)
    assert interval.estimate == successes / trials
    for edge in (interval.low, interval.high):
        if 0 < edge < 1:
            found = evidence_against(edge, successes, trials)
            assert found == pytest.approx(1 / (1 - confidence), rel=1e-6)
    for inner in np.linspace(*interval[1:], 5)[1:-1]:
        assert evidence_against(inner, successes, trials) < 1 / (1 - confidence)


@settings(derandomize=True, deadline=None)
@given(st.integers(1, 10**6).flatmap(lambda trials: st.tuples(st.integers(0, trials), st.just(trials))))
def test_the_sequence_holds_the_estimate_and_is_wider_than_wilsons(case):
    """Wider by how much looking often costs; with the very first trials alone, by how it is made."""
    successes, trials = case
    low, high = confidence_sequence(*case)[1:]
    assert 0 <= low <= successes / trials <= high <= 1
    assert (low == 0) == (successes == 0)
    assert (high == 1) == (successes == trials)
    fixed = wilson(*case)
    assert high - low > fixed.high - fixed.low
    if min(successes, trials - successes) >= 10:
        assert low < fixed.low < fixed.high < high
    mirrored = confidence_sequence(trials - successes, trials)
    np.testing.assert_allclose((low, high), (1 - mirrored.high, 1 - mirrored.low), atol=1e-9)


def test_more_confidence_is_wider_and_more_trials_are_narrower():
    levels = [confidence_sequence(30, 100, confidence) for confidence in (0.5, 0.9, 0.95, 0.99, 0.9999)]
    for narrow, wide in itertools.pairwise(levels):
        assert wide.low < narrow.low < narrow.high < wide.high
    assert confidence_sequence(30, 100) == levels[2]
    widths = [
        high - low for _, low, high in (confidence_sequence(3 * k, 10 * k) for k in (1, 10, 100, 10_000))
    ]
    assert widths == sorted(widths, reverse=True)
    assert widths[-1] < 0.02


def test_before_the_first_trial_nothing_is_known():
    estimate, low, high = confidence_sequence(0, 0)
    assert math.isnan(estimate)
    assert (low, high) == (0.0, 1.0)


@pytest.mark.parametrize(("successes", "trials"), [(-1, 10), (11, 10), (0, -1), (math.nan, 10)])
def test_a_sequence_of_impossible_counts_is_refused(successes, trials):
    with pytest.raises(ValueError, match="successes <= trials"):
        confidence_sequence(successes, trials)


@pytest.mark.parametrize("confidence", [0.0, -0.1, 1.0, 1.5, math.nan])
def test_a_sequence_of_an_impossible_confidence_is_refused(confidence):
    with pytest.raises(ValueError, match="confidence = "):
        confidence_sequence(1, 10, confidence)


def ever_refuted(interval, rate, looks, sequences=2000):
    """Return in which share of simulated sequences an interval misses the rate at one look or more."""
    draws = np.random.default_rng(12).random((sequences, max(looks))) < rate
    successes = draws.cumsum(axis=1)
    missed = np.zeros(sequences, bool)
    for trials in looks:
        known = successes[:, trials - 1]
        for value in np.unique(known):
            _, low, high = interval(int(value), trials)
            if not low <= rate <= high:
                missed |= known == value
    return missed.mean()


@pytest.mark.parametrize("rate", [0.5, 0.9])
def test_looking_after_every_trial_refutes_the_truth_no_more_often_than_said(rate):
    """Time-uniform coverage, up to 5.3 standard errors: catches a sequence that fails in 10 % of cases."""
    limit = 0.05 + 5.3 * math.sqrt(0.05 * 0.95 / 2000)
    found = ever_refuted(confidence_sequence, rate, range(1, 1001))
    assert 0.001 < found < limit


@pytest.mark.parametrize("rate", [0.5, 0.9])
def test_wilsons_interval_looked_at_every_10_trials_fails_far_more_often_than_said(rate):
    assert ever_refuted(wilson, rate, range(10, 1001, 10)) > 0.2
