"""The public `sweep` and `open_results`: a table of all runs, that a scientist can index."""

from __future__ import annotations

import numpy as np
import pytest

import feasibee
from feasibee import FeasibeeError, Scenario
from feasibee.simulation import executors

SMALL = Scenario(arena={"side": 6.0}, robots={"count": 5}, run={"steps": 40})
VARY = {"tasks.count": [2, 9], "radio.loss": np.array([0.0, 0.25, 0.5])}


@pytest.fixture(scope="module")
def table():
    return feasibee.sweep(SMALL, VARY, runs=12, seed=3)


def test_each_point_has_the_runs_of_its_scenario(table):
    assert dict(table.sizes) == {"tasks.count": 2, "radio.loss": 3, "run": 12}
    for tasks in (2, 9):
        for loss in (0.0, 0.25, 0.5):
            scenario = SMALL.replace({"tasks.count": tasks, "radio.loss": loss})
            alone = feasibee.simulate(scenario, runs=12, seed=3)
            point = table.sel({"tasks.count": tasks, "radio.loss": loss})
            for name in alone.data_vars:
                np.testing.assert_array_equal(point[name], alone[name])
            assert point.truth == feasibee.truth(scenario)
            np.testing.assert_array_equal(point.right, alone.decision == point.truth)


def test_fields_may_go_in_step():
    table = feasibee.sweep(SMALL, {"tasks.count": (2, 9), "radio.loss": [0.0, 0.5]}, runs=4, combine="zip")
    assert dict(table.sizes) == {"point": 2, "run": 4}
    assert table["radio.loss"].values.tolist() == [0.0, 0.5]


def test_a_folder_keeps_the_runs(table, tmp_path, monkeypatch):
    told = []
    kept = feasibee.sweep(SMALL, VARY, runs=12, seed=3, out=tmp_path, progress=told.append)
    assert kept.identical(table)
    assert told[-1] == 1.0
    assert feasibee.open_results(tmp_path).identical(table)
    monkeypatch.setattr(executors, "play", None)  # nothing is computed again
    assert feasibee.sweep(SMALL, VARY, runs=12, seed=3, out=tmp_path).identical(table)
    fewer = feasibee.sweep(SMALL, {"tasks.count": [9]}, runs=5, seed=3, out=tmp_path)
    np.testing.assert_array_equal(
        fewer.decision.sel({"tasks.count": 9}), table.decision.sel({"tasks.count": 9, "radio.loss": 0})[:5]
    )


@pytest.mark.parametrize(
    ("vary", "rule"),
    [
        ({"tasks.count": []}, r"vary\['tasks.count'\] = \[\]: must be a list of values"),
        (3, r'vary = 3: must be fields with their values; such as \{"tasks.count": \[10, 20\]\}'),
        ({"tasks.count": 5}, r"vary\['tasks.count'\] = 5: must be a list of values"),
        ({"tasks.count": "abc"}, "must be a list of values"),
        ({"tasks.coun": [1]}, "tasks.coun = 1: unknown key; did you mean tasks.count"),
        ({"tasks.count": [-1], "radio.loss": [2.0]}, r"(?s)tasks.count = -1.*radio.loss = 2.0"),
    ],
)
def test_what_isnt_a_sweep_is_told(vary, rule):
    with pytest.raises(FeasibeeError, match=rule):
        feasibee.sweep(SMALL, vary)


@pytest.mark.parametrize("wrong", [{"runs": 0}, {"seed": -1}, {"combine": "other"}, {"progress": 3}])
def test_other_arguments_that_are_wrong_are_told(wrong):
    with pytest.raises(FeasibeeError, match=next(iter(wrong))):
        feasibee.sweep(SMALL, {"tasks.count": [2]}, **wrong)
