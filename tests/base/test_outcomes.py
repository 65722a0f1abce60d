"""The table of outcomes: records, datasets, sweeps, exports and docs have its columns, and no others."""

from __future__ import annotations

import csv
import runpy
from pathlib import Path

import numpy as np
import pytest
from declaring import declaring
from stores import PLACES, filled, rows_in

from feasibee import Scenario, save_results
from feasibee.base.outcomes import ACCOUNT, CURVES, DECLARES, OUTCOMES, TRACES
from feasibee.base.record import Record
from feasibee.results.dataset import to_dataset
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.plan import DesignPoint
from feasibee.simulation.store import Store
from feasibee.simulation.table import export

NAMES = [each.name for each in OUTCOMES]
SCENARIO = Scenario(robots={"count": 5}, run={"steps": 30}, decision={"declare": {"rounds": 1, "heard": 1}})
DOCS = Path(__file__).parents[2] / "docs" / "_extensions" / "outcomes.py"


@pytest.fixture(scope="module")
def record():
    return simulate_record(SCENARIO, Runs(4, 1, 2), curves=True)


def test_an_empty_record_has_the_fill_values_and_types_of_the_table():
    record = Record.empty(0, 3, 2, 4)
    for outcomes, shape in ((OUTCOMES, (3,)), (CURVES, (3, 2)), (TRACES, (3, 4))):
        for each in outcomes:
            array = getattr(record, each.name)
            assert (array.shape, array.dtype, set(array.flat)) == (shape, each.dtype, {each.fill})
    with pytest.raises(AttributeError, match="no outcome 'sent'"):
        record.sent  # noqa: B018


def test_a_column_of_the_account_is_an_attribute_to_write_to(record):
    part = record.part(1, 3)
    part.bits_sent[:] = 7
    assert record.account[:, 0].tolist()[1:3] == [7, 7]
    assert (part.first_run, part.runs, len(ACCOUNT)) == (3, 2, part.account.shape[1])


def test_longer_curves_keep_what_was_there():
    record = Record.empty(5, 2, 2)
    record.feasible_count[:] = [[1, 2], [3, 4]]
    record.decision[:] = 1, 0
    record.bits_sent[:] = 8, 9
    longer = record.lengthened(3)
    assert longer.truth.shape == (2, 0)
    assert Record.empty(5, 2, 2, 2).lengthened(3).truth.tolist() == [[-1] * 3] * 2
    assert longer.first_run == 5
    assert longer.feasible_count.tolist() == [[1, 2, -1], [3, 4, -1]]
    assert longer.infeasible_count.tolist() == [[-1] * 3] * 2
    assert (longer.decision.tolist(), longer.bits_sent.tolist()) == ([1, 0], [8, 9])


def test_a_dataset_has_the_columns_of_the_table(record, tmp_path):
    by_votes, sure = (to_dataset(record, each, 1) for each in (SCENARIO, declaring(tmp_path)))
    without = to_dataset(record, SCENARIO.replace({"decision.declare": None}), 1)
    stops = Scenario(acting={"start": 9}, run={"stop_when_taken": True}, tasks={"work": 5})
    stopping = to_dataset(record, stops, 1)
    curves = [each.name for each in CURVES]
    for dataset, needs in ((by_votes, DECLARES), (sure, DECLARES), (without, None)):
        had = [each.name for each in OUTCOMES if each.needs in (None, needs)]
        assert list(dataset.data_vars) == [*had, *curves]
    saying = to_dataset(record, Scenario(decision={"strategy": "bayes"}), 1)
    variables = {**stopping.data_vars, **saying.data_vars, **sure.data_vars}
    assert set(variables) == {*NAMES, *curves}
    for each in (*OUTCOMES, *CURVES):
        assert variables[each.name].dtype == each.dtype
        assert variables[each.name].attrs["long_name"].startswith(each.words)
        assert variables[each.name].attrs.get("units", "") == each.unit


def test_a_dataset_of_a_world_that_changes_has_its_traces():
    record = Record.empty(0, 2, 0, 3)
    dataset = to_dataset(record, Scenario(), 1)
    for each in TRACES:
        assert dataset[each.name].dims == ("run", "step")
        assert dataset[each.name].dtype == each.dtype
        assert dataset[each.name].attrs["long_name"].startswith(each.words)
    assert dataset["step"].values.tolist() == [0, 1, 2]
    assert "feasible_count" not in dataset


def test_files_and_folders_have_the_columns_of_the_table(record, tmp_path):
    """A file of results lacks the outcomes that its scenario can't have; a folder has all columns."""
    save_results(to_dataset(record, SCENARIO, 1), tmp_path / "runs.csv")
    store = Store(filled(tmp_path / "sweep", [DesignPoint({}, SCENARIO)], [record], 1))
    export(store, tmp_path / "sweep.csv")
    stored = rows_in(store, store.points[0])
    np.testing.assert_array_equal(stored[:, 1:].T, [getattr(record, name) for name in NAMES])
    with (tmp_path / "runs.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["run", *(each.name for each in OUTCOMES if each.needs in (None, DECLARES))]
    places = [PLACES[name] for name in header]
    assert rows == stored[:, places].astype(str).tolist()
    with (tmp_path / "sweep.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header[-len(NAMES) - 1 :] == ["run", *NAMES]
    assert [row[-len(NAMES) :] for row in rows] == stored[:, 1:].astype(str).tolist()


def test_each_outcome_says_what_it_is_and_in_which_unit():
    for each in (*OUTCOMES, *CURVES, *TRACES):
        assert len(each.words.split()) >= 5, each.name
        assert bool(each.unit) != bool(each.codes), each.name
        assert each.fill >= 0 or each.missing or each.codes, each.name


def test_the_documentation_shows_the_table():
    pytest.importorskip("sphinx")
    rows = list(runpy.run_path(str(DOCS))["lines"]())[2:]
    names = [row.split("`")[1] for row in rows]
    assert names == [*NAMES, *(each.name for each in (*CURVES, *TRACES))]
    assert "-1: never; only with `decision.declare`" in rows[3]
