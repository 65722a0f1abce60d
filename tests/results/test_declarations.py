"""Declarations and swarms that are right at the end: counts by hand, intervals by their definition."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
from declaring import declaring

from feasibee import Scenario
from feasibee.base.record import Record
from feasibee.results.dataset import to_dataset
from feasibee.results.measures import declarations, declared_right, declared_wrong, ended_right
from feasibee.results.statistics import declare_times, plain, wilson


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    """A scenario of 20 robots that declare."""
    return declaring(tmp_path_factory.mktemp("own"))


def record_of(**columns):
    """Return a record with these outcomes; the others have their fill values."""
    record = Record.empty(0, len(next(iter(columns.values()))), 0)
    for name, values in columns.items():
        getattr(record, name)[:] = values
    return record


# --- Runs that are right and wrong ---


def test_a_run_is_ok_if_enough_robots_declared_rightly_and_none_wrongly():
    record = record_of(declared_feasible=[20, 19, 18, 19, 0], declared_infeasible=[0, 0, 0, 1, 20])
    assert declared_right(record, Scenario(), True).tolist() == [True, True, False, False, False]
    assert declared_wrong(record, Scenario(), True).tolist() == [False, False, False, True, True]
    assert declared_right(record, Scenario(), False).tolist() == [False] * 4 + [True]
    assert declared_wrong(record, Scenario(), False).tolist() == [True] * 4 + [False]


def test_a_run_is_right_at_the_end_if_enough_robots_hold_the_truth():
    record = record_of(feasible_at_end=[20, 19, 18, 0], infeasible_at_end=[0, 1, 0, 20])
    assert ended_right(record, Scenario(), True).tolist() == [True, True, False, False]
    assert ended_right(record, Scenario(), False).tolist() == [False, False, False, True]


def test_enough_is_more_than_the_threshold_exactly():
    """0.57 of 100 robots are 57, and 57 are not more; with floats, 0.57 * 100 is less than 57."""
    scenario = Scenario(robots={"count": 100}, decision={"threshold": 0.57})
    record = record_of(feasible_at_end=[57, 58])
    assert ended_right(record, scenario, True).tolist() == [False, True]


def test_only_robots_that_count_at_the_end_of_a_run_are_asked():
    """4 of 20 robots lie, and 6 stop at step 50: 16 count before, 10 from then on."""
    faults = {"byzantine": 0.2, "stopped": 0.3, "stop_step": 50}
    record = record_of(declared_feasible=[10, 9, 15, 10, 10], decision_step=[-1, -1, 40, 40, 0])
    whole = Scenario(faults=faults)
    assert declared_right(record, whole, True).tolist() == [True, False, True, True, True]
    until = Scenario(faults=faults, run={"steps": 50})
    assert declared_right(record, until, True).tolist() == [True, False, True, True, True]
    short = Scenario(faults=faults, run={"steps": 49})
    assert declared_right(record, short, True).tolist() == [False, False, True, False, False]
    early = Scenario(faults=faults, run={"stop_at_decision": True})
    assert declared_right(record, early, True).tolist() == [True, False, True, False, False]


# --- Their statistics ---


def test_the_statistics_are_shares_with_intervals_and_quantiles_of_all_runs(quiet):
    record = record_of(
        declared_feasible=[20] * 7 + [19, 5, 0],
        declared_infeasible=[0] * 7 + [1, 0, 0],
        declare_step=[*range(101, 109), -1, -1],
    )
    found = declarations(record, quiet)
    assert (found.ok, found.wrong) == (wilson(7, 10), wilson(1, 10))
    assert found.step_90 == declare_times(record.declare_step)
    assert (found.step_90.median, found.step_90.p95) == (105, None)
    assert plain(found) == {
        "feasible": 164 / 200,
        "infeasible": 1 / 200,
        "ok": wilson(7, 10)._asdict(),
        "wrong": wilson(1, 10)._asdict(),
        "step_90": {"median": 105, "p95": None, "median_interval": [102, None], "p95_interval": [108, None]},
    }
    again = declarations(to_dataset(record, quiet, 0), quiet)
    assert again == found


def test_without_declare_or_runs_there_are_no_statistics(quiet):
    assert declarations(record_of(declared_feasible=[20]), Scenario()) is None
    assert declarations(Record.empty(0, 0, 0), quiet) is None


# --- Quantiles ---


def below(runs, share, most):
    return sum(comb(runs, k) * share**k * (1 - share) ** (runs - k) for k in range(most + 1))


@pytest.mark.parametrize("runs", [1, 5, 20, 71, 72, 73, 200])
def test_the_interval_is_that_of_order_statistics(runs):
    """Ranks low and high with P(B < low) and P(B >= high) at most 2.5 %, as close together as can be."""
    times = declare_times(np.arange(1, runs + 1))
    for share, ends in ((0.5, times.median_interval), (0.95, times.p95_interval)):
        low = max(rank for rank in range(runs + 1) if below(runs, share, rank - 1) <= 0.025)
        high = min(rank for rank in range(1, runs + 2) if below(runs, share, rank - 1) >= 0.975)
        assert ends == (low, high if high <= runs else None)


def test_half_of_the_runs_is_a_median_and_one_less_is_not():
    assert declare_times(np.array([7, -1])).median == 7
    assert declare_times(np.array([0, 0])).median == 0
    assert declare_times(np.array([7, -1, -1])).median is None
    assert declare_times(np.array([5] * 19 + [-1])).p95 == 5
    assert declare_times(np.array([5] * 18 + [-1] * 2)).p95 is None
    assert declare_times(np.empty(0, np.int64)) == (None, None, (None, None), (None, None))


def test_many_runs_have_ranks_near_those_of_the_normal_distribution():
    times = declare_times(np.arange(200_000))
    np.testing.assert_allclose(times.median_interval, (99_561, 100_438), atol=3)
    np.testing.assert_allclose(times.p95_interval, (189_808, 190_191), atol=3)
