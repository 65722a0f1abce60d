"""Runs by the engine in WebAssembly, in node."""

from __future__ import annotations

import json
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from feasibee.engine.build import build
from feasibee.engine.compilers import zig
from feasibee.engine.given import struct_of
from feasibee.engine.library import ffi
from feasibee.engine.params import packed
from feasibee.engine.platforms import WEBASSEMBLY

HARNESS = Path(__file__).with_name("wasm.mjs")
ARRAYS = ("decision", "decision_step", "feasible_count", "infeasible_count", "account")
"""Of a record, in the order of ``struct outcome``."""


@cache
def module():
    """Return the path of the engine in WebAssembly; skip the test without ziglang or node."""
    if shutil.which("node") is None:
        pytest.skip("no node in PATH")
    if zig() is None:
        pytest.skip("ziglang isn't installed: it compiles WebAssembly")
    return build(WEBASSEMBLY)[0]


def play_in_node(lowered, record, *options):
    """Fill in a record of runs of a scenario with a built-in strategy; return what node says."""
    setting, (plan, parameters) = struct_of(ffi(), lowered.setting)
    kept = [getattr(record, name) for name in ARRAYS]
    given = [
        packed(lowered.params).tobytes(),
        *(bytes(ffi().buffer(each)) for each in (setting, plan, parameters)),
    ]
    job = {
        "strategy": lowered.strategy.name,
        "memory": lowered.strategy.memory,
        "first_run": record.first_run,
        "runs": record.runs,
        "curve_length": record.feasible_count.shape[1],
        "columns": record.account.shape[1],
        "given": [len(each) for each in given],
        "arrays": [each.nbytes for each in kept],
        "offset_of_plan": ffi().offsetof("struct setting", "plan"),
        "offset_of_parameters": ffi().offsetof("struct setting", "parameters"),
    }
    command = ["node", str(HARNESS), str(module()), *options]
    sent = json.dumps(job).encode() + b"\n" + b"".join([*given, *(each.tobytes() for each in kept)])
    done = subprocess.run(command, input=sent, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    at = 0
    for each in kept:
        each.reshape(-1).view("uint8")[:] = memoryview(done.stdout)[at : at + each.nbytes]
        at += each.nbytes
    assert at == len(done.stdout)
    return done.stderr.decode()
