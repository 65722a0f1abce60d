"""Figures of declarations: shares of runs by step, and by ratio."""

from __future__ import annotations

import numpy as np
import pytest
from declaring import declaring
from matplotlib.colors import to_hex

from feasibee.base.codes import COLOURS
from feasibee.base.record import Record
from feasibee.figures.comparison import draw_against_ratio
from feasibee.figures.decisions import plot_declare_steps
from feasibee.results.dataset import to_dataset
from feasibee.results.statistics import wilson


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Five runs: two declare rightly, one with a wrong robot, one wrongly, and one never."""
    record = Record.empty(0, 5, 0)
    record.declare_step[:] = 40, 90, 50, 60, -1
    record.declared_infeasible[:] = 20, 20, 18, 0, 5
    record.declared_feasible[:] = 0, 0, 1, 20, 0
    scenario = declaring(tmp_path_factory.mktemp("own"), tasks={"count": 30}, run={"steps": 200})
    return to_dataset(record, scenario, 0)


def test_runs_climb_at_their_step_split_into_right_and_wrong(results):
    ax = plot_declare_steps(results)
    right, wrong, median = ax.lines
    assert (right.get_label(), wrong.get_label()) == ("rightly", "a robot wrongly")
    np.testing.assert_array_equal(right.get_xdata(), [0, 40, 90, 200])
    np.testing.assert_allclose(right.get_ydata(), [0, 20, 40, 40])
    np.testing.assert_array_equal(wrong.get_xdata(), [0, 50, 60, 200])
    np.testing.assert_allclose(wrong.get_ydata(), [0, 20, 40, 40])
    assert [to_hex(line.get_color()).upper() for line in (right, wrong)] == [
        COLOURS["infeasible"],
        COLOURS["feasible"],
    ]
    assert (median.get_label(), median.get_xdata()[0]) == ("half of the runs: step 60", 60)
    assert ax.get_xlim() == (0, 200)
    late = plot_declare_steps(results.isel(run=[1]).assign(declare_step=("run", [150])))
    names = [text for each in (ax, late) for text in each.texts if "half" in text.get_text()]
    assert [(name.xy[0], name.get_ha()) for name in names] == [(60, "left"), (150, "right")]


def test_runs_that_never_declared_are_flat_lines(results):
    ax = plot_declare_steps(results.isel(run=[4]))
    assert [line.get_ydata().tolist() for line in ax.lines] == [[0, 0], [0, 0]]


def test_contenders_that_cant_declare_are_left_out_and_wrong_ones_marked():
    shares = {"dmmd": None, "sure": [wilson(10, 10), wilson(7, 10)]}
    wrong = {"sure": [wilson(0, 10), wilson(3, 10)]}
    (ax,) = draw_against_ratio(20, [10, 20], shares, "right (%)", wrong).axes
    assert [text.get_text().strip() for text in ax.texts] == ["sure"]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "with a robot that declared wrongly (%)"
    ]
    (crosses,) = (line for line in ax.lines if line.get_marker() == "x" and line.get_xdata().size)
    assert (crosses.get_xdata().tolist(), crosses.get_ydata().tolist()) == ([1], [30])
    (plain,) = draw_against_ratio(20, [10, 20], {"dmmd": shares["sure"]}).axes
    assert plain.get_legend() is None
