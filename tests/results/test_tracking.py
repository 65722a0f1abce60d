"""Measures of worlds that change: small runs by hand, a plain definition, and what intervals cover."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from feasibee import Scenario, decision_times, wilson
from feasibee.results.measures import (
    changes_of,
    counts_of,
    measures_of_runs,
    together,
    tracking,
    truth_intervals,
)
from feasibee.results.statistics import (
    Quartiles,
    event_rate,
    mean_difference,
    mean_of,
    mean_share,
    opinion_quartiles,
    quartiles,
)

CODES = {"F": 1, "I": 0, ".": -1}


def steps(*runs):
    """Return runs as an array: F feasible, I infeasible, . undecided, or after the end of a run."""
    return np.array([[CODES[each] for each in run] for run in runs], np.int8)


def changing(**arrays):
    """Return a scenario that changes, and these arrays as its results."""
    return SimpleNamespace(**arrays), SimpleNamespace(dynamic=True)


def counted(truth, held, first_step=1):
    """Return what is counted of runs."""
    return counts_of(SimpleNamespace(truth=truth, held=held), first_step)


# --- Changes and false alarms ---


def test_a_swarm_that_was_never_right_has_no_changes():
    results, scenario = changing(truth=steps("FFII"), held=steps("IIFF"))
    measured = tracking(results, scenario)
    assert measured.right_share.estimate == 0
    assert (measured.missed, measured.changes) == (None, 0)
    assert measured.detection_delay == (None, None, None)


def test_a_run_that_ends_early_is_watched_until_its_end():
    truth, held = steps("FFII..", "FFIIII", "FFII.."), steps("FFFF..", "FFFFFI", "FFII..")
    assert [each.tolist() for each in changes_of(truth, held)] == [
        [0, 1, 2],
        [2, 2, 2],
        [-1, 3, 0],
        [1, 3, 1],
    ]
    results, scenario = changing(truth=truth, held=held)
    assert [each.tolist() for each in counts_of(results)[:2]] == [[3, 5, 3], [1, 2, 3]]
    assert tracking(results, scenario, 5).right_share.estimate == 1  # of the one run that lasts so long
    assert counts_of(results, 3).shares.tolist() == [0, 1 / 3, 1]


def test_a_warm_up_leaves_out_steps_changes_and_alarms():
    truth, held = steps("FFIIIII"), steps("FFFIFII")
    counts = {first: counted(truth, held, first) for first in (2, 3, 4, 5)}
    assert (counts[3].right, counts[3].steps, counts[4].alarms, counts[5].alarms) == (3, 4, 1, 0)
    assert [counts[first].changes.delay.tolist() for first in (2, 3)] == [[1], []]


# --- All of them, by a plain definition ---


def plain(truth, held):
    """Return right steps, false alarms and delays of one run, step by step."""
    right = sum(held[t] == truth[t] for t in range(1, len(truth)))
    alarms, was_right, delays = 0, False, []
    for t in range(len(truth)):
        if t and truth[t] != truth[t - 1]:
            was_right = False
            if held[t - 1] == truth[t - 1]:
                ends = [u for u in range(t + 1, len(truth)) if truth[u] != truth[u - 1]] + [len(truth)]
                hits = [u - t for u in range(t, ends[0]) if held[u] == truth[u]]
                delays.append((t, hits[0] if hits else -1, ends[0] - 1 - t))
        if held[t] >= 0:
            alarms += t > 0 and was_right and held[t] != truth[t]
            was_right = held[t] == truth[t]
    return right, alarms, delays


def test_the_measures_are_those_of_a_plain_definition():
    draw = np.random.default_rng(7)
    for length in (2, 3, 9, 40):
        truth = (np.cumsum(draw.random((50, length)) < 0.15, axis=1) % 2).astype(np.int8)
        held = np.where(draw.random(truth.shape) < 0.2, -1, truth ^ (draw.random(truth.shape) < 0.3))
        expected = [plain(*each) for each in zip(truth.tolist(), held.tolist(), strict=True)]
        counts = counted(truth, held)
        assert counts.right.tolist() == [each[0] for each in expected]
        assert counts.alarms.tolist() == [each[1] for each in expected]
        changes = [(run, *each) for run, (*_, delays) in enumerate(expected) for each in delays]
        assert list(zip(*(each.tolist() for each in counts.changes), strict=True)) == changes


def test_a_world_that_does_not_change_has_no_measures():
    assert tracking(SimpleNamespace(), Scenario()) is None
    results, scenario = changing(truth=np.empty((0, 3), np.int8), held=np.empty((0, 3), np.int8))
    assert tracking(results, scenario) is None


def test_the_measures_come_with_their_intervals():
    truth = np.repeat(steps("FFFFFIIIII"), 40, axis=0)
    held = truth.copy()
    held[:10, 5:7] = 1  # two steps late
    held[10:20, 5:] = 1  # never
    held[20:25, 2] = 0
    held[25:27, 4] = -1  # not right before the change, so that it doesn't count
    measured = tracking(*changing(truth=truth, held=held))
    assert measured.right_share.estimate == pytest.approx(1 - (10 * 2 + 10 * 5 + 5 + 2) / (40 * 9))
    assert measured.detection_delay == Quartiles(0, 2, None)
    assert measured.missed == wilson(10, 38)
    assert measured.false_alarms.estimate == pytest.approx(1000 * 5 / 360)
    for name in ("right_share", "false_alarms"):
        estimate, low, high = getattr(measured, name)
        assert low < estimate < high
    table = measured.to_dict()
    assert table["detection_delay"] == {"q25": 0, "median": 2, "q75": None, "changes": 38}
    assert set(table) == {"right_share", "detection_delay", "missed", "false_alarms"}
    middle, low, high = together([SimpleNamespace(followed=counted(truth, held))], "detection_delay")
    assert ((middle, low), math.isnan(high)) == ((2, 0), True)


def test_the_measures_of_each_run_by_hand():
    """Run 0 follows one change after a step and one at once; run 2 misses one, and so the next."""
    results = SimpleNamespace(
        truth=steps("FFIIIFF", "FFFFFFF", "FFIIIFF"),
        held=steps("FFFIIFI", "FFFFFFF", "FFFFFFF"),
        robots_present=np.array([[9, 3, 3, 3, 3, 3, 3], [9, 1, 2, 3, 4, 5, 6], [9, 0, 0, 0, 0, 0, 1]]),
    )
    assert {name: each.tolist() for name, each in measures_of_runs(results).items()} == {
        "right_steps": [4, 6, 3],
        "changes": [2, 0, 1],
        "missed": [0, 0, 1],
        "first_delay": [1, -1, -1],
        "false_alarms": [1, 0, 0],
        "robot_steps": [18, 21, 1],
    }


def test_the_quartiles_of_opinions_are_of_the_robots_present_at_each_step():
    feasible, present = [[4, 5], [1, 2], [0, 0], [2, 8], [3, 1]], [[4, 10], [4, 10], [4, 0], [4, 8], [4, 1]]
    np.testing.assert_allclose(opinion_quartiles(feasible, present), [[25, 20], [50, 50], [75, 100]])


# --- The truth of all runs ---


def test_intervals_of_truth_are_those_that_all_runs_share():
    assert [(each["first"], each["last"], each["truth"]) for each in truth_intervals(steps("FFIIF"))] == [
        (0, 1, "feasible"),
        (2, 3, "infeasible"),
        (4, 4, "feasible"),
    ]
    assert truth_intervals(steps("FFI", "FII")) is None
    assert truth_intervals(np.empty((0, 5), np.int8)) is None
    assert truth_intervals(steps("FF..")) == [{"first": 0, "last": 1, "truth": "feasible"}]


# --- Durations, some of them censored ---


def test_without_early_censoring_the_quartiles_are_those_of_decision_times():
    draw = np.random.default_rng(3)
    for size in (1, 2, 3, 4, 8, 97):
        times = np.where(draw.random(size) < 0.3, -1, draw.integers(0, 20, size))
        assert quartiles(times, np.full(size, 20)) == tuple(decision_times(times))
    for size in (24, 28, 44):  # products of floats are just below a quarter, half or three quarters
        assert quartiles(range(size), [99] * size) == tuple(decision_times(range(size)))


@pytest.mark.parametrize(
    ("durations", "watched", "expected"),
    [
        ([1, -1, 5, 9], [9, 2, 9, 9], (1, 5, 9)),  # 1 - (1 - 1/4)(1 - 1/2) = 0.625 by 5, all by 9
        ([3, -1], [9, 3], (3, 3, None)),  # censored at the time of an event, it was still watched then
        ([3, -1], [9, 2], (3, 3, 3)),
        ([], [], (None, None, None)),
        ([-1, -1], [5, 7], (None, None, None)),
    ],
)
def test_censored_durations_count_until_they_end(durations, watched, expected):
    assert quartiles(durations, watched) == expected


# --- Intervals over runs ---


@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.99])
def test_the_intervals_over_runs_by_hand(confidence):
    """Of events 0 and 4 in 1 step each, chi-squared is 4, and so the dispersion: 1 event in half a step."""
    z = norm.ppf(0.5 + confidence / 2)
    weight = max(1, z * z / 4)  # of each of the two runs that are added
    total = 3 + 2 * weight
    wald = z * math.sqrt(((1.25 + weight) / total - 0.5**2) / total)  # shares 0.5, 0, 1; and 0 and 1
    assert mean_share([0.5, 0.0, 1.0], confidence) == pytest.approx(
        (0.5, max(0, 0.5 - wald), min(1, 0.5 + wald))
    )
    half = z * math.sqrt(7 / 3)  # of 1, 2 and 6 the variance is 14 / (3 - 1)
    assert mean_of([1, 2, 6], confidence) == pytest.approx((3, 3 - half, 3 + half))
    assert mean_of([1, 3], confidence) == pytest.approx((2, 2 - z, 2 + z))
    middle = 0.5 / total
    wald = z * math.sqrt(((0.75 + 2 * weight) / total - middle**2) / total)  # 0.5, 0.5, -0.5; and 1 and -1
    found = mean_difference([0.75, 1.0, 0.0], [0.25, 0.5, 0.5], confidence)
    assert found == pytest.approx((0.5 / 3, middle - wald, middle + wald))
    for events, total, time in (([0, 4], 1, 0.5), ([2, 2], 4, 2)):  # counts that vary less aren't divided
        middle, half = total + z * z / 2, z * math.sqrt(total + z * z / 4)
        expected = total / time, (middle - half) / time, (middle + half) / time
        for found in (
            event_rate(events, [1, 1], confidence),
            event_rate([*events, 0], [1, 1, 0], confidence),
        ):
            assert found == pytest.approx(expected)


def test_a_mean_of_less_than_two_runs_has_no_interval():
    assert [mean_of([5]).estimate, *map(math.isnan, mean_of([5])[1:])] == [5, True, True]
    assert all(map(math.isnan, mean_of([])))


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_an_interval_of_little_confidence_holds_its_estimate(share):
    """Without limits, those of 20 equal shares at 50 % would be 0.015 to 0.076 away from 0 or 1."""
    estimate, low, high = mean_share([share] * 20, 0.5)
    assert low <= estimate == share <= high
    assert high - low == pytest.approx(1 / 22 + norm.ppf(0.75) * math.sqrt((1 / 22 - 1 / 22**2) / 22))


def test_no_event_leaves_a_rate_of_up_to_four_events_open():
    assert event_rate([0, 0], [500, 500]).high == pytest.approx(1.959963984540054**2 / 1000)
    assert event_rate([2], [4]).estimate == 0.5


@pytest.mark.parametrize("shares", [[], [1.2], [-0.1], [float("nan")]])
def test_shares_that_are_none_are_refused(shares):
    with pytest.raises(ValueError, match="from 0 to 1"):
        mean_share(shares)


def test_a_rate_needs_a_time():
    with pytest.raises(ValueError, match="above 0"):
        event_rate([1], [0])
