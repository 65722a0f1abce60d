"""An engine that compiles as long as a test wants."""

from __future__ import annotations

from threading import Event

import pytest
from numba.core.compiler_lock import global_compiler_lock

from feasibee import Scenario
from feasibee.engine import runner
from feasibee.engine.compile import on_compile
from feasibee.simulation import loading
from feasibee.simulation.loading import FAST, load_engine


@pytest.fixture
def slow_engine(monkeypatch):
    """An engine for walls that isn't on disk: it compiles until the event is set."""
    ready, done = runner.engine_functions, Event()

    def compile_slowly(strategy, fast, few):
        if not fast:
            with global_compiler_lock:
                on_compile.get()("advance_general")
                assert done.wait(30)
        return ready(strategy, fast, few)

    for boundary in ("torus", "walls"):
        load_engine(Scenario(arena={"boundary": boundary}))
    monkeypatch.setattr(runner, "engine_functions", compile_slowly)
    monkeypatch.setattr(loading, "_loaded", {each for each in loading._loaded if each[0] == FAST})
    yield done
    done.set()
