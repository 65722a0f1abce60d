"""What compiles is said truly: which engine, for how long, once, and only if it compiles."""

from __future__ import annotations

import io
import re
import sys
import threading
import time
from multiprocessing import current_process

import pytest
from rich.console import Console

from feasibee import Scenario, simulate
from feasibee.cli.options import progress
from feasibee.engine import compiled
from feasibee.engine.compile import on_compile
from feasibee.simulation import loading
from feasibee.simulation.loading import GENERAL, NATIVE, compilation, engine_of, load_engine, prepare_engines
from feasibee.strategies import STRATEGIES

WALLS = Scenario(arena={"boundary": "walls"})


class Engine:
    """An engine whose parts are missing on disk; it notes what is said to compile at each."""

    def __init__(self, missing):
        self.missing = missing
        self.seen = []
        self.seconds = 0.0

    def functions(self, *arguments):
        for name in self.missing:
            on_compile.get()(name)
            self.seen.append(compilation())
            time.sleep(self.seconds)
        return ()


@pytest.fixture
def engine(monkeypatch):
    """An engine of which nothing is loaded or on disk."""
    made = Engine(["start_general", "advance_general", "decide"])
    monkeypatch.setattr(compiled, "engine_functions", made.functions)
    monkeypatch.setattr(loading, "_loaded", set())
    return made


@pytest.fixture
def screen(monkeypatch):
    """A terminal; what is written to it."""
    written = io.StringIO()
    console = Console(file=written, force_terminal=True, width=100, legacy_windows=False)
    monkeypatch.setattr(loading, "is_terminal", lambda: True)
    monkeypatch.setattr(loading, "stderr_console", lambda: console)
    return written


def test_there_are_two_engines():
    assert engine_of(Scenario()) == NATIVE
    assert engine_of(WALLS) == GENERAL


@pytest.mark.parametrize(("scenario", "stepwise"), [(WALLS, False), (WALLS, True), (Scenario(), True)])
def test_elsewhere_than_on_a_terminal_one_line_names_the_engine(engine, capsys, scenario, stepwise):
    assert not load_engine(scenario, stepwise)
    assert load_engine(scenario, stepwise)
    assert capsys.readouterr().err == (
        f"feasibee: compiling the {GENERAL}, once for this machine; 5 to 20 s of CPU time ...\n"
    )
    assert [each.engine for each in engine.seen] == [GENERAL] * 3
    assert compilation() is None


def test_nothing_compiles_for_runs_of_the_paper_s_world(engine, capsys):
    assert load_engine(Scenario())
    assert engine.seen == []
    assert capsys.readouterr() == ("", "")


def test_what_is_on_disk_is_loaded_in_silence(engine, capsys):
    engine.missing = []
    assert load_engine(WALLS)
    assert capsys.readouterr() == ("", "")


def test_a_strategy_alone_compiles_in_silence(engine, capsys):
    engine.missing = ["quality", "decide", "update"]
    assert not load_engine(WALLS)
    assert capsys.readouterr() == ("", "")
    assert engine.seen == [None] * 3


def test_nothing_compiles_any_more_after_an_error(engine, capsys, monkeypatch):
    def fail(*arguments):
        on_compile.get()("advance_general")
        raise MemoryError

    monkeypatch.setattr(compiled, "engine_functions", fail)
    with pytest.raises(MemoryError):
        load_engine(WALLS)
    assert compilation() is None
    on_compile.get()("advance_general")
    assert compilation() is None
    assert capsys.readouterr().err.count("\n") == 1
    monkeypatch.setattr(compiled, "engine_functions", engine.functions)
    assert not load_engine(WALLS)


def test_a_terminal_shows_a_spinner_and_the_time_passed(engine, screen, capsys):
    engine.seconds = 0.6
    load_engine(WALLS)
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())
    times = re.findall(r"Compiling the general engine, once for this machine … (\d+) s", text)
    assert times[0] == "0"
    assert times[-1] != "0"
    assert screen.getvalue().endswith("\x1b[2K")  # nothing of it stays
    assert capsys.readouterr() == ("", "")


def test_the_spinner_shows_beside_a_bar(engine, screen, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with progress("Simulating") as advance:
        load_engine(WALLS)
        advance(1.0)
    assert "Compiling the general engine" in screen.getvalue()
    assert "Simulating" in screen.getvalue()


@pytest.mark.parametrize("daemon", [True, False])
def test_a_daemon_thread_writes_a_line_since_the_program_may_end_first(engine, screen, capsys, daemon):
    thread = threading.Thread(target=load_engine, args=(WALLS,), daemon=daemon)
    thread.start()
    thread.join()
    assert ("Compiling the general engine" in screen.getvalue()) is not daemon
    assert ("compiling the general engine" in capsys.readouterr().err) is daemon


def test_a_worker_process_writes_a_line_since_its_parent_draws(engine, screen, capsys, monkeypatch):
    monkeypatch.setattr(loading, "parent_process", current_process)
    load_engine(WALLS)
    assert screen.getvalue() == ""
    assert "compiling the general engine" in capsys.readouterr().err


def test_the_general_engine_and_all_strategies_are_prepared(engine, capsys):
    first, second = list(prepare_engines()), list(prepare_engines())
    assert [each.name for each in first] == [GENERAL, f"{len(STRATEGIES)} built-in strategies"]
    assert not any(each.cached for each in first)
    assert all(each.cached for each in second)
    loaded = {(strategy.name, words) for strategy, words, _ in loading._loaded}
    assert loaded >= {("dmmd", words) for words in (0, 1, 2)}
    assert len(loaded) == len(STRATEGIES) + 2


def test_simulating_afterwards_finds_what_was_prepared(capsys):
    for _ in prepare_engines():
        pass
    capsys.readouterr()
    for scenario in (Scenario(), WALLS):
        assert load_engine(scenario)
        simulate(scenario, 1)
    assert capsys.readouterr() == ("", "")
