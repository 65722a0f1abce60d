"""A server of the live arena, for tests."""

from __future__ import annotations

import json
import threading
from contextlib import contextmanager

import numpy as np
from websockets.sync.client import connect

from feasibee.live import server as serving
from feasibee.live.messages import PROTOCOL


@contextmanager
def serving_at(catalogue, port=0):
    """Run a server in a thread; give its port."""
    with serving.listen("127.0.0.1", port) as listening:
        server = serving.server_of(catalogue, "127.0.0.1")
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            yield listening.getsockname()[1]
        finally:
            server.should_exit = True
            thread.join(60)
            assert not thread.is_alive()


class Page:
    """What a page does, without a browser."""

    def __init__(self, port, **options):
        options.setdefault("origin", f"http://127.0.0.1:{port}")
        self.line = connect(f"ws://127.0.0.1:{port}/swarm", max_size=None, proxy=None, **options)

    def __enter__(self):
        self.socket = self.line.__enter__()
        self.welcome = self.receive()
        return self

    def __exit__(self, *error):
        self.line.__exit__(*error)

    def receive(self):
        message = self.socket.recv(60)
        return json.loads(message) if isinstance(message, str) else decode(message)

    def say(self, **message):
        self.socket.send(json.dumps(message))

    def answer(self, kind, **message):
        """Send a message to the server; return its first answer of a kind, and skip others."""
        self.say(**message)
        return self.until(kind)

    def until(self, kind):
        """Return the next message of a kind, and skip others."""
        while (received := self.receive())["type"] != kind:
            assert received["type"] in ("going", "opened", "tasks", "robot"), received
        return received

    def open(self, **message):
        return self.answer("frame", type="open", **message)

    def problems(self, **message):
        return [each["path"] for each in self.answer("error", **message)["problems"]]


def decode(message):
    """Return a binary message as the page reads it; see messages.py."""
    start = 4 + int.from_bytes(message[:4], "little")
    found = json.loads(message[4:start])
    assert found["protocol"] == PROTOCOL
    for name, kind, length in found["arrays"]:
        found[name] = np.frombuffer(message, f"<{kind}", length, start)
        start += found[name].nbytes
    assert start == len(message)
    return found
