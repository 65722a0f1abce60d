"""The paper's study: every file, and in every file what the simulation says."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from matplotlib.image import imread

from feasibee import Scenario, Swarm, decision_counts, decision_rates, decision_times, simulate
from feasibee.studies.paper import run_study, write_study
from feasibee.sweeps import executors
from feasibee.sweeps.schema import LOCK, NAME, SEAL
from feasibee.sweeps.sweep import Execution

RUNS, SEED = 8, 1
FIGURES = ("fig1_arena", "fig2a_converging", "fig2b_diverging", "fig3_decisions")
FILES = sorted([*(f"{name}.{suffix}" for name in FIGURES for suffix in ("png", "pdf", "csv")), "claims.json"])
JOURNAL = [LOCK, SEAL, NAME]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The study on one thread: its folder, and its claims."""
    folder = tmp_path_factory.mktemp("study") / "new" / "paper"
    return folder, reproduced(folder, 1)


def reproduced(folder, threads):
    """Write the study into a folder; return its claims."""
    folder.mkdir(parents=True)
    points = run_study(RUNS, SEED, Execution(folder, executors.threads(threads)))
    return write_study(folder, points, SEED)


@pytest.fixture(scope="module")
def simulated(study):
    """The same runs, simulated apart, by number of tasks."""
    return {
        int(row["tasks"]): simulate(
            Scenario(tasks={"count": int(row["tasks"])}),
            runs=RUNS,
            seed=SEED,
            first_run=int(row["tasks"]) * 1_000_000,
            curves=True,
        )
        for row in rows(study[0] / "fig3_decisions.csv")
    }


def test_every_file_is_there_and_no_other(study):
    assert names(study[0]) == sorted([*FILES, *JOURNAL])
    assert names(study[0].parent) == ["paper"]


def test_the_ratios_are_many_and_symmetrical_around_1(study):
    tasks = [int(row["tasks"]) for row in rows(study[0] / "fig3_decisions.csv")]
    assert tasks == sorted(set(tasks))
    assert (tasks[0], tasks[-1]) == (2, 200)
    assert len(tasks) >= 15
    assert {4, 10, 20, 40, 100} <= set(tasks)
    mirrored = [m * mirror / 20**2 for m, mirror in zip(tasks, tasks[::-1], strict=True)]
    np.testing.assert_allclose(mirrored, 1, atol=0.02)


def test_fig_3_has_the_rates_with_intervals_and_the_times_of_the_simulation(study, simulated):
    for row in rows(study[0] / "fig3_decisions.csv"):
        dataset = simulated[int(row["tasks"])]
        assert float(row["ratio"]) == 20 / int(row["tasks"])
        assert (int(row["runs"]), int(row["first_run"])) == (RUNS, dataset.run.values[0])
        for name, rate in decision_rates(dataset.decision).items():
            written = [float(row[f"{name}{part}"]) for part in ("", "_low", "_high")]
            assert written == list(rate)
            assert written[0] * RUNS == decision_counts(dataset.decision)[name]
        times = decision_times(dataset.decision_step.values.astype(int))
        written = [row[f"step_{name}"] for name in ("q25", "median", "q75")]
        assert written == ["" if step is None else str(step) for step in times]


@pytest.mark.parametrize("name", ["fig2a_converging", "fig2b_diverging"])
def test_fig_2_has_the_quartiles_of_the_simulation(study, simulated, name):
    written = rows(study[0] / f"{name}.csv")
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
        {float(row["ratio"]) for row in rows(study[0] / f"{name}.csv")}
        for name in ("fig2a_converging", "fig2b_diverging")
    )
    assert {0.1, 0.5, 2.0, 10.0} <= far
    assert all(abs(math.log2(ratio)) >= 1 for ratio in far)
    assert 1.0 in near
    assert all(abs(math.log2(ratio)) < 0.5 for ratio in near)


def test_fig_1_has_the_places_of_the_swarm(study):
    swarm = Swarm(Scenario(), SEED)
    written = rows(study[0] / "fig1_arena.csv")
    for kind, places in (("robot", swarm.positions), ("task", swarm.tasks)):
        of_kind = [row for row in written if row["kind"] == kind]
        assert [int(row["number"]) for row in of_kind] == list(range(1, 21))
        np.testing.assert_array_equal([(float(row["x"]), float(row["y"])) for row in of_kind], places)


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", FIGURES)
def test_the_figures_are_pictures(study, name):
    picture = imread(study[0] / f"{name}.png")
    assert min(picture.shape[:2]) > 400
    assert len(np.unique(picture.reshape(-1, picture.shape[-1]), axis=0)) > 50
    assert (study[0] / f"{name}.pdf").read_bytes().startswith(b"%PDF")


def test_the_claims_are_written_as_they_are_returned(study):
    folder, claims = study
    written = json.loads((folder / "claims.json").read_text())
    assert written["claims"] == [asdict(claim) for claim in claims]
    assert (written["runs_per_ratio"], written["seed"]) == (RUNS, SEED)
    assert len(claims) >= 5
    assert {claim.verdict for claim in claims} <= {"holds", "fails", "can't tell"}


def test_the_least_share_of_right_decisions_is_that_of_the_simulation(study, simulated):
    claims = study[1]
    feasible = [float((s.decision == 1).mean()) for tasks, s in simulated.items() if tasks < 10]
    infeasible = [float((s.decision == 0).mean()) for tasks, s in simulated.items() if tasks > 40]
    assert claims[0].estimate == min(feasible)
    assert claims[1].estimate == min(infeasible)


def test_the_bands_of_the_claims_are_those_of_every_25th_step(simulated):
    points = {point.tasks: point for point in run_study(RUNS, SEED)}
    for tasks in (2, 10, 20):
        shares = simulated[tasks].feasible_count.values[:, ::25] * 5
        np.testing.assert_allclose(points[tasks].thinned, shares)
    assert points[3].thinned.size == points[3].quartiles.size == 0  # nothing draws them
