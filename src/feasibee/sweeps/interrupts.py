"""Ctrl-C while chunks are computed: counted by a signal handler, and handled between two chunks."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from types import FrameType
from typing import Any, Self


class Interrupts:
    """Counts Ctrl-C; the second one kills the workers, and a third one calls the handler before this one.

    Outside the main thread, or where Python doesn't handle Ctrl-C, nothing is counted.

    Parameters
    ----------
    stop : callable
        Kills the workers if they are processes; returns whether they are. If not, the second Ctrl-C calls
        the handler before this one.
    """

    def __init__(self, stop: Callable[[], bool]) -> None:
        self.seen = 0
        self._stop = stop
        self._before: Any = None

    def __enter__(self) -> Self:
        is_main = threading.current_thread() is threading.main_thread()
        if is_main and callable(signal.getsignal(signal.SIGINT)):
            self._before = signal.signal(signal.SIGINT, self._count)
        return self

    def __exit__(self, *error: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    def _count(self, number: int, frame: FrameType | None) -> None:
        self.seen += 1
        if self.seen > 2 or (self.seen == 2 and not self._stop()):
            self._before(number, frame)


@contextmanager
def inherited_block() -> Iterator[None]:
    """Block Ctrl-C in processes that are started within; a terminal sends it even while they start."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # starting it later would unblock Ctrl-C
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
