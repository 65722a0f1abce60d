"""The study beyond the paper: its files, its rows against runs simulated apart, its table."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from matplotlib.image import imread

from feasibee import decision_counts, decision_times, simulate, truth
from feasibee.scenario.feasibility import explain
from feasibee.scenario.runs import RUNS_APART
from feasibee.studies.paper import (
    BASELINE,
    MIXED,
    PLACES,
    WORLDS,
    simulate_panels,
    summary,
    world,
    write_panels,
)
from feasibee.sweeps import executors
from feasibee.sweeps.schema import LOCK, NAME, SEAL
from feasibee.sweeps.sweep import Execution

RUNS, SEED = 4, 1
FILES = ["beyond.csv", "beyond.pdf", "beyond.png"]
JOURNAL = [LOCK, SEAL, NAME]


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study") / "new" / "beyond"
    folder.mkdir(parents=True)
    rows = simulate_panels(RUNS, SEED, Execution(folder, executors.threads(1)))
    write_panels(folder, rows)
    return folder, rows


def written(folder):
    with (folder / "beyond.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_the_files_are_written_and_the_figure_is_a_picture(study):
    folder = study[0]
    assert sorted(path.name for path in folder.iterdir()) == sorted([*FILES, *JOURNAL])
    picture = imread(folder / "beyond.png")
    assert picture.shape[1] == 1440
    assert len(np.unique(picture.reshape(-1, picture.shape[-1]), axis=0)) > 50
    assert (folder / "beyond.pdf").read_bytes().startswith(b"%PDF")


def test_every_panel_has_every_ratio_and_they_are_mirrored():
    assert len(PLACES) >= 11
    ratios = np.log([20 / places for places in PLACES])
    np.testing.assert_allclose(ratios, -ratios[::-1], atol=0.02)


@pytest.mark.quick(1)
@pytest.mark.parametrize("panel", WORLDS)
def test_a_row_is_what_runs_simulated_apart_say(study, panel):
    lines = [line for line in written(study[0]) if line["panel"] == panel]
    assert [int(line["places"]) for line in lines] == list(PLACES)
    for line in lines[::4]:
        places = int(line["places"])
        assert float(line["ratio"]) == 20 / places
        assert int(line["first_run"]) == places * RUNS_APART
        scenario = world(panel, places)
        runs = simulate(scenario, RUNS, SEED, first_run=places * RUNS_APART)
        counts = decision_counts(runs.decision)
        assert {name: float(line[name]) * RUNS for name in counts} == counts
        assert line["truth"] == ("feasible" if truth(scenario) else "infeasible")
        assert float(line["accuracy"]) * RUNS == counts[line["truth"]]
        assert (
            0 <= float(line["accuracy_low"]) <= float(line["accuracy"]) <= float(line["accuracy_high"]) <= 1
        )
        steps = decision_times(runs.decision_step.values.astype(int))
        assert [line[f"step_{name}"] for name in steps._fields] == [
            "" if step is None else str(step) for step in steps
        ]


def test_worlds_differ_in_what_they_say():
    paper = world(BASELINE, 20).to_dict()
    for panel, tables in WORLDS.items():
        if panel != MIXED:
            changed = {
                (section, key)
                for section, table in world(panel, 20).to_dict().items()
                for key, value in table.items()
                if paper[section][key] != value
            }
            assert changed == {(section, key) for section, table in tables.items() for key in table}


@pytest.mark.parametrize("places", PLACES)
def test_the_mixed_tasks_ask_for_as_many_robots_as_the_ratio_says(places):
    scenario = world(MIXED, places)
    assert scenario.robots.count == 20
    assert sum(each.count * sum(each.needs.values()) for each in scenario.tasks.classes) == places
    verdict = explain(scenario)
    assert verdict.feasible == (places <= 10)
    if places == 13:  # robots enough, lifters too few
        assert verdict.violator == (("lift",), 6, 4)


def test_the_table_has_a_line_for_each_panel(study):
    header, *lines = summary(study[1])
    assert header[1:5] == ["at 10", "at 2", "at 0.5", "at 0.1"]
    assert [line[0] for line in lines] == list(WORLDS)
    by_place = {(row.panel, row.tasks): row for row in study[1]}
    for line in lines:
        assert line[1] == f"{by_place[line[0], 2].accuracy.estimate:.1%}"
        assert line[3] == f"{by_place[line[0], 40].accuracy.estimate:.1%}"
