"""The pages of docs/: their Python prints what they say. `make docs` checks links and runs the gallery."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from feasibee import Scenario, simulate

ROOT = Path(__file__).parents[2]
SCRIPT = re.compile(r"```python\n((?:(?!```).)*print\([^\n]*\)  # ([^\n]*)\n)```", re.DOTALL)


@pytest.mark.parametrize("page", ["deploying", "add-a-strategy"])
def test_the_controller_on_the_page_does_what_the_page_says(page, tmp_path):
    shutil.copy(ROOT / "examples" / "strategies" / "witness.py", tmp_path / "mine.py")
    ((script, said),) = SCRIPT.findall((ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8"))
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stderr, done.stdout.strip()) == ("", said.partition(":")[0])


def test_the_strategy_on_the_page_is_the_example():
    text = (ROOT / "docs" / "add-a-strategy.md").read_text(encoding="utf-8")
    blocks = re.findall(r"   ```python\n(.*?)   ```", text, re.DOTALL)
    assert (ROOT / "examples" / "strategies" / "witness.py").read_text() in [
        re.sub(r"(?m)^   ", "", each) for each in blocks
    ]


def test_the_robots_on_the_page_declare_rightly_in_both_implementations():
    path = str(ROOT / "examples" / "strategies" / "quiet_census.py")
    short = {"arena.side": 8.0, "run.steps": 160, "robots.know_count": True, "decision.strategy": path}
    for tasks, count in ((20, "declared_feasible"), (21, "declared_infeasible")):
        scenario = Scenario().replace({**short, "tasks.count": tasks})
        engine, plain = (
            simulate(scenario, runs=1, seed=1, curves=True, backend=each) for each in ("engine", "reference")
        )
        assert plain.equals(engine)
        assert engine[count].item() == 20


def test_a_phase_may_have_mean_zero_on_the_pages():
    """A robot that saw only tasks gives *feasible* quality 0, and tells it for a mean of 0 steps."""
    for name in ("docs/deploying.md", "docs/add-a-strategy.md", "src/feasibee/robot/controller.py"):
        (line,) = re.findall(r"draw_duration=(lambda.*),\n", (ROOT / name).read_text(encoding="utf-8"))
        assert eval(line, {"random": __import__("random")})(0.0) == 1
