"""A field in lockstep in memory: its world and its robots talk without processes."""

from __future__ import annotations

import json
from collections import deque
from contextlib import ExitStack, closing
from pathlib import Path

from fields import opinions, steps_of

from feasibee.field.connections import BYE, END, HELLO, SAID, STEP, WELCOME, Channel, Frame
from feasibee.field.logs import LineLog
from feasibee.field.robot import Robot
from feasibee.field.world import Lockstep


class Net:
    """What robots answer at once; it is what `Server` is for a world."""

    def __init__(self, plan, folder, brain):
        self.frames = deque()
        self.ended = set()
        self.logs = ExitStack()
        self._robots = {}
        self._strategy = plan.scenario.strategy if plan.scenario.manifest.source else None
        self._folder, self._brain = folder, brain

    def hello(self, number):
        self.frames.append(Frame(HELLO, {"robot": number}, Channel(None)))

    def receive(self, timeout):
        return self.frames.popleft() if self.frames else None

    def send(self, channel, kind, body):
        body = json.loads(json.dumps(body))
        if kind == WELCOME and channel not in self._robots:
            log = LineLog(Path(self._folder) / f"robot-{channel.robot}.jsonl")
            self.logs.enter_context(closing(log))
            self._robots[channel] = Robot(body, log, self._strategy, self._brain)
            self.frames.append(Frame(SAID, self._robots[channel].ready, channel))
        elif kind in (STEP, END):
            said = json.loads(json.dumps(self._robots[channel].obey(kind, body)))
            self.frames.append(Frame(SAID, said, channel))
        elif kind == BYE:
            self.ended.add(channel.robot)


def play(plan, folder, brain=None):
    """Run a field in lockstep; its logs are in a folder. Return the opinions at each step, and the result."""
    folder.mkdir(exist_ok=True)
    net = Net(plan, folder, brain)

    def follow(event):
        if event["event"] == "comes":
            net.hello(event["robot"])

    with net.logs:
        world = Lockstep(plan, net, follow, folder / "world.jsonl")
        for body in world.bodies.bodies:
            net.hello(body.process)
        world.gather()
        world.play()
        result = world.end()
    assert net.ended >= {body.process for body in world.bodies.everyone}
    return opinions(steps_of(folder)), result
