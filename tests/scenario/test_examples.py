"""The examples: each is what its comment says, and runs alike in engine and reference."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from feasibee import Scenario, truth
from feasibee.scenario.feasibility import explain
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

FOLDER = Path(__file__).parents[2] / "examples"
FILES = sorted(FOLDER.glob("*.toml"))


@pytest.fixture(params=FILES, ids=lambda path: path.stem)
def path(request):
    return request.param


def test_there_are_four_and_the_readme_names_them():
    assert [path.stem for path in FILES] == ["changing", "field", "search", "spill"]
    assert set(re.findall(r"\((?:\./)?(\w+)\.toml\)", (FOLDER / "README.md").read_text())) == {
        path.stem for path in FILES
    }


def test_the_truth_is_as_the_comment_says_and_swarms_decide(path):
    (said,) = re.findall(r"^# Ground truth: (\w+)\.", path.read_text(), re.MULTILINE)
    assert said == ("feasible" if truth(Scenario.read(path)) else "infeasible")
    assert (simulate_record(Scenario.read(path), Runs(20, 1)).decision != -1).sum() >= 15


def test_with_ten_porters_less_it_is_infeasible_as_the_comment_says():
    tables = Scenario.read(FOLDER / "search.toml").to_dict()
    tables["robots"]["classes"][0]["count"] -= 10
    violator = explain(Scenario.model_validate(tables)).violator
    assert violator is not None
    assert (violator.skills, violator.demand, violator.robots) == (("lift", "relay"), 15, 6)


@pytest.mark.quick(1)
def test_engine_and_reference_agree(path):
    scenario = Scenario.read(path).replace({"run.steps": 60})
    engine, plain = (
        simulate_record(scenario, Runs(2, 3), curves=True, backend=backend)
        for backend in ("engine", "reference")
    )
    for name in ("decision", "decision_step", "feasible_count"):
        np.testing.assert_array_equal(getattr(engine, name), getattr(plain, name), err_msg=name)


def test_the_truth_of_the_changing_world_changes_as_the_comment_says():
    scenario = Scenario.read(FOLDER / "changing.toml").replace({"run.steps": 12_000})
    record = simulate_record(scenario.replace({"decision.strategy": "dmmd"}), Runs(60, 1))
    changes = (np.diff(record.truth[:, 2000:]) != 0).sum()
    assert 400 < 60 * 10_000 / changes < 600


def test_robots_are_sent_until_there_is_one_for_each_task():
    example = runpy.run_path(FOLDER / "send_robots.py")
    swarm, sent = example["serve"](example["SCENARIO"])
    assert sent == [413, 523, 633]
    assert swarm.robot_counts[[462, 463, -1]].tolist() == [20, 22, 26]
    assert (swarm.task_counts[-1], swarm.truth, swarm.decision) == (26, True, 1)
    assert (swarm.truths == (swarm.robot_counts >= swarm.task_counts)).all()
