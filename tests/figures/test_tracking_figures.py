"""Figures of worlds that change: the truth behind the curves, and delay against bits."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from feasibee import Scenario, plot_opinions
from feasibee.base.record import Record
from feasibee.figures.comparison import draw_delay_against_bits, draw_right_over_time
from feasibee.figures.decisions import SHADE, draw_truth, infeasible_share, plot_right_steps
from feasibee.figures.style import figure
from feasibee.results.dataset import to_dataset
from feasibee.results.statistics import Quartiles

SCENARIO = Scenario(run={"steps": 9}, events=[{"step": 4, "tasks": 5}])
TRUTH = np.array([[1] * 4 + [0] * 6] * 2, np.int8)


def results(truth=TRUTH):
    """Two runs of ten robots, of which five leave at step 6; run 1 follows the change at step 8."""
    record = Record.empty(0, 2, 10, 10)
    record.truth[:] = truth
    record.held[:] = [[1] * 10, [1] * 8 + [0] * 2]
    record.robots_present[:] = [10] * 6 + [5] * 4
    record.tasks_present[:] = 9
    record.feasible_count[:] = [[10] * 6 + [5] * 4, [10] * 6 + [5, 5, 0, 0]]
    record.infeasible_count[:] = record.robots_present - record.feasible_count
    return to_dataset(record, SCENARIO, 0)


def band(ax):
    """Return the grey of each step behind an axis: 1 is white."""
    (mesh,) = (each for each in ax.collections if isinstance(each, QuadMesh))
    ax.figure.draw_without_rendering()
    return mesh.get_facecolors()[:, 0]


def names(ax):
    return [text.get_text() for text in ax.texts]


def test_infeasible_steps_are_grey_and_each_stretch_is_named():
    with figure(3, 2) as (_, ax):
        draw_truth(ax, infeasible_share(TRUTH))
    np.testing.assert_allclose(band(ax), [1.0] * 4 + [SHADE] * 6, atol=0.01)
    assert names(ax) == ["feasible", "infeasible"]
    assert [text.xy[0] for text in ax.texts] == [2.0, 6.5]


def test_a_short_stretch_has_no_name():
    with figure(3, 2) as (_, ax):
        draw_truth(ax, np.array([0.0] * 50 + [1.0] * 5 + [0.0] * 50))
    assert names(ax) == ["feasible", "feasible"]


def test_where_runs_differ_the_grey_is_as_dark_as_many_are_infeasible():
    truth = TRUTH.copy()
    truth[1, 2] = 0
    with figure(3, 2) as (_, ax):
        draw_truth(ax, infeasible_share(truth))
    shades = band(ax)
    assert shades[2] == pytest.approx((1 + SHADE) / 2, abs=0.01)
    assert names(ax) == ["grey: share of runs whose tasks are infeasible"]


def test_opinions_have_the_truth_behind_them_as_shares_of_the_robots_present():
    ax = plot_opinions(results())
    np.testing.assert_allclose(band(ax), [1.0] * 4 + [SHADE] * 6, atol=0.01)
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_ydata(), [100.0] * 8 + [50.0] * 2)
    assert ax.get_ylim()[1] > 102  # room for the names


def test_right_steps_are_shares_of_the_runs():
    ax = plot_right_steps(results())
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_ydata(), [100.0] * 4 + [0.0] * 4 + [50.0] * 2)
    assert ax.get_xlim() == (0, 9)


def test_contenders_are_drawn_over_time_with_the_truth_behind():
    shares = {"one": np.linspace(0, 1, 10), "other": np.full(10, 0.3)}
    (ax,) = draw_right_over_time(shares, infeasible_share(TRUTH)).axes
    np.testing.assert_allclose(band(ax), [1.0] * 4 + [SHADE] * 6, atol=0.01)
    lines = [line for line in ax.lines if len(line.get_ydata()) == 10]
    np.testing.assert_allclose(lines[0].get_ydata(), 100 * shares["one"])
    assert {"one", "other"} <= {text.get_text().strip() for text in ax.texts}


def test_the_front_of_delay_and_bits_is_highlighted_and_never_stands_at_the_top():
    contenders = {
        "cheap": (5.0, Quartiles(80, 100, None)),
        "good": (20.0, Quartiles(30, 40, 60)),
        "beaten": (30.0, Quartiles(50, 60, 70)),
        "blind": (2.0, Quartiles(None, None, None)),
    }
    (ax,) = draw_delay_against_bits(contenders, 1000).axes
    points = {line.get_xdata()[0]: line for line in ax.lines if line.get_marker() not in ("None", "")}
    assert {x: line.get_ydata()[0] for x, line in points.items()} == pytest.approx(
        {5.0: 100, 20.0: 40, 30.0: 60, 2.0: 1.15 * 100}
    )
    colours = {x: line.get_color() for x, line in points.items()}
    assert colours[30.0] == colours[2.0] == "0.72"
    assert len({colours[5.0], colours[20.0], "0.72"}) == 3
    assert points[2.0].get_markerfacecolor() == "white"
    assert {"cheap", "good", "beaten", "blind"} <= set(names(ax))
    assert [text.get_text() for text in ax.get_yticklabels()][-1] == "never"
    assert "of 1,000" in ax.get_ylabel()


def test_contenders_that_never_follow_have_a_figure_too():
    draw_delay_against_bits({"blind": (0.0, Quartiles(None, None, None))}, 50)
