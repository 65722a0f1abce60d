"""Limits of the server's connections and log, so that no client blocks pages or fills the terminal.

uvicorn ends connections that are idle after a request, but not those that never send a complete request. Its
limit of connections rejects the newest, so that a few hundred silent connections would block every page.
"""

from __future__ import annotations

import asyncio
import logging
from typing import Any, Final

from uvicorn.config import LOGGING_CONFIG
from uvicorn.protocols.http.h11_impl import H11Protocol

LIFETIME: Final = 20.0
"""Seconds until a connection ends that has not become a page's WebSocket."""
CONNECTIONS_LIMIT: Final = 128
"""Most open connections; a newer one replaces the oldest that is not a WebSocket."""


class Connection(H11Protocol):
    """An HTTP connection that ends after `LIFETIME`, unless it becomes a WebSocket."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start the timer, and abort the oldest connection if more than `CONNECTIONS_LIMIT` are open."""
        super().connection_made(transport)
        self.since = self.loop.time()
        self._deadline = self.loop.call_later(LIFETIME, self._end)
        if len(self.connections) > CONNECTIONS_LIMIT:
            plain = (each for each in self.connections if isinstance(each, Connection))
            oldest = min(plain, key=lambda each: each.since)
            self.connections.discard(
                oldest
            )  # now: connection_lost is called later, and more connections may open before
            oldest.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the timer."""
        self._deadline.cancel()
        super().connection_lost(exc)

    def _end(self) -> None:
        protocol = self.transport.get_protocol()
        if protocol is self or not getattr(protocol, "handshake_complete", False):
            self.transport.abort()


class Once(logging.Filter):
    """A filter that passes each message once, and each error once per line that raised it."""

    def __init__(self) -> None:
        super().__init__()
        self._seen: set[tuple[str, tuple[str, int] | None]] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a log record is the first of its kind."""
        kind = (record.msg, _raised_at(record))
        first = kind not in self._seen
        self._seen.add(kind)
        return first


def _raised_at(record: logging.LogRecord) -> tuple[str, int] | None:
    """Return the file and line that raised the error of a log record, if any."""
    trace = record.exc_info[2] if record.exc_info else None
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace and (trace.tb_frame.f_code.co_filename, trace.tb_lineno)


def log_config() -> dict[str, Any]:
    """Return uvicorn's logging configuration with the filter `Once` on each handler."""
    handlers = {
        name: {**handler, "filters": ["once"]} for name, handler in LOGGING_CONFIG["handlers"].items()
    }
    return {**LOGGING_CONFIG, "filters": {"once": {"()": Once}}, "handlers": handlers}
