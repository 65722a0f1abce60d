"""What robots that act achieved, from outcomes that are written by hand."""

from __future__ import annotations

import math

import pytest

from feasibee import Scenario
from feasibee.base.record import Record
from feasibee.results.measures import achieved, acts_of, last_steps, measured, together

SCENARIO = Scenario(robots={"count": 4, "speed": 0.5}, acting={"start": 5}, run={"stop_when_taken": True})


@pytest.fixture
def record():
    record = Record.empty(0, 5, 0)
    record.first_taken_step[:] = 6, 7, 6, 8, 6
    record.all_taken_step[:] = 9, -1, 30, 12, 20
    record.tasks_taken[:] = 4, 3, 4, 4, 4
    record.distance_walked[:] = 32, 400, 80, 40, 48
    record.vain_arrivals[:] = 0, 5, 1, 0, 1
    record.starts_in_vain[:] = 0, 3, 0, 0, 0
    record.last_step[:] = 9, 1000, 30, 12, 20
    return record


def test_steps_shares_and_means_are_those_of_the_runs(record):
    acting = measured(record, SCENARIO).acting
    assert (acting.all_taken_step.median, acting.all_taken_step.p95) == (20, None)
    assert (acting.first_taken_step.median, acting.first_taken_step.p95) == (6, 8)
    assert (acting.done.estimate, acting.started_in_vain.estimate) == (0.8, 0.2)
    assert acting.done.low < 0.8 < acting.done.high
    assert (acting.tasks_taken.estimate, acting.vain_arrivals.estimate) == (3.8, 1.4)
    assert acting.distance.estimate == pytest.approx(600 * 0.5 / 4 / 5)


def test_tasks_that_take_time_are_done_later(record):
    record.all_done_step[:] = 19, -1, 40, 22, 30
    working = SCENARIO.replace({"tasks.work": 10})
    assert measured(record, working).acting.all_done_step.median == 30
    assert measured(record, SCENARIO).acting.all_done_step is None


def test_runs_of_two_parts_count_together(record):
    parts = [record.part(0, 2), record.part(2, 5)]
    assert achieved([acts_of(each, SCENARIO) for each in parts]) == measured(record, SCENARIO).acting
    found = [measured(each, SCENARIO) for each in parts]
    assert together(found, "makespan")[:2] == (20, 0)
    assert math.isnan(together(found, "makespan").high)  # a fifth of the runs never ended
    assert together(found, "distance").estimate == pytest.approx(15)
    assert together(found, "done").estimate == 0.8
    assert math.isnan(together([measured(record, Scenario())], "makespan").estimate)


def test_a_run_that_ends_when_all_is_taken_has_no_later_steps(record):
    assert last_steps(record, SCENARIO).tolist() == [9, 1000, 30, 12, 20]


def test_tables_have_what_robots_did_only_if_they_act(record):
    acting = measured(record, SCENARIO).to_dict()["acting"]
    assert acting["all_taken_step"]["median"] == 20
    assert acting["done"]["estimate"] == 0.8
    assert "acting" not in measured(record, Scenario()).to_dict()
    assert measured(record.part(0, 0), SCENARIO).acting is None
