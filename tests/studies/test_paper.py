"""The paper's studies, in its world and in others: every file, and in every file what the simulation says."""

from __future__ import annotations

import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from commands import rows_of
from matplotlib.image import imread

from feasibee import Scenario, Swarm, decision_counts, decision_rates, decision_times, simulate, truth
from feasibee.scenario.feasibility import explain
from feasibee.scenario.runs import RUNS_APART
from feasibee.simulation import executors, store
from feasibee.simulation.sweep import Execution
from feasibee.studies.paper import (
    BASELINE,
    MIXED,
    PLACES,
    WORLDS,
    run_study,
    simulate_panels,
    summary,
    world,
    write_panels,
    write_study,
)

RUNS, SEED = 8, 1
FIGURES = ("fig1_arena", "fig2a_converging", "fig2b_diverging", "fig3_decisions", "beyond")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The study on one thread: its folder, its points, and its claims."""
    folder = tmp_path_factory.mktemp("study")
    points = run_study(RUNS, SEED, Execution(folder, executors.threads(1)))
    return folder, points, write_study(folder, points, SEED)


@pytest.fixture(scope="module")
def panels(tmp_path_factory):
    """The study of other worlds on one thread: its folder and its points."""
    folder = tmp_path_factory.mktemp("panels")
    points = simulate_panels(RUNS, SEED, Execution(folder, executors.threads(1)))
    write_panels(folder, points)
    return folder, points


@pytest.fixture(scope="module")
def simulated(study):
    """The same runs, simulated apart, by number of tasks."""
    return {tasks: apart(Scenario(tasks={"count": tasks}), tasks) for tasks in tasks_of(study)}


def apart(scenario, number):
    return simulate(scenario, RUNS, SEED, first_run=number * RUNS_APART, curves=True)


def tasks_of(study):
    return [int(row["tasks"]) for row in rows_of(study[0] / "fig3_decisions.csv")]


@pytest.mark.parametrize("name", FIGURES)
def test_every_file_is_there_and_no_other_and_figures_are_pictures(request, name):
    folder = request.getfixturevalue("panels" if name == "beyond" else "study")[0]
    shown = ["beyond"] if name == "beyond" else FIGURES[:-1]
    claims = [] if name == "beyond" else ["claims.json"]
    files = [f"{each}.{suffix}" for each in shown for suffix in ("png", "pdf", "csv")]
    assert {path.name for path in folder.iterdir()} == {*files, *claims, store.RUNS}
    picture = imread(folder / f"{name}.png")
    assert min(picture.shape[:2]) > 400
    assert len(np.unique(picture[..., :3].sum(axis=-1))) > 50  # shades
    assert (folder / f"{name}.pdf").read_bytes().startswith(b"%PDF")


def test_the_ratios_are_many_and_symmetrical_around_1(study):
    for numbers in (tasks_of(study), list(PLACES)):
        assert numbers == sorted(set(numbers))
        assert (numbers[0], numbers[-1]) == (2, 200)
        assert len(numbers) >= 11
        assert {4, 10, 20, 40, 100} <= set(numbers)
        mirrored = [m * mirror / 20**2 for m, mirror in zip(numbers, numbers[::-1], strict=True)]
        np.testing.assert_allclose(mirrored, 1, atol=0.02)


def check_row(row, dataset, number):
    """Check what the tables of both studies have in common."""
    assert float(row["ratio"]) == 20 / number
    assert (int(row["runs"]), int(row["first_run"])) == (RUNS, dataset.run.values[0])
    for name, rate in decision_rates(dataset.decision).items():
        written = [float(row[f"{name}{part}"]) for part in ("", "_low", "_high")]
        assert written == list(rate)
        assert written[0] * RUNS == decision_counts(dataset.decision)[name]
    times = decision_times(dataset.decision_step.values.astype(int))
    assert [row[f"step_{name}"] for name in times._fields] == [
        "" if step is None else str(step) for step in times
    ]


def test_fig_3_has_the_rates_with_intervals_and_the_times_of_the_simulation(study, simulated):
    for row in rows_of(study[0] / "fig3_decisions.csv"):
        check_row(row, simulated[int(row["tasks"])], int(row["tasks"]))


@pytest.mark.quick(1)
@pytest.mark.parametrize("panel", WORLDS)
def test_a_row_of_another_world_is_what_runs_simulated_apart_say(panels, panel):
    lines = [line for line in rows_of(panels[0] / "beyond.csv") if line["panel"] == panel]
    assert [int(line["places"]) for line in lines] == list(PLACES)
    for line in lines[::4]:
        places = int(line["places"])
        scenario = world(panel, places)
        check_row(line, apart(scenario, places), places)
        assert line["truth"] == ("feasible" if truth(scenario) else "infeasible")
        for part in ("", "_low", "_high"):
            assert line[f"accuracy{part}"] == line[f"{line['truth']}{part}"]


@pytest.mark.parametrize("name", ["fig2a_converging", "fig2b_diverging"])
def test_fig_2_has_the_quartiles_of_the_simulation(study, simulated, name):
    written = rows_of(study[0] / f"{name}.csv")
    by_tasks = {}
    for row in written:
        by_tasks.setdefault(int(row["tasks"]), []).append(row)
    assert set(by_tasks) <= set(simulated)
    for tasks, steps in by_tasks.items():
        percentage = simulated[tasks].feasible_count.values / 20 * 100
        assert [int(row["step"]) for row in steps] == list(range(1001))
        for share, column in ((0.25, "q25"), (0.5, "median"), (0.75, "q75")):
            values = [float(row[column]) for row in steps]
            np.testing.assert_allclose(values, np.quantile(percentage, share, axis=0), atol=1e-9)
        assert {float(row["ratio"]) for row in steps} == {20 / tasks}


def test_fig_2a_converges_and_fig_2b_is_near_ratio_1(study):
    far, near = (
        {float(row["ratio"]) for row in rows_of(study[0] / f"{name}.csv")}
        for name in ("fig2a_converging", "fig2b_diverging")
    )
    assert {0.1, 0.5, 2.0, 10.0} <= far
    assert all(abs(math.log2(ratio)) >= 1 for ratio in far)
    assert 1.0 in near
    assert all(abs(math.log2(ratio)) < 0.5 for ratio in near)


def test_fig_1_has_the_places_of_the_swarm(study):
    swarm = Swarm(Scenario(), SEED)
    written = rows_of(study[0] / "fig1_arena.csv")
    for kind, places in (("robot", swarm.positions), ("task", swarm.tasks)):
        of_kind = [row for row in written if row["kind"] == kind]
        assert [int(row["number"]) for row in of_kind] == list(range(1, 21))
        np.testing.assert_array_equal([(float(row["x"]), float(row["y"])) for row in of_kind], places)


def test_the_claims_are_written_as_they_are_returned_and_are_those_of_the_simulation(study, simulated):
    folder, _, claims = study
    written = json.loads((folder / "claims.json").read_text())
    assert written["claims"] == [asdict(claim) for claim in claims]
    assert (written["runs_per_ratio"], written["seed"]) == (RUNS, SEED)
    assert claims[0].estimate == min(float((simulated[m].decision == 1).mean()) for m in simulated if m < 10)
    assert claims[1].estimate == min(float((simulated[m].decision == 0).mean()) for m in simulated if m > 40)


def test_the_bands_of_the_claims_are_those_of_every_25th_step(study, simulated):
    points = {point.tasks: point for point in study[1]}
    for tasks in (2, 10, 20):
        shares = simulated[tasks].feasible_count.values[:, ::25] * 5
        np.testing.assert_allclose(points[tasks].thinned, shares)
    assert points[3].thinned.size == points[3].quartiles.size == 0  # nothing draws them


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


def test_the_mixed_tasks_ask_for_as_many_robots_as_the_ratio_says():
    for places in PLACES:
        scenario = world(MIXED, places)
        assert scenario.robots.count == 20
        assert sum(each.count * sum(each.needs.values()) for each in scenario.tasks.classes) == places
        verdict = explain(scenario)
        assert verdict.feasible == (places <= 10)
        if places == 13:  # robots enough, lifters too few
            assert verdict.violator == (("lift",), 6, 4)


def test_the_table_has_a_line_for_each_panel(panels):
    header, *lines = summary(panels[1])
    assert header[1:5] == ["at 10", "at 2", "at 0.5", "at 0.1"]
    assert [line[0] for line in lines] == list(WORLDS)
    by_place = {(row.panel, row.tasks): row for row in panels[1]}
    for line in lines:
        for place, number in ((1, 2), (3, 40)):
            assert line[place] == f"{by_place[line[0], number].accuracy.estimate:.1%}"
