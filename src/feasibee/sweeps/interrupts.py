"""Ctrl-C while chunks are computed: noted, and acted on between two of them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from types import FrameType
from typing import Any, Self


class Interrupts:
    """Notes the first Ctrl-C; the second stops the work; a third does what it would have done before.

    Without a handler of Python's, as in another thread than the main one, nothing is noted.

    Parameters
    ----------
    stop : callable
        Stops the work at once, if it can: says whether it did. If not, the second does what a third would.
    """

    def __init__(self, stop: Callable[[], bool]) -> None:
        self.seen = 0
        self._stop = stop
        self._before: Any = None

    def __enter__(self) -> Self:
        is_main = threading.current_thread() is threading.main_thread()
        if is_main and callable(signal.getsignal(signal.SIGINT)):
            self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *error: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.seen += 1
        if self.seen > 2 or (self.seen == 2 and not self._stop()):
            self._before(number, frame)


@contextmanager
def inherited_block() -> Iterator[None]:
    """Keep Ctrl-C from processes that are started meanwhile, from their first moment on.

    A terminal sends it to all of them, also while their interpreters start.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # its own start ends with Ctrl-C unblocked
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
