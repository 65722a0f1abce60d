"""A network in memory, on which tests see each packet, write any other one, and attack a whole field."""

from __future__ import annotations

from collections import defaultdict, deque
from contextlib import closing
from threading import Condition, Thread
from typing import NamedTuple

from fields import opinions, steps_of

from feasibee.field.checks import HELLO
from feasibee.field.connections import Client, Server
from feasibee.field.logs import LineLog
from feasibee.field.robot import Robot
from feasibee.field.world import Lockstep

ASKED = HELLO, {"robot": 0, "nonce": 0}
"""What a robot says that asks for a connection."""
KEY = b"sixteen or more characters"


class Way(NamedTuple):
    """Where a packet goes: up to the world from a peer, or down to it."""

    peer: str | int
    up: bool


def let_pass(packet, way):
    """Attack nothing: an attack takes a packet and its way, and returns all that is sent instead."""
    return [(packet, way)]


class Net:
    """The packets on their way up to a world, and down to each peer; it is the world's link."""

    address = "127.0.0.1:1"

    def __init__(self, attack=let_pass):
        self.up, self.down = deque(), defaultdict(deque)
        self.seen = []
        """All packets sent, with their ways."""
        self._attack, self._news = attack, Condition()
        self._error = None

    def fail(self, error):
        """Raise an error in all that read or write from now on."""
        with self._news:
            self._error = self._error or error
            self._news.notify_all()

    def put(self, packet, way):
        """Let a packet pass the attack."""
        with self._news:
            self.seen.append((packet, way))
            for each, (peer, up) in self._attack(packet, way):
                (self.up if up else self.down[peer]).append((each, peer))
            self._news.notify_all()

    def take(self, waiting, timeout):
        """Return the next packet of a queue and its peer; wait for it so many seconds."""
        with self._news:
            self._news.wait_for(lambda: waiting or self._error, timeout)
            if self._error:
                raise self._error
            return waiting.popleft() if waiting else None

    def send(self, packet, peer=None):
        self.put(packet, Way(peer, up=False))

    def receive(self, timeout):
        return self.take(self.up, timeout)


class Wire:
    """The link of a peer of the world."""

    def __init__(self, net, peer):
        self._net, self._peer = net, peer

    def send(self, packet, peer=None):
        self._net.put(packet, Way(self._peer, up=True))

    def receive(self, timeout):
        return self._net.take(self._net.down[self._peer], timeout)


class Pair:
    """A world's side of all connections, and one robot's side."""

    def __init__(self, key=b"", peer="peer"):
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
    waiting = pair.net.down[pair.client._link._peer]
    while pair.net.up or waiting:
        while pair.net.up:
            up.append(pair.server.receive(0.0))
        while waiting:
            down.append(pair.client.receive(0.0))
    return [each for each in up if each], [each for each in down if each]


def joined(pair):
    """Let a client ask until it has its connection; return what the world accepted."""
    pair.client.send(*ASKED)
    return settle(pair)[0]


def play(plan, folder, attack=let_pass, brain=None):
    """Run a field in lockstep, in threads; its logs are in a folder.

    Return the opinions at each step, the world's result, how the robots ended, and the packets. If a robot
    fails, raise its error at once.
    """
    folder.mkdir(exist_ok=True)
    net, ended, threads = Net(attack), {}, []

    def be_a_robot(number):
        strategy = plan.scenario.strategy if plan.scenario.manifest.source else None
        with closing(LineLog(folder / f"robot-{number}.jsonl")) as log:
            robot = Robot(Wire(net, number), KEY, number, log, strategy, patience=10.0, brain=brain)
            try:
                ended[number] = robot.run()
            except Exception as error:
                net.fail(error)

    def start(number):
        threads.append(Thread(target=be_a_robot, args=[number]))
        threads[-1].start()

    def follow(event):
        if event["event"] == "comes":
            start(event["robot"])

    world = Lockstep(plan, Server(net, 7, KEY), follow, folder / "world.jsonl")
    for body in world.bodies.bodies:
        start(body.process)
    try:
        world.gather()
        world.play()
    finally:
        result = world.end()
        for each in threads:
            each.join(60)
    return opinions(steps_of(folder)), result, ended, net.seen
