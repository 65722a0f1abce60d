"""Each script of research/ runs with the public interface, and prints what it should."""

from __future__ import annotations

import ast
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
