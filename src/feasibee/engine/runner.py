"""Many runs over threads, in chunks; what each run gives doesn't depend on either."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from feasibee.engine import entrypoints
from feasibee.engine.compile import careful, entry
from feasibee.engine.guards import guarded
from feasibee.engine.layout import Kinds, Params, empty_state, packed
from feasibee.engine.translation import is_paper, kinds_of, params_of
from feasibee.errors import FeasibeeError
from feasibee.model.record import Record
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.trial import own_function
from feasibee.strategies.contract import Strategy

CHUNK = 2_000_000  # robot-steps: about 30 ms, much longer than the call, much shorter than a user's patience
FIRST_SLOTS = 64
FAILURES = (ArithmeticError, LookupError, TypeError, ValueError)
"""What a user's strategy may raise."""


class RunError(Exception):
    """A strategy has raised an error in a run: the number of that run, and the error."""

    def __init__(self, run: int, error: Exception) -> None:
        super().__init__(run, error)
        self.run = run
        self.error = error


POLL = 0.1  # seconds between two looks at the progress


Functions = tuple[Callable[..., Any], ...]


def engine_functions(scenario: Scenario) -> Functions:
    """Compile what a scenario takes: how a run starts, how it goes on, and its strategy."""
    return (*entrypoints.world_functions(not is_paper(scenario)), *strategy_functions(scenario.strategy))


@cache
def strategy_functions(strategy: Strategy) -> Functions:
    """Compile the functions of a strategy; the kernels take them as typed function pointers."""
    return tuple(_compiled(strategy, name) for name in entrypoints.SIGNATURES)


def _compiled(strategy: Strategy, name: str) -> Callable[..., Any]:
    function, signature = getattr(strategy, name), entrypoints.SIGNATURES[name]
    own = own_function(strategy, name)
    if own is function:
        return entry(signature)(function)
    try:
        return entry(signature, strategy.source)(guarded(name, careful(own)))
    except NumbaError as error:
        raise FeasibeeError(_explained(strategy, name, error)) from None


def _explained(strategy: Strategy, name: str, error: Exception) -> str:
    """Say what doesn't compile, and in which line."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", str(error))
    lines = [line.strip(" -") for line in text.splitlines() if line.strip(" -")]
    function = own_function(strategy, name)
    file = re.escape(Path(function.__code__.co_filename).name)
    place = re.search(rf'{file}(?:", line |:| \()(\d+)', text)
    empty = ("Failed in", "File", "During", "Resolution failure", "No implementation of function")
    what = next((line for line in lines if not line.startswith(empty)), lines[0])
    line = place[1] if place else function.__code__.co_firstlineno
    return (
        f"{strategy.name}, line {line}: {name} doesn't compile: {what}; "
        "a strategy computes with numbers and math only"
    )


def simulate(
    scenario: Scenario,
    seed: int,
    record: Record,
    threads: int,
    chunk: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Fill in a record, run by run.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    seed : int
        64 bits.
    record : Record
        Empty, of the length and first run that are wanted.
    threads : int
        How many chunks to play at a time.
    chunk : int, optional
        Runs a chunk; by default about 30 ms of work.
    progress : callable, optional
        Called now and then with the share of the work done, 0 to 1.

    Raises
    ------
    RunError
        If the strategy raises an error.
    """
    params = params_of(scenario, seed)
    kinds = kinds_of(scenario, params)
    functions = engine_functions(scenario)
    memory = scenario.strategy.memory
    parts = list(_parts(record, chunk or _chunk_length(params, record.runs, threads)))
    done = np.zeros((len(parts), 1), np.int64)
    cancel = np.zeros(1, np.bool_)
    slots = [FIRST_SLOTS]
    with ThreadPoolExecutor(threads) as pool:
        futures = [
            pool.submit(_play, params, kinds, memory, part, functions, done[row], cancel, slots)
            for row, part in enumerate(parts)
        ]
        try:
            _watch(futures, done, parts, params, progress)
        except BaseException:
            cancel[0] = True
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _watch(
    futures: list[Future[None]],
    done: NDArray[np.int64],
    parts: list[Record],
    params: Params,
    progress: Callable[[float], None] | None,
) -> None:
    """Wait for all chunks, tell the progress, raise what a chunk raised."""
    runs = sum(part.runs for part in parts)
    pending = set(futures)
    while pending:
        finished, pending = wait(pending, timeout=POLL, return_when=FIRST_EXCEPTION)
        for future in (each for each in futures if each in finished):  # the first failure in order of runs
            future.result()
        if progress is not None:
            # A run that stops at its decision does fewer steps; a finished chunk counts in full.
            shares = [
                part.runs if future.done() else count / params.steps
                for part, future, count in zip(parts, futures, done[:, 0].tolist(), strict=True)
            ]
            progress(min(1.0, sum(shares) / runs))


def _parts(record: Record, chunk: int) -> Iterator[Record]:
    for start in range(0, record.runs, chunk):
        yield record.part(start, min(start + chunk, record.runs))


def _chunk_length(params: Params, runs: int, threads: int) -> int:
    by_work = CHUNK // (params.robots * params.steps)
    by_balance = math.ceil(runs / (4 * threads))
    return max(1, min(by_work, by_balance))


def _play(
    params: Params,
    kinds: Kinds,
    memory: int,
    record: Record,
    functions: Functions,
    done: NDArray[np.int64],
    cancel: NDArray[np.bool_],
    slots: list[int],
) -> None:
    """Play one chunk; when an inbox table runs full, play that run again with twice the room.

    ``slots[0]`` is the room that has sufficed so far, for all chunks; it changes no result.
    """
    whole = 0
    while whole < record.runs and not cancel[0]:
        rest = record.part(whole, record.runs)
        try:
            whole += entrypoints.play(
                packed(params),
                empty_state(params, kinds, slots[0], memory),
                rest.first_run,
                rest.decision,
                rest.decision_step,
                rest.feasible_count,
                rest.infeasible_count,
                rest.account,
                done,
                cancel,
                *functions,
            )
        except FAILURES as error:
            if rest.runs == 1:
                raise RunError(rest.first_run, error) from error
            for row in range(rest.runs):  # one at a time, to find the run that fails
                _play(params, kinds, memory, rest.part(row, row + 1), functions, done, cancel, slots)
            raise
        if whole < record.runs:
            slots[0] *= 2
