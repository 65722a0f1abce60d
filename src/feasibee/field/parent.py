"""A process that ends once its parent has: the pipe between them says so, however the parent ended."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from threading import Thread
from typing import Any


def read_order() -> dict[str, Any]:
    """Return the order that the parent has written to standard input; without one, end as it did."""
    line = sys.stdin.buffer.readline()
    if not line.endswith(b"\n"):
        os._exit(1)
    order: dict[str, Any] = json.loads(line)
    return order


def follow_parent(
    source: int,
    heed: Callable[[bytes], object] = lambda _: None,
    at_end: Callable[[], object] = lambda: None,
) -> Thread:
    """Start and return a thread that ends this process when the pipe of its parent ends.

    Parameters
    ----------
    source : int
        File descriptor of the pipe's end for reading. Only the parent may have the end for writing.
    heed : callable
        Takes what the parent writes.
    at_end : callable
        Called before this process ends.
    """

    def follow() -> None:
        while read := os.read(source, 4096):  # not a file object: the exit would wait for its lock
            heed(read)
        at_end()
        os._exit(1)

    thread = Thread(target=follow, daemon=True)
    thread.start()
    return thread
