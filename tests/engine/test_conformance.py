"""One record from every backend: reference, and the engine in C of each level, portable, by gcc, by zig."""

from __future__ import annotations

import shutil
from functools import cache

import numpy as np
import pytest

from feasibee import Scenario, reference
from feasibee.engine import given, library, platforms
from feasibee.engine.build import LIBRARIES, compile_library
from feasibee.engine.compilers import Compiler
from feasibee.model.record import Record
from feasibee.scenario.runs import Runs
from feasibee.scenario.supported import FAST_PATH, takes_fast_path
from feasibee.simulation.ensemble import simulate_record
from tests import worlds

RUNS = 2
ARRAYS = ("decision", "decision_step", "feasible_count", "infeasible_count", "account")
NUMBERS = range(12)
MORE = range(12, 60)


@cache
def expected(number: int) -> Record:
    """Return the reference's record of a world, whose number is also the seed."""
    return reference.simulate(worlds.world(number), which(number), curves=True)


def which(number: int) -> Runs:
    """Return runs of a world; some have seeds and numbers of more than 32 bits."""
    return Runs(RUNS, number * 0x9E3779B97F4A7C15 % 2**64, (2**32 - RUNS) * (number % 2))


def check(number: int, record: Record) -> None:
    """See that a record is that of the reference."""
    for name in ARRAYS:
        told, wanted = getattr(record, name), getattr(expected(number), name)
        np.testing.assert_array_equal(
            told, wanted, f"{name} of world {number}: {worlds.world(number).to_toml()}"
        )


MADE = {
    "portable": (("cc",), "x86-64-v2", "-DPORTABLE"),
    "gcc": (("gcc",), "x86-64-v3"),
    "clang": (("clang",), "x86-64-v3"),
    "undefined": (("gcc",), "x86-64-v3", "-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"),
}
"""Libraries that are compiled for these tests: compiler, level, and more options."""
BACKENDS = [*library.levels(), *MADE]


@pytest.fixture(scope="session")
def library_of(tmp_path_factory):
    """Return the library of a backend; compile it if the package has none."""
    folder = tmp_path_factory.mktemp("engines")
    shutil.copy(LIBRARIES / "strategies.c", folder)

    @cache
    def make(name):
        if name not in MADE:
            return library.library_of(name)
        command, level, *options = MADE[name]
        if shutil.which(command[0]) is None:
            pytest.skip(f"there is no {command[0]}")
        file = folder / f"{name}.so"
        compile_library(file, platforms.native(), level, Compiler(command, command[0]), *options)
        return file

    return make


@pytest.fixture
def engine(request, library_of, monkeypatch):
    """A backend in place of the engine."""
    file = library_of(request.param)
    monkeypatch.setattr(given, "library", lambda: (library.ffi(), library.load(file)))


def records(numbers):
    """See that the engine gives the records of the reference."""
    for number in numbers:
        check(number, simulate_record(worlds.world(number), which(number), curves=True, threads=1))


@pytest.mark.parametrize("engine", BACKENDS, indirect=True)
def test_all_backends_give_the_record_of_the_reference(engine):
    records(NUMBERS)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(2))
@pytest.mark.parametrize("engine", BACKENDS, indirect=True)
def test_all_backends_give_the_record_of_the_reference_in_more_worlds(engine, part):
    records(MORE[part::2])


def test_several_threads_give_the_same_record():
    for number in NUMBERS:
        check(number, simulate_record(worlds.world(number), which(number), curves=True, threads=3, chunk=1))


def test_the_worlds_have_every_field_that_the_engine_plays():
    drawn, paper = [worlds.world(number) for number in MORE], Scenario()

    def value(scenario, path):
        section, name = path.split(".")
        return getattr(getattr(scenario, section), name)

    assert [
        path for path in FAST_PATH if all(value(each, path) == value(paper, path) for each in drawn)
    ] == []


def test_the_engine_plays_all_of_them():
    assert all(takes_fast_path(worlds.world(number)) for number in (*NUMBERS, *MORE))
