"""Connections of a field: messages come in order, an end is known at once, and nobody blocks the world."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path

import pytest
from fields import NEEDS_GROUPS, a_plan, small

from feasibee.base.errors import FeasibeeError
from feasibee.field.connections import (
    DIED,
    HEARD,
    HELLO,
    REFUSED,
    SAID,
    WELCOME,
    Connections,
    connection_to,
    packed,
)
from feasibee.field.world import World

pytestmark = NEEDS_GROUPS


@pytest.fixture(params=["", "x" * 120], ids=["a socket", "localhost"])
def server(request, tmp_path):
    """Give a server, in a folder whose path is too long for a Unix socket if it has a long name."""
    folder = tmp_path / request.param
    folder.mkdir(exist_ok=True)
    with closing(Connections(folder)) as server:
        yield server


def next_of(source):
    """Return the next message that a server or a world takes; the time limit is that of the whole run."""
    while (frame := source.receive(1.0)) is None:
        pass
    return frame


def test_messages_come_in_order_and_the_end_of_a_robot_is_one(server):
    with connection_to(server.address) as robot:
        for step in range(3):
            robot.send_bytes(packed(SAID, {"t": step}))
        frames = [next_of(server) for _ in range(3)]
        assert [(each.kind, each.body) for each in frames] == [(SAID, {"t": step}) for step in range(3)]
        server.send(frames[0].channel, HEARD, {"heard": [1, "00"]})
        assert json.loads(robot.recv_bytes()) == [HEARD, {"heard": [1, "00"]}]
    assert next_of(server).kind == DIED
    server.send(frames[0].channel, HEARD, {"heard": [1, "00"]})


def test_a_robot_that_reads_nothing_does_not_block_the_world(server):
    with connection_to(server.address) as robot:
        robot.send_bytes(packed(SAID, {}))
        channel = next_of(server).channel
        for _ in range(5_000):
            server.send(channel, HEARD, {"heard": [1, "00" * 100]})


def test_another_key_or_a_world_that_has_ended_is_an_error(server):
    path = Path(server.address)
    assert path.stat().st_mode & 0o777 == 0o600
    path.write_text(json.dumps({**json.loads(path.read_text()), "key": "another"}))
    with pytest.raises(FeasibeeError, match="no world of a field is there"), connection_to(str(path)):
        pass


def test_a_number_has_one_robot(tmp_path):
    with closing(Connections(tmp_path)) as server:
        world = World(a_plan(small()), server, lambda event: None, tmp_path / "log.jsonl")
        kinds = []
        for number in (1, 1, 9):
            with connection_to(server.address) as robot:
                robot.send_bytes(packed(HELLO, {"robot": number}))
                while not robot.poll(0):
                    world.receive(0.2)
                kinds.append(json.loads(robot.recv_bytes())[0])
                world._is_complete = True
        world.log.close()
    assert kinds == [WELCOME, REFUSED, REFUSED]
