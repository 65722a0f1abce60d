"""feasibee run, sweep and plot in worlds that change."""

from __future__ import annotations

import csv
import json

import changing
import numpy as np
import pytest
from commands import invoke, json_of, output_of, refused_in_a_line

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
    said = invoke("run", file, "--runs", 30, "--seed", 4, "--details").stdout
    assert "feasible in steps 0 to 119, infeasible in steps 120 to 240" in said
    found = tracking(record, Scenario.from_toml(TOML))
    right, followed = said.splitlines()[:2]
    assert right.startswith(f"Right in {100 * found.right_share.estimate:.0f} % of the steps (")
    assert right.endswith(f"), with {found.false_alarms.estimate:.2g} false alarms per 1,000 steps.")
    half = f"half were followed within {found.detection_delay.median} steps"
    assert followed.startswith(f"Of {found.changes} changes, {half}; ")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["decision.strategy=dmmd"], "changes, fewer than half were followed; "),
        (["events.0.tasks=1"], "No swarm was right just before a change, so none could follow one."),
        (["tasks.arrival_rate=0.05", "tasks.lifetime=100.0"], "truth_intervals                 none"),
    ],
)
def test_what_is_unlike_is_told(file, changes, words):
    options = [word for change in changes for word in ("--set", change)]
    assert words in invoke("run", file, *options, "--runs", 30, "--details").stdout
    said = json_of("run", file, *options, "--runs", 5)
    assert (said["truth_intervals"] is None) == ("truth_intervals" in words)


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
def test_a_sweep_is_drawn_by_its_measures(tmp_path):
    """Over two fields, in lines, and by itself; where the world stays, there is nothing to draw."""
    scenario = "[scenario]\nrun.steps = 200\nevents = [{step = 100, tasks = 10}]\nrobots.count = 10\n"
    sweep = "[sweep]\n'events.0.tasks' = [5, 20]\n'decision.strategy' = ['census', 'dmmd']\n"
    (tmp_path / "study.toml").write_text(f"runs = 10\n{scenario}{sweep}")
    (tmp_path / "plain.toml").write_text(
        "runs = 2\n[scenario]\nrun = {steps = 5}\n[sweep]\n'tasks.count' = [3]\n"
    )
    for name in ("study", "plain"):
        assert invoke("sweep", tmp_path / f"{name}.toml", "--out", tmp_path / name).exit_code == 0
    assert "changes" in output_of("results", "status", tmp_path / "study")
    words = ("results", "plot", tmp_path / "study", "--x", "events.0.tasks", "--out", tmp_path / "a.png")
    for show in ("right_share", "detection_delay", "missed", "false_alarms"):
        for more in (("--hue", "decision.strategy"), ("--y", "decision.strategy"), ()):
            output_of(*words, "--show", show, *more)
    words = ("results", "plot", tmp_path / "plain", "--x", "tasks.count", "--show", "missed")
    assert "no world of" in refused_in_a_line(*words)
