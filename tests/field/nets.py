"""A network in memory, on which tests see each packet and write any other one."""

from __future__ import annotations

from collections import defaultdict, deque

from feasibee.field.checks import HELLO
from feasibee.field.connections import Client, Server

ASKED = HELLO, {"robot": 0, "nonce": 0}
"""What a robot says that asks for a connection."""


class Net:
    """The packets on their way up to a world, and down to each peer; it is the world's link."""

    address = "127.0.0.1:1"

    def __init__(self):
        self.up, self.down = deque(), defaultdict(deque)
        self.seen = []
        """All packets sent: the packet, its peer, and whether it went up."""

    def send(self, packet, peer=None):
        self.seen.append((packet, peer, False))
        self.down[peer].append(packet)

    def receive(self, timeout):
        return self.up.popleft() if self.up else None

    def close(self):
        """Do nothing."""

    def sent(self, peer, up):
        return [packet for packet, whose, way in self.seen if (whose, way) == (peer, up)]


class Wire:
    """The link of a peer of the world."""

    address = Net.address

    def __init__(self, net, peer):
        self._net, self._peer = net, peer

    def send(self, packet, peer=None):
        self._net.seen.append((packet, self._peer, True))
        self._net.up.append((packet, self._peer))

    def receive(self, timeout):
        waiting = self._net.down[self._peer]
        return (waiting.popleft(), None) if waiting else None

    def close(self):
        """Do nothing."""


class Pair:
    """A world's side of all connections, and one robot's or viewer's side."""

    def __init__(self, key=b"", peer="peer", receive=None):
        self.net = Net()
        self._key, self._peer = key, peer
        self.server = Server(self.net, 7, key)
        self.client = Client(Wire(self.net, peer), key, lambda: ASKED)

    @property
    def channel(self):
        """The world's side of the only connection."""
        ((channel, _),) = self.server._known.values()
        return channel

    def join(self, pair):
        """Join another pair's world."""
        self.net, self.server = pair.net, pair.server
        self.client = Client(Wire(self.net, self._peer), self._key, lambda: ASKED)
        joined(self)


def settle(pair):
    """Let both sides read until nothing is on its way; return the frames that they accepted."""
    up, down = [], []
    while pair.net.up or pair.net.down[pair.client._link._peer]:
        while pair.net.up:
            up.append(pair.server.receive(0.0))
        while pair.net.down[pair.client._link._peer]:
            down.append(pair.client.receive(0.0))
    return [each for each in up if each], [each for each in down if each]


def joined(pair):
    """Let a client ask until it has its connection; return what the world accepted."""
    pair.client.send(*ASKED)
    return settle(pair)[0]
