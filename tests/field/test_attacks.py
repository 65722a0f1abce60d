"""Whoever has no key changes nothing, though all packets pass through their hands."""

from __future__ import annotations

import itertools
import random

import pytest
from fields import a_plan, simulated, small
from nets import KEY, Net, Way, Wire, let_pass, play

from feasibee.field.checks import HELLO, REFUSED, WELCOME
from feasibee.field.connections import Client, Server
from feasibee.field.world import World

SCENARIO = small(3, steps=12, **{"run.stop_at_decision": False})


def expect_the_run(attack, folder):
    """Expect that a field under attack equals the run, and that no robot is lost; return its packets."""
    held, result, ended, seen = play(a_plan(SCENARIO, patience=10.0, wait=10.0), folder, attack)
    assert held == simulated(SCENARIO)[0]
    assert result["lost"] == []
    assert ended == dict.fromkeys(range(3), (0, ""))
    return seen


def reflect(*, up):
    """Send packets of one way on, and back to their sender, as if the other side had sent them."""

    def attack(packet, way):
        return [(packet, way), *([(packet, way._replace(up=not up))] if way.up == up else [])]

    return attack


def repeat(packet, way):
    return [(packet, way)] * 3


def cross(packet, way):
    """Send each packet on the wires of all robots."""
    return [(packet, way), *((packet, way._replace(peer=other)) for other in range(3))]


def redirect():
    """Send every tenth packet to the world from another address, and never from its own."""
    tenths = itertools.cycle([True, *[False] * 9])

    def attack(packet, way):
        return [(packet, Way(-1, True) if way.up and next(tenths) else way)]

    return attack


def damage():
    """Send three damaged copies before each packet: with a changed bit, cut, and longer."""
    generator = random.Random(1)

    def attack(packet, way):
        changed = bytearray(packet)
        changed[generator.randrange(len(packet))] ^= 1 << generator.randrange(8)
        cut = packet[: generator.randrange(len(packet))]
        return [(bytes(changed), way), (cut, way), (packet + b"0", way), (packet, way)]

    return attack


def recorded(seen, *, up):
    """Send all packets that went one way in an earlier field, before the first packet of each robot."""
    begun = set()

    def attack(packet, way):
        before = [] if way.peer in begun else [each for each in seen if each[1] == Way(way.peer, up)]
        begun.add(way.peer)
        return [*before, (packet, way)]

    return attack


ATTACKS = {
    "robots' packets sent back to them": lambda: reflect(up=True),
    "the world's packets sent back to it": lambda: reflect(up=False),
    "packets sent again": lambda: repeat,
    "packets of one robot sent to the others": lambda: cross,
    "packets from another address": redirect,
    "packets changed, cut and lengthened": damage,
}


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", ATTACKS)
def test_a_field_under_attack_equals_the_run(name, tmp_path):
    expect_the_run(ATTACKS[name](), tmp_path)


def test_a_field_equals_the_run_when_it_gets_the_packets_of_an_earlier_one(tmp_path):
    """A robot's first packet would take its number, and the world's last one would end a robot."""
    seen = expect_the_run(let_pass, tmp_path / "earlier")
    for up in (True, False):
        expect_the_run(recorded(seen, up=up), tmp_path / f"later, {up}")


def test_a_robot_has_one_number_and_one_connection(tmp_path):
    world = World(a_plan(SCENARIO), Server(Net(), 7, KEY), lambda event: None, tmp_path / "world.jsonl")

    def hello(client, robot, nonce):
        client._greet = lambda: (HELLO, {"robot": robot, "nonce": nonce})
        client.send(*client._greet())
        answers = []
        while world.server._link.up or world.server._link.down[client._link._peer]:
            world.receive(0.0)
            answers.append(client.receive(0.0))
        return [frame.kind for frame in answers if frame]

    first, again, other = (Client(Wire(world.server._link, name), KEY, None) for name in "abc")
    assert hello(first, 1, 5) == [WELCOME]
    assert hello(first, 1, 5) == [WELCOME]
    assert hello(first, 2, 5) == [REFUSED]
    assert hello(other, 1, 6) == [REFUSED]
    assert hello(other, 2, 6) == [WELCOME]
    assert hello(again, 1, 5) == [WELCOME]  # the same robot
    assert [peer for peer, _ in world.server._known] == ["c", "b"]
    world.log.close()
