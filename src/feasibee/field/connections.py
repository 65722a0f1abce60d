"""Connections between the processes of a field on one machine: JSON bytes by `multiprocessing.connection`.

The world listens in a folder that only its user may enter, by a Unix socket, or on localhost if the folder's
path is too long for one. Robots find address and key in the file `FILE` of that folder.
"""

from __future__ import annotations

import json
import os
import secrets
import select
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import AuthenticationError, Pipe
from multiprocessing.connection import Client, Connection, Listener
from pathlib import Path
from selectors import EVENT_READ, DefaultSelector
from threading import Thread
from typing import Any, Final, NamedTuple

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import named, read_text

HELLO, WELCOME, REFUSED, BYE = "hello", "welcome", "refused", "bye"
"""Kinds of messages: a robot joins, gets its orders or the reason against it, and hears of the end."""
STEP, SAID, END, DIED = "step", "said", "end", "died"
"""A step begins, its answer, a step ends; a connection has ended, which no one sends."""
TICK, SIGHT, HEARD = "tick", "sight", "heard"
"""With clocks: a robot's step, what it sees, and a message that it hears."""
FILE: Final = "world.json"
FILE_LIMIT: Final = 2**16
"""Bytes of this file that are read at most."""
NO_WORLD: Final = (FeasibeeError, OSError, EOFError, ValueError, LookupError, TypeError, AuthenticationError)
"""What reading that file and connecting may raise."""
PATH_LIMIT: Final = 100
"""Longest path of a Unix socket, in bytes; systems allow 103 or 107."""


class Channel:
    """The world's side of a connection with a robot, whose number is -1 until it has joined."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.robot = -1


class Frame(NamedTuple):
    """A message of a robot."""

    kind: str
    body: dict[str, Any]
    channel: Any
    """A `Channel`, or what another network has instead, with the number of the ``robot``."""


class Connections:
    """The world's side of all connections. It listens in a folder, which must exist."""

    def __init__(self, folder: Path) -> None:
        path, key = folder / "socket", secrets.token_hex()
        fits = len(os.fsencode(path)) < PATH_LIMIT
        self._listener = Listener(str(path) if fits else ("localhost", 0), backlog=128, authkey=key.encode())
        self.address = str(folder / FILE)
        file = os.open(self.address, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with open(file, "w", encoding="utf-8") as text:  # noqa: PTH123 (it takes a file that is open)
            json.dump({"address": self._listener.address, "key": key}, text)
        self._selector, self._ready = DefaultSelector(), deque[Any]()
        self._accepted = deque[Channel]()
        self._news, self._told = Pipe(duplex=False)
        self._selector.register(self._news, EVENT_READ)
        Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        """Accept connections until the world closes; `receive` takes them over."""
        while not self._told.closed:
            with suppress(OSError, EOFError, AuthenticationError):  # of who has gone, or has another key
                self._accepted.append(Channel(self._listener.accept()))
                self._told.send_bytes(b"1")

    def receive(self, timeout: float) -> Frame | None:
        """Return the next message of a robot, or None if none comes in so many seconds."""
        if not self._ready:
            self._ready.extend(key.data for key, _ in self._selector.select(max(0.0, timeout)))
        if not self._ready:
            return None
        channel = self._ready.popleft()
        if channel is None:
            self._news.recv_bytes()
            channel = self._accepted.popleft()
            self._selector.register(channel.connection, EVENT_READ, channel)
            return None
        try:
            kind, body = json.loads(channel.connection.recv_bytes())
        except (OSError, EOFError):
            self._selector.unregister(channel.connection)
            channel.connection.close()
            return Frame(DIED, {}, channel)
        return Frame(kind, body, channel)

    def send(self, channel: Channel, kind: str, body: dict[str, Any]) -> None:
        """Send a message, unless the robot has ended, or has left too many unread, as a stopped one does."""
        if channel.connection.closed:
            return
        room = select.poll()
        room.register(channel.connection, select.POLLOUT)
        if room.poll(0):
            with suppress(OSError):  # it has ended, which `receive` finds
                channel.connection.send_bytes(packed(kind, body))

    def close(self) -> None:
        """Accept no more connections, and end all."""
        self._told.close()
        self._listener.close()
        for key in [*self._selector.get_map().values()]:
            key.fileobj.close()  # type: ignore[union-attr]


def packed(kind: str, body: dict[str, Any]) -> bytes:
    """Return a message as bytes."""
    return json.dumps([kind, body], separators=(",", ":")).encode()


@contextmanager
def connection_to(address: str) -> Iterator[Connection]:
    """Give a robot's side of a connection to the world whose file is at an address.

    Raise a FeasibeeError if there is no world.
    """
    try:
        found = json.loads(read_text(address, "a world's file", FILE_LIMIT))
        where = found["address"]
        connection = Client(where if isinstance(where, str) else tuple(where), authkey=found["key"].encode())
    except NO_WORLD as error:
        rule = "no world of a field is there; use the path that feasibee robot launch --no-robots prints"
        raise FeasibeeError(f"{named(address)}: {rule}") from error
    with connection:
        yield connection
