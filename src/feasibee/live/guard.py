"""What keeps others out: the check of Host and Origin, and limits of the connections and the log.

Only pages that this server served may use it.

A page of another site can send requests to this machine. Its browser states where the page comes from
(Origin) and by which name it found the server (Host). Both must be the server's own. This also stops DNS
rebinding, where the name of another site suddenly leads to this machine. An IP address cannot be rebound.

uvicorn ends connections that are idle after a request, but not those that never send a complete request. Its
limit of connections rejects the newest, so that a few hundred silent connections would block every page.
"""

from __future__ import annotations

import asyncio
import logging
import re
import socket
import traceback
from ipaddress import ip_address
from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from feasibee.errors import FeasibeeError, Problem

HEADERS: Final = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
LIFETIME: Final = 20.0
"""Seconds until a connection ends that has not become a page's WebSocket."""
CONNECTIONS_LIMIT: Final = 128
"""Most open connections; a newer one replaces the oldest that is not a WebSocket."""
REFUSED = 1008
"""WebSocket close code: policy violation."""
HOST: Final = re.compile(r"(?:\[([0-9a-f:.]+)\]|([0-9a-z_.-]+))(?::([0-9]{1,5}))?", re.ASCII)
"""An IPv6 address in brackets, a name or an IPv4 address, and a port, if any. A URL parser would also accept
a user's name or a path."""
NAME: Final = re.compile(r"(?=.{1,253}$)(?:(?!-)[0-9a-z_-]{1,63}(?<!-)(?:\.(?!$)|$))+", re.ASCII)
NUMBER: Final = re.compile(r"(?:.*\.)?(?:[0-9]+|0x[0-9a-f]*)", re.ASCII)
"""Names that systems read as addresses: ``0`` means every address of this machine."""


class Guard:
    """An ASGI application that rejects requests whose Host or Origin isn't the server's own.

    ``app`` receives the accepted requests. ``host`` is where the server listens; beyond loopback, all
    addresses and this machine's names are accepted.
    """

    def __init__(self, app: ASGIApp, host: str) -> None:
        self._app = app
        self._addresses = not is_loopback(host)
        self._names = {"localhost"}
        if self._addresses:
            self._names |= {each.lower() for each in (host, socket.gethostname(), socket.getfqdn())}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer with status 403 or close code 1008."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        why = self._refusal(scope)
        if why and scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": REFUSED, "reason": why})
        elif why:
            await PlainTextResponse(f"{why}\n", 403)(scope, receive, send)
        else:
            await self._app(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> str:
        """Return why a request is rejected; an empty string if it is accepted."""
        headers = Headers(scope=scope)
        host, origins = headers.getlist("host"), headers.getlist("origin")
        if len(host) != 1 or not self._is_own(host[0].lower(), scope.get("server")):
            return "Host: not the name and port of this server; open the address that feasibee watch printed"
        from_page = scope["type"] == "websocket" or origins
        if from_page and [_place(origin) for origin in origins] != [host[0].lower()]:
            return "Origin: not a page of this server; open the address that feasibee watch printed"
        return ""

    def _is_own(self, host: str, server: tuple[str, int | None] | None) -> bool:
        """Return whether a Host, with or without a port, names the server."""
        parts = HOST.fullmatch(host)
        if parts is None:
            return False
        if parts[3] and server and server[1] and parts[3] != str(server[1]):
            return False
        if parts[2] in self._names:
            return True
        try:
            address = ip_address(parts[1] or parts[2])
        except ValueError:
            return False
        if (address.version == 6) != bool(parts[1]):
            return False
        return self._addresses or address.is_loopback


def is_loopback(host: str) -> bool:
    """Return whether a server on a host can be reached from this machine only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def check_host(host: str) -> None:
    """Raise an error unless a host is a valid address or name; an empty one would mean all addresses."""
    try:
        ip_address(host)
        correct = "%" not in host
    except ValueError:
        name = host.lower()
        correct = NAME.fullmatch(name) is not None and NUMBER.fullmatch(name) is None
    if not correct:
        rule = "must be an address or a name of this machine"
        raise FeasibeeError(str(Problem("--host", host, rule, "use 127.0.0.1, or leave it out")))


def _place(origin: str) -> str:
    """Return host and port of an origin; an empty string if its scheme isn't http or https."""
    scheme, _, place = origin.lower().partition("://")
    return place if scheme in ("http", "https") else ""


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return sending


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
        self._seen: set[tuple[str, str]] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a log record is the first of its kind."""
        raised_at = traceback.extract_tb(record.exc_info[2])[-1:] if record.exc_info else ""
        kind = record.msg, str(raised_at)
        first = kind not in self._seen
        self._seen.add(kind)
        return first
