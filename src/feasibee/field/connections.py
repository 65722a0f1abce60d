"""Connections of robots to their world: UDP links, packets, and who may send them.

A packet is a header and JSON, sealed if there is a key. Who asks for a connection gets a token for its
address, and must send it back. Until then, the world sends an address no more bytes than come from it. With a
key, both sides also prove that they have the key.
"""

from __future__ import annotations

import json
import secrets
import select
import socket
import struct
import time
from collections import Counter, deque
from collections.abc import Callable, Hashable
from contextlib import suppress
from hashlib import blake2b, sha256
from hmac import compare_digest
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from feasibee.errors import FeasibeeError
from feasibee.field.checks import CHECKS, ROBOTS_LIMIT

if TYPE_CHECKING:
    from feasibee.field.noise import Cipher, Handshake

DEFAULT_HOST = "127.0.0.1"
BUFFER = 4 * 2**20
"""Size of the socket's buffers in bytes. On macOS, a packet can't be larger than the buffer for sending."""


def join_address(host: str, port: int) -> str:
    """Return an address as HOST:PORT, or [HOST]:PORT for IPv6."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def split_address(text: str) -> tuple[str, int]:
    """Return host and port of an address.

    Raise a FeasibeeError if it isn't HOST:PORT.
    """
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (colon and host and port.isascii() and port.isdigit() and 0 < int(port) < 65_536):
        raise FeasibeeError(f"address {text}: must be HOST:PORT, such as 127.0.0.1:7400")
    return host, int(port)


def is_loopback(host: str) -> bool:
    """Return whether a server on a host can be reached from this machine only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Link:
    """One end of the network: of the world, with many peers, or of a robot, whose one peer is the world.

    Host and port are those of the world, which ``listens``; port 0 takes a free one.
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
            where, remedy = join_address(host, port), "another port"
            if not port:
                where, remedy = f"--host {host}", DEFAULT_HOST
            action, remedy = ("listen on", remedy) if listens else ("send to", "the world's address")
            raise FeasibeeError(f"{where}: can't {action} it: {why}; use {remedy}") from None
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


MAGIC: Final = b"fb3"
"""First bytes of each packet, with the version of its format."""
HEADER: Final = struct.Struct("!3sB8sQ")
"""Magic and version, way, name of the connection, number of the packet."""
ASK, TOKEN, ACCEPT, UP, DOWN = range(5)
"""Ways of packets. A robot asks for a connection, the world sends it a token, and accepts it with
that. Then packets go up to the world and down from it."""
LARGEST: Final = 60_000
"""Largest packet in bytes; a datagram holds 65,507."""
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

    Its name is eight random bytes. Packets are sent the way `UP` or `DOWN`, sealed by the first cipher, and
    opened by the second one; without a key there are none. ``peer`` is the address of the other side.
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

    Raise a DroppedError if it has no such header.
    """
    if not HEADER.size <= len(packet) <= LARGEST or not packet.startswith(MAGIC):
        raise DroppedError("malformed")
    _, way, name, number = HEADER.unpack_from(packet)
    return way, name, number, packet[HEADER.size :]


TOKEN_SIZE: Final = 8
"""Bytes of a token: with its header it is shorter than each packet of a robot."""
TOKEN_KEPT: Final = 60.0
"""Seconds for which a token is good, at least; at most twice as many."""
SESSION_SIZE: Final = 8
"""Bytes of a field's number."""
CONNECTIONS_LIMIT: Final = ROBOTS_LIMIT + 1_000
"""Most connections of a world; of more, the one that has been silent for longest ends."""
AGAIN: Final = 0.2
"""Least seconds between two connections of a robot."""


class _Side:
    """One side of connections, over a link, with a shared key; an empty key is none."""

    def __init__(self, link: Link, key: bytes) -> None:
        self._link, self._key = link, key
        self.dropped: Counter[str] = Counter()

    def receive(self, timeout: float) -> Frame | None:
        """Return the next packet of a connection, or None if none comes in so many seconds."""
        received = self._link.receive(timeout)
        try:
            return self._taken(*received) if received else None
        except DroppedError as error:
            self.dropped[str(error)] += 1
            return None

    def _taken(self, packet: bytes, peer: Hashable) -> Frame | None:
        """Return what a packet of a connection says; act on any other one."""
        raise NotImplementedError


class Client(_Side):
    """A robot's side of its connection to a world, which is a new one if the world starts again.

    ``greet`` returns kind and body of the first packet of each connection.
    """

    def __init__(self, link: Link, key: bytes, greet: Callable[[], tuple[int, dict[str, Any]]]) -> None:
        super().__init__(link, key)
        self._greet = greet
        self.session = 0
        """Number of the field; 0 before it has answered."""
        self._channels: deque[Channel] = deque(maxlen=2)
        """The present connection and the one before, which the world uses until it hears from this one."""
        self._begin(bytes(TOKEN_SIZE))

    def send(self, kind: int, body: dict[str, Any]) -> None:
        """Send a packet by the connection; ask for one while it is missing or the world has lost it."""
        if self._is_asking:
            self._ask()
        if self._channels:
            self._link.send(self._channels[0].write(kind, body))

    def _begin(self, token: bytes) -> None:
        """Begin to ask for a connection."""
        self._began_at, self._is_asking = time.monotonic(), True
        self._token, self._name = token, secrets.token_bytes(8)
        self._handshake = _handshake(self._key, self._name)
        self._message = self._handshake.write(b"") if self._handshake else b""

    def _ask(self) -> None:
        self._link.send(packed(ASK, self._name, self._token + self._message))

    def _taken(self, packet: bytes, _: Hashable) -> Frame | None:
        way, name, number, content = parsed(packet)
        known = [channel for channel in self._channels if channel.name == name]
        if way == DOWN and known:
            return known[0].read(number, content)
        if way == TOKEN and len(content) == TOKEN_SIZE:
            self._return(content, name)
        elif way == ACCEPT and self._is_asking and name == self._name:
            self._connect(content)
        else:
            raise ForeignError("of no connection")
        return None

    def _return(self, token: bytes, name: bytes) -> None:
        """Ask with the token that came for a connection; begin another one if the world has lost that."""
        if self._is_asking and name == self._name and token != self._token:
            self._token = token
            self._ask()
        elif self._channels and name == self._channels[0].name and time.monotonic() > self._began_at + AGAIN:
            self._begin(token)
            self._ask()

    def _connect(self, content: bytes) -> None:
        """Use a connection that the world has accepted, unless it is to another field than before."""
        ciphers = None
        if self._handshake:
            try:
                handshake, content = self._handshake.read(content)
            except ValueError:
                raise ForeignError("not sealed with the key") from None
            ciphers = handshake.ciphers()
        session = int.from_bytes(content)
        if len(content) != SESSION_SIZE or self.session not in (0, session):
            raise ForeignError("of another field")
        self.session, self._is_asking = session, False
        self._channels.appendleft(Channel(self._name, UP, ciphers))
        self.send(*self._greet())


class Server(_Side):
    """The world's side of all connections of the field of a number."""

    def __init__(self, link: Link, session: int, key: bytes = b"") -> None:
        super().__init__(link, key)
        self.session = session
        self._secret = secrets.token_bytes(32)
        self._known: dict[tuple[Hashable, bytes], tuple[Channel, bytes]] = {}
        """Channels by address and name, with the packets that accepted them; the last was heard last."""

    @property
    def address(self) -> str:
        """Where robots find the world, HOST:PORT."""
        return self._link.address

    def send(self, channel: Channel, kind: int, body: dict[str, Any]) -> None:
        """Send a packet; raise a ValueError if it is too large."""
        self._link.send(channel.write(kind, body), channel.peer)

    def end(self, channel: Channel) -> None:
        """Accept no more packets of a connection."""
        self._known.pop((channel.peer, channel.name), None)

    def _taken(self, packet: bytes, peer: Hashable) -> Frame | None:
        way, name, number, content = parsed(packet)
        asked = peer, name
        if way == ASK:
            if not self._is_there(peer, content[:TOKEN_SIZE]):
                self._challenge(asked, len(packet))
            else:
                if asked not in self._known:
                    self._accept(asked, content[TOKEN_SIZE:])
                self._link.send(self._known[asked][1], peer)
            return None
        if way != UP:
            raise ForeignError("of no connection")
        try:
            if asked not in self._known:
                raise ForeignError("of no connection")
            frame = self._known[asked][0].read(number, content)
        except ForeignError:
            self._challenge(asked, len(packet))
            raise
        self._known[asked] = self._known.pop(asked)
        return frame

    def _tokens(self, peer: Hashable) -> list[bytes]:
        """Return the present token of an address, and the one before."""
        now = int(time.monotonic() / TOKEN_KEPT)
        texts = [f"{part} {peer}".encode() for part in (now, now - 1)]
        return [blake2b(text, key=self._secret, digest_size=TOKEN_SIZE).digest() for text in texts]

    def _is_there(self, peer: Hashable, token: bytes) -> bool:
        """Return whether a token was sent to an address."""
        return any(compare_digest(token, each) for each in self._tokens(peer))

    def _challenge(self, asked: tuple[Hashable, bytes], size: int) -> None:
        """Send an address its token, if that is no longer than its packet, which has so many bytes."""
        peer, name = asked
        packet = packed(TOKEN, name, self._tokens(peer)[0])
        if len(packet) <= size:
            self._link.send(packet, peer)

    def _accept(self, asked: tuple[Hashable, bytes], message: bytes) -> None:
        """Accept a connection, if its side has the same key or neither has one."""
        peer, name = asked
        handshake, ciphers = _handshake(self._key, name), None
        content = self.session.to_bytes(SESSION_SIZE)
        if handshake:
            try:
                handshake, _ = handshake.read(message)
                content = handshake.write(content)
            except ValueError:
                raise ForeignError("not sealed with the key") from None
            ciphers = handshake.ciphers()[::-1]
        elif message:
            raise ForeignError("not sealed with the key")
        self._known[asked] = Channel(name, DOWN, ciphers, peer), packed(ACCEPT, name, content)
        if len(self._known) > CONNECTIONS_LIMIT:
            del self._known[next(iter(self._known))]


def _handshake(key: bytes, name: bytes) -> Handshake | None:
    """Return a handshake for a connection; None without a key."""
    if not key:
        return None
    from feasibee.field.noise import Handshake  # heavy: only with a key

    return Handshake(sha256(key).digest(), MAGIC + name)
