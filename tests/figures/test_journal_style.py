"""Figures for a column of a journal: size, type, symbols, caption and methods."""

from __future__ import annotations

import re

import pytest
from matplotlib.text import Text
from PIL import Image

from feasibee import Scenario
from feasibee.figures.sizing import draw_sizing
from feasibee.figures.style import name_of_axis
from feasibee.figures.sweep import draw_lines, draw_map
from feasibee.results.statistics import wilson
from feasibee.scenario.fields import fields
from feasibee.scenario.units import SYMBOLS
from feasibee.studies.size import Band, Edge, Finding, Rule, Sizing, panels_of
from feasibee.studies.tuning import Objective, Sensitivity, Tuned, draw_search, draw_sensitivities
from tests.commands import output_of, refused_in_a_line


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the journal of a sweep of four points, two runs each."""
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
    lines, cells = {0.1: {1: share, 2: share}}, {(1.0, 2): share, (2.0, 2): share}
    (ax,) = draw_lines(lines, "tasks.count", "radio.loss", "accuracy", (), 3.3).axes
    assert ax.get_xlabel() == "$m$"
    assert "$p_\\mathrm{loss}$" in [each.get_text() for each in ax.texts]
    ax, _ = draw_map(cells, "sensing.range", "radio.id_bits", "accuracy", journal=3.3).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$d$ (units)", "id bits")
    assert draw_lines(lines, "tasks.count", None, "accuracy").axes[0].get_xlabel() == "number of tasks $m$"
    ax, _ = draw_map(cells, "robots.speed", "radio.id_bits", "accuracy").axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("robot speed $v$ (units per step)", "radio id bits")
    assert name_of_axis("ratio") == "ratio"


SHARE = wilson(1, 2)
ASKED = Scenario(units={"metres": 0.5})
FOUND = [Finding(place, 50, 100, SHARE, "enough") for place in (0, 1)]
EDGES = [Edge(path, [1, 2], FOUND, 1, 0) for path in ("radio.range", "tasks.count", "tasks.count")]
TRIAL = ({"radio.range": 3.0, "decision.gain": 9}, 0.5)
LABELLED = {
    "sizing": lambda: draw_sizing(
        panels_of(Sizing(ASKED, Rule(0.9), EDGES[0], Band(*EDGES[1:]), 0, False)), 0.9
    ),
    "search": lambda: draw_search(Tuned(TRIAL[0], SHARE, SHARE, SHARE, [TRIAL], Objective())),
    "sensitivities": lambda: draw_sensitivities([Sensitivity("radio.range", SHARE)]),
    "map": lambda: draw_map({(1, 2): SHARE}, "radio.range", "radio.loss", "accuracy", ["tasks.count"]),
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


@pytest.mark.parametrize("width", ["84", "1in", "84 km", "-84mm"])
def test_a_width_needs_a_unit(folder, width):
    words = ("results", "plot", folder, "--x", "tasks.count", "--style", "journal", f"--width={width}")
    assert "must be a length from 2in to 20in, with its unit" in refused_in_a_line(*words)


def test_a_width_needs_the_style(folder):
    line = refused_in_a_line("results", "plot", folder, "--x", "tasks.count", "--width", "84mm")
    assert line.endswith("--width: is for --style journal; add it, or leave out --width")
