"""Crowds in the engine's C: several threads, large counts, a grid of one cell, and runs that end early."""

from __future__ import annotations

import shutil
from functools import cache
from threading import Thread
from time import sleep

import numpy as np
import pytest

from feasibee import Scenario, reference
from feasibee.engine import given, library, platforms, players
from feasibee.engine.build import LIBRARIES, compile_library
from feasibee.engine.compilers import Compiler
from feasibee.engine.tables import Control, RunError
from feasibee.model.record import Record
from feasibee.scenario.runs import Runs
from feasibee.simulation.lowering import lower

ARRAYS = ("decision", "decision_step", "feasible_count", "infeasible_count", "account")
CROWD = {"robots.count": 133, "tasks.count": 120, "arena.side": 51.5, "run.steps": 20}
WORLDS = {
    "paper": {},
    "values": {"decision.strategy": "dc", "radio.range": 9.0},
    "every message": {"decision.inbox": "every-message", "decision.listen": "dissemination"},
    "one cell": {"sensing.range": 20.0, "radio.range": 25.7, "run.steps": 10},
    "four cells": {"sensing.range": 12.0, "run.steps": 10},
}


def crowd(**changes):
    """Return a world of a crowd."""
    return Scenario().replace(CROWD | changes)


def control():
    """Return a control of a run that nobody has cancelled."""
    return Control(np.zeros(1, np.int64), np.zeros(1, np.bool_))


def played(scenario, threads):
    """Return the record of the engine, whose threads play each run together."""
    record = Record.empty(0, 1, scenario.run.steps + 1)
    players.PaperWorld(given.Given(lower(scenario, 5)), threads).play(record, control())
    return record


@cache
def expected_of(scenario, runs):
    """Return the record of the reference."""
    return reference.simulate(scenario, Runs(runs, 5, 0), curves=True)


def assert_as_reference(scenario, record):
    """See that a record is that of the reference."""
    expected = expected_of(scenario, record.runs)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(record, name), getattr(expected, name), name)


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("world", WORLDS)
def test_threads_together_give_the_record_of_the_reference(world, threads):
    scenario = crowd(**WORLDS[world])
    assert_as_reference(scenario, played(scenario, threads))


@pytest.fixture(scope="module")
def small_counts(tmp_path_factory):
    """A library that carries counts of 200 and more, in place of 2**31."""
    folder = tmp_path_factory.mktemp("small_counts")
    shutil.copy(LIBRARIES / "strategies.c", folder)
    name = shutil.which("cc") or pytest.skip("there is no cc")
    compile_library(
        folder / "engine.so",
        platforms.native(),
        next(iter(platforms.native().levels)),
        Compiler((name,), name),
        "-O1",
        "-DENOUGH=200u",
    )
    return folder / "engine.so"


@pytest.mark.parametrize("changes", [{}, {"decision.inbox": "every-message"}])
def test_counts_may_be_larger_than_their_rows_hold(small_counts, monkeypatch, changes):
    ffi = library.ffi()
    monkeypatch.setattr(given, "library", lambda: (ffi, library.load(small_counts)))
    long = {"decision.exploration": 25.0, "decision.gain": 40.0, "sensing.range": 9.0, "radio.range": 9.0}
    scenario = crowd(**long, **changes, **{"run.steps": 40})
    assert_as_reference(scenario, played(scenario, 2))


@pytest.mark.parametrize("threads", [1, 3])
def test_cancelled_runs_end(threads):
    scenario = crowd(**{"robots.count": 20_000, "arena.side": 632.0, "run.steps": 10**9})
    shared, record = control(), Record.empty(0, 1, 0)

    def cancel():
        while shared.steps_done[0] < 3:
            sleep(0.01)
        shared.cancelled[0] = True

    other = Thread(target=cancel)
    other.start()
    players.PaperWorld(given.Given(lower(scenario, 5)), threads).play(record, shared)
    other.join()
    assert 3 <= shared.steps_done[0] < scenario.run.steps


FAILS = """
MEMORY = 1

def decide(mind, inbox):
    mind.memory[0] += 1.0
    return 1 // (4 - int(mind.memory[0]))
"""


@pytest.mark.parametrize("threads", [1, 3])
def test_a_strategy_that_fails_ends_the_run_for_all_threads(tmp_path, threads):
    (tmp_path / "mine.py").write_text(FAILS, encoding="utf-8")
    scenario = crowd(**{"decision.strategy": str(tmp_path / "mine.py"), "run.steps": 10**6})
    with pytest.raises(RunError) as raised:
        played(scenario, threads)
    assert "mine.py, line 6: fails: ZeroDivisionError: 1 // 0" in str(raised.value.error)
