"""A strategy is added by its file and one row: engine, reference, wire, C and commands have it then."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import feasibee
from feasibee.engine import library

PACKAGE = Path(feasibee.__file__).parent


BUILD = """
import sys
from feasibee.engine.build import build
from feasibee.engine.platforms import native
level = sys.argv[1]
build(native()._replace(levels={level: native().levels[level]}))
"""


@pytest.mark.slow
def test_a_strategy_is_its_file_and_one_row(tmp_path):
    """Programs that use it find it; no other file of the package is touched."""
    package = tmp_path / "feasibee"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(package / "strategies" / "census.py", package / "strategies" / "parrot.py")
    table = package / "strategies" / "__init__.py"
    row = '        "roster",\n'
    text = table.read_text()
    assert text.count(row) == 1
    table.write_text(text.replace(row, f'{row}        "parrot",\n'))
    level = library.levels()[0]  # one of them: compiling takes 10 s
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), library.LEVEL: level}
    build = [sys.executable, "-c", BUILD, level]
    changes = ("decision.strategy=parrot", "tasks.count=5", "run.steps=150")
    chosen = (*(word for each in changes for word in ("--set", each)), "--json")
    run = [sys.executable, "-m", "feasibee", "run", *chosen]
    before = subprocess.run(run, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)
    assert "strategy parrot: it isn't in the compiled engine; install feasibee again, or" in before.stderr
    subprocess.run(build, capture_output=True, env=environment, cwd=tmp_path, check=True)
    for wanted, arguments in (
        ('"feasible": 2', ("run", "--runs", "2", *chosen)),
        ("feasibee_parrot", ("robot", "header", "parrot")),
        ('"decision": "feasible"', ("robot", "launch", "--lockstep", "--c", *chosen)),
    ):
        command = [sys.executable, "-m", "feasibee", *arguments]
        done = subprocess.run(
            command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False
        )
        assert done.returncode == 0, done.stderr
        assert wanted in done.stdout
