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
from feasibee.engine.given import Given
from feasibee.engine.players import AnyWorld
from feasibee.engine.tables import Control
from feasibee.model.record import Record
from feasibee.scenario.fields import fields
from feasibee.scenario.runs import Runs
from feasibee.scenario.supported import FAST_PATH, takes_fast_path
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import lower
from tests import anyworlds, fastworlds
from tests.equal import assert_same, assert_same_swarms

RUNS = 2
NUMBERS = range(12)
MORE = range(12, 60)
ANY = range(48)
MORE_ANY = range(48, 400)


@cache
def world_of(kind: str, number: int) -> Scenario:
    """Return a world of the fast path, any world, or one of a crowd."""
    if kind == "paper":
        return fastworlds.world(number)
    if kind == "crowd":
        return anyworlds.world(number, anyworlds.CROWDS, shared=number % 3 < 2)
    return anyworlds.world(number, own=number in MORE_ANY)


@cache
def expected(kind: str, number: int) -> Record:
    """Return the reference's record of a world, whose number is also the seed."""
    return reference.simulate(world_of(kind, number), which(kind, number), curves=True)


def which(kind: str, number: int) -> Runs:
    """Return runs of a world; some have seeds and numbers of more than 32 bits."""
    runs = RUNS if kind == "paper" else 1
    return Runs(runs, number * 0x9E3779B97F4A7C15 % 2**64, (2**32 - runs) * (number % 2))


def check(kind: str, number: int, record: Record) -> None:
    """See that a record is that of the reference."""
    assert_same(record, expected(kind, number), f"of world {number}: {world_of(kind, number).to_toml()}")


MADE = {
    "portable": (("cc",), "x86-64-v2", "-O1", "-DPORTABLE"),
    "gcc": (("gcc",), "x86-64-v3"),
    "clang": (("clang",), "x86-64-v3"),
    "undefined": (("gcc",), "x86-64-v3", "-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"),
}
"""Libraries that are compiled for these tests: compiler, level, and more options."""
SLOW = ("gcc", "clang", "undefined")
"""Each takes 10 s to 20 s to compile."""
BACKENDS = [*library.levels(), "portable", *(pytest.param(each, marks=pytest.mark.slow) for each in SLOW)]


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


def records(kind, numbers):
    """See that the engine gives the records of the reference."""
    for number in numbers:
        check(
            kind, number, simulate_record(world_of(kind, number), which(kind, number), curves=True, threads=1)
        )


@pytest.mark.parametrize("engine", BACKENDS, indirect=True)
def test_all_backends_give_the_record_of_the_reference(engine):
    records("paper", NUMBERS)
    records("any", ANY[::2])


@pytest.mark.slow
@pytest.mark.parametrize("part", range(2))
@pytest.mark.parametrize("engine", BACKENDS, indirect=True)
def test_all_backends_give_the_record_of_the_reference_in_more_worlds(engine, part):
    records("paper", MORE[part::2])
    records("any", MORE_ANY[part:100:2])


def test_several_threads_give_the_same_record():
    for number in NUMBERS:
        scenario, runs = world_of("paper", number), which("paper", number)
        check("paper", number, simulate_record(scenario, runs, curves=True, threads=3, chunk=1))


PARTS = 12


@pytest.mark.parametrize("part", range(PARTS))
def test_any_world_has_the_record_of_the_reference(part):
    records("any", ANY[part::PARTS])


@pytest.mark.parametrize("part", range(PARTS))
def test_a_swarm_of_any_world_step_by_step_is_the_references_swarm(part):
    for number in ANY[part::PARTS]:
        scenario = world_of("any", number)
        assert_same_swarms(scenario, number, number, scenario.run.steps)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_more_of_any_worlds_have_the_record_and_the_swarm_of_the_reference(part):
    records("any", MORE_ANY[part::PARTS])
    for number in MORE_ANY[part::PARTS]:
        assert_same_swarms(
            world_of("any", number), number, number, min(40, world_of("any", number).run.steps)
        )


CROWDS = [*range(6), *(pytest.param(number, marks=pytest.mark.slow) for number in range(6, 60))]


@pytest.mark.parametrize("number", CROWDS)
def test_threads_together_give_any_crowd_the_record_of_the_reference(number):
    scenario, runs = world_of("crowd", number), which("crowd", number)
    given = Given(lower(scenario, runs.seed, fast=False))
    for team in (1,) if anyworlds.by_one_thread(scenario) else (1, 2, 3):
        lengths = scenario.run.steps + 1, (scenario.run.steps + 1) * scenario.dynamic
        record = Record.empty(runs.first, runs.count, *lengths)
        AnyWorld(given, team).play(record, Control(np.zeros(1, np.int64), np.zeros(1, np.bool_)))
        check("crowd", number, record)


# --- What is compared ---


def value(scenario, path):
    section, name = path.split(".")
    return getattr(getattr(scenario, section), name)


@pytest.mark.parametrize(
    ("kind", "numbers", "paths"), [("paper", MORE, FAST_PATH), ("any", MORE_ANY, fields())]
)
def test_the_worlds_have_every_field(kind, numbers, paths):
    drawn, paper = [world_of(kind, number) for number in numbers], Scenario()
    assert [path for path in paths if all(value(each, path) == value(paper, path) for each in drawn)] == []


def test_the_engine_plays_all_of_them():
    assert all(takes_fast_path(world_of("paper", number)) for number in (*NUMBERS, *MORE))
    assert not any(takes_fast_path(world_of("any", number)) for number in ANY)


def test_what_robots_can_do_does_occur_in_any_worlds():
    """Else comparing would compare nothing."""
    found = {number: expected("any", number) for number in ANY}

    def occur(name, least=1):
        return sum((getattr(each, name) >= least).any() for each in found.values())

    least = {"decision_step": 12, "bits_sent": 24, "distance_walked": 8, "tasks_taken": 3, "vain_arrivals": 2}
    least |= {"declared_feasible": 1, "declared_infeasible": 1, "starts_in_vain": 1}
    assert [name for name, number in least.items() if occur(name) < number] == []
    assert occur("all_done_step", 0) > 1
    assert len({world_of("any", number).decision.strategy for number in ANY}) > 12
    for name, number in (("robots_present", 8), ("truth", 3)):
        traces = [getattr(each, name) for each in found.values()]
        assert sum(np.ptp(each) > 0 for each in traces if each.size) > number
    assert any((each.feasible_count + each.infeasible_count < 1).any() for each in found.values())
