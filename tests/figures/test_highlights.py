"""Figures highlight at most five lines, name them where they end, and tell those that overlap apart."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from feasibee import wilson
from feasibee.figures.comparison import Side as Sized
from feasibee.figures.comparison import draw_against_bits, draw_against_ratio, draw_against_time, draw_sizing
from feasibee.figures.decisions import draw_opinion_panels
from feasibee.figures.labels import spread
from feasibee.figures.style import GREY, PALETTE, PLAIN, are_spaced_by_ratio, looks, text_colour
from feasibee.figures.sweep import Shown, draw_lines, draw_maps

NAMES = [f"rule-{number}" for number in range(16)]
RATES = {name: [wilson(50 + number, 100), wilson(2 * number, 100)] for number, name in enumerate(NAMES)}
CURVES = {name: np.full((2, 50), number / 16) for number, name in enumerate(NAMES)}
TOTALS = {name: (2.0 + number, wilson(3 * number, 100)) for number, name in enumerate(NAMES)}
COST_ONLY = {name: (2.0 + number, wilson(90 - number, 100)) for number, name in enumerate(NAMES)}


def colours_of(drawn):
    """Return the colours of the lines of a figure that aren't grey."""
    lines = {to_hex(line.get_color()).upper() for ax in drawn.axes for line in ax.lines}
    return {colour for colour in lines if len(set(to_rgb(colour))) > 1}


def names_of(drawn):
    return {text.get_text().strip() for ax in drawn.axes for text in ax.texts}


# --- Which lines are highlighted ---


def test_the_first_and_the_best_are_highlighted_and_no_more_than_five():
    found = looks({name: float(number) for number, name in enumerate(NAMES)})
    shown = [name for name, look in found.items() if look.highlighted]
    assert shown == ["rule-0", "rule-12", "rule-13", "rule-14", "rule-15"]
    assert list(found) == NAMES
    assert {look.colour for look in found.values()} == {*PALETTE, GREY}
    assert len({found[name].marker for name in shown}) == len({found[name].dashes for name in shown}) == 5


def test_what_is_to_be_kept_is_highlighted_even_if_it_is_worst():
    scores = {name: float(number) for number, name in enumerate(NAMES)}
    found = looks(scores, keep=["rule-3", "nobody"])
    assert [name for name, look in found.items() if look.highlighted] == ["rule-3", *NAMES[-4:]]
    assert not looks(scores, keep=())["rule-0"].highlighted


def test_a_line_keeps_its_look_in_the_next_figure():
    before = looks({"a": 1.0, "b": 5.0, "c": 4.0, "d": 3.0, "e": 2.0, "f": 0.0})
    after = looks({"a": 1.0, "b": 0.0, "c": 4.0, "d": 3.0, "e": 2.0, "f": 9.0}, before=before)
    assert [after[name] for name in "acde"] == [before[name] for name in "acde"]
    assert after["f"] == before["b"]  # the look that is free
    assert after["b"] == PLAIN


def test_labels_are_readable_on_white():
    """Contrast of at least 4.5, by the Web Content Accessibility Guidelines."""
    for colour in PALETTE:
        parts = [
            part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
            for part in to_rgb(text_colour(colour))
        ]
        assert 1.05 / (np.dot(parts, (0.2126, 0.7152, 0.0722)) + 0.05) >= 4.5


# --- The figures ---


@pytest.mark.parametrize(
    "draw",
    [
        lambda: draw_against_ratio(20, [10, 20], RATES),
        lambda: draw_against_time(CURVES),
        lambda: draw_against_bits(TOTALS),
        lambda: draw_lines(
            {"": {name: dict(zip((1, 2), rates, strict=True)) for name, rates in RATES.items()}},
            Shown("tasks.count", "accuracy", "decision.strategy"),
        ),
    ],
)  # fmt: skip
def test_sixteen_contenders_have_five_colours_and_names(draw):
    drawn = draw()
    assert colours_of(drawn) == set(PALETTE)
    assert {"rule-0", *NAMES[-4:]} <= names_of(drawn)
    assert all(ax.get_legend() is None for ax in drawn.axes)


def test_lines_that_are_grey_are_named_below_the_figure():
    note = draw_against_ratio(20, [10, 20], RATES)._supxlabel.get_text()
    assert note.split("grey: ")[1].replace("\n", " ").split(", ") == NAMES[1:12]
    assert draw_against_time({"only": CURVES["rule-3"]})._supxlabel is None


def test_what_another_beats_in_both_is_grey():
    drawn = draw_against_bits(COST_ONLY, keep=())
    assert colours_of(drawn) == {PALETTE[0]}  # the cheapest is also the best


def test_a_strategy_that_sends_nothing_is_drawn():
    totals = {"silent": (0.0, wilson(1, 9)), "loud": (6.0, wilson(8, 9))}
    drawn = draw_against_bits(totals)
    assert names_of(drawn) == set(totals)
    assert drawn.axes[0].get_xscale() == "linear"
    assert names_of(draw_against_bits({"silent": totals["silent"]})) == {"silent"}


def boxes(drawn, ax):
    drawn.draw_without_rendering()
    return [Text.get_window_extent(text) for text in ax.texts]  # without the lines to their points


@pytest.mark.quick(1)
@pytest.mark.parametrize("seed", range(5))
def test_names_at_points_cover_neither_names_nor_points(seed):
    random = np.random.default_rng(seed)
    bits, right = 10 ** random.uniform(0, 2.5, 16), random.integers(0, 100, 16)
    totals = {name: (float(bits[k]), wilson(int(right[k]), 100)) for k, name in enumerate(NAMES)}
    drawn = draw_against_bits(totals)
    (ax,) = drawn.axes
    placed = boxes(drawn, ax)
    names = [text.get_text() for text in ax.texts]
    assert len(names) == len(set(names)) > 10
    for number, box in enumerate(placed):
        assert not any(box.shrunk(0.9, 0.9).overlaps(other) for other in placed[:number])
        points = ax.transData.transform([(cost, 100 * share.estimate) for cost, share in totals.values()])
        assert not any(box.contains(*point) for point in points)


def test_names_at_the_ends_keep_their_distance_and_their_order():
    shares = {"a": 1, "b": 1, "c": 1, "d": 0.99, "e": 0.5}
    curves = {name: np.full((1, 50), share) for name, share in shares.items()}
    drawn = draw_against_time(curves)
    (ax,) = drawn.axes
    places = dict(zip([text.get_text().strip() for text in ax.texts], boxes(drawn, ax), strict=True))
    middles = [(place.y0 + place.y1) / 2 for place in sorted(places.values(), key=lambda place: place.y0)]
    assert np.diff(middles).min() >= 8 * drawn.dpi / 72
    assert min(places, key=lambda name: places[name].y0) == "e"


def on_lines(box, ax):
    """Return whether a box crosses a line within the axes."""
    within = Bbox.intersection(box, ax.bbox)
    paths = [line.get_transform().transform_path(line.get_path()) for line in ax.lines]
    return within is not None and any(path.intersects_bbox(within, filled=False) for path in paths)


def test_no_text_of_a_sizing_lies_on_a_curve():
    falls = [(number, wilson(80 - number, 100)) for number in (5, 10, 20, 36)]
    drawn = draw_sizing([Sized("radio range", falls), Sized("tasks", falls, band=(10, 35), truth=20)], 0.7)
    texts = [(box, ax) for ax in drawn.axes for box in boxes(drawn, ax)]
    assert len(texts) == 4
    assert not any(on_lines(box, ax) for box, ax in texts)


@pytest.mark.parametrize("numbers", [[10], [12, 13, 14]])
def test_a_sizing_of_few_numbers_of_robots_has_no_fractions_of_them(numbers):
    ax = draw_sizing([Sized("robots", [(each, wilson(100, 100)) for each in numbers])], 0.95).axes[0]
    assert all(float(tick).is_integer() for tick in ax.get_xticks())


@pytest.mark.parametrize("wanted", [[], [5], [1, 2, 3], [9, 9, 9, 9], [-5, -4, 20], [0, 0, 10, 10]])
def test_places_are_a_gap_apart_and_within_limits(wanted):
    found = spread(wanted, 1.0, 0.0, 10.0)
    assert all(np.diff(found) >= 1 - 1e-9)
    assert all(0 <= place <= 10 for place in found)
    assert spread([2, 5, 8], 1.0, 0.0, 10.0) == [2, 5, 8]
    np.testing.assert_allclose(spread([5, 5], 1.0, 0.0, 10.0), [4.5, 5.5])


# --- Bands that overlap, and axes ---


def test_bands_have_edges():
    lines = {1: {1: wilson(5, 9), 2: wilson(6, 9)}, 2: {1: wilson(5, 9), 2: wilson(4, 9)}}
    drawn = draw_lines({"": lines}, Shown("tasks.count", "accuracy", "sensing.range"))
    for band in drawn.axes[0].collections:
        assert band.get_linewidth()[0] > 0
        assert band.get_edgecolor()[0][3] > band.get_facecolor()[0][3]


def test_each_band_has_a_panel_of_its_own():
    bands = {f"n/m = {number}": np.add(10.0 * number, [[-5] * 9, [0] * 9, [5] * 9]) for number in range(6)}
    drawn = draw_opinion_panels(bands, ["#0072B2"] * 6, until=8)
    assert [ax.get_title() for ax in drawn.axes] == list(bands)
    for ax, (_, median, _) in zip(drawn.axes, bands.values(), strict=True):
        (band,) = ax.collections
        assert len(ax.lines) == 7
        np.testing.assert_array_equal(ax.lines[-1].get_ydata(), median)
        assert {line.get_color() for line in ax.lines[:-1]} == {GREY}
        assert band.get_datalim(ax.transData).y0 == median[0] - 5


@pytest.mark.parametrize(
    ("values", "logarithmic"),
    [
        ([1, 2, 4, 8], True),
        ([10, 14, 20, 28, 40], True),  # rounded
        ([1, 5, 10], True),
        ([16, 18, 20, 22], False),
        ([5, 10, 15, 20, 25], False),
        ([0, 1, 100], False),
        ([3], False),
        ([4, 8], False),
        ([], False),
    ],
)
def test_an_axis_is_logarithmic_for_a_decade_or_values_spaced_by_ratio(values, logarithmic):
    assert are_spaced_by_ratio(values) is logarithmic
    if len(values) > 1:
        drawn = draw_lines(
            {"": {"": {value: wilson(1, 2) for value in values}}}, Shown("tasks.count", "accuracy")
        )
        assert (drawn.axes[0].get_xscale() == "log") is logarithmic


def test_a_figure_says_over_what_it_averages():
    lines, cells = {"": {"": {1: wilson(1, 2)}}}, {"": {2: {1: wilson(1, 2)}}}
    for drawn in (
        draw_lines(lines, Shown("tasks.count", "accuracy"), ["radio.loss"]),
        draw_maps(cells, Shown("tasks.count", "accuracy", y="sensing.range"), ["radio.loss"]),
    ):
        assert drawn.get_suptitle() == "averaged over radio loss $p_\\mathrm{loss}$"
    assert draw_lines(lines, Shown("tasks.count", "accuracy")).get_suptitle() == ""
