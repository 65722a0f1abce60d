"""Packets between the world and the robots: a header, JSON, and a signature if both sides have a key.

Whoever doesn't have the key can neither write a packet that is accepted nor send an old one again: each
packet names its session and has a number above that of the sender's last one.
"""

from __future__ import annotations

import json
import struct
import time
from collections import Counter
from typing import Any, Final, NamedTuple

from feasibee.field.checks import CHECKS, HELLO, VIEW

MAGIC: Final = b"fb1"
"""First bytes of each packet, with the version of its format."""
HEADER: Final = struct.Struct("!3sBHQQ")
"""Magic and version, kind, robot, session, number of the packet."""
SIGNATURE: Final = 16
"""Length of a signature in bytes: the first half of an HMAC-SHA-256."""
LARGEST: Final = 60_000
"""Largest packet in bytes; a datagram holds 65,507."""
ROBOTS_LIMIT: Final = 65_535
"""Numbers of robots are smaller than this."""


class Frame(NamedTuple):
    """A packet that was accepted."""

    kind: int
    robot: int
    session: int
    number: int
    body: dict[str, Any]


class _DroppedError(Exception):
    """A packet that isn't accepted."""


class Frames:
    """Write and read the packets of one side.

    Parameters
    ----------
    session : int
        Number of the session; 0 until a robot knows it.
    key : bytes
        The shared key; empty for none.
    """

    def __init__(self, session: int, key: bytes = b"") -> None:
        self.session = session
        self._key = key
        # Numbers begin with the time, so that those of a restarted process are above its earlier ones.
        self._number = time.time_ns()
        self._last: dict[int, int] = {}
        self.dropped: Counter[str] = Counter()

    def write(self, kind: int, robot: int, body: dict[str, Any]) -> bytes:
        """Return a packet; raise a ValueError if it is larger than `LARGEST`."""
        self._number += 1
        text = json.dumps(body, separators=(",", ":")).encode()
        packet = HEADER.pack(MAGIC, kind, robot, self.session, self._number) + text
        if self._key:
            packet += self._signature(packet)
        if len(packet) > LARGEST:
            raise ValueError(f"a packet of {len(packet):,} bytes; at most {LARGEST:,} fit")
        return packet

    def read(self, packet: bytes) -> Frame | None:
        """Return an accepted packet; count and drop any other one."""
        try:
            return self._accepted(packet)
        except _DroppedError as error:
            self.dropped[str(error)] += 1
            return None

    def _accepted(self, packet: bytes) -> Frame:
        """Return the content of a packet, or raise an error that says why it is dropped."""
        end = len(packet) - (SIGNATURE if self._key else 0)
        if not HEADER.size <= end <= LARGEST:
            raise _DroppedError("malformed")
        magic, kind, robot, session, number = HEADER.unpack_from(packet)
        if magic != MAGIC or kind not in CHECKS:
            raise _DroppedError("malformed")
        if self._key and not self._is_signed(packet, end):
            raise _DroppedError("not signed with the key")
        expected = 0 if kind == HELLO else self.session  # a robot that joins doesn't know the session
        is_asking = kind == VIEW and not session  # nor does a viewer
        if session != expected and self.session and not is_asking:
            raise _DroppedError("of another session")
        sender = -1 - robot if kind == VIEW else robot  # viewers' numbers are their own
        if number <= self._last.get(sender, 0):
            raise _DroppedError("old")
        try:
            body = json.loads(packet[HEADER.size : end])
        except (ValueError, RecursionError):
            raise _DroppedError("malformed") from None
        if not (isinstance(body, dict) and CHECKS[kind](body)):
            raise _DroppedError("malformed")
        if kind != HELLO and not is_asking:
            self._last[sender] = number
        return Frame(kind, robot, session, number, body)

    def _is_signed(self, packet: bytes, end: int) -> bool:
        from hmac import compare_digest

        return compare_digest(self._signature(packet[:end]), packet[end:])

    def _signature(self, packet: bytes) -> bytes:
        from hmac import digest

        return digest(self._key, packet, "sha256")[:SIGNATURE]
