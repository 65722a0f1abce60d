"""Compile the page's world from C to WebAssembly: ``python -m feasibee.live.world.build``, or ``make wasm``.

Needs the PyPI package ziglang, whose version pyproject.toml pins: another one may give other bytes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

from feasibee.live.page import WASM
from feasibee.live.world.lowering import PAGE_STRATEGIES, ROBOTS_LIMIT, TASKS_LIMIT
from feasibee.robot.firmware import header

FOLDER: Final = Path(__file__).parent
FLAGS: Final = (
    *("-target", "wasm32-freestanding", "-nostdlib", "-Wl,--no-entry", "-s"),
    *("-std=c99", "-O2", "-ffp-contract=off"),
    *("-Wall", "-Wextra", "-Wpedantic", "-Werror"),
)


def limits() -> str:
    """Return the text of limits.h: sizes of arrays, and the table of strategies."""
    table = ", ".join(f"&feasibee_{name.replace('-', '_')}" for name in PAGE_STRATEGIES)
    values = {"ROBOTS": ROBOTS_LIMIT, "TASKS": TASKS_LIMIT, "STRATEGIES": table}
    return "".join(f"#define WORLD_{name} {value}\n" for name, value in values.items())


def compile_world(out: Path) -> None:
    """Compile world.c to WebAssembly, with the headers that it needs."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "limits.h").write_text(limits(), encoding="utf-8")
        (folder / "feasibee.h").write_text(header(PAGE_STRATEGIES), encoding="utf-8")
        zig = [sys.executable, "-m", "ziglang", "cc", *FLAGS, "-I", name]
        cache = {"ZIG_GLOBAL_CACHE_DIR": str(folder / "global"), "ZIG_LOCAL_CACHE_DIR": str(folder / "local")}
        subprocess.run(
            [*zig, "-o", str(out), str(FOLDER / "world.c")], check=True, env={**os.environ, **cache}
        )
    out.chmod(0o644)  # the linker makes it executable


if __name__ == "__main__":
    compile_world(WASM)
