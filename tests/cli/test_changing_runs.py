"""feasibee run, sweep and plot in worlds that change."""

from __future__ import annotations

import csv
import json

import changing
import numpy as np
import pytest
from commands import invoke, json_of, refused_in_a_line

from feasibee import Scenario, open_results
from feasibee.results.measures import decided_right, mean_bits, measures_of_runs, tracking
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

TOML = f'{changing.TOML}[decision]\nstrategy = "census"\n'


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "changing.toml"
    path.write_text(TOML)
    return path


@pytest.fixture(scope="module")
def record():
    return simulate_record(Scenario.from_toml(TOML), Runs(30, 4))


def test_a_run_has_its_measures_with_intervals_and_the_truth_that_runs_share(file, record):
    said = json_of("run", file, "--runs", 30, "--seed", 4)
    scenario = Scenario.from_toml(TOML)
    found = tracking(record, scenario).to_dict()
    assert {name: said[name] for name in found} == json.loads(json.dumps(found))
    assert set(said["detection_delay"]) == {"median", "q25", "q75", "changes"}
    for name in ("right_share", "missed", "false_alarms"):
        assert set(said[name]) == {"estimate", "low", "high"}
    assert said["truth_intervals"] == [
        {"first": 0, "last": 119, "truth": "feasible"},
        {"first": 120, "last": 240, "truth": "infeasible"},
    ]
    assert said["accuracy"]["estimate"] == pytest.approx(decided_right(record, scenario).mean())
    assert said["bits_per_robot_and_step"] == mean_bits(record, scenario)


def test_a_run_says_when_the_truth_changes_and_how_it_is_followed(file, record):
    said = invoke("run", file, "--runs", 30, "--seed", 4).stdout
    assert "Truth: feasible in steps 0 to 119, infeasible in steps 120 to 240." in said
    found = tracking(record, Scenario.from_toml(TOML))
    assert f"Changes: {found.changes}. Followed: a quarter within" in said
    assert f"Right: in {found.right_share.estimate:.1%}" in said
    assert "(true)" not in said


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["decision.strategy=dmmd"], "Followed: fewer than a quarter. Missed: "),
        (["events.0.tasks=1"], "Changes: none just before which a swarm was right."),
        (
            ["tasks.arrival_rate=0.05", "tasks.lifetime=100.0"],
            "The truth changes at other steps in each run.",
        ),
    ],
)
def test_what_is_unlike_is_told(file, changes, words):
    options = [word for change in changes for word in ("--set", change)]
    assert words in invoke("run", file, *options, "--runs", 30).stdout
    said = json_of("run", file, *options, "--runs", 5)
    assert (said["truth_intervals"] is None) == ("at other steps" in words)


def test_a_run_in_a_world_that_stays_has_none_of_this():
    said = json_of("run", "--runs", 2, "--steps", 5)
    assert not said.keys() & {"right_share", "detection_delay", "missed", "false_alarms", "truth_intervals"}


def test_results_are_saved_with_their_truth_and_their_measures(file, record, tmp_path):
    words = ("run", file, "--runs", 30, "--seed", 4, "--out")
    assert invoke(*words, tmp_path / "a.nc", "--out", tmp_path / "a.png").exit_code == 0
    opened = open_results(tmp_path / "a.nc")
    np.testing.assert_array_equal(opened["held"], record.held)
    assert opened["truth"].attrs["flag_meanings"] == "infeasible feasible"
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert invoke(*words, tmp_path / "a.csv").exit_code == 0
    with (tmp_path / "a.csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    for name, values in measures_of_runs(record).items():
        assert [int(row[name]) for row in rows] == values.tolist()


@pytest.mark.slow
def test_a_sweep_is_drawn_by_its_measures(file, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        "runs = 10\nseed = 1\n[scenario]\ndecision = {strategy = 'census'}\nrobots = {count = 10}\n"
        "tasks = {count = 5}\narena = {side = 12.0}\nrun = {steps = 200}\n[[scenario.events]]\nstep = 100\n"
        "tasks = 10\n[sweep]\n'events.0.tasks' = [10, 20]\n'decision.strategy' = ['census', 'dmmd']\n"
    )
    out = tmp_path / "out"
    assert invoke("sweep", study, "--out", out, "--workers", 1).exit_code == 0
    said = invoke("results", "status", out).stdout
    assert "steps right" in said or "of the steps" in said
    assert "changes" in said
    for show in ("right_share", "detection_delay", "missed", "false_alarms"):
        words = ("results", "plot", out, "--x", "events.0.tasks", "--show", show, "--out", tmp_path / "a.png")
        assert invoke(*words, "--hue", "decision.strategy").exit_code == 0
        assert invoke(*words, "--y", "decision.strategy").exit_code == 0
        assert invoke(*words).exit_code == 0
    plain = tmp_path / "plain.toml"
    plain.write_text("runs = 2\nseed = 1\n[scenario]\nrun = {steps = 5}\n[sweep]\n'tasks.count' = [3]\n")
    invoke("sweep", plain, "--out", tmp_path / "other", "--workers", 1)
    words = ("results", "plot", tmp_path / "other", "--x", "tasks.count", "--show", "missed")
    assert "no world of" in refused_in_a_line(*words)
