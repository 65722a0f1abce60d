"""Whose code runs, and when: reading a file runs nothing of it, and what runs is what was kept."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
from commands import invoke
from stores import rows_in

from feasibee import FeasibeeError, Scenario, open_results, save_results, scenario_of, simulate, truth
from feasibee.live.catalogue import read_catalogue
from feasibee.scenario import trial
from feasibee.scenario.runs import Runs
from feasibee.simulation import executors
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.plan import Study, study_of
from feasibee.simulation.store import Store
from feasibee.simulation.sweep import complete

TEXT = """\
PARAMETERS = {"weight": 1.0}

def decide(mind, inbox):
    return 1 if inbox.chance < 0.5 else 0
"""
OTHER = TEXT.replace("< 0.5", "< 2.0")
"""Decides feasible always, so that its rows are told apart."""


MARK = "MARK = 1"
"""A line of a text whose run leaves a mark."""


@pytest.fixture
def marker(tmp_path, monkeypatch):
    """A file that is made when a text with the line is run."""
    made, run = tmp_path / "ran", trial._executed

    def executed(manifest, file):
        if MARK in manifest.source:
            made.touch()
        return run(manifest, file)

    monkeypatch.setattr(trial, "_executed", executed)
    return made


@pytest.fixture
def program(tmp_path):
    """A strategy whose file leaves a mark when it runs."""
    file = tmp_path / "program.py"
    file.write_text(f"{MARK}\n{TEXT}")
    return file


@pytest.fixture
def scenario_file(tmp_path, program):
    file = tmp_path / "swarm.toml"
    file.write_text(f"[decision]\nstrategy = '{program.name}'\n[run]\nsteps = 10\n")
    return file


def test_a_scenario_is_read_checked_and_printed_without_its_strategy_being_run(scenario_file, marker):
    for command in (("truth",), ("truth", "--json"), ("scenario",)):
        assert invoke("show", *command, scenario_file).exit_code == 0
    scenario = Scenario.read(scenario_file)
    changed = scenario.replace({"tasks.count": 3})
    assert (truth(scenario), changed.decision.parameters) == (True, {"weight": 1.0})
    assert changed.hash != scenario.hash
    assert "weight" in scenario._repr_html_()
    assert not marker.exists()
    assert scenario.strategy.memory == 0
    assert marker.exists()


@pytest.fixture
def results(tmp_path, scenario_file, marker):
    """The folder of a study with that strategy, and its results as NetCDF."""
    study = tmp_path / "study.toml"
    study.write_text('file = "swarm.toml"\nruns = 6\nseed = 1\n[sweep]\n"tasks.count" = [2, 40]\n')
    complete(Study.read(study), tmp_path / "results", executors.threads(1))
    save_results(simulate(Scenario.read(scenario_file), runs=3), tmp_path / "runs.nc")
    marker.unlink()
    return tmp_path / "results"


@pytest.mark.parametrize("file", ["there", "gone", "another"])
def test_results_are_shown_without_their_strategies_being_run(results, tmp_path, program, marker, file):
    if file == "gone":
        program.unlink()
    if file == "another":
        program.write_text(f"{MARK}\n{OTHER}")
    for command in (
        ("results", "status", results),
        ("results", "status", results, "--json"),
        ("results", "plot", results, "--x", "tasks.count"),
        ("results", "export", results),
        ("results", "export", results, "--out", tmp_path / "all.nc"),
    ):
        done = invoke(*command)
        assert done.exit_code == 0, done.output
    assert read_catalogue(results, "all").replays["found"] == 12
    dataset = open_results(tmp_path / "runs.nc")
    scenario = scenario_of(dataset)
    assert scenario.hash == json.loads(dataset.attrs["recipe"])["scenario_hash"]
    assert not marker.exists()


def test_the_text_in_results_runs_only_if_it_is_a_present_file_or_trusted(results, tmp_path, program, marker):
    dataset = open_results(tmp_path / "runs.nc")
    again = simulate(scenario_of(dataset), runs=3)
    np.testing.assert_array_equal(again.decision, dataset.decision)
    marker.unlink(missing_ok=True)  # it ran before, in the fixture
    program.write_text(OTHER)
    foreign = scenario_of(dataset)
    for scenario in (foreign, foreign.replace({"tasks.count": 3}), pickle.loads(pickle.dumps(foreign))):
        with pytest.raises(
            FeasibeeError, match=r"isn't that of a file of yours .* with --trust .*trust=True"
        ):
            simulate(scenario)
    assert not marker.exists()
    np.testing.assert_array_equal(
        simulate(scenario_of(dataset, trust=True), runs=3).decision, dataset.decision
    )


def test_a_link_to_a_file_of_somebody_else_is_not_the_users_own(tmp_path, program, monkeypatch):
    scenario = Scenario.from_tables(
        {"decision": {"strategy": str(program)}}, source=program.read_text(), trusted=False
    )
    assert scenario.strategy.name == str(program)
    monkeypatch.setattr("os.getuid", lambda: program.stat().st_uid + 1)
    with pytest.raises(FeasibeeError, match="isn't that of a file of yours"):
        _ = scenario.strategy


def test_imports_are_checked_before_anything_is_executed(tmp_path, marker):
    file = tmp_path / "evil.py"
    for first in (
        f"import os; os.system('touch {marker}')",
        f"open('{marker}', 'w').close(); from . import os",
    ):
        file.write_text(f"{first}\n{TEXT}")
        done = invoke("run", "--set", f"decision.strategy={file}", "--runs", "1")
        assert done.exit_code == 2
        assert "evil.py, line 1: imports" in done.stderr
        assert not marker.exists()


# --- What was kept is what ran ---


@pytest.mark.slow
def test_a_strategys_file_that_is_edited_during_a_sweep_changes_no_row(tmp_path):
    """In the folder is the text of the start, and every row is that text's."""
    file = tmp_path / "mine.py"
    file.write_text(TEXT)
    tables = {"runs": 40, "scenario": {"run": {"steps": 60}, "decision": {"strategy": "mine.py"}}}
    study = study_of({**tables, "sweep": {"tasks.count": list(range(1, 31))}}, tmp_path)
    told = []

    def edit(progress):
        told.append(progress)
        file.write_text(OTHER)

    complete(study, tmp_path / "results", executors.threads(1), progress=edit)
    assert told[0].runs_done == 0  # it was edited before the first run
    store = Store(tmp_path / "results")
    for point, row in zip(study.points, store.points, strict=True):
        assert row.scenario.manifest.source == TEXT
        kept = simulate_record(point.scenario, Runs(40, 0))
        columns = rows_in(store, row)
        np.testing.assert_array_equal(columns[:, 1], kept.decision)
        np.testing.assert_array_equal(columns[:, 3], kept.bits_sent)


def test_a_scenario_takes_its_strategys_text_along(tmp_path):
    """To other processes and machines, where the path may lead to another file or nowhere."""
    file = tmp_path / "mine.py"
    file.write_text(TEXT)
    scenario = Scenario(decision={"strategy": str(file)}, sensing={"range": 3.0})
    packed = pickle.dumps(scenario)
    file.write_text(OTHER)
    there = pickle.loads(packed)
    file.unlink()
    assert (there, there.hash, there.manifest) == (scenario, scenario.hash, scenario.manifest)
    assert there.replace({"sensing.range": 4.0}).radio.range == 4.0  # what wasn't set isn't set there
    assert there.replace({"tasks.count": 3}).strategy.source == TEXT
    np.testing.assert_array_equal(simulate(there, runs=5).decision, simulate(scenario, runs=5).decision)
    with pytest.raises(FeasibeeError, match="can't be read"):
        scenario.replace({"decision.strategy": str(file)})
