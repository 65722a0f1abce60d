"""Packets that are malformed, of others, old or not signed are dropped and counted; nothing crashes."""

from __future__ import annotations

import json
import random

import pytest
from fields import a_plan, small

from feasibee.field.bodies import Bodies
from feasibee.field.checks import END, HEARD, HELLO, SAID, SIGHT, STEP, TICK
from feasibee.field.frames import HEADER, LARGEST, Frames
from feasibee.field.node import Node
from feasibee.field.robot import Robot
from feasibee.field.world import World

STATUS = [0, False, -1, False, 1, 1, None]
BODIES = {
    HELLO: {"nonce": 5},
    SAID: {"t": 0, "said": None, "was": STATUS},
    TICK: {"t": 3, "said": "012873308d6db5b8", "was": STATUS},
    STEP: {"t": 1, "place": [1.0, 2.0], "see": [[0, 1, 0, 7, 1.0, 2.0, 1]]},
    END: {"t": 1, "heard": [[1, "00"]]},
    SIGHT: {"place": [1.0, 2.0], "see": []},
    HEARD: {"heard": [1, "00"]},
}


class Loopback:
    """A link whose packets are given by hand."""

    address = "127.0.0.1:1"

    def __init__(self):
        self.waiting, self.sent = [], []

    def send(self, packet, peer=None):
        self.sent.append(packet)

    def receive(self, timeout):
        return (self.waiting.pop(0), "peer") if self.waiting else None

    def close(self):
        pass


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("key", [b"", b"a key"])
def test_a_packet_is_read_as_it_was_written(kind, key):
    session = 0 if kind == HELLO else 7
    frame = Frames(7, key).read(Frames(session, key).write(kind, 3, BODIES[kind]))
    assert (frame.kind, frame.robot, frame.body) == (kind, 3, BODIES[kind])


def test_a_packet_is_accepted_once_and_only_with_key_and_session():
    packet = Frames(7, b"a key").write(SAID, 3, BODIES[SAID])
    reader = Frames(7, b"a key")
    assert reader.read(packet) is not None
    for other, why in (
        (packet, "old"),
        (Frames(7, b"another key").write(SAID, 3, BODIES[SAID]), "not signed with the key"),
        (Frames(8, b"a key").write(SAID, 3, BODIES[SAID]), "of another session"),
        (b"", "malformed"),
        (packet[:20], "malformed"),
    ):
        assert reader.read(other) is None
        assert reader.dropped[why] >= 1


def test_no_changed_bit_passes_the_signature():
    packet = Frames(7, b"a key").write(TICK, 3, BODIES[TICK])
    reader = Frames(7, b"a key")
    for bit in range(8 * len(packet)):
        changed = bytearray(packet)
        changed[bit // 8] ^= 1 << bit % 8
        assert reader.read(bytes(changed)) is None
    assert sum(reader.dropped.values()) == 8 * len(packet)


def test_a_packet_that_is_too_large_is_an_error():
    with pytest.raises(ValueError, match="at most 60,000 fit"):
        Frames(7).write(TICK, 3, {"said": "0" * LARGEST})


def mutated(generator, packet):
    """Return a packet with some bytes changed, cut or repeated, or with another value in its JSON."""
    if generator.random() < 0.5:
        head, body = packet[: HEADER.size], json.loads(packet[HEADER.size :])
        name = generator.choice(list(body))
        values = [None, True, -1, 2**70, 1e308, "x", [], {}, [[]], [1], "0" * 9, [[0, 9, 9, 9, 0.0, 0.0, 0]]]
        body[name] = generator.choice(values)
        if generator.random() < 0.2:
            del body[name]
        return head + json.dumps(body).encode()
    data = bytearray(packet)
    for _ in range(generator.randrange(1, 6)):
        data[generator.randrange(len(data))] = generator.randrange(256)
    return bytes(data[: generator.randrange(len(data) + 1)] if generator.random() < 0.3 else data)


def test_the_world_survives_any_packet(tmp_path):
    link, generator = Loopback(), random.Random(1)
    world = World(a_plan(small()), link, Frames(7), lambda event: None, tmp_path / "world.jsonl")
    robots = Frames(7)
    for _ in range(5_000):
        kind = generator.choice(list(BODIES))
        packet = (Frames(0) if kind == HELLO else robots).write(kind, generator.randrange(5), BODIES[kind])
        link.waiting.append(mutated(generator, packet))
        world.receive(0.0)
        world.frames._last.clear()
    assert world.frames.dropped["malformed"] > 1_000
    world.log.close()


def test_a_robot_survives_any_packet():
    link, generator = Loopback(), random.Random(2)
    robot = Robot(link, Frames(7), 1)
    bodies = Bodies(small(), 1, 0)
    orders = json.loads(json.dumps(bodies.orders(bodies.bodies[1])))
    robot._node = Node(orders)
    robot._ready = {"t": 0, "said": None, "was": STATUS}
    robot._see, robot._heard, robot._insight, robot._has_begun = [], [], None, False
    world = Frames(7)
    for step in range(1, 5_000):
        kind = generator.choice([STEP, END, SIGHT, HEARD])
        packet = world.write(kind, 1, BODIES[kind] | ({"t": step} if kind in (STEP, END) else {}))
        link.waiting.append(mutated(generator, packet) if generator.random() < 0.8 else packet)
        robot._answers = {(step - 1, True): robot._ready}  # whatever step or number a changed packet had
        robot._frames._last.clear()
        frame = robot._receive(0.0)
        if frame is not None and frame.kind in (STEP, END):
            robot._obey(frame)
        elif frame is not None:
            robot._take(frame)
    assert robot._frames.dropped["malformed"] > 500
    assert robot._node.dropped["malformed message"] > 10
