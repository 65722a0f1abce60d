"""Links: addresses, and how packets travel to them: UDP of the standard library."""

from __future__ import annotations

import select
import socket
from collections.abc import Hashable
from contextlib import suppress

from feasibee.errors import FeasibeeError

DEFAULT_HOST = "127.0.0.1"
BUFFER = 4 * 2**20
"""Size of the socket's buffers in bytes. On macOS, a packet can't be larger than the buffer for sending."""


def join_address(host: str, port: int) -> str:
    """Return an address as HOST:PORT, or [HOST]:PORT for IPv6."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def split_address(text: str) -> tuple[str, int]:
    """Return host and port of an address.

    Raises
    ------
    FeasibeeError
        If it isn't HOST:PORT.
    """
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (colon and host and port.isascii() and port.isdigit() and 0 < int(port) < 65_536):
        raise FeasibeeError(f"address {text}: must be HOST:PORT, such as 127.0.0.1:7400")
    return host, int(port)


def is_loopback(host: str) -> bool:
    """Return whether an address can be reached from this machine only."""
    return host in ("localhost", "::1") or host.startswith("127.")


class Link:
    """One end of the network: of the world, with many peers, or of a robot, whose one peer is the world.

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
