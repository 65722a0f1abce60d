"""Whatever numbers the engine in C is given, it plays them or says that it can't."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from random import Random
from typing import Any

import numpy as np
import pytest

from feasibee.base.record import Record
from feasibee.engine import given, library, platforms, players
from feasibee.engine.build import LIBRARIES, compile_library
from feasibee.engine.compilers import Compiler
from feasibee.engine.tables import Control
from feasibee.simulation.lowering import lower
from tests.worlds import world

ODD = {
    bool: (True, False),
    int: (-(2**63), -1, 0, 1, 2, 3, 7, 127, 128, 129, 5000, 2**24 + 1, 2**31, 2**32, 2**63 - 1),
    float: (-1e308, -1.0, 0.0, 1e-300, 0.5, 3.0, 1e9, 1e308, float("inf"), float("nan")),
    np.uint32: (0, 1, 17, 2**16, 2**31, 2**32 - 1),
    np.uint64: (0, 1, 2**20, 2**40, 2**58, 2**61, 2**62, 2**63, 2**64 - 1),
}
"""Numbers at the edges of each type, and beyond what scenarios have."""


def paths(numbers: Any, before: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Return where each number of a tuple of numbers is."""
    found = []
    for name, value in numbers._asdict().items():
        found += paths(value, (*before, name)) if hasattr(value, "_fields") else [(*before, name)]
    return found


def replaced(numbers: Any, path: tuple[str, ...], value: Any) -> Any:
    """Return numbers of which one is another."""
    name, *rest = path
    own = getattr(numbers, name)
    return numbers._replace(**{name: replaced(own, tuple(rest), value) if rest else value})


def odd(number: int) -> Any:
    """Return a world of which up to three numbers are others."""
    draw = Random(number)
    lowered = lower(world(number, fast=True), number)
    params = lowered.params
    for path in draw.sample(paths(params), draw.randint(1, 3)):
        old = params
        for name in path:
            old = getattr(old, name)
        kind = bool if isinstance(old, bool | np.bool_) else next(k for k in ODD if isinstance(old, k))
        params = replaced(params, path, kind(draw.choice(ODD[kind])))
    return lowered._replace(params=params)


def play(lowered: Any) -> bool:
    """Play a run for a few steps; return whether the engine has the world."""
    try:
        player = players.PaperWorld(given.Given(lowered), 1)
    except ValueError:
        return False
    ends = Control(np.zeros(1, np.int64), np.ones(1, np.bool_))
    player.play(Record.empty(0, 1, 0), ends)
    return True


@pytest.mark.parametrize("part", range(4))
def test_odd_numbers_are_played_or_refused(part):
    played = [play(odd(number)) for number in range(100 * part, 100 * part + 100)]
    assert 20 < sum(played) < 100


def test_the_worlds_of_scenarios_are_played():
    assert all(play(lower(world(number, fast=True), number)) for number in range(60))


SANITIZED = """
import sys
from pathlib import Path
from feasibee.engine import given, library
from tests.engine.test_params import odd, play
given.library = lambda: (library.ffi(), library.load(Path(sys.argv[1])))
print(sum(play(odd(number)) for number in range(400, 500)))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux" or shutil.which("gcc") is None, reason="needs gcc's sanitizers")
def test_odd_numbers_touch_nothing_that_is_not_theirs(tmp_path):
    shutil.copy(LIBRARIES / "strategies.c", tmp_path)
    file, target = tmp_path / "sanitized.so", platforms.native()
    options = ("-O0", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    compile_library(file, target, library.levels()[-1], Compiler(("gcc",), "gcc"), *options)
    asked = (["gcc", f"-print-file-name={each}"] for each in ("libasan.so", "libubsan.so"))
    first = ":".join(subprocess.check_output(each, text=True).strip() for each in asked)
    leaks = "detect_leaks=0:allocator_may_return_null=1"  # Python's own
    done = subprocess.run(
        [sys.executable, "-c", SANITIZED, str(file)],
        env={**os.environ, "LD_PRELOAD": first, "ASAN_OPTIONS": leaks},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) > 60
