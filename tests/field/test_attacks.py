"""Whoever has no key changes nothing, though all packets pass through their hands."""

from __future__ import annotations

import random

import pytest
from fields import a_plan, simulated, small
from wires import Way, play

SCENARIO = small(3, steps=12, **{"run.stop_at_decision": False})


def a_short_plan():
    return a_plan(SCENARIO, patience=10.0, wait=10.0)


def expect_the_run(attack, folder, **options):
    """Expect that a field under attack equals the run, and that no robot is lost; return its packets."""
    held, results, ended, seen = play(a_short_plan(), folder, attack, **options)
    assert held == simulated(SCENARIO)[0]
    assert [each["lost"] for each in results] == [[]]
    assert ended == dict.fromkeys(range(3), (0, ""))
    return seen


def let_pass(packet, way):
    return [(packet, way)]


def reflect(packet, way):
    """Send each packet on, and back to its sender as if from the other side."""
    return [(packet, way), (packet, way._replace(up=not way.up))]


def repeat(packet, way):
    return [(packet, way)] * 3


def cross(packet, way):
    """Send each packet on the wires of all robots."""
    return [(packet, way), *((packet, way._replace(robot=other)) for other in range(3))]


def redirect():
    """Send every tenth packet to the world from another address, and never from its own."""
    count = 0

    def attack(packet, way):
        nonlocal count
        count += way.up
        return [(packet, Way(-1, True) if way.up and count % 10 == 9 else way)]

    return attack


def damage():
    """Send three damaged copies before each packet: a changed bit, its beginning, and with more bytes."""
    generator = random.Random(1)

    def attack(packet, way):
        changed = bytearray(packet)
        changed[generator.randrange(len(packet))] ^= 1 << generator.randrange(8)
        cut = packet[: generator.randrange(len(packet))]
        return [(bytes(changed), way), (cut, way), (packet + b"0", way), (packet, way)]

    return attack


def recorded(seen):
    """Send all packets of an earlier field before the first one on each way, to the world and to robots."""
    begun = set()

    def attack(packet, way):
        before = [] if way.robot in begun else [each for each in seen if each[1].robot == way.robot]
        begun.add(way.robot)
        return [*before, (packet, way)]

    return attack


ATTACKS = {
    "packets sent back to their sender": reflect,
    "packets sent again": repeat,
    "packets of one robot sent to the others": cross,
    "packets from another address": redirect(),
    "packets changed and cut": damage(),
}


@pytest.mark.parametrize("name", ATTACKS)
def test_a_field_under_attack_equals_the_run(name, tmp_path):
    expect_the_run(ATTACKS[name], tmp_path)


def test_packets_of_an_earlier_field_take_no_robots_number_and_end_no_robot(tmp_path):
    seen = expect_the_run(let_pass, tmp_path / "earlier")
    expect_the_run(recorded(seen), tmp_path / "later")
