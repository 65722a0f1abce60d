"""Viewers of a field: they change nothing, their packets are checked, and there are at most ten."""

from __future__ import annotations

import random
import threading

import pytest
from fields import STREAMS, a_plan, opinions, run, simulated, small, steps_of
from test_frames import STATUS, Loopback, mutated

from feasibee.field.addresses import split_address
from feasibee.field.checks import REFUSED, SAID, SCENE, STATE, VIEW
from feasibee.field.frames import Frames
from feasibee.field.links import open_link
from feasibee.field.supervisor import Field, Network
from feasibee.field.viewers import VIEWERS_LIMIT, scene_of, view_of
from feasibee.field.world import World


@pytest.fixture
def world(tmp_path):
    link = Loopback()
    world = World(a_plan(small()), link, Frames(7), lambda event: None, tmp_path / "world.jsonl")
    yield world
    world.log.close()


class Hand:
    """A viewer whose packets are written by hand."""

    def __init__(self, world, peer="viewer"):
        self.world, self.peer = world, peer
        self.frames, self.reader = Frames(0), Frames(0)

    def ask(self, **body):
        """Send a packet; return kind and body of the answers."""
        self.world.link.sent.clear()
        packet = self.frames.write(VIEW, 3, {"nonce": 5, "has": False, **body})
        self.world.link.receive = lambda timeout: (packet, self.peer)
        assert self.world.receive(0.0) is None
        return self.answers()

    def answers(self):
        read = [self.reader.read(packet) for packet in self.world.link.sent]
        return [(frame.kind, frame.body) for frame in read if frame]


def places(world):
    return [body.state() for body in world.bodies.bodies]


def test_a_viewer_names_the_session_before_it_gets_more_than_that(world):
    viewer = Hand(world)
    assert viewer.ask() == [(VIEW, {"nonce": 5, "session": 7})]
    viewer.frames.session = 7
    [(kind, scene)] = viewer.ask()
    assert kind == SCENE
    assert scene["nonce"] == 5
    assert len(scene["tasks"]) == 4
    world.link.sent.clear()
    world.look(0)
    [(kind, view)] = viewer.answers()
    assert (kind, view["t"], view["end"], view["opinions"]) == (STATE, 0, False, [-1] * 4)
    world.link.sent.clear()
    world.end()
    assert viewer.answers()[-1][1]["end"]


def test_ten_viewers_are_the_limit_and_hasty_ones_are_not_answered(world):
    for k in range(VIEWERS_LIMIT):
        viewer = Hand(world, f"viewer {k}")
        viewer.frames.session = 7
        assert [kind for kind, _ in viewer.ask()] == [SCENE]
    assert viewer.ask() == []
    assert world.frames.dropped["of a hasty viewer"] == 1
    late = Hand(world, "one more")
    late.frames.session = 7
    [(kind, body)] = late.ask()
    assert kind == REFUSED
    assert "10 viewers" in body["why"]


def test_a_viewer_that_is_silent_gets_no_more(world, monkeypatch):
    viewer = Hand(world)
    viewer.frames.session = 7
    viewer.ask()
    monkeypatch.setattr("feasibee.field.viewers.KEPT", 0.0)
    world.link.sent.clear()
    world.look(0)
    assert world.link.sent == []


def test_a_viewer_of_the_process_before_gets_the_steps_that_it_lacks(world):
    viewer = Hand(world)
    viewer.frames.session = 7
    for step in (0, 1, 2):
        world.look(step)
    assert [view["t"] for _, view in viewer.ask(has=True)] == [0, 1, 2]
    late = Hand(world, "late")
    late.frames.session = 7
    assert [kind for kind, _ in late.ask()] == [SCENE]


def test_a_world_keeps_its_first_steps_for_a_short_time(world, monkeypatch):
    monkeypatch.setattr("feasibee.field.viewers.KEPT", 0.0)
    viewer = Hand(world)
    viewer.frames.session = 7
    for step in (0, 1, 2):
        world.look(step)
    assert [kind for kind, _ in viewer.ask(has=True)] == [SCENE]


def test_a_viewer_takes_no_robots_place(world):
    viewer = Hand(world)
    viewer.frames.session = 7
    viewer.ask()
    said = Frames(7).write(SAID, 3, {"t": 0, "said": None, "was": STATUS})
    world.link.receive = lambda timeout: (said, "robot")
    assert world.receive(0.0).robot == 3
    assert world._peers == {3: "robot"}


def test_any_packet_of_a_viewer_or_to_one_is_survived(world):
    generator = random.Random(3)
    said = {"nonce": 5, **scene_of(world)}
    bodies = {VIEW: {"nonce": 5, "has": True}, SCENE: said, STATE: view_of(world, 3, places(world))}
    reader, found = Frames(7), set()
    for _ in range(4_000):
        kind = generator.choice(list(bodies))
        packet = mutated(generator, Frames(7).write(kind, generator.randrange(5), bodies[kind]))
        for frames in (world.frames, reader):
            frames._last.clear()
        frame = reader.read(packet)
        found |= {frame.kind} if frame else set()
        if kind == VIEW:
            world.link.receive = lambda timeout, packet=packet: (packet, generator.random())
            world.receive(0.0)
    assert world.frames.dropped["malformed"] > 300
    assert reader.dropped["malformed"] > 1_000
    assert found >= {VIEW, SCENE, STATE}


@pytest.mark.parametrize("world", [{}, STREAMS])
def test_a_field_that_is_watched_decides_to_the_bit_as_one_that_is_not(world, tmp_path):
    scenario = small(8, steps=100, **{"run.stop_at_decision": False, **world})
    steps, threads = [], []

    def watch(address):
        link, frames = open_link("udp", *split_address(address), listens=False), Frames(0, b"a key")
        for k in range(2_000):
            link.send(frames.write(VIEW, 3, {"nonce": 5, "has": bool(steps)}))
            link.send(b"malformed" * (k % 5))
            received = link.receive(0.02)
            frame = frames.read(received[0]) if received else None
            if frame and frame.kind == VIEW:
                frames.session = frame.body["session"]
            elif frame and frame.kind == STATE:
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
