"""One record from every backend: reference, and the engine in C of each level, portable, by gcc, by zig."""

from __future__ import annotations

import pickle
import shutil
from functools import cache, partial
from pathlib import Path
from threading import Thread
from time import sleep

import numpy as np
import pytest

from feasibee import STRATEGIES, Scenario, reference
from feasibee.base.record import Record
from feasibee.engine import given, library, platforms
from feasibee.engine.build import LIBRARIES, compile_library
from feasibee.engine.compilers import Compiler
from feasibee.engine.given import Given
from feasibee.engine.players import AnyWorld, PaperWorld
from feasibee.engine.tables import Control
from feasibee.scenario.fields import fields
from feasibee.scenario.runs import Runs
from feasibee.scenario.supported import FAST_PATH, takes_fast_path
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import lower
from tests.equal import assert_equal, assert_same, assert_same_swarms
from tests.once import made_once
from tests.worlds import CROWDS, EDGES, OWN, by_one_thread, fields_of, value, world

KINDS = {
    "paper": {"fast": True},
    "crowd of the paper": {"fast": True, "robots": (129, 133, 161)},
    "any": {},
    "any, of users": {"own": True},
    "crowd": {"robots": CROWDS},
    "shared crowd": {"robots": CROWDS, "shared": True},
    "both sides of the switch to sorted robots": {"robots": (1024, 1025), "shared": True},
}
"""Worlds of the fast path, and of the general one."""
PAPER, MORE = range(len(fields_of(fast=True))), range(14, 60)
ANY, MORE_ANY = range(len(fields_of())), range(59, 400)


@cache
def world_of(kind: str, number: int) -> Scenario:
    """Return a world of a kind."""
    return world(number, **KINDS[kind])


@pytest.fixture(scope="session", autouse=True)
def shelf(tmp_path_factory):
    """Make a folder of the reference's records for all workers: most worlds are compared several times."""
    _shelf[:] = [tmp_path_factory.mktemp("records")]


_shelf: list[Path] = []


@cache
def expected(kind: str, number: int) -> Record:
    """Return the reference's record of a world; of any world, compare the swarm at each step, too."""
    simulate = assert_same_swarms if kind.startswith("any") else partial(reference.simulate, curves=True)

    def make(path: Path) -> None:
        path.write_bytes(pickle.dumps(simulate(world_of(kind, number), which(kind, number))))

    return pickle.loads(made_once(_shelf[0], f"{kind} {number}.record", make).read_bytes())


def which(kind: str, number: int) -> Runs:
    """Return runs of a world; some have seeds and numbers of more than 32 bits."""
    runs = 2 if kind == "paper" else 1
    return Runs(runs, number * 0x9E3779B97F4A7C15 % 2**64, (2**32 - runs) * (number % 2))


def check(kind: str, number: int, record: Record) -> None:
    """See that a record is that of the reference."""
    assert_same(record, expected(kind, number), f"of world {number}: {world_of(kind, number).to_toml()}")


MADE = {
    "portable": (("cc",), "x86-64-v2", "-O0", "-DPORTABLE", "-DENOUGH=200u"),
    "gcc": (("gcc",), "x86-64-v3"),
    "clang": (("clang",), "x86-64-v3"),
    "undefined": (("gcc",), "x86-64-v3", "-O0", "-fsanitize=undefined", "-fno-sanitize-recover=all"),
}
"""Libraries that are compiled for these tests: compiler, level, and more options.

The portable one also carries counts of 200 and more, in place of 2**31.
"""
SLOW = ("gcc", "clang", "undefined")
"""Each takes 10 s to 20 s to compile."""
BACKENDS = [*library.levels(), "portable", *(pytest.param(each, marks=pytest.mark.slow) for each in SLOW)]


@pytest.fixture(scope="session")
def library_of(tmp_path_factory):
    """Return the library of a backend; compile it if the package has none."""
    folder = tmp_path_factory.mktemp("engines")

    def compile_engine(name, file):
        command, level, *options = MADE[name]
        shutil.copy(LIBRARIES / "strategies.c", file.parent)
        compile_library(file, platforms.native(), level, Compiler(command, command[0]), *options)

    def make(name):
        if name not in MADE:
            return library.library_of(name)
        command = MADE[name][0][0]
        if shutil.which(command) is None:
            pytest.skip(f"there is no {command}")
        return made_once(folder, f"{name}.so", partial(compile_engine, name))

    return make


@pytest.fixture
def engine(request, library_of, monkeypatch):
    """A backend in place of the engine."""
    file = library_of(request.param)
    monkeypatch.setattr(given, "library", lambda: (library.ffi(), library.load(file)))


def records(kind, numbers):
    """See that the engine gives the records of the reference."""
    for number in numbers:
        scenario, runs = world_of(kind, number), which(kind, number)
        check(kind, number, simulate_record(scenario, runs, curves=True, threads=1))


def played(scenario, runs, team, fast=True):
    """Return the record of the engine, whose threads play each run together."""
    lengths = scenario.run.steps + 1, (scenario.run.steps + 1) * scenario.dynamic
    record = Record.empty(runs.first, runs.count, *lengths)
    player = (PaperWorld if fast else AnyWorld)(Given(lower(scenario, runs.seed, fast=fast)), team)
    player.play(record, Control(np.zeros(1, np.int64), np.zeros(1, np.bool_)))
    return record


@pytest.mark.parametrize("engine", BACKENDS, indirect=True)
def test_all_backends_give_the_record_of_the_reference(engine):
    """Catches code of one level or compiler that rounds or counts otherwise; each has vectors of its own."""
    records("paper", PAPER)
    records("any", ANY[::2])


@pytest.mark.slow
@pytest.mark.parametrize("part", range(2))
@pytest.mark.parametrize("engine", BACKENDS, indirect=True)
def test_all_backends_give_the_record_of_the_reference_in_more_worlds(engine, part):
    records("paper", MORE[part::2])
    records("any, of users", MORE_ANY[part:100:2])


def test_several_threads_give_the_same_record():
    for number in PAPER:
        scenario, runs = world_of("paper", number), which("paper", number)
        check("paper", number, simulate_record(scenario, runs, curves=True, threads=3, chunk=1))


PARTS = 12


@pytest.mark.parametrize("part", range(PARTS))
def test_any_world_has_the_record_and_step_by_step_the_swarm_of_the_reference(part):
    records("any", ANY[part::PARTS])


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_more_of_any_worlds_have_the_record_and_the_swarm_of_the_reference(part):
    records("any, of users", MORE_ANY[part::PARTS])


@pytest.mark.parametrize("file", OWN, ids=lambda file: Path(file).stem)
def test_a_users_strategy_has_the_record_of_the_reference(file):
    """Most of them pass on knowledge."""
    small = {
        "robots.count": 6,
        "tasks.count": 9,
        "arena.side": 8.0,
        "run.steps": 80,
        "robots.know_count": True,
    }
    for more in ({"sensing.miss": 0.2}, {"arena.boundary": "walls", "radio.delay": 2}):
        assert_equal(Scenario().replace(small | {"decision.strategy": file, **more}), 1)


PARAMETERS = [
    *(("quiet-census", each) for each in ({"tolerates": 2.0}, {"quiet": 30.0}, {"lasts": 40.0})),
    *(("map", each) for each in ({"cell": 4.0, "rows": 2.0}, {"cell": 5.0, "tolerates": 1.0})),
    *(("turns", each) for each in ({"names": -1.0}, {"names": 2.0, "tolerates": 1.0}, {"looks": 2.0})),
    *(("roster", each) for each in ({"tolerates": 1.0}, {"task_timeout": 9.0, "looks": 1.0})),
]


@pytest.mark.parametrize(("strategy", "parameters"), PARAMETERS)
def test_parameters_of_knowledge_give_the_record_of_the_reference(strategy, parameters):
    """Among liars, so that what enough neighbours have told is believed; drawn worlds seldom have both."""
    small = {
        "robots.count": 6,
        "robots.know_count": True,
        "tasks.count": 9,
        "arena.side": 8.0,
        "run.steps": 60,
    }
    liar = {"faults.byzantine": {"count": 1}, "decision.strategy": strategy}
    assert_equal(Scenario().replace({**small, **liar, "decision.parameters": parameters}), 1)


def some(kind, fast, numbers):
    """Return worlds of a kind, of which all but some are slow."""
    return [
        pytest.param(kind, number, id=f"{kind} {number}", marks=() if number in fast else pytest.mark.slow)
        for number in numbers
    ]


ON_LATTICES = [fields_of().index(each) for each in sorted(EDGES)[:3]]
BY_ONE = [number for number, each in enumerate(fields_of()) if each not in fields_of(shared=True)]
CROWD = some("crowd of the paper", range(5), range(14))
CROWD += some("crowd", ON_LATTICES[::2], ON_LATTICES + BY_ONE)  # the reference plays the other for 14 s
CROWD += some("shared crowd", range(4), range(len(fields_of(shared=True))))
CROWD += some("both sides of the switch to sorted robots", (), range(4))


@pytest.mark.parametrize(("kind", "number"), CROWD)
def test_threads_together_give_any_crowd_the_record_of_the_reference(kind, number):
    scenario, fast = world_of(kind, number), KINDS[kind].get("fast", False)
    for team in (1,) if by_one_thread(scenario) else (1, 2, 5):
        check(kind, number, played(scenario, which(kind, number), team, fast))


LONG = {
    **{"robots.count": 133, "tasks.count": 120, "arena.side": 51.5, "run.steps": 40},
    **{"decision.exploration": 25.0, "decision.gain": 40.0, "sensing.range": 9.0, "radio.range": 9.0},
}
"""A crowd whose robots count hundreds in one phase."""


@pytest.mark.parametrize("inbox", ["latest-per-robot", "every-message"])
@pytest.mark.parametrize("engine", ["portable"], indirect=True)
def test_counts_of_a_crowd_may_be_larger_than_their_rows_hold(engine, inbox):
    scenario, runs = Scenario().replace({**LONG, "decision.inbox": inbox}), Runs(1, 5)
    assert_same(played(scenario, runs, 2), reference.simulate(scenario, runs, curves=True))


@pytest.mark.parametrize("threads", [1, 3])
def test_cancelled_runs_end(threads):
    scenario = Scenario().replace({"robots.count": 20_000, "arena.side": 632.0, "run.steps": 10**9})
    shared, record = Control(np.zeros(1, np.int64), np.zeros(1, np.bool_)), Record.empty(0, 1, 0)

    def cancel():
        while shared.steps_done[0] < 3:
            sleep(0.01)
        shared.cancelled[0] = True

    other = Thread(target=cancel)
    other.start()
    PaperWorld(Given(lower(scenario, 5)), threads).play(record, shared)
    other.join()
    assert 3 <= shared.steps_done[0] < scenario.run.steps


# --- What is compared ---


@pytest.mark.parametrize(("kind", "numbers", "paths"), [("paper", PAPER, FAST_PATH), ("any", ANY, fields())])
def test_the_worlds_have_every_field(kind, numbers, paths):
    """Each has another value than the paper's in some world, also of those that aren't slow."""
    drawn, paper = [world_of(kind, number) for number in numbers], Scenario()
    assert [path for path in paths if all(value(each, path) == value(paper, path) for each in drawn)] == []
    strategies = {each.decision.strategy for each in drawn}
    assert strategies >= {name for name, each in STRATEGIES.items() if kind == "any" or not each.knowledge}


def test_the_engine_plays_all_of_them():
    assert all(takes_fast_path(world_of("paper", number)) for number in (*PAPER, *MORE))
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
    for name, number in (("robots_present", 8), ("truth", 3)):
        traces = [getattr(each, name) for each in found.values()]
        assert sum(np.ptp(each) > 0 for each in traces if each.size) > number
    assert any((each.feasible_count + each.infeasible_count < 1).any() for each in found.values())
