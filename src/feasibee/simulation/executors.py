"""Where runs are computed: threads of this process, or a Dask cluster. Ctrl-C is handled between chunks."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    as_completed,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import FrameType
from typing import Any

from feasibee.base.errors import FeasibeeError, how_to_install
from feasibee.base.record import Record
from feasibee.engine.runner import processors
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.plan import Study
from feasibee.simulation.schedule import FIRST_WORK, RunRange, Schedule, chunk_work, next_budget

PATIENCE = 20.0
"""Seconds to wait for the answer of a cluster."""
PULSE = 1.0
"""Progress is reported at least so often, in seconds, however long a chunk takes."""
TRIES = 3
"""Number of tries of a chunk whose worker dies."""

Pieces = list[RunRange]
Chunk = Future[tuple[list[Record], float]]


@dataclass(frozen=True)
class WorkerPool:
    """Workers that compute chunks of runs; they change no result.

    Parameters
    ----------
    make : callable
        Makes an executor of `concurrent.futures`.
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

    return WorkerPool(lambda: client.get_executor(pure=False, retries=TRIES), number, is_local=False)


def play(
    scenarios: Sequence[Scenario], pieces: Sequence[RunRange], seed: int, curves: bool
) -> tuple[list[Record], float]:
    """Compute a chunk from a scenario per piece, wherever this runs; return its runs and its seconds."""
    records, begin = [], time.monotonic()
    for scenario, piece in zip(scenarios, pieces, strict=True):
        try:
            runs = Runs(piece.runs, seed, piece.first_run)
            records.append(simulate_record(scenario, runs, curves=curves, threads=1, chunk=piece.runs))
        except MemoryError:
            raise FeasibeeError(
                f"robots.count = {scenario.robots.count}: a worker has not enough memory for such a swarm; "
                "use fewer workers or robots, and run the same command again: the runs so far are kept"
            ) from None
    return records, time.monotonic() - begin


class Workers:
    """The workers of a pool, kept over all rounds of a study."""

    def __init__(self, pool: WorkerPool) -> None:
        self.pool = pool
        self._budget: float = FIRST_WORK
        self._executor: Executor | None = None
        self._waiting: dict[Chunk, Pieces] = {}

    def close(self) -> None:
        """End the workers; wait for what they compute."""
        if self._executor is not None:
            self._executor.shutdown(wait=True)
            self._executor = None

    def work_off(self, schedule: Schedule, report: Callable[[bool], None]) -> bool:
        """Compute all chunks of a schedule, of which few wait; return whether an interrupt ended the work.

        ``report`` is called after each chunk, and each second, with whether an interrupt was seen.
        """
        with counted_interrupts() as interrupts:
            try:
                while (schedule.queue or self._waiting) and not interrupts:
                    while schedule.queue and len(self._waiting) < 2 * self.pool.workers:
                        self._submit(schedule)
                    self._collect(schedule, report)
                if interrupts:
                    report(True)
            finally:
                self._stop(schedule)
        return bool(interrupts)

    def _submit(self, schedule: Schedule) -> None:
        if self._executor is None:
            self._executor = self.pool.make()
        study, work = schedule.study, chunk_work(self._budget, schedule.left, self.pool.workers)
        pieces = schedule.chunk(work)
        scenarios = [study.points[piece.point].scenario for piece in pieces]
        self._waiting[self._executor.submit(play, scenarios, pieces, study.seed, study.curves)] = pieces

    def _collect(self, schedule: Schedule, report: Callable[[bool], None]) -> None:
        """Enter the chunks that are done."""
        done = wait(self._waiting, PULSE, return_when=FIRST_COMPLETED).done
        if not done:
            report(False)
        for chunk in done:
            pieces = self._waiting.pop(chunk)
            records, seconds = _result(chunk, schedule.study, pieces)
            schedule.enter(pieces, records)
            self._budget = next_budget(self._budget, schedule.work(pieces), seconds)
            report(False)

    def _stop(self, schedule: Schedule) -> None:
        """Cancel the chunks that wait; enter those that are being computed or have been."""
        running = [chunk for chunk in self._waiting if not chunk.cancel()]
        for chunk in as_completed(running):
            with suppress(Exception):  # the error that ended the work is the one to raise
                schedule.enter(self._waiting[chunk], chunk.result()[0])
        self._waiting = {}


def _result(chunk: Chunk, study: Study, pieces: Pieces) -> tuple[list[Record], float]:
    """Return what a chunk gave; raise the errors of a cluster in words."""
    try:
        return chunk.result()
    except CancelledError:
        raise FeasibeeError(
            "the cluster has gone; start it, and run the same command again: the runs so far are kept"
        ) from None
    except Exception as error:
        if type(error).__name__ != "KilledWorker":  # Dask's, which has tried the chunk on several workers
            raise
        values = dict(study.points[pieces[0].point].values)
        raise FeasibeeError(
            f"workers died {TRIES} times, at last with runs of {values}: they may have run out of memory; "
            "use fewer workers or smaller swarms"
        ) from None


@contextmanager
def counted_interrupts() -> Iterator[list[int]]:
    """Give a list to which Ctrl-C adds; from the second one on, the old handler is called.

    Outside the main thread, or where Python doesn't handle Ctrl-C, nothing is counted.
    """
    seen: list[int] = []
    before: Any = signal.getsignal(signal.SIGINT)

    def count(number: int, frame: FrameType | None) -> None:
        seen.append(number)
        if len(seen) > 1:
            before(number, frame)

    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield seen
        return
    signal.signal(signal.SIGINT, count)
    try:
        yield seen
    finally:
        signal.signal(signal.SIGINT, before)
