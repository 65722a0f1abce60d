"""The engine in WebAssembly gives the same record as on this processor, bit for bit."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest
from in_node import ARRAYS, play_in_node

from feasibee import STRATEGIES, Scenario
from feasibee.engine.build import SOURCES
from feasibee.engine.compilers import zig
from feasibee.engine.library import ffi
from feasibee.engine.platforms import WEBASSEMBLY
from feasibee.model.record import Record
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import lower

FIRST = 3
WORLDS = {
    "paper": {},
    "two": {"robots.count": 2, "tasks.count": 1},
    "forty": {"robots.count": 40, "tasks.count": 35, "radio.range": 2.5},
    "full": {"robots.count": 128, "tasks.count": 100, "arena.side": 30.0},
    "crowd": {"robots.count": 300, "tasks.count": 300, "arena.side": 77.0},
}
OPINIONS = [name for name, each in STRATEGIES.items() if not each.knowledge]


def scenario_of(changes, strategy):
    return Scenario().replace({"run.steps": 150, **changes, "decision.strategy": strategy})


def assert_same(scenario, runs):
    """Compare a record of node with one of this processor."""
    record = Record.empty(FIRST, runs, scenario.run.steps + 1)
    play_in_node(lower(scenario, 7), record)
    own = simulate_record(scenario, Runs(runs, 7, FIRST), curves=True)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(record, name), getattr(own, name), name)


@pytest.mark.parametrize("world", WORLDS)
def test_worlds(world):
    assert_same(scenario_of(WORLDS[world], "dmmd"), 20 if world != "crowd" else 2)


@pytest.mark.parametrize("strategy", OPINIONS)
@pytest.mark.quick(3)
def test_strategies(strategy):
    assert_same(scenario_of({}, strategy), 20)


def names(struct):
    """Yield the names of the numbers of a struct in C, those of its structs in addition."""
    for name, field in struct.fields:
        yield name
        if field.type.kind == "struct":
            yield from (f"{name}.{below}" for below in names(field.type))


def test_structs_that_python_writes_are_the_same_with_short_pointers(tmp_path):
    """Bytes of params and settings are handed to pages as they are."""
    if zig() is None:
        pytest.skip("ziglang isn't installed")
    lines = ["#include <stddef.h>", '#include "engine.h"']
    for struct in ("struct params", "struct setting"):
        for name in names(ffi().typeof(struct)):
            offset = ffi().offsetof(struct, *name.split("."))
            lines.append(f'_Static_assert(offsetof({struct}, {name}) == {offset}, "{name}");')
        lines.append(f'_Static_assert(sizeof({struct}) == {ffi().sizeof(struct)}, "{struct}");')
    source = tmp_path / "places.c"
    source.write_text("\n".join(lines))
    options = ["-target", WEBASSEMBLY.target, "-c", "-o", str(tmp_path / "places.o"), "-I", str(SOURCES)]
    command = [*zig().command, *options, str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(lines) > 200
