"""Where runs are computed: threads of this process, other processes, or a Dask cluster.

``Workers`` compute the chunks of a schedule, and replace one that dies. Ctrl-C is handled between chunks.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context, parent_process, resource_tracker
from threading import Thread
from types import FrameType
from typing import Any

from feasibee.engine.runner import processors
from feasibee.errors import FeasibeeError, how_to_install
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import simulate_record
from feasibee.sweeps.plan import Study
from feasibee.sweeps.schedule import FIRST_WORK, RunRange, Schedule, chunk_work, next_budget
from feasibee.sweeps.schema import EncodedRuns, encode

PATIENCE = 20.0
"""Seconds to wait for the answer of a cluster."""
PULSE = 1.0
"""Progress is reported at least so often, in seconds, however long a chunk takes."""
TRIES = 3
"""Number of tries of a chunk whose worker dies; the last one alone, since others died with it."""

Pieces = list[RunRange]
Chunk = Future[tuple[list[EncodedRuns], float]]


@dataclass(frozen=True)
class WorkerPool:
    """Workers that compute chunks of runs; they change no result.

    Parameters
    ----------
    make : callable
        Makes an executor of `concurrent.futures`. Called again after the death of a worker broke the last.
    workers : int
        Number of chunks computed at a time.
    is_local : bool
        Whether the workers share this machine's cache.
    """

    make: Callable[[], Executor]
    workers: int
    is_local: bool = True


def threads(workers: int | None = None) -> WorkerPool:
    """Return threads of this process, by default one per processor.

    The compiled engine releases Python's global lock, so threads compute in parallel.
    """
    number = workers or processors()
    return WorkerPool(lambda: ThreadPoolExecutor(number), number)


def processes(workers: int | None = None) -> WorkerPool:
    """Return processes of this machine, by default one per processor; a process that dies is replaced."""
    number = workers or processors()
    context = get_context("spawn")
    return WorkerPool(lambda: _Processes(number, mp_context=context, initializer=_serve), number)


class _Processes(ProcessPoolExecutor):
    """Processes that ignore Ctrl-C, which the main process handles; they start with the first chunk."""

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        if not hasattr(signal, "pthread_sigmask"):
            return super().submit(work, *arguments, **options)
        resource_tracker.ensure_running()  # starting it later would unblock Ctrl-C
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # for processes that start now
        try:
            return super().submit(work, *arguments, **options)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def kill_workers(self) -> None:
        """Kill all processes at once; Python has this method from 3.14 on."""
        for process in list((self._processes or {}).values()):
            process.kill()


def _serve() -> None:
    """Ignore Ctrl-C, also on Windows, and exit when the main process does, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_leave_with, args=(parent_process(),), daemon=True).start()


def _leave_with(parent: Any) -> None:
    connection.wait([parent.sentinel])
    os._exit(1)


def dask(client: Any) -> WorkerPool:
    """Return the workers of a Dask cluster.

    Parameters
    ----------
    client : dask.distributed.Client or str
        A connected client, or the address of a scheduler, such as ``"tcp://10.0.0.1:8786"``.

    Raises
    ------
    FeasibeeError
        If Dask isn't installed, or the cluster doesn't answer or has no workers.
    """
    if isinstance(client, str):
        try:
            from distributed import Client

            client = Client(client, timeout=PATIENCE)  # type: ignore[no-untyped-call,unused-ignore]
        except ImportError:
            raise FeasibeeError(f"Dask: not installed; {how_to_install('dask')}") from None
        except (OSError, TypeError, ValueError) as error:  # TypeError: tls:// without certificates
            raise FeasibeeError(
                f"--dask {client}: doesn't answer: {error}; give a scheduler's address"
            ) from None
    number = sum(client.nthreads().values())
    if number == 0:
        raise FeasibeeError(f"{client.scheduler.address}: the cluster has no workers; start some")

    return WorkerPool(lambda: client.get_executor(pure=False, retries=3), number, is_local=False)


def play(
    scenarios: Sequence[Scenario], pieces: Sequence[RunRange], seed: int, curves: bool
) -> tuple[list[EncodedRuns], float]:
    """Compute a chunk from a scenario per piece, wherever this runs; return its runs and its seconds."""
    encoded, begin = [], time.monotonic()
    for scenario, piece in zip(scenarios, pieces, strict=True):
        try:
            runs = Runs(piece.runs, seed, piece.first_run)
            encoded.append(encode(simulate_record(scenario, runs, curves=curves, threads=1)))
        except MemoryError:
            raise FeasibeeError(
                f"robots.count = {scenario.robots.count}: a worker has not enough memory for such a swarm; "
                "use fewer workers or robots, and run the same command again: the runs in the journal are "
                "kept"
            ) from None
    return encoded, time.monotonic() - begin


class Workers:
    """The workers of a pool, kept over all rounds of a study."""

    def __init__(self, pool: WorkerPool) -> None:
        self.pool = pool
        self._budget: float = FIRST_WORK
        self._executor: Executor | None = None
        self._waiting: dict[Chunk, Pieces] = {}
        self._again: deque[Pieces] = deque()
        self._deaths: Counter[tuple[RunRange, ...]] = Counter()

    def close(self) -> None:
        """End the workers; wait for what they compute."""
        if self._executor is not None:
            self._executor.shutdown(wait=True)
            self._executor = None

    def work_off(self, schedule: Schedule, report: Callable[[bool], None]) -> bool:
        """Compute all chunks of a schedule, of which few wait; return whether an interrupt ended the work.

        ``report`` is called after each chunk, and each second, with whether an interrupt was seen.
        """
        self._again.clear()
        self._deaths.clear()
        with counted_interrupts(self._kill) as interrupts:
            try:
                while (schedule.queue or self._again or self._waiting) and not interrupts:
                    self._submit_chunks(schedule)
                    self._collect(schedule, report)
                if interrupts:
                    report(True)
            finally:
                self._stop(schedule)
        return bool(interrupts)

    def _submit_chunks(self, schedule: Schedule) -> None:
        while self._may_submit(schedule):
            work = chunk_work(self._budget, schedule.left, self.pool.workers)
            pieces = self._again.popleft() if self._again else schedule.chunk(work)
            self._waiting[self._submit(schedule.study, pieces)] = pieces

    def _may_submit(self, schedule: Schedule) -> bool:
        """Whether to submit the next chunk; one that may have killed workers goes alone at its last try."""
        some = bool(self._again or schedule.queue)
        if not self._waiting:
            return some
        near = (*self._waiting.values(), *list(self._again)[:1])
        at_last = any(self._deaths[tuple(pieces)] >= TRIES - 1 for pieces in near)
        return some and len(self._waiting) < 2 * self.pool.workers and not at_last

    def _submit(self, study: Study, pieces: Pieces) -> Chunk:
        if self._executor is None:
            self._executor = self.pool.make()
        scenarios = [study.points[piece.point].scenario for piece in pieces]
        try:
            return self._executor.submit(play, scenarios, pieces, study.seed, study.curves)
        except BrokenExecutor as error:  # a worker has died since the last look
            failed: Chunk = Future()
            failed.set_exception(error)
            return failed

    def _collect(self, schedule: Schedule, report: Callable[[bool], None]) -> None:
        """Enter the chunks that are done; submit all again if a worker has died."""
        done = wait(self._waiting, PULSE, return_when=FIRST_COMPLETED).done
        if not done:
            report(False)
        for chunk in done:
            if isinstance(_failure(chunk, schedule.study, self._waiting[chunk]), BrokenExecutor):
                self._replace(schedule.study)
                return
            pieces = self._waiting.pop(chunk)
            encoded, seconds = chunk.result()
            schedule.enter(pieces, encoded)
            self._budget = next_budget(self._budget, schedule.work(pieces), seconds)
            report(False)

    def _replace(self, study: Study) -> None:
        """Make new workers in place of a broken executor's; give up a chunk that has killed one alone."""
        if self._executor is not None:
            self._executor.shutdown(wait=False)
            self._executor = None
        self._again.extendleft(reversed(self._waiting.values()))
        self._deaths.update(map(tuple, self._waiting.values()))
        self._waiting = {}
        for pieces in self._again:
            if self._deaths[tuple(pieces)] >= TRIES:
                raise _deadly(study, pieces)

    def _kill(self) -> bool:
        """Kill the workers if they are processes; return whether they are."""
        kill = getattr(self._executor, "kill_workers", None)
        if kill is not None:
            kill()
        return kill is not None

    def _stop(self, schedule: Schedule) -> None:
        """Cancel the chunks that wait; enter those that are being computed or have been."""
        running = [chunk for chunk in self._waiting if not chunk.cancel()]
        for chunk in as_completed(running):
            with suppress(Exception):  # the error that ended the work is the one to raise
                schedule.enter(self._waiting[chunk], chunk.result()[0])
        self._waiting = {}


def _failure(chunk: Chunk, study: Study, pieces: Pieces) -> BaseException | None:
    """Return the error of a chunk, if any; raise that of a cluster."""
    try:
        error = chunk.exception()
    except CancelledError:
        raise FeasibeeError(
            "the cluster has gone; start it, and run the same command again: the runs in the journal are kept"
        ) from None
    if type(error).__name__ == "KilledWorker":  # Dask's, which has tried it on several workers by now
        raise _deadly(study, pieces) from None
    return error


def _deadly(study: Study, pieces: Pieces) -> FeasibeeError:
    return FeasibeeError(
        f"workers died {TRIES} times, at last with runs of {dict(study.points[pieces[0].point].values)}: "
        "they may have run out of memory; use fewer workers or smaller swarms"
    )


@contextmanager
def counted_interrupts(stop: Callable[[], bool]) -> Iterator[list[int]]:
    """Give a list to which Ctrl-C adds; the second one kills the workers, a third one calls the old handler.

    ``stop`` kills the workers if they are processes, and returns whether they are. If not, the second Ctrl-C
    calls the old handler. Outside the main thread, or where Python doesn't handle Ctrl-C, nothing is counted.
    """
    seen: list[int] = []
    before: Any = signal.getsignal(signal.SIGINT)

    def count(number: int, frame: FrameType | None) -> None:
        seen.append(number)
        if len(seen) > 2 or (len(seen) == 2 and not stop()):
            before(number, frame)

    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield seen
        return
    signal.signal(signal.SIGINT, count)
    try:
        yield seen
    finally:
        signal.signal(signal.SIGINT, before)
