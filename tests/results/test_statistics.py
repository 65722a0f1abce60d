"""Rates with intervals, and times with undecided runs, against published numbers and by hand."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import binomtest

from feasibee import decision_counts, decision_rates, decision_times, wilson
from feasibee.results.statistics import (
    accuracy,
    bits_per_robot_and_step,
    confidence_sequence,
    opinion_quartiles,
    paired_difference,
    pareto,
    quartiles,
)

# --- Rates ---


COUNTS = st.integers(1, 10**6).flatmap(lambda trials: st.tuples(st.integers(0, trials), st.just(trials)))


@given(COUNTS, st.sampled_from([0.5, 0.9, 0.95, 0.99]))
def test_the_interval_is_wilsons(case, confidence):
    """It holds the estimate, and is never of zero width."""
    interval = wilson(*case, confidence)
    expected = binomtest(*case).proportion_ci(confidence, "wilson")
    assert interval == pytest.approx((case[0] / case[1], *expected), abs=1e-9)
    assert 0 <= interval.low <= interval.estimate <= interval.high <= 1
    assert interval.high - interval.low > 1e-7
    assert (interval.low == 0) == (case[0] == 0)
    assert (interval.high == 1) == (case[0] == case[1])


@pytest.mark.parametrize(
    "use", [lambda: wilson(0, 0), lambda: decision_rates([]), lambda: accuracy([], True)]
)
def test_no_runs_have_no_rates(use):
    with pytest.raises(ValueError, match="at least one trial"):
        use()


def test_decisions_are_counted_by_name_and_rates_are_shares_of_all_runs():
    """An undecided run is never right."""
    decision, counts = [1] * 15 + [0] * 4 + [-1], {"feasible": 15, "infeasible": 4, "undecided": 1}
    assert decision_counts(np.array(decision, np.int8)) == counts
    assert decision_counts([]) == dict.fromkeys(counts, 0)
    assert all(type(count) is int for count in decision_counts(decision).values())
    for confidence in (0.95, 0.99):
        expected = {name: wilson(count, 20, confidence) for name, count in counts.items()}
        assert decision_rates(decision, confidence) == expected
        assert accuracy(decision, True, confidence) == expected["feasible"]
        assert accuracy(decision, False, confidence) == expected["infeasible"]


# --- Decision times ---


@pytest.mark.parametrize(
    ("steps", "q25", "median", "q75"),
    [
        ([], None, None, None),
        ([40, 10, 30, 20], 10, 20, 30),
        ([10, -1, -1, -1, -1], None, None, None),
        ([2**31, 2**62, -1, -1], 2**31, 2**62, None),
    ],
)
def test_quartiles_of_times_by_hand(steps, q25, median, q75):
    times = decision_times(np.array(steps, np.int64))
    assert (times.q25, times.median, times.q75) == (q25, median, q75)
    assert all(step is None or type(step) is int for step in times)


@example([*range(24)])  # the share of a quarter of them, a product of floats, is less than 1/4
@given(st.lists(st.integers(-1, 30), min_size=1, max_size=40))
def test_a_quartile_is_the_first_step_by_which_that_share_of_all_runs_had_decided(steps):
    def first(share):
        for step in range(31):
            if Fraction(sum(0 <= taken <= step for taken in steps), len(steps)) >= share:
                return step
        return None

    assert decision_times(steps) == tuple(first(Fraction(quarter, 4)) for quarter in (1, 2, 3))
    assert quartiles(steps, [30] * len(steps)) == decision_times(steps)


# --- Quartiles of the opinions ---


def test_quartiles_of_opinions_by_hand():
    """Of 0, 1, 2, 3, 4 the quartiles are 1, 2, 3; of 0, 0, 0, 4, 4 they are 0, 0, 4; in per cent of 4."""
    counts = np.array([[0, 4], [1, 0], [2, 0], [3, 4], [4, 0]], np.int32)
    np.testing.assert_allclose(opinion_quartiles(counts, 4), [[25, 0], [50, 0], [75, 100]])
    np.testing.assert_allclose(opinion_quartiles(np.array([[0], [10]]), 20), [[12.5], [25.0], [37.5]])


def test_a_run_that_has_ended_keeps_its_last_value():
    ended = np.array([[5, 6, 10, -1, -1], [5, 4, 3, 2, 1], [5, 0, -1, -1, -1]], np.int32)
    whole = np.array([[5, 6, 10, 10, 10], [5, 4, 3, 2, 1], [5, 0, 0, 0, 0]], np.int32)
    np.testing.assert_array_equal(opinion_quartiles(ended, 10), opinion_quartiles(whole, 10))
    np.testing.assert_allclose(opinion_quartiles(ended, 10)[1], [50, 40, 30, 20, 10])


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


@given(COUNTS)
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


def test_before_the_first_trial_nothing_is_known():
    estimate, low, high = confidence_sequence(0, 0)
    assert math.isnan(estimate)
    assert (low, high) == (0.0, 1.0)


# --- Extremes: nothing overflows, nothing that isn't a number of runs passes for one ---


def test_bits_beyond_64_bits_are_summed_exactly():
    """Two runs of 2**62 bits each: a sum in 64 bits would be negative."""
    most = 2**62
    assert bits_per_robot_and_step([most, most], [2**31, 2**31]) == 2 * most / (2 * 2**31)
    many = bits_per_robot_and_step([2**63 - 1] * 5, [2**62] * 5)
    assert many == (2**63 - 1) / 2**62


def test_bits_of_runs_that_stop_at_step_0_are_none_a_step():
    assert bits_per_robot_and_step([0], [0]) == 0.0
    assert bits_per_robot_and_step([0, 60], [0, 20]) == 3.0


def test_a_rate_of_very_many_runs_has_an_interval():
    rate, low, high = wilson(2**52, 2**53)
    assert low < rate == 0.5 < high
    assert high - low < 1e-7


def test_numbers_of_other_libraries_are_numbers():
    once = wilson(3, 10)
    assert wilson(np.int64(3), np.uint8(10)) == wilson(3.0, np.float64(10)) == once
    assert decision_counts(np.array([1.0, -1.0])) == {"feasible": 1, "infeasible": 0, "undecided": 1}
    assert decision_counts([True, False]) == {"feasible": 1, "infeasible": 1, "undecided": 0}


WRONG = [None, "x", b"x", {}, [None], ["x"], [object()], object(), 1j, {1, 2}]
"""What is no array of numbers."""


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize(
    "use",
    [
        decision_counts,
        decision_rates,
        decision_times,
        lambda each: accuracy(each, True),
        lambda each: opinion_quartiles(each, 10),
        lambda each: bits_per_robot_and_step(each, [1]),
        lambda each: bits_per_robot_and_step([1], each),
        lambda each: paired_difference(each, [True]),
        lambda each: paired_difference([True], each),
    ],
)
def test_what_isnt_numbers_is_a_type_error(use, wrong):
    """None of them decided, it was said of ["x"]: {'feasible': 0, 'infeasible': 0, 'undecided': 0}."""
    with pytest.raises(TypeError, match=r"must be whole numbers$"):
        use(wrong)


@pytest.mark.parametrize("wrong", [*WRONG, [1], np.array([1, 2])])
@pytest.mark.parametrize(
    "use",
    [
        lambda each: wilson(each, 10),
        lambda each: wilson(1, each),
        lambda each: confidence_sequence(each, 10),
        lambda each: confidence_sequence(1, each),
        lambda each: opinion_quartiles([[1]], each),
    ],
)
def test_what_isnt_a_number_is_a_type_error(use, wrong):
    with pytest.raises(TypeError, match=r"must be a whole number$"):
        use(wrong)


@pytest.mark.parametrize("wrong", [-1, 1.5, math.nan, math.inf, 10**400, -(10**400)])
@pytest.mark.parametrize("use", [wilson, confidence_sequence])
def test_what_isnt_whole_is_a_value_error(use, wrong):
    for numbers in ((wrong, 10), (1, wrong), (11, 10)):
        with pytest.raises(ValueError, match="must be a whole number from 0 to"):
            use(*numbers)


@pytest.mark.parametrize("wrong", [0, 1, -0.5, 1.5, math.nan, math.inf, 1 - 2**-53, 10**400, True])
def test_a_confidence_that_none_is_is_refused(wrong):
    uses = (
        lambda: wilson(1, 2, wrong),
        lambda: confidence_sequence(1, 2, wrong),
        lambda: paired_difference([True], [False], wrong),
        lambda: decision_rates([1], wrong),
        lambda: accuracy([1], True, wrong),
    )
    for use in uses:
        with pytest.raises(ValueError, match="must be between 0 and 1"):
            use()
    with pytest.raises(TypeError, match="must be a number"):
        wilson(1, 2, "0.95")


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ([2], "must be 1 feasible, 0 infeasible, or -1"),
        ([-2, 1], "must be 1 feasible, 0 infeasible, or -1"),
        ([0.5], "must be whole numbers"),
        ([math.nan], "63 bits"),
        ([2**64 - 1], "63 bits"),
        (1, "has 0 dimensions: must have 1, one number per run"),
        ([[1, 0]], "has 2 dimensions: must have 1, one number per run"),
    ],
)
def test_what_isnt_decisions_is_refused(wrong, rule):
    for use in (decision_counts, decision_rates, lambda each: accuracy(each, True)):
        with pytest.raises(ValueError, match=rule):
            use(wrong)


def test_arrays_that_dont_fit_are_refused():
    for use, rule in (
        (lambda: opinion_quartiles([1, 2], 10), "has 1 dimensions: must have 2"),
        (lambda: opinion_quartiles(np.zeros((0, 5), int), 10), "at least one run, step and robot"),
        (lambda: opinion_quartiles([[1]], 0), "at least one run, step and robot"),
        (lambda: bits_per_robot_and_step([1, 2], [1]), "2 and 1 runs"),
        (lambda: paired_difference([2], [1]), "must be True or False"),
        (lambda: pareto([1.0], []), "1 costs and 0 gains"),
        (lambda: pareto([math.nan], [1.0]), "both must have the same number of numbers"),
    ):
        with pytest.raises(ValueError, match=rule):
            use()


@pytest.mark.parametrize("wrong", [None, "x", [True], 1.0])
def test_a_truth_is_true_or_false(wrong):
    with pytest.raises(TypeError, match="must be True or False"):
        accuracy([1], wrong)
