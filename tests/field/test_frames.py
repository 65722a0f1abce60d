"""Packets that say what can't be are dropped and counted; nothing crashes."""

from __future__ import annotations

import json
import random
import socket

import pytest
from commands import refused_in_a_line
from fields import a_plan, small
from nets import Pair, joined

from feasibee.field.bodies import Bodies
from feasibee.field.checks import END, HEARD, HELLO, SAID, SIGHT, STEP, TICK
from feasibee.field.connections import HEADER
from feasibee.field.node import Node
from feasibee.field.robot import Robot
from feasibee.field.world import World

STATUS = [0, -1, False, 1, 1, None]
BODIES = {
    HELLO: {"robot": 3, "nonce": 5},
    SAID: {"t": 0, "said": None, "was": STATUS, "ends": False},
    TICK: {"t": 3, "said": "012873308d6db5b8", "was": STATUS},
    STEP: {"t": 1, "place": [1.0, 2.0], "see": [[0, 1, 0, 7, 1.0, 2.0, 1]]},
    END: {"t": 1, "heard": [[1, "00"]]},
    SIGHT: {"place": [1.0, 2.0], "see": []},
    HEARD: {"heard": [1, "00"]},
}


def mutated(generator, packet):
    """Return a packet with some bytes changed, cut or repeated, or with another value in its JSON."""
    if generator.random() < 0.5:
        head, body = packet[: HEADER.size + 1], json.loads(packet[HEADER.size + 1 :])
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


@pytest.fixture
def pair():
    pair = Pair()
    joined(pair)
    return pair


def test_the_world_survives_any_packet(pair, tmp_path):
    generator = random.Random(1)
    world = World(a_plan(small()), pair.server, lambda event: None, tmp_path / "world.jsonl")
    robot = pair.client._channels[0]
    for _ in range(5_000):
        kind = generator.choice(list(BODIES))
        pair.channel.robot = generator.randrange(-1, 4)
        pair.net.up.append((mutated(generator, robot.write(kind, BODIES[kind])), "peer"))
        world.receive(0.0)
        pair.channel._newest = -1
    assert pair.server.dropped["malformed"] > 1_000
    world.log.close()


def test_a_robot_survives_any_packet(pair):
    generator = random.Random(2)
    robot = Robot(pair.client._link, b"", 1)
    robot._client = pair.client
    bodies = Bodies(small(), 1, 0)
    orders = json.loads(json.dumps(bodies.orders(bodies.bodies[1])))
    robot._node = Node(orders)
    robot._ready = {"t": 0, "said": None, "was": STATUS}
    robot._see, robot._heard, robot._insight, robot._has_begun = [], [], None, False
    for step in range(1, 5_000):
        kind = generator.choice([STEP, END, SIGHT, HEARD])
        packet = pair.channel.write(kind, BODIES[kind] | ({"t": step} if kind in (STEP, END) else {}))
        packet = mutated(generator, packet) if generator.random() < 0.8 else packet
        pair.net.down["peer"].append((packet, "peer"))
        robot._answers = {(step - 1, True): robot._ready}  # whatever step or number a changed packet had
        pair.client._channels[0]._newest = -1
        frame = robot._client.receive(0.0)
        if frame is not None and frame.kind in (STEP, END):
            robot._obey(frame)
        elif frame is not None:
            robot._take(frame)
    assert pair.client.dropped["malformed"] > 500
    assert robot._node.dropped["malformed message"] > 10


def test_a_key_that_is_too_short_is_an_error(tmp_path, monkeypatch):
    file = tmp_path / "key.txt"
    file.write_text("secret\n")
    rule = "has 6 characters, must have at least 16; take that many random ones"
    said = refused_in_a_line("robot", "--connect", "127.0.0.1:9", "--id", "0", "--key-file", file)
    assert said == f"feasibee: --key-file {file}: {rule}"
    monkeypatch.setenv("FEASIBEE_FIELD_KEY", "secret")
    assert refused_in_a_line("launch") == f"feasibee: FEASIBEE_FIELD_KEY: {rule}"


def test_a_port_that_is_taken_is_an_error():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        host, port = other.getsockname()
        said = refused_in_a_line("launch", "--port", port)
    assert said.startswith(f"feasibee: {host}:{port}: can't listen on it: ")
    assert said.endswith("; use another port")
