"""Links: how packets travel. One small interface, with UDP of the standard library and with zenoh."""

from __future__ import annotations

import select
import socket
from collections.abc import Hashable
from contextlib import suppress
from typing import Protocol

from feasibee.errors import FeasibeeError
from feasibee.field.addresses import join_address

BUFFER = 4 * 2**20
"""Size of the socket's buffers in bytes. On macOS, a packet can't be larger than the buffer for sending."""


class Link(Protocol):
    """One end of the network: of the world, with many peers, or of a robot, whose one peer is the world."""

    address: str
    """The world's address, as a robot gives it to ``--connect``."""

    def send(self, packet: bytes, peer: Hashable = None) -> None:
        """Send a packet to a peer; it may be lost."""

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Return the next packet with its peer, or None if none comes in so many seconds."""

    def close(self) -> None:
        """Stop sending and receiving."""


class UdpLink:
    """A link over UDP.

    Parameters
    ----------
    host, port : str and int
        Where the world listens; port 0 takes a free one.
    listens : bool
        Whether this is the world's end.
    """

    def __init__(self, host: str, port: int, *, listens: bool) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            with suppress(OSError):  # some systems refuse a size, others give less
                self._socket.setsockopt(socket.SOL_SOCKET, option, BUFFER)
        try:
            (self._socket.bind if listens else self._socket.connect)((host, port))
        except (OSError, UnicodeError, TypeError) as error:  # TypeError: a NUL in the name
            self._socket.close()
            why = error.strerror if isinstance(error, OSError) else "invalid name"
            action, remedy = ("listen on", "another port") if listens else ("send to", "the world's address")
            raise FeasibeeError(
                f"{join_address(host, port)}: can't {action} it: {why}; use {remedy}"
            ) from None
        self._socket.setblocking(False)
        self.address = join_address(*self._socket.getsockname()[:2]) if listens else join_address(host, port)

    def send(self, packet: bytes, peer: Hashable = None) -> None:
        """Send a packet to a peer; without a peer, to the world."""
        try:
            if peer is None:
                self._socket.send(packet)
            else:
                self._socket.sendto(packet, peer)  # type: ignore[call-overload]
        except OSError:  # full buffer, or nobody listens: the same as a lost packet
            return

    def receive(self, timeout: float) -> tuple[bytes, Hashable] | None:
        """Return the next packet with its peer, or None if none comes in so many seconds."""
        try:
            if timeout > 0 and not select.select([self._socket], [], [], timeout)[0]:
                return None
            return self._socket.recvfrom(65_536)
        except OSError:  # nothing there, or an earlier packet found nobody
            return None

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def open_link(transport: str, host: str, port: int, *, listens: bool, name: str = "") -> Link:
    """Return a link by the name of its transport, ``udp`` or ``zenoh``; ``name`` is a robot's own."""
    if transport == "zenoh":
        from feasibee.field.zenoh_link import ZenohLink

        return ZenohLink(host, port, listens=listens, name=name)
    return UdpLink(host, port, listens=listens)
