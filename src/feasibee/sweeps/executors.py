"""Where runs are computed: threads of this process, other processes, or a Dask cluster."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from multiprocessing import connection, get_context, parent_process
from threading import Thread
from typing import Any

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.simulation.ensemble import processors
from feasibee.sweeps.interrupts import inherited_block

PATIENCE = 20.0
"""Seconds to wait for the answer of a cluster."""


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
        Whether the workers share this machine's cache of compiled code.
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
        with inherited_block():
            return super().submit(work, *arguments, **options)

    def kill_workers(self) -> None:
        """Kill all processes at once; Python has this method from 3.14 on."""
        for process in list((self._processes or {}).values()):
            process.kill()


def _serve() -> None:
    """Ignore Ctrl-C, also on Windows, and exit when the main process does, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
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
        client = _connected(client)
    number = sum(client.nthreads().values())
    if number == 0:
        raise FeasibeeError(f"{client.scheduler.address}: the cluster has no workers; start some")

    def make() -> Executor:
        executor: Executor = client.get_executor(pure=False, retries=3)
        return executor

    return WorkerPool(make, number, is_local=False)


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise FeasibeeError(f"Dask: not installed; {how_to_install('dask')}") from None
    try:
        return Client(address, timeout=PATIENCE)  # type: ignore[no-untyped-call,unused-ignore]
    except (OSError, TypeError, ValueError) as error:  # TypeError: tls:// without certificates
        raise FeasibeeError(
            f"--dask {address}: doesn't answer: {error}; give a scheduler's address"
        ) from None
