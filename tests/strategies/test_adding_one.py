"""A strategy is added by its file and one row: engine, reference, wire, C and commands have it then."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import feasibee

PACKAGE = Path(feasibee.__file__).parent
PARROT = '''"""Parrot: robots pass on the largest number of tasks that any has seen in one step.

Message: 8 bits. Memory: that number, the number in this step, and the step.
"""

PARAMETERS = {"weight": 1.0}


def decide(mind, inbox):
    """Return feasible if there are as many robots as tasks, or more."""
    return 1 if mind.feasible_quality >= 0.5 else 0


def words(setting):
    """Return the size of what is known."""
    return 3


def message_words(setting):
    """Return the size of a message."""
    return 1


def observe(known, thing, me):
    """Count the tasks in sight in this step."""
    if known[2] != me.step + 1:
        known[1], known[2] = 0, me.step + 1
    known[1] += 0 if thing.is_robot else 1
    known[0] = min(max(known[0], known[1]), 255)


def encode(message, known, me):
    """Write the largest number."""
    message[0] = known[0]


def merge(known, message, sender, me):
    """Keep the larger number."""
    known[0] = max(known[0], message[0])


def count(known, counts, me):
    """Count a robot for each task that may be in sight."""
    counts[0], counts[1] = me.setting.robots, int(me.setting.parameters[0] * known[0])


def bits(message, me):
    """Return the length of a message."""
    return 8


def layout(wire, message, sender, setting):
    """Go through the number."""
    message[0] = wire.number(message[0], 8)
    return -1
'''


@pytest.mark.slow
def test_a_strategy_is_its_file_and_one_row(tmp_path):
    """Programs that use it find it; no other file of the package is touched."""
    package = tmp_path / "feasibee"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    (package / "strategies" / "parrot.py").write_text(PARROT)
    table = package / "strategies" / "__init__.py"
    row = '        "roster",\n'
    text = table.read_text()
    assert text.count(row) == 1
    table.write_text(text.replace(row, f'{row}        "parrot",\n'))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    build = [sys.executable, "-m", "feasibee.engine.build"]
    chosen = ("--set", "decision.strategy=parrot", "--set", "run.steps=50", "--json")
    run = [sys.executable, "-m", "feasibee", "run", *chosen]
    before = subprocess.run(run, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)
    assert "strategy parrot: it isn't in the compiled engine; install feasibee again, or" in before.stderr
    subprocess.run(build, capture_output=True, env=environment, cwd=tmp_path, check=True)
    for wanted, arguments in (
        ('"feasible": 2', ("run", "--runs", "2", *chosen)),
        ("feasibee_parrot", ("header", "--strategy", "parrot")),
        ('"decision": "feasible"', ("launch", "--lockstep", "--c", *chosen)),
    ):
        command = [sys.executable, "-m", "feasibee", *arguments]
        done = subprocess.run(
            command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False
        )
        assert done.returncode == 0, done.stderr
        assert wanted in done.stdout
