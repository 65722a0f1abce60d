"""A field in one process, whose packets pass an attacker that has no key."""

from __future__ import annotations

import select
import socket
import time
from contextlib import closing
from threading import Event, Thread
from typing import NamedTuple

from fields import opinions, steps_of

from feasibee.field.connections import Link, Server
from feasibee.field.robot import take_part
from feasibee.field.world import World
from feasibee.field.worldprocess import Lockstep

KEY = b"sixteen or more characters"


class Way(NamedTuple):
    """Where a packet goes: up to the world or down, on the wire of which robot; -1 is the attacker's own."""

    robot: int
    up: bool


class Attacker:
    """Reads all packets between robots and their world, and sends any bytes from any of their addresses.

    ``attack`` takes a packet and its way, and returns the packets to send instead, each with its way.
    """

    def __init__(self, world, robots, attack):
        self._attack, self._ended = attack, Event()
        self.seen = []
        self._fronts = [self._bound() for _ in range(robots)]
        self._backs = [self._bound() for _ in range(robots + 1)]
        for back in self._backs:
            back.connect(world)
        self._robots = [None] * robots
        self._thread = Thread(target=self._run)

    @staticmethod
    def _bound():
        end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        end.bind(("127.0.0.1", 0))
        return end

    def __enter__(self):
        self._thread.start()
        return ["{}:{}".format(*front.getsockname()) for front in self._fronts]

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join()
        for each in (*self._fronts, *self._backs):
            each.close()

    def _run(self):
        while not self._ended.is_set():
            for end in select.select([*self._fronts, *self._backs], [], [], 0.05)[0]:
                try:
                    packet, sender = end.recvfrom(65_536)
                except OSError:  # an earlier packet found nobody
                    continue
                if end in self._fronts:
                    way = Way(self._fronts.index(end), True)
                    self._robots[way.robot] = sender
                else:
                    robot = self._backs.index(end)
                    way = Way(robot if robot < len(self._fronts) else -1, False)
                self.seen.append((packet, way))
                if way.robot >= 0:
                    for each, where in self._attack(packet, way):
                        self._send(each, where)

    def _send(self, packet, way):
        try:
            if way.up:
                self._backs[way.robot].send(packet)
            elif self._robots[way.robot] is not None:
                self._fronts[way.robot].sendto(packet, self._robots[way.robot])
        except OSError:
            return


def play(plan, folder, attack, robots=3, key=KEY, robots_first=False):
    """Run a field under an attack; the world may begin before the robots or after they have asked for it.

    Return the opinions at each step, the world's result, how the robots ended, and the packets.
    """
    folder.mkdir(exist_ok=True)
    link = Link("127.0.0.1", 0, listens=True)
    host, port = link.address.split(":")
    found, ended = [], {}

    def be_the_world():
        while robots_first and len({way.robot for _, way in attacker.seen}) < robots:
            time.sleep(0.01)
        with closing(link):
            world = World(plan, Server(link, 7, key), lambda event: None, folder / "world.jsonl")
            try:
                world.gather()
                Lockstep(world).play()
            finally:
                found.append(world.end())

    def be_a_robot(number, address):
        ended[number] = take_part(address, number, key=key, patience=10.0)

    attacker = Attacker((host, int(port)), robots, attack)
    with attacker as addresses:
        threads = [Thread(target=be_the_world)]
        threads += [Thread(target=be_a_robot, args=each) for each in enumerate(addresses)]
        for each in threads:
            each.start()
        for each in threads:
            each.join(60)
    return opinions(steps_of(folder)), found, ended, attacker.seen
