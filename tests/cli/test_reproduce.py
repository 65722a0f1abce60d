"""feasibee run --again: the same bytes, and lines that name what differs."""

from __future__ import annotations

import json
from urllib.parse import quote

import pytest

import feasibee
from feasibee.scenario.runs import Runs
from feasibee.studies import reproduce
from tests.commands import invoke, output_of, refused_in_a_line


@pytest.fixture
def saved(tmp_path):
    """Return the path of results with a figure."""
    path = tmp_path / "saved.nc"
    settings = ("--set", "tasks.count=40", "--set", "run.steps=100", "--runs", 20, "--run", 5, "--seed", 3)
    output_of("run", *settings, "--out", path, "--out", path.with_suffix(".svg"))
    return path


def test_saved_results_and_their_figure_are_the_same(saved):
    answer = output_of("run", "--again", saved)
    assert "20 runs, written by feasibee" in " ".join(answer.split())
    assert "All results are the same, byte for byte." in answer
    assert "saved.svg: the same, byte for byte." in answer


def test_a_changed_value_is_named_by_column_and_run(saved):
    results = feasibee.open_results(saved)
    results.decision_step[[2, 7]] += 1
    results.feasible_count[4, 50] += 1
    feasibee.save_results(results, saved)
    result = invoke("run", "--again", saved)
    assert result.exit_code == 1
    assert "Different: decision_step in 2 of 20 runs: 7, 12." in result.stdout
    assert "Different: feasible_count in 1 of 20 runs: 9." in result.stdout
    assert "All results" not in result.stdout


def test_other_figures_and_versions_are_named(saved):
    results = feasibee.open_results(saved)
    recipe = {**json.loads(results.attrs["recipe"]), "version": "0.0.1"}
    feasibee.save_results(results.assign_attrs(recipe=json.dumps(recipe)), saved)
    other = saved.with_name("other.svg")
    other.write_text("another figure")
    result = invoke("run", "--again", saved, "--again", other)
    assert result.exit_code == 1
    assert "written by feasibee 0.0.1; now:" in " ".join(result.stdout.split())
    assert "other.svg: differs." in result.stdout
    saved.with_suffix(".svg").unlink()
    assert "svg" not in output_of("run", "--again", saved)
    assert "does not exist" in refused_in_a_line(
        "run", "--again", saved, "--again", saved.with_name("none.svg")
    )


def test_part_of_the_results_is_compared_with_its_runs(saved):
    results = feasibee.open_results(saved).isel(run=[3, 9], step=slice(10, 20))
    feasibee.save_results(results, saved)
    assert "2 runs" in output_of("run", "--again", saved)


@pytest.fixture
def folder(tmp_path):
    """Return the folder of a sweep of two points, three runs each."""
    study = tmp_path / "study.toml"
    study.write_text('runs = 3\nseed = 1\n[scenario.run]\nsteps = 50\n[sweep]\n"tasks.count" = [5, 40]\n')
    output_of("sweep", study, "--out", tmp_path / "results")
    return tmp_path / "results"


FIGURES = {
    "line.png": ("--show", "right_at_end"),
    "map.svg": ("--y", "radio.loss"),
    "column.pdf": ("--hue", "decision.strategy", "--style", "journal", "--width", "3in"),
}
"""Figures of a sweep, and the options that each is drawn with."""


def test_figures_of_a_sweep_are_drawn_again_as_their_files_say(folder):
    for name, options in FIGURES.items():
        output_of("results", "plot", folder, "--x", "tasks.count", *options, "--out", folder / name)
    answer = output_of("run", "--again", folder)
    for name in FIGURES:
        assert f"{name}: the same, byte for byte." in answer
    column = folder / "column.pdf"
    column.write_bytes(column.read_bytes().replace(b"x%22:%20%22tasks.count", b"x%22:%20%22radio.range"))
    for options in ((), ("--again", column)):
        result = invoke("run", "--again", folder, *options)
        assert result.exit_code == 1
        assert "column.pdf: differs." in result.stdout
        assert ("map.svg" in result.stdout) == (not options)


@pytest.mark.parametrize(
    "wrong",
    [
        *("{", '{"x": "tasks.count"}', '{"x": "tasks.count", "show": "all"}'),
        '{"x": "tasks.count", "show": "accuracy", "height": NaN}',
        '{"x": "tasks.count", "show": "accuracy", "facet": ["radio.loss"]}',
    ],
)
def test_a_file_that_says_something_else_is_no_figure_of_a_sweep(folder, wrong):
    other = folder / "other.png"
    other.write_text(f"feasibee results plot {quote(wrong)}")
    assert "other.png" not in output_of("run", "--again", folder)
    answer = refused_in_a_line("run", "--again", folder, "--again", other)
    assert "isn't a figure of feasibee results plot; leave it out, or draw it again" in answer


def test_a_folder_is_the_same_and_another_seed_is_not(folder, monkeypatch):
    assert "6 runs" in output_of("run", "--again", folder)

    true = reproduce.simulate_record

    def off_at_forty(scenario, runs, **options):
        seed = runs.seed + (scenario.tasks.count == 40)
        return true(scenario, Runs(runs.count, seed, runs.first), **options)

    monkeypatch.setattr(reproduce, "simulate_record", off_at_forty)
    result = invoke("run", "--again", folder)
    assert result.exit_code == 1
    answer = " ".join(result.stdout.split())
    for run in range(3):
        assert f"Different: point 2 (tasks.count = 40), run {run}: " in answer
    assert "tasks.count = 5)" not in result.stdout
