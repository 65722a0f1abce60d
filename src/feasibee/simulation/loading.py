"""Load the engine of a scenario, and show that the general one compiles where it isn't on disk yet.

There are two engines: the one in C, for worlds like the paper's, and the general one, for all others and for
swarms that are looked at step by step. That one compiles once on a machine, when a scenario first needs it.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cache
from multiprocessing import parent_process
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from feasibee.engine.layout import FEW, WORD, words_together
from feasibee.files.cache import cache_root, own_folder
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import takes_fast_path
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy

if TYPE_CHECKING:
    from rich.console import Console

NATIVE: Final = "engine in C"
GENERAL: Final = "general engine"
DURATION: Final = "5 to 20 s of CPU time"
"""Time to compile the general engine, measured in docs/decisions/02-two-compiled-steps.md."""
ENTRIES: Final = ("play", "start", "advance")
"""How names of the engine's functions start; those of a strategy compile in about 1 s, without a message."""
PASSED: Final = "{task.description} … {task.elapsed:.0f} s"


class Compilation(NamedTuple):
    """An engine that this process compiles at the moment."""

    engine: str
    """`GENERAL`."""
    since: float
    """When it began, by `time.monotonic`."""


class Prepared(NamedTuple):
    """What `prepare_engines` has made ready."""

    name: str
    seconds: float
    """Time spent, including the time to load what was on disk."""
    cached: bool
    """Whether all of it was on disk already."""


_loading = threading.Lock()  # a second thread finds what the first has compiled
_loaded: set[tuple[Strategy, int, bool]] = set()
_current: Compilation | None = None


def engine_of(scenario: Scenario) -> str:
    """Return which engine simulates runs of a scenario: `NATIVE` or `GENERAL`."""
    return NATIVE if takes_fast_path(scenario) else GENERAL


def compilation() -> Compilation | None:
    """Return what this process compiles at the moment, if anything."""
    return _current


def load_engine(scenario: Scenario, stepwise: bool = False) -> bool:
    """Load the engine and the strategy of a scenario, compiling what isn't on disk.

    ``stepwise`` says that the swarm is to be looked at step by step.

    Returns
    -------
    bool
        Whether everything was on disk or in memory already.
    """
    if True:
        from feasibee.engine.native import rules_of

        rules_of(scenario.strategy)
        return True
    form = (scenario.strategy, words_together(scenario.most.robots), scenario.in_motion)
    if form in _loaded:
        return True  # without the lock: another thread may hold it while it compiles
    own_folder(cache_root())  # an error of it needs no engine
    with _loading, _showing(GENERAL) as compiled:
        from feasibee.engine.compiled import engine_functions

        engine_functions(*form)
    _loaded.add(form)
    return not compiled


def prepare_engines(files: Sequence[Path] = ()) -> Iterator[Prepared]:
    """Load what files of scenarios and strategies (``.py``) need; yield each part when it is ready.

    By default, that is the general engine and all built-in strategies.
    """
    if files:
        parts = {str(file): [_scenario_of(file)] for file in files}
    else:
        parts = {
            GENERAL: [
                Scenario(arena={"boundary": "walls"}, robots={"count": count})
                for count in (WORD, FEW, FEW + 1)
            ],
            f"{len(STRATEGIES)} built-in strategies": [_with_strategy(name) for name in STRATEGIES],
        }
    for name, scenarios in parts.items():
        start = time.monotonic()
        cached = [load_engine(each, stepwise) for each in scenarios for stepwise in (False, True)]
        yield Prepared(name, time.monotonic() - start, all(cached))


def _scenario_of(file: Path) -> Scenario:
    """Return the scenario of a file, or one with the strategy of a file."""
    return _with_strategy(str(file)) if file.suffix == ".py" else Scenario.read(file)


def _with_strategy(name: str) -> Scenario:
    return Scenario(
        robots={"know_count": True}, decision={"strategy": name}
    )  # some strategies need the count


@contextmanager
def _showing(engine: str) -> Iterator[list[str]]:
    """Show that an engine compiles as soon as its code is missing; give the names of what is compiled."""
    from feasibee.engine.compile import on_compile

    global _current  # noqa: PLW0603  # one at a time: `_loading` is held
    compiled: list[str] = []
    with ExitStack() as display:

        def begin(name: str) -> None:
            global _current  # noqa: PLW0603
            compiled.append(name)
            if _current is None and name.startswith(ENTRIES):
                _current = Compilation(engine, time.monotonic())
                display.enter_context(_displayed(engine))

        token = on_compile.set(begin)
        try:
            yield compiled
        finally:
            on_compile.reset(token)
            _current = None


@contextmanager
def _displayed(engine: str) -> Iterator[None]:
    """Show a spinner and the time passed on a terminal, and elsewhere one line."""
    if not is_terminal() or not _may_draw():
        text = f"feasibee: compiling the {engine}, once for this machine; {DURATION} ..."
        print(text, file=sys.stderr, flush=True)
        yield
        return
    from rich.progress import Progress, SpinnerColumn, TextColumn

    with Progress(SpinnerColumn(), TextColumn(PASSED), console=stderr_console(), transient=True) as spinner:
        spinner.add_task(f"Compiling the {engine}, once for this machine")
        yield


def _may_draw() -> bool:
    """Return whether this thread may draw a spinner.

    A program may end while a daemon thread compiles, and a spinner would leave the cursor hidden. Worker
    processes would draw theirs over the parent's display.
    """
    return parent_process() is None and not threading.current_thread().daemon


def processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_terminal() -> bool:
    """Return whether standard error is a terminal that can show progress."""
    return sys.stderr is not None and sys.stderr.isatty() and not stderr_console().is_dumb_terminal


@cache
def stderr_console() -> Console:
    """Return the console of standard error: one for all displays, since rich nests those of one console."""
    from rich.console import Console

    return Console(stderr=True)
