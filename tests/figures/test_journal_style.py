"""Figures for a column of a journal: size, type, symbols, caption and methods."""

from __future__ import annotations

import re

import pytest
from matplotlib.text import Text
from PIL import Image

from feasibee import Scenario
from feasibee.figures.comparison import draw_sizing
from feasibee.figures.style import name_of_axis
from feasibee.figures.sweep import Shown, draw_lines, draw_maps, view_in
from feasibee.results.statistics import wilson
from feasibee.scenario.fields import fields
from feasibee.scenario.units import SYMBOLS
from feasibee.studies.size import Band, Edge, Finding, Rule, Sizing, panels_of
from tests.commands import output_of, refused_in_a_line


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of a sweep of four points, two runs each."""
    folder = tmp_path_factory.mktemp("journal")
    study = folder / "study.toml"
    study.write_text(
        "runs = 2\nseed = 7\n[scenario]\nrun = {steps = 40}\n"
        '[sweep]\n"tasks.count" = [5, 40]\n"radio.loss" = [0.0, 0.5]\n'
    )
    output_of("sweep", study, "--out", folder)
    return folder


def plot(folder, *options):
    words = ("results", "plot", folder, "--x", "tasks.count", "--hue", "radio.loss")
    return output_of(*words, "--style", "journal", *options)


def test_the_figure_is_as_wide_as_the_column_and_has_its_type_embedded(folder):
    plot(folder, "--width", "8.4cm", "--out", folder / "column.pdf")
    text = (folder / "column.pdf").read_bytes()
    width = float(re.search(rb"/MediaBox \[ 0 0 ([0-9.]+)", text)[1])
    assert abs(width / 72 * 25.4 - 84) < 0.1
    assert b"/FontFile2" in text
    assert b"/Type3" not in text
    plot(folder, "--out", folder / "column.png")
    with Image.open(folder / "column.png") as image:
        assert image.width == 84 / 25.4 * 600 // 1


def test_the_text_next_to_it_has_all_that_repeats_it(folder):
    assert "column.txt" in plot(folder, "--out", folder / "column.svg")
    text = (folder / "column.txt").read_text()
    assert "Right decisions (%) against m and p_loss. Intervals: 95 %. m: Number of tasks" in text
    assert "8 runs with feasibee" in text
    assert "2 runs of each of 4 points, with seed 7" in text
    assert "except run.steps = 40." in text
    rows = re.findall(
        "^tasks.count = (.*), radio.loss = (.*): 2 runs, seed 7, scenario ([0-9a-f]{64})$", text, re.M
    )
    assert [row[:2] for row in rows] == [("5", "0.0"), ("5", "0.5"), ("40", "0.0"), ("40", "0.5")]
    assert len({row[2] for row in rows}) == 4


def test_axes_have_symbols_with_units_and_by_default_words_too():
    share = wilson(1, 2)
    lines, cells = {"": {0.1: {1: share, 2: share}}}, {"": {2: {1.0: share, 2.0: share}}}
    paper = {"journal": True, "width": 3.3}
    (ax,) = draw_lines(lines, Shown("tasks.count", "accuracy", "radio.loss", **paper)).axes
    assert ax.get_xlabel() == "$m$"
    assert "$p_\\mathrm{loss}$" in [each.get_text() for each in ax.texts]
    ax, _ = draw_maps(cells, Shown("sensing.range", "accuracy", y="radio.id_bits", **paper)).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$d$ (units)", "id bits")
    (ax,) = draw_lines(lines, Shown("tasks.count", "accuracy")).axes
    assert ax.get_xlabel() == "number of tasks $m$"
    ax, _ = draw_maps(cells, Shown("robots.speed", "accuracy", y="radio.id_bits")).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("robot speed $v$ (units per step)", "radio id bits")
    assert name_of_axis("ratio") == "ratio"


SHARE = wilson(1, 2)
ASKED = Scenario(units={"metres": 0.5})
FOUND = [Finding(place, 50, 100, SHARE, "enough") for place in (0, 1)]
EDGES = [Edge(path, [1, 2], FOUND, 1, 0) for path in ("radio.range", "tasks.count", "tasks.count")]
LABELLED = {
    "sizing": lambda: draw_sizing(
        panels_of(Sizing(ASKED, Rule(0.9), EDGES[0], Band(*EDGES[1:]), 0, False)), 0.9
    ),
    "map": lambda: draw_maps(
        {"": {2: {1: SHARE}}}, Shown("radio.range", "accuracy", y="radio.loss"), ["tasks.count"]
    ),
}


@pytest.mark.parametrize("name", LABELLED)
def test_no_figure_names_fields_by_their_keys(name):
    drawn = LABELLED[name]()
    drawn.draw_without_rendering()
    shown = {text.get_text() for text in drawn.findobj(Text)}
    assert not [text for text in shown if re.search(r"[a-z]\.[a-z]", text)]
    assert any(text.startswith("radio range $d_\\mathrm{radio}$") for text in shown)
    assert "number of tasks $m$" in shown or name != "sizing"
    assert "radio range $d_\\mathrm{radio}$ (m)" in shown or name != "sizing"


def test_symbols_are_those_of_fields_and_each_of_one():
    assert set(SYMBOLS) <= set(fields())
    assert len(set(SYMBOLS.values())) == len(SYMBOLS)


@pytest.mark.parametrize("width", ["84", "0.5in", "84 km", "-84mm"])
def test_a_width_needs_a_unit(folder, width):
    words = ("results", "plot", folder, "--x", "tasks.count", "--style", "journal", f"--width={width}")
    assert "must be a length from 1in to 20in, with its unit" in refused_in_a_line(*words)


TITLES = ("--title", r"Loss & \{a} (b) <c> %7D", "--xlabel", "tasks", "--ylabel", "right")


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_size_panels_and_texts_are_as_asked_and_repeated(folder, suffix):
    path = folder / f"panels.{suffix}"
    words = ("results", "plot", folder, "--x", "tasks.count", "--facet", "radio.loss", "--out", path)
    output_of(*words, "--width", "6in", "--height", "2in", *TITLES)
    view = view_in(path)
    assert (view.facet, view.width, view.height) == ("radio.loss", 6.0, pytest.approx(2.0))
    assert (view.title, view.xlabel, view.ylabel) == TITLES[1::2]
    if suffix == "png":
        with Image.open(path) as image:
            assert image.size == (1200, 400)
    assert f"{path}: the same, byte for byte" in output_of("run", "--again", folder, "--again", path)


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (2, 2), (3, 3), (4, 2), (5, 3), (7, 3)])
def test_panels_share_axes_and_label_them_outside(count, columns):
    lines = {"dmmd": {5: SHARE, 40: SHARE}, "census": {5: SHARE, 40: SHARE}}
    shown = Shown("tasks.count", "accuracy", "decision.strategy", facet="radio.loss")
    drawn = draw_lines({k / 10: lines for k in range(count)}, shown)
    axes = [ax for ax in drawn.axes if ax.get_visible()]
    assert [ax.get_title() for ax in axes] == [
        f"radio loss $p_\\mathrm{{loss}}$ = {k / 10:g}" for k in range(count)
    ]
    assert [bool(ax.get_ylabel()) for ax in axes] == [k % columns == 0 for k in range(count)]
    assert [bool(ax.get_xlabel()) for ax in axes] == [k + columns >= count for k in range(count)]
    named = [k for k, ax in enumerate(axes) if {text.get_text().strip() for text in ax.texts} >= set(lines)]
    assert named == [columns - 1]


def test_a_panel_needs_a_field_of_its_own_and_few_values(folder, tmp_path):
    words = ("results", "plot", folder, "--x", "tasks.count", "--facet")
    assert "choose another field that the sweep varies" in refused_in_a_line(*words, "tasks.count")
    study = tmp_path / "study.toml"
    study.write_text(
        'runs = 1\n[scenario]\nrun = {steps = 1}\n[sweep]\n"tasks.count" = {range = [1, 13, 1]}\n'
    )
    output_of("sweep", study, "--out", tmp_path)
    line = refused_in_a_line("results", "plot", tmp_path, "--x", "run.steps", "--facet", "tasks.count")
    assert "has 13 values; must have at most 12; use --hue tasks.count, or sweep fewer values" in line
