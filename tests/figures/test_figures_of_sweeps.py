"""What a reader of a sweep's figure, and of a comparison's, reads off it: heights, bands, ends, names."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest

from feasibee.figures.comparison import draw_delay_against_bits
from feasibee.figures.decisions import Panel, draw_panels
from feasibee.figures.labels import Point, label_points
from feasibee.figures.style import PLAIN, looks
from feasibee.figures.sweep import Shown, draw_lines, draw_maps
from feasibee.results.statistics import Interval, Quartiles, wilson

RISES = {1: Interval(0.2, 0.1, 0.3), 2: Interval(0.6, 0.5, 0.8)}
UNKNOWN = Interval(np.nan, np.nan, np.nan)


def test_a_line_has_its_shares_in_percent_a_band_and_its_name_at_its_last_point():
    (ax,) = draw_lines({"": {5.0: RISES}}, Shown("tasks.count", "accuracy", "sensing.range")).axes
    (line,), (band,) = ax.lines[:1], ax.collections
    assert line.get_ydata().tolist() == pytest.approx([20, 60])
    corners = {(x, round(y)) for x, y in band.get_paths()[0].vertices.tolist()}
    assert corners == {(1.0, 10), (1.0, 30), (2.0, 50), (2.0, 80)}
    (name,) = (text for text in ax.texts if text.get_text().strip() == "5")
    assert name.xy == pytest.approx((2, 60))


def test_only_lines_without_any_value_never_followed():
    lines = {"a": {1: UNKNOWN, 2: UNKNOWN}, "b": {1: UNKNOWN, 2: Interval(9.0, 8.0, 10.0)}}
    (ax,) = draw_lines({"": lines}, Shown("tasks.count", "detection_delay", "decision.strategy")).axes
    assert "half of the changes never followed: a" in [text.get_text() for text in ax.texts]


def test_of_what_is_better_small_the_line_with_most_is_grey():
    lines = {f"rule-{k}": {1: wilson(10 * k, 100), 2: wilson(10 * k, 100)} for k in range(7)}
    for show, grey in (("accuracy", "rule-1, rule-2"), ("missed", "rule-5, rule-6")):
        drawn = draw_lines({"": lines}, Shown("tasks.count", show, "decision.strategy"))
        assert drawn._supxlabel.get_text() == f"grey: {grey}"


def test_a_map_rises_and_its_colours_reach_from_none_to_all():
    drawn = draw_maps(
        {"": {1: RISES, 2: {2: wilson(9, 9)}}}, Shown("tasks.count", "accuracy", y="sensing.range")
    )
    ax, (image,) = drawn.axes[0], drawn.axes[0].images
    assert (image.origin, image.get_clim()) == ("lower", (0, 100))
    assert {text.get_text(): text.get_position() for text in ax.texts} == {
        "20": (0, 0),
        "60": (1, 0),
        "100": (1, 1),
    }


def test_a_highlighted_point_has_its_name_nearest():
    _, ax = plt.subplots()
    look = looks({"best": 1.0})["best"]
    points = [Point(name, 5, 50, PLAIN, 49, 51) for name in "abcdefgh"] + [Point("best", 5, 50, look, 49, 51)]
    ax.set(xlim=(0, 10), ylim=(0, 100))
    label_points(ax, points)
    first, *_ = ax.texts
    assert first.get_text() == "best"
    plt.close(ax.figure)


def test_delays_have_their_steps_at_the_axis_and_those_without_any_stand_at_never():
    ax = draw_delay_against_bits(
        {"a": (5.0, Quartiles(20, 40, 80)), "b": (9.0, Quartiles(90, None, None))}, 500
    ).axes[0]
    ticks = dict(zip((tick.get_text() for tick in ax.get_yticklabels()), ax.get_yticks(), strict=True))
    assert ticks.pop("never") == pytest.approx(1.15 * 80)
    assert ticks == {name: float(name) for name in ticks}
    assert len(ticks) > 2


def test_panels_mark_where_tasks_become_infeasible_and_repeat_the_first_faintly():
    rates = {
        name: [wilson(k, 9), wilson(9 - k, 9)]
        for k, name in enumerate(("feasible", "infeasible", "undecided"))
    }
    first, second = draw_panels(
        [Panel("one", [0.5, 2.0], rates, 1.0), Panel("two", [0.5, 2.0], rates, 0.5)]
    ).axes[:2]
    tips = [next(line for line in ax.lines if line.get_linestyle() == ":") for ax in (first, second)]
    assert [tip.get_xdata()[0] for tip in tips] == [1.0, 0.5]
    faint = [[line for line in ax.lines if line.get_alpha() == 0.22] for ax in (first, second)]
    assert [len(each) for each in faint] == [0, 2]
