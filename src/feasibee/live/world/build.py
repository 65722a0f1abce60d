"""Compile the page's world from C to WebAssembly: ``python -m feasibee.live.world.build``, or ``make wasm``.

Needs the PyPI package ziglang, whose version pyproject.toml pins: another one may give other bytes.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from subprocess import PIPE
from typing import Final

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.live.world.lowering import CELLS_LIMIT, EVENTS_LIMIT, ROBOTS_LIMIT, TASKS_LIMIT, WORDS_LIMIT
from feasibee.robot.firmware import FOLDER as PARTS
from feasibee.robot.firmware import constant, header
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy

FOLDER: Final = Path(__file__).parent
WASM: Final = FOLDER / "world.wasm"
"""The world compiled with all built-in strategies."""
FLAGS: Final = (
    *("-target", "wasm32-wasi", "-mexec-model=reactor", "-s"),
    *("-std=c99", "-O2", "-ffp-contract=off"),
)
WARNINGS: Final = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")


def limits(strategies: Sequence[Strategy]) -> str:
    """Return the text of limits.h: sizes of arrays, and the table of strategies."""
    table = ", ".join(f"&{constant(each)}" for each in strategies)
    sizes = {"ROBOTS": ROBOTS_LIMIT, "TASKS": TASKS_LIMIT, "EVENTS": EVENTS_LIMIT, "WORDS": WORDS_LIMIT}
    values = {**sizes, "CELLS": CELLS_LIMIT, "STRATEGIES": table}
    return "".join(f"#define WORLD_{name} {value}\n" for name, value in values.items())


def compile_world(out: Path, strategies: Sequence[Strategy] = tuple(STRATEGIES.values()), *more: str) -> None:
    """Compile world.c and strategies to WebAssembly, with the headers that it needs.

    Raise a FeasibeeError if the compiler isn't installed, or a strategy can't be compiled.
    """
    if find_spec("ziglang") is None:
        raise FeasibeeError(f"ziglang: not installed; {how_to_install('c')}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "limits.h").write_text(limits(strategies), encoding="utf-8")
        (folder / "feasibee.h").write_text(header(strategies), encoding="utf-8")
        zig = [sys.executable, "-m", "ziglang", "cc", *FLAGS, *more, "-I", name, "-I", str(PARTS)]
        done = subprocess.run(
            [*zig, "-o", str(out), str(FOLDER / "world.c")], stderr=PIPE, text=True, check=False
        )
    if done.returncode:
        said = next((line for line in done.stderr.splitlines() if "error:" in line), done.stderr[-300:])
        raise FeasibeeError(
            f"ziglang: can't compile a page's world: {said.strip()}; report it with the strategy"
        )
    out.chmod(0o644)  # the linker makes it executable


if __name__ == "__main__":
    compile_world(WASM, tuple(STRATEGIES.values()), *WARNINGS)
