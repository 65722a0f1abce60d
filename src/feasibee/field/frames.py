"""Packets between the world and its robots: a header and JSON, sealed if there is a key."""

from __future__ import annotations

import json
import struct
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from feasibee.field.checks import CHECKS

if TYPE_CHECKING:
    from feasibee.field.noise import Cipher

MAGIC: Final = b"fb3"
"""First bytes of each packet, with the version of its format."""
HEADER: Final = struct.Struct("!3sB8sQ")
"""Magic and version, way, name of the connection, number of the packet."""
ASK, TOKEN, ACCEPT, UP, DOWN = range(5)
"""Ways of packets. A robot asks for a connection, the world sends it a token, and accepts it with
that. Then packets go up to the world and down from it."""
LARGEST: Final = 60_000
"""Largest packet in bytes; a datagram holds 65,507."""
ROBOTS_LIMIT: Final = 65_535
"""Numbers of robots are smaller than this."""
WINDOW: Final = 1024
"""By how many packets one may be overtaken; later it is dropped as old."""


class DroppedError(Exception):
    """A packet that isn't accepted."""


class ForeignError(DroppedError):
    """A packet that isn't of the connection that it names."""


class Frame(NamedTuple):
    """A packet that was accepted."""

    kind: int
    robot: int
    """The robot that the connection belongs to; -1 for none."""
    body: dict[str, Any]
    channel: Channel


class Channel:
    """One side of a connection between the world and a robot.

    Parameters
    ----------
    name : bytes
        Eight random bytes that tell connections apart.
    way : int
        The way of the packets that are sent, `UP` or `DOWN`.
    ciphers : pair of Cipher, optional
        Those of the packets sent and received; None without a key.
    peer : Hashable
        Address of the other side.
    """

    def __init__(
        self, name: bytes, way: int, ciphers: tuple[Cipher, Cipher] | None = None, peer: Hashable = None
    ) -> None:
        self.name, self.peer = name, peer
        self.robot = -1
        self._way, self._ciphers = way, ciphers
        self._sent, self._newest = 0, -1
        self._seen = 0  # the newest packets received, a bit for each

    def write(self, kind: int, body: dict[str, Any]) -> bytes:
        """Return a packet; raise a ValueError if it is larger than `LARGEST`."""
        content = bytes([kind]) + json.dumps(body, separators=(",", ":")).encode()
        number, self._sent = self._sent, self._sent + 1
        if self._ciphers:
            content = self._ciphers[0].seal(number, content)
        packet = packed(self._way, self.name, content, number)
        if len(packet) > LARGEST:
            raise ValueError(f"a packet of {len(packet):,} bytes; at most {LARGEST:,} fit")
        return packet

    def read(self, number: int, content: bytes) -> Frame:
        """Return what a packet says that was received.

        Raises
        ------
        ForeignError
            If it isn't sealed for this connection.
        DroppedError
            If it came before, or can't be.
        """
        if self._ciphers:
            try:
                content = self._ciphers[1].open(number, content)
            except ValueError:
                raise ForeignError("not sealed with the key") from None
        ahead = number - self._newest
        if ahead <= -WINDOW or (ahead <= 0 and self._seen >> -ahead & 1):
            raise DroppedError("old")
        if ahead > 0:
            self._newest, self._seen = number, (self._seen << min(ahead, WINDOW)) % 2**WINDOW
        self._seen |= 1 << max(0, -ahead)
        try:
            kind, body = content[0], json.loads(content[1:])
        except (IndexError, ValueError, RecursionError):
            raise DroppedError("malformed") from None
        if not (kind in CHECKS and isinstance(body, dict) and CHECKS[kind](body)):
            raise DroppedError("malformed")
        return Frame(kind, self.robot, body, self)


def packed(way: int, name: bytes, content: bytes, number: int = 0) -> bytes:
    """Return a packet."""
    return HEADER.pack(MAGIC, way, name, number) + content


def parsed(packet: bytes) -> tuple[int, bytes, int, bytes]:
    """Return way, name of the connection, number and content of a packet.

    Raises
    ------
    DroppedError
        If it has no such header.
    """
    if not HEADER.size <= len(packet) <= LARGEST or not packet.startswith(MAGIC):
        raise DroppedError("malformed")
    _, way, name, number = HEADER.unpack_from(packet)
    return way, name, number, packet[HEADER.size :]
