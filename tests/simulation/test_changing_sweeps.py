"""Sweeps of worlds that change: the truth of each step goes in, comes out, and judges what is exported."""

from __future__ import annotations

import json

import pandas as pd
import pytest
import xarray as xr
from commands import json_of
from stores import filled

from feasibee import Scenario, wilson
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
from feasibee.simulation.plan import DesignPoint
from feasibee.simulation.store import Store
from feasibee.simulation.table import export

WORLD = {"arena": {"side": 6.0}, "robots": {"count": 5}, "tasks": {"count": 3}, "run": {"steps": 60}}
STILL = Scenario(**WORLD)
CHANGING = Scenario(**WORLD, events=[{"step": 30, "tasks": 4}], decision={"exploration": 6, "gain": 5.0})


@pytest.fixture(scope="module")
def records():
    """Records of a world that stays and of one that changes."""
    return [simulate_record(each, Runs(12, 7), backend="reference") for each in (STILL, CHANGING)]


@pytest.fixture
def folder(records, tmp_path):
    """A folder with the runs of both."""
    points = [DesignPoint({"name": name}, each) for name, each in (("still", STILL), ("changing", CHANGING))]
    return filled(tmp_path / "results", points, records, 7)


def test_status_has_the_measures_of_each_point(folder, records):
    still, changing = json_of("results", "status", folder)
    assert {still[name] for name in ("right_share", "missed", "false_alarms", "detection_delay")} == {None}
    found = tracking(records[1], CHANGING).to_dict()
    assert {name: changing[name] for name in found} == json.loads(json.dumps(found))
    assert changing["bits_per_robot_and_step"] == pytest.approx(mean_bits(records[1], CHANGING))
    right = ended_right(records[1], CHANGING)
    assert changing["right_at_end"] == wilson(int(right.sum()), 12)._asdict()


def test_an_export_has_the_measures_of_each_run(folder, records, tmp_path):
    for name in ("a.csv", "a.nc"):
        export(Store(folder), tmp_path / name)
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
