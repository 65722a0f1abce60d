"""The server's connections and log, limited, so that no client keeps out pages or fills the terminal.

uvicorn ends a connection that is idle after a request, not one that never sends a whole one, and its limit
of connections turns away the newest: a few hundred silent ones would keep out every page.
"""

from __future__ import annotations

import asyncio
import logging
from typing import Any, Final

from uvicorn.config import LOGGING_CONFIG
from uvicorn.protocols.http.h11_impl import H11Protocol

LIFETIME: Final = 20.0
"""Seconds that a connection has for its requests, or to become a page's WebSocket."""
CONNECTIONS_LIMIT: Final = 128
"""Open connections; beyond, the newest takes the place of the oldest that is no WebSocket."""


class Connection(H11Protocol):
    """An HTTP connection that lasts `LIFETIME` at most, unless it becomes a WebSocket."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start the clock, and end the oldest connection if there are too many."""
        super().connection_made(transport)
        self.since = self.loop.time()
        self._deadline = self.loop.call_later(LIFETIME, self._end)
        if len(self.connections) > CONNECTIONS_LIMIT:
            plain = (each for each in self.connections if isinstance(each, Connection))
            oldest = min(plain, key=lambda each: each.since)
            self.connections.discard(oldest)  # at once: more may come before it is told of its end
            oldest.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the clock."""
        self._deadline.cancel()
        super().connection_lost(exc)

    def _end(self) -> None:
        protocol = self.transport.get_protocol()
        if protocol is self or not getattr(protocol, "handshake_complete", False):
            self.transport.abort()


class Once(logging.Filter):
    """Pass each message once, and each error once for the line that raised it."""

    def __init__(self) -> None:
        super().__init__()
        self._seen: set[tuple[str, tuple[str, int] | None]] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a record is the first of its kind."""
        kind = (record.msg, _raised_at(record))
        first = kind not in self._seen
        self._seen.add(kind)
        return first


def _raised_at(record: logging.LogRecord) -> tuple[str, int] | None:
    """Return file and line that raised a record's error, if it has one."""
    trace = record.exc_info[2] if record.exc_info else None
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace and (trace.tb_frame.f_code.co_filename, trace.tb_lineno)


def log_config() -> dict[str, Any]:
    """Return uvicorn's logging, with `Once` before each handler."""
    handlers = {
        name: {**handler, "filters": ["once"]} for name, handler in LOGGING_CONFIG["handlers"].items()
    }
    return {**LOGGING_CONFIG, "filters": {"once": {"()": Once}}, "handlers": handlers}
