"""The engine's library is the one that this processor needs, and takes numbers as Python lays them out."""

from __future__ import annotations

import os

import numpy as np
import pytest
from commands import python

from feasibee.engine import library, platforms
from feasibee.engine.params import PARAMS, packed
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.lowering import lower

KINDS = {
    "bool": np.bool_,
    "_Bool": np.bool_,
    "int64_t": np.int64,
    "uint64_t": np.uint64,
    "uint32_t": np.uint32,
    "double": np.float64,
}
"""Types of numpy by those of C."""


def assert_same(struct, record):
    """Compare a struct, as cffi reads engine.h, with a record type of numpy, field by field."""
    fields = struct.fields
    assert [name for name, _ in fields] == list(record.names)
    for name, field in fields:
        dtype, offset = record.fields[name][:2]
        assert field.offset == offset, name
        if field.type.kind == "struct":
            assert_same(field.type, dtype)
        else:
            assert KINDS[field.type.cname] == dtype, name
    assert library.ffi().sizeof(struct) == record.itemsize


def test_the_numbers_of_a_scenario_lie_where_the_header_says():
    assert_same(library.ffi().typeof("struct params"), PARAMS)


def test_the_engine_reads_the_numbers_that_python_packs():
    record = packed(lower(Scenario(robots={"count": 23}, run={"steps": 77}), 2**40 + 5).params)
    params = library.pointer(record, "struct params")
    assert (params.seed.low, params.seed.high) == (5, 2**8)
    assert (params.robots.count, params.run.steps) == (23, 77)


def test_a_pointer_is_of_numbers_of_that_size():
    numbers = np.arange(6, dtype=np.int32).reshape(2, 3)
    assert library.pointer(numbers, "int32_t")[4] == 4
    assert library.pointer(None, "int32_t") == library.ffi().NULL
    library.pointer(np.zeros((3, 0), np.int32), "int32_t")
    with pytest.raises(TypeError, match="an array of int32 has no numbers of type int64_t"):
        library.pointer(numbers, "int64_t")
    with pytest.raises(ValueError, match="contiguous"):
        library.pointer(numbers.T, "int32_t")


def run(level):
    """Return what a command prints with a level, and its errors."""
    words = ("-m", "feasibee", "run", "--runs", 40, "--seed", 1, "--set", "run.steps=80")
    done = python(*words, env={**os.environ, library.LEVEL: level})
    return done.stdout + done.stderr


def test_each_level_gives_the_same_results():
    found = library.levels()
    assert found == list(platforms.native().levels)[: len(found)]
    (said,) = {run(level) for level in found}
    assert "feasible 3, infeasible 4" in said
