"""The page about the controller in C: its program compiles and runs."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from feasibee.robot.firmware import header, strategies_in_c
from feasibee.strategies import STRATEGIES
from tests.robot.driving import HERE, SANITIZED, STRICT, compiler

PAGE = Path(__file__).parents[2] / "docs" / "firmware.md"


def test_the_program_on_the_page_runs(tmp_path):
    (code,) = re.findall(r"```c\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "robot.c").write_text(code)
    (tmp_path / "feasibee.h").write_text(header("dmmd", inbox=32))
    sources = [tmp_path / "robot.c", HERE / "stubs.c", "-I", tmp_path, "-o", tmp_path / "robot"]
    subprocess.run([*compiler(), *STRICT, *SANITIZED, *sources], check=True)
    said = subprocess.run([tmp_path / "robot"], capture_output=True, text=True, check=True).stdout
    broadcasts, feasible = (int(number) for number in re.findall(r"\d+", said))
    assert 200 < broadcasts < 800
    assert feasible > 900


def test_the_page_names_all_strategies_without_knowledge():
    text = PAGE.read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in strategies_in_c() if not STRATEGIES[name].knowledge)
