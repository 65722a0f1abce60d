"""Each script of research/ runs with the public interface, and prints what it should."""

from __future__ import annotations

import ast
import json
import re
import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "research"
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.py"))


@pytest.fixture
def run(capsys, monkeypatch, tmp_path):
    """Return a function that runs a script with arguments, in an empty folder, and returns what it prints."""
    monkeypatch.chdir(tmp_path)

    def run(name, *arguments):
        monkeypatch.setattr(sys, "argv", [f"{name}.py", *map(str, arguments)])
        runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
        return capsys.readouterr().out

    return run


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_is_short_uses_the_public_interface_and_explains_itself(name, run, capsys):
    text = (FOLDER / f"{name}.py").read_text("utf-8")
    assert len(text.splitlines()) <= 150
    imported = [each for each in ast.walk(ast.parse(text)) if isinstance(each, ast.Import | ast.ImportFrom)]
    names = [getattr(each, "module", None) or each.names[0].name for each in imported]
    assert "feasibee" in names
    assert not any(each.startswith("feasibee.") for each in names)
    with pytest.raises(SystemExit, match="0"):
        run(name, "--help")
    assert f"example: python research/{name}.py" in capsys.readouterr().out
    assert f"`{name}.py`" in (FOLDER / "README.md").read_text("utf-8")


def test_the_chain_is_written_with_chances_that_add_up(run):
    text = run("export_prism", "--tasks", 10)
    rows = re.findall(r"\[\] x=(\d+) -> (.*);", text)
    assert len(rows) == 20
    for _, row in rows:
        assert sum(map(float, re.findall(r"([\d.e-]+):\(", row))) == pytest.approx(1)
    assert 'label "feasible" = x=20;' in text


def test_robots_visit_the_arena(run, tmp_path):
    assert run("heat", "--runs", 1, "--every", 200).startswith("4.")
    assert (tmp_path / "heat.png").stat().st_size > 10_000


def test_pooled_sightings_come_before_what_enough_robots_know(run):
    found = json.loads(run("limits", "--tasks", 21, "--runs", 3))
    for what in ("names", "map"):
        assert 0 < found[f"pooled {what}"]["median"] < found[what]["median"] < 100
    assert found["names"]["median"] < found["map"]["median"]
    assert 1 <= found["all taken"]["median"] <= found["all taken"]["p95"] < 15
    assert 1 < found["distance"] < 5


def test_robots_that_ask_first_cost_least_with_fewer_robots_than_tasks(run):
    found = json.loads(run("pays", "--missions", 2, "--ratio", 0.7))
    assert {*found} == {"start at once", "search first", "ask first"}
    assert min(found, key=lambda policy: found[policy]["cost"]) == "ask first"
    assert all(each["low"] <= each["cost"] <= each["high"] for each in found.values())


@pytest.mark.parametrize("strategy", ["dmvd", FOLDER.parent / "examples" / "strategies" / "quiet_census.py"])
def test_the_worst_lie_is_no_better_than_none(run, strategy):
    found = json.loads(run("lies", strategy, "--runs", 1, "--trials", 1))
    assert {*found} == {"feasible", "infeasible"}
    for side in found.values():
        assert side["right"]["estimate"] <= side["without"]["estimate"]
        assert side["lie"]


def test_a_door_splits_some_swarms(run):
    found = json.loads(run("rooms", "--runs", 1))
    assert found["twice the door"]["changes"] > found["as it is"]["changes"] > 0
    assert all(each["low"] <= each["split"] <= each["high"] for each in found.values())


def test_a_search_is_judged_on_fresh_runs(run):
    pytest.importorskip("optuna")
    found = json.loads(run("tune", "--trials", 2, "--runs", 4))
    assert {*found["values"]} == {"decision.exploration", "decision.gain"}
    assert 0 < found["best"]["estimate"] <= 1


def test_more_tasks_lower_the_share_that_decides_feasible(run):
    found = json.loads(run("sensitivities", "-", "tasks.count"))["tasks.count"]
    assert found["feasible"] == pytest.approx(-0.28, abs=0.03)
    found = json.loads(run("sensitivities", "-", "tasks.count=2:40", "--points", 10, "--runs", 4))
    assert -1 <= found["tasks.count"]["low"] <= found["tasks.count"]["correlation"] <= 1
