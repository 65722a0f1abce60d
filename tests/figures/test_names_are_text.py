"""Names of strategy files, zones and scenarios are text in every figure, whatever letters they have."""

from __future__ import annotations

import io
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from walled import DOCK, PLACE

from feasibee import Scenario, Swarm, plot_arena, plot_opinions, wilson
from feasibee.base.errors import one_line
from feasibee.base.record import Record
from feasibee.figures import comparison, sweep
from feasibee.figures.style import NAME_LIMIT, save_figure
from feasibee.results.calibration import Bin, Calibration
from feasibee.results.dataset import to_dataset
from feasibee.results.statistics import Interval, Quartiles

NAMES = ["$\\frac{$", "$x$", "<b>&amp;\n\u202e\udc80", "$" * 3 + "\\" + "long" * 999, "\\$a_b^c\\"]
"""As many as have a colour of their own."""
MORE = ["", "%", "{}", "--]]>", "\\", "\\\\$", "$\\$", "a$b", "a$b$c$d", "\x00\x1b[31m", "\u200b", "\t", "_"]
"""Names for the slow tests, in addition."""
RESULTS = to_dataset(
    replace(
        Record.empty(0, 1, 0),
        decision=np.array([1], np.int8),
        decision_step=np.array([4], np.int32),
        feasible_count=np.full((1, 6), 9, np.int32),
        infeasible_count=np.full((1, 6), 1, np.int32),
    ),
    Scenario(robots={"count": 10}, run={"steps": 5}),
    seed=0,
)


def shares(names):
    return {name: [wilson(9 - number, 9)] * 2 for number, name in enumerate(names)}


def curves(names, *shape):
    return {name: np.full(shape, number / 9) for number, name in enumerate(names)}


def totals(names):
    return {name: (4.0**number, wilson(number, 9)) for number, name in enumerate(names)}


def delays(names):
    found = {name: Quartiles(9 - number, 9, 9) for number, name in enumerate(names)}
    return {name: (4.0**number, delay) for number, (name, delay) in enumerate(found.items())}


def calibrated(names):
    half = Interval(0.5, 0.4, 0.6)
    return {name: Calibration(half, None, 0.0, 0.0, 0.25, (Bin(0.5, 9, half),)) for name in names}


def lines(names):
    return {name: dict(zip((1, 2), each, strict=True)) for name, each in shares(names).items()}


def zones(names):
    """Return a place with zones; a scenario accepts short printable names."""
    return PLACE.replace({"place.zones": dict.fromkeys(filter(is_for_a_zone, names), DOCK)})


def is_for_a_zone(name):
    return 0 < len(name) <= 40 and name.isprintable()


def swept(**fields):
    return sweep.Shown("tasks.count", "accuracy", **fields)


def across(names):
    """Return cells with names along the horizontal axis."""
    return {"": {2.5: {name: wilson(1, 2) for name in names}}}


def in_own_axes(plot):
    """Draw into axes of a user's own figure, with a legend if something has a label."""
    drawn = Figure()
    ax = plot(drawn.subplots())
    if ax.get_legend_handles_labels()[1]:
        ax.legend()
    return drawn


FIGURES = {
    "ratio": lambda names: comparison.draw_against_ratio(20, [10, 20], shares(names)),
    "time": lambda names: comparison.draw_against_time(curves(names, 2, 50)),
    "bits": lambda names: comparison.draw_against_bits(totals(names), keep=names),
    "calibration": lambda names: comparison.draw_calibration(calibrated(names)),
    "right": lambda names: comparison.draw_right_over_time(curves(names, 50), np.zeros(50)),
    "delay": lambda names: comparison.draw_delay_against_bits(delays(names), 50),
    "lines": lambda names: sweep.draw_lines({"": lines(names)}, swept(hue="decision.strategy")),
    "panels": lambda names: sweep.draw_lines(
        {name: {"": each} for name, each in lines(names).items()}, swept(facet="decision.strategy")
    ),
    "categories": lambda names: sweep.draw_lines(across(names), swept()),
    "rows": lambda names: sweep.draw_maps({"": lines(names)}, swept(y="decision.strategy")),
    "columns": lambda names: sweep.draw_maps(across(names), swept(y="sensing.range")),
    "zones": lambda names: in_own_axes(lambda ax: plot_arena(Swarm(zones(names), seed=1), ax)),
    "labels": lambda names: in_own_axes(lambda ax: plot_opinions(dict.fromkeys(names, RESULTS), ax)),
}
QUICK = "time", "bits", "categories", "rows", "zones", "labels"
"""Figures that together write names in all ways in which the others do, too."""
SLOW = {name: () if name in QUICK else pytest.mark.slow for name in FIGURES}
CASES = [pytest.param(draw, id=name, marks=SLOW[name]) for name, draw in FIGURES.items()]


def texts_of(drawn):
    """Return the texts of a figure as a reader sees them, after drawing it."""
    drawn.savefig(io.BytesIO(), format="png", dpi=20)
    return [text.get_text().replace("\\$", "$") for text in drawn.findobj(Text)]


@pytest.mark.filterwarnings("ignore:constrained_layout not applied", "ignore:Glyph")
@pytest.mark.parametrize("draw", CASES)
def test_a_name_is_drawn_letter_by_letter(draw):
    shown = texts_of(draw(NAMES))
    for name in filter(is_for_a_zone, NAMES) if draw is FIGURES["zones"] else NAMES:
        assert any(one_line(name, NAME_LIMIT) in text for text in shown), name


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:constrained_layout not applied", "ignore:Glyph")
@pytest.mark.parametrize("names", [NAMES, MORE[:5], MORE[5:9], MORE[9:]])
@pytest.mark.parametrize("draw", [FIGURES[name] for name in QUICK], ids=QUICK)
def test_any_name_gives_a_figure_in_each_format(draw, names, tmp_path):
    drawn = draw(names)
    for suffix in (".png", ".pdf", ".svg"):
        save_figure(drawn, tmp_path / f"drawn{suffix}")
    ElementTree.parse(tmp_path / "drawn.svg")


@pytest.mark.parametrize("text", ["$\\frac{$", "a$b"])
def test_a_title_with_an_invalid_formula_is_text(text):
    drawn = sweep.draw_lines({"": lines(["a"])}, swept(title=text, xlabel=text, ylabel=text))
    assert texts_of(drawn).count(text) == 3


def test_a_title_may_have_a_formula():
    drawn = sweep.draw_lines({"": lines(["a"])}, swept(title="$\\frac{n}{m}$"))
    assert drawn.get_suptitle() == "$\\frac{n}{m}$"
