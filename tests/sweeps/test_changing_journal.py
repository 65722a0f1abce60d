"""Journals of worlds that change: the truth of each step goes in, comes out, and judges what is exported."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from commands import json_of
from journals import write

from feasibee import FeasibeeError, Scenario, wilson
from feasibee.model.outcomes import OUTCOMES, TRACES
from feasibee.model.record import Record
from feasibee.results.measures import (
    OF_RUNS,
    decided_right,
    ended_right,
    mean_bits,
    measures_of_runs,
    tracking,
)
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.sweeps.journal import Journal, merge
from feasibee.sweeps.plan import DesignPoint
from feasibee.sweeps.schema import NAME
from feasibee.sweeps.table import export

WORLD = {"arena": {"side": 6.0}, "robots": {"count": 5}, "tasks": {"count": 3}, "run": {"steps": 60}}
STILL = Scenario(**WORLD)
CHANGING = Scenario(**WORLD, events=[{"step": 30, "tasks": 4}], decision={"exploration": 6, "gain": 5.0})


@pytest.fixture(scope="module")
def records():
    """Records of a world that stays and of one that changes."""
    return [simulate_record(each, Runs(12, 7), backend="reference") for each in (STILL, CHANGING)]


@pytest.fixture
def folder(records, tmp_path):
    """A folder with a journal of both."""
    folder = tmp_path / "journal"
    folder.mkdir()
    points = [DesignPoint({"name": name}, each) for name, each in (("still", STILL), ("changing", CHANGING))]
    with Journal(folder, write=True) as journal:
        numbers = journal.add(points, 7)
        write(journal, zip(numbers, records, strict=True))
    return folder


def test_traces_that_go_in_come_out(folder, records):
    length = CHANGING.run.steps + 1
    with Journal(folder) as journal:
        back = journal.record(2, Record.empty(0, 12, 0, length))
        results = journal.results(2)
        assert not hasattr(journal.results(1), "truth")
    for each in TRACES:
        for found in (back, results):
            np.testing.assert_array_equal(getattr(found, each.name), getattr(records[1], each.name))
            assert getattr(found, each.name).dtype == each.dtype
    for each in OUTCOMES:
        np.testing.assert_array_equal(getattr(results, each.name), getattr(records[1], each.name))


def test_runs_without_their_traces_are_missing(folder):
    with closing(sqlite3.connect(folder / NAME, isolation_level=None)) as database:
        database.execute("DELETE FROM traces WHERE run = 3")
    with Journal(folder) as journal, pytest.raises(FeasibeeError, match="damaged"):
        journal.results(2)
    with Journal(folder, write=True, rescue=True) as journal:
        assert "12 undamaged runs" in journal.rescued or "24 undamaged runs" in journal.rescued
        assert journal.missing(2, 0, 12, False, True) == [(0, 12)]
        assert journal.missing(1, 0, 12, False) == []
    (still, changing) = json_of("results", "status", folder)
    assert (still["runs"], changing["runs"]) == (12, 0)
    assert changing["right_share"] is None


@pytest.mark.parametrize("table", ["traces", "runs"])
def test_runs_that_have_kept_their_traces_are_still_read(records, tmp_path, table):
    with Journal(tmp_path, write=True) as journal:
        (number,) = journal.add([DesignPoint({}, CHANGING)], 7)
        write(journal, [(number, records[1].part(0, 4))])
        write(journal, [(number, records[1].part(4, 12))])
    with closing(sqlite3.connect(tmp_path / NAME, isolation_level=None)) as database:
        database.execute(f"DELETE FROM {table} WHERE run = 2")
    with Journal(tmp_path, write=True, rescue=True) as journal:
        results = journal.results(1)
        assert journal.missing(1, 0, 12, False, True) == [(0, 4)]
    assert results.run.tolist() == list(range(4, 12))
    np.testing.assert_array_equal(results.decision, records[1].decision[4:])
    np.testing.assert_array_equal(results.held, records[1].held[4:])


def test_status_has_the_measures_of_each_point(folder, records):
    still, changing = json_of("results", "status", folder)
    assert {still[name] for name in ("right_share", "missed", "false_alarms", "detection_delay")} == {None}
    found = tracking(records[1], CHANGING).to_dict()
    assert {name: changing[name] for name in found} == json.loads(json.dumps(found))
    assert changing["bits_per_robot_and_step"] == pytest.approx(mean_bits(records[1], CHANGING))
    right = ended_right(records[1], CHANGING)
    assert changing["right_at_end"] == wilson(int(right.sum()), 12)._asdict()


def test_an_export_has_the_measures_of_each_run(folder, records, tmp_path):
    with Journal(folder) as journal:
        for name in ("a.csv", "a.nc"):
            export(journal, tmp_path / name)
    table = pd.read_csv(tmp_path / "a.csv")
    expected = measures_of_runs(records[1])
    with xr.open_dataset(tmp_path / "a.nc") as opened:
        for name in OF_RUNS:
            assert table[name][:12].isna().all()
            assert table[name][12:].tolist() == expected[name].tolist()
            assert opened[name].sel(name="still").values.tolist() == [-1] * 12
            assert opened[name].sel(name="changing").values.tolist() == expected[name].tolist()
            assert opened[name].attrs["long_name"] == OF_RUNS[name]
    assert table["right"][12:].tolist() == decided_right(records[1], CHANGING).tolist()
    assert table["right_at_end"][12:].tolist() == ended_right(records[1], CHANGING).tolist()


def test_journals_are_merged_with_their_traces_unless_one_differs(folder, records, tmp_path):
    held = records[1].held.copy()
    held[5, 17] = 1 - np.maximum(held[5, 17], 0)
    with Journal(tmp_path, write=True) as journal:
        (number,) = journal.add([DesignPoint({}, CHANGING)], 7)
        write(journal, [(number, replace(records[1], held=held))])
        with pytest.raises(FeasibeeError, match=r"run 5: held at step 17 is -?\d in"):
            merge(journal, [folder])
    (tmp_path / "other").mkdir()
    with Journal(tmp_path / "other", write=True) as journal:
        assert [merge(journal, [folder]) for _ in "12"] == [24, 0]
        np.testing.assert_array_equal(journal.results(2).held, records[1].held)
