"""Who does a sweep's work: threads of this process, other processes, or a Dask cluster."""

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
"""Seconds for a cluster to answer."""


@dataclass(frozen=True)
class Crew:
    """Who does the work.

    Parameters
    ----------
    make : callable
        Makes an executor of `concurrent.futures`; called again if a worker's death broke the last one.
    workers : int
        How many chunks it does at a time.
    """

    make: Callable[[], Executor]
    workers: int


def threads(workers: int | None = None) -> Crew:
    """Return threads of this process, by default one a processor: the engine runs free of Python's lock."""
    number = workers or processors()
    return Crew(lambda: ThreadPoolExecutor(number), number)


def processes(workers: int | None = None) -> Crew:
    """Return processes of this machine, by default one for each processor; one that dies is replaced."""
    number = workers or processors()
    context = get_context("spawn")
    return Crew(lambda: _Processes(number, mp_context=context, initializer=_serve), number)


class _Processes(ProcessPoolExecutor):
    """Processes that leave Ctrl-C to the sweep's; they start when there is work for them."""

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        with inherited_block():
            return super().submit(work, *arguments, **options)

    def kill_workers(self) -> None:
        """End all processes now; Python has this from 3.14 on."""
        for process in list((self._processes or {}).values()):
            process.kill()


def _serve() -> None:
    """Leave Ctrl-C to the sweep's process, also on Windows, and don't outlive that if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


def dask(client: Any) -> Crew:
    """Return the workers of a Dask cluster.

    Parameters
    ----------
    client : dask.distributed.Client, or str
        Or the address of a scheduler, such as ``"tcp://10.0.0.1:8786"``.

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

    return Crew(make, number)


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
