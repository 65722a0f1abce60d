"""Viewers of a field: they change nothing, their packets are checked, and there are at most ten."""

from __future__ import annotations

import random
import threading

import pytest
from fields import STREAMS, a_plan, opinions, run, simulated, small, steps_of
from nets import Net, Pair, Wire, joined
from test_frames import mutated

from feasibee.field.checks import REFUSED, SCENE, STATE, VIEW
from feasibee.field.connections import Client, Server
from feasibee.field.links import Link, split_address
from feasibee.field.supervisor import Field, Network
from feasibee.field.viewers import VIEWERS_LIMIT, scene_of, view_of
from feasibee.field.world import World


@pytest.fixture
def world(tmp_path):
    world = World(a_plan(small()), Server(Net(), 7), lambda event: None, tmp_path / "world.jsonl")
    yield world
    world.log.close()


class Hand:
    """A viewer whose packets are written by hand."""

    def __init__(self, world, peer="viewer"):
        self.world, self.net = world, world.server._link
        self._asked = VIEW, {"has": False}
        self.client = Client(Wire(self.net, peer), b"", lambda: self._asked)

    def ask(self, has=False):
        """Send a packet; return kind and body of the answers."""
        self._asked = VIEW, {"has": has}
        self.client.send(*self._asked)
        return self.answers()

    def answers(self):
        """Let both sides read what is there; return kind and body of what came."""
        read = []
        while self.net.up or self.net.down[self.client._link._peer]:
            assert self.world.receive(0.0) is None
            read.append(self.client.receive(0.0))
        return [(frame.kind, frame.body) for frame in read if frame]


def places(world):
    return [body.state() for body in world.bodies.bodies]


def test_a_viewer_gets_the_scene_and_then_each_step(world):
    viewer = Hand(world)
    [(kind, scene)] = viewer.ask()
    assert kind == SCENE
    assert len(scene["tasks"]) == 4
    world.look(0)
    [(kind, view)] = viewer.answers()
    assert (kind, view["t"], view["end"], view["opinions"]) == (STATE, 0, False, [-1] * 4)
    world.end()
    assert viewer.answers()[-1][1]["end"]


def test_ten_viewers_are_the_limit_and_hasty_ones_are_not_answered(world):
    for k in range(VIEWERS_LIMIT):
        viewer = Hand(world, f"viewer {k}")
        assert [kind for kind, _ in viewer.ask()] == [SCENE]
    assert viewer.ask() == []
    assert world.server.dropped["of a hasty viewer"] == 1
    [(kind, body)] = Hand(world, "one more").ask()
    assert kind == REFUSED
    assert "10 viewers" in body["why"]


def test_a_viewer_that_is_silent_gets_no_more(world, monkeypatch):
    viewer = Hand(world)
    viewer.ask()
    monkeypatch.setattr("feasibee.field.viewers.KEPT", 0.0)
    world.look(0)
    assert viewer.answers() == []


def test_a_viewer_of_the_process_before_gets_the_steps_that_it_lacks(world):
    for step in (0, 1, 2):
        world.look(step)
    assert [view["t"] for _, view in Hand(world).ask(has=True)] == [0, 1, 2]
    assert [kind for kind, _ in Hand(world, "late").ask()] == [SCENE]


def test_a_world_keeps_its_first_steps_for_a_short_time(world, monkeypatch):
    monkeypatch.setattr("feasibee.field.viewers.KEPT", 0.0)
    for step in (0, 1, 2):
        world.look(step)
    assert [kind for kind, _ in Hand(world).ask(has=True)] == [SCENE]


def test_any_packet_of_a_viewer_or_to_one_is_survived(world):
    generator = random.Random(3)
    pair = Pair()
    pair.net, pair.server = world.server._link, world.server
    pair.client = Client(Wire(pair.net, "peer"), b"", lambda: (VIEW, {"has": False}))
    joined(pair)
    up = {VIEW: {"has": True}}
    down = {SCENE: scene_of(world), STATE: view_of(world, 3, places(world))}
    found = set()
    for _ in range(4_000):
        kind = generator.choice([VIEW, SCENE, STATE])
        for channel in (pair.channel, pair.client._channels[0]):
            channel._newest = -1
        if kind == VIEW:
            pair.net.up.append((mutated(generator, pair.client._channels[0].write(kind, up[kind])), "peer"))
            world.receive(0.0)
        else:
            pair.net.down["peer"].clear()
            pair.net.down["peer"].append(mutated(generator, pair.channel.write(kind, down[kind])))
            frame = pair.client.receive(0.0)
            found |= {frame.kind} if frame else set()
    assert world.server.dropped["malformed"] > 300
    assert pair.client.dropped["malformed"] > 1_000
    assert found >= {SCENE, STATE}


@pytest.mark.parametrize("world", [{}, STREAMS])
def test_a_field_that_is_watched_decides_to_the_bit_as_one_that_is_not(world, tmp_path):
    scenario = small(8, steps=100, **{"run.stop_at_decision": False, **world})
    steps, threads = [], []

    def watch(address):
        link = Link(*split_address(address), listens=False)
        client = Client(link, b"a key", lambda: (VIEW, {"has": bool(steps)}))
        for k in range(2_000):
            client.send(VIEW, {"has": bool(steps)})
            link.send(b"malformed" * (k % 5))
            frame = client.receive(0.02)
            if frame and frame.kind == STATE:
                steps.append(frame.body)
                if frame.body["end"]:
                    break
        link.close()

    def tell(event):
        if event["event"] == "listening":
            threads.append(threading.Thread(target=watch, args=(event["address"],)))
            threads[-1].start()

    watched, alone = tmp_path / "watched", tmp_path / "alone"
    watched.mkdir()
    Field(a_plan(scenario), Network(key="a key"), watched, tell).run()
    for each in threads:
        each.join(30)
    expected = simulated(scenario)[0]
    run(a_plan(scenario), alone)
    assert steps_of(watched) == steps_of(alone)  # with places, phases and messages
    assert opinions(steps_of(watched)) == expected
    assert len(steps) > 30
    assert steps[-1]["end"]
    assert all(each["opinions"] == expected[each["t"]] for each in steps)
