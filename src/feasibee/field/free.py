"""Free running: each robot steps by its own clock, and the world answers as their packets come."""

from __future__ import annotations

import heapq
import itertools
import time
from statistics import median

from feasibee.field.bodies import Body
from feasibee.field.checks import HEARD, SAID, SIGHT, TICK
from feasibee.field.frames import Frame
from feasibee.field.node import Status
from feasibee.field.world import World

AIR_LIMIT = 100_000
"""Largest number of messages under way; more are dropped."""


class FreeRunning:
    """A field whose robots have clocks of their own.

    A robot's packet moves its body by one step; the other bodies stand meanwhile. Its message reaches the
    robots in range at this moment, after the delay.

    Parameters
    ----------
    world : World
        The world; its robots have joined.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._bodies = world.bodies
        now = self._passed_at = time.monotonic()
        self._ticks = {body.process: world.step for body in world.bodies.bodies}
        self._seen_at = {body.process: now for body in world.bodies.bodies}
        self._air: list[tuple[float, int, int, list[object]]] = []
        self._order = itertools.count()

    def play(self) -> None:
        """Play until the robots have done all steps, by the median of their clocks."""
        world = self._world
        if world.step == 0:
            world.look(0)
            for body in self._bodies.bodies:
                self._show(body)
        while world.step < world.plan.scenario.run.steps and not world.is_over:
            frame = world.receive(self._time_to_wait())
            if frame is not None:
                self._take(frame)
            self._deliver()
            self._lose_silent()
            self._pass_steps()

    def _time_to_wait(self) -> float:
        """Return the seconds until a message arrives, at most a step."""
        longest = 1.0 / self._world.plan.hz
        if not self._air:
            return longest
        return min(longest, max(0.0, self._air[0][0] - time.monotonic()))

    def _take(self, frame: Frame) -> None:
        """Simulate a robot's step: move its body, pass its message on, send it what it sees."""
        world, body, step = self._world, self._world.body(frame), frame.body["t"]
        self._seen_at[body.process] = time.monotonic()
        if body.lost:
            world.find(body)
        if frame.kind == SAID:  # it waits for the start
            self._show(body)
            return
        if frame.kind != TICK or step <= self._ticks.get(body.process, 0):
            return
        self._ticks[body.process] = self._bodies.time = step
        body.remote.report(Status(*frame.body["was"]))
        if body.works(step):
            self._bodies.advance([body])
            self._send_around(body, frame.body["said"])
        self._show(body)

    def _send_around(self, sender: Body, text: str | None) -> None:
        """Send a message on its way to all robots in range."""
        world = self._world
        world.said[sender.process] = text
        if text is None:
            return
        arrives = time.monotonic() + world.plan.delay / world.plan.hz
        for receiver in self._bodies.bodies:
            if receiver.works(self._bodies.time) and world.reaches(sender, receiver):
                if len(self._air) >= AIR_LIMIT:
                    world.server.dropped["too many messages"] += 1
                    return
                heard: list[object] = [sender.number, text]
                heapq.heappush(self._air, (arrives, next(self._order), receiver.process, heard))

    def _deliver(self) -> None:
        """Deliver the messages whose time has come."""
        now = time.monotonic()
        while self._air and self._air[0][0] <= now:
            _, _, number, heard = heapq.heappop(self._air)
            receiver = self._bodies.everyone[number]
            if not receiver.has_left:
                self._world.send(receiver, HEARD, {"heard": heard})

    def _show(self, body: Body) -> None:
        """Send a robot its place and what it sees."""
        self._world.send(body, SIGHT, self._bodies.sight_of(body))

    def _lose_silent(self) -> None:
        """Count the robots no longer that have been silent for too long."""
        now = time.monotonic()
        for body in self._bodies.bodies:
            if not body.lost and now - self._seen_at[body.process] > self._world.plan.patience:
                self._world.lose(body)

    def _pass_steps(self) -> None:
        """Advance to the median of the robots' clocks."""
        world = self._world
        now = self._median_step()
        while world.step < now and not world.is_over:
            self._passed_at = time.monotonic()
            world.step += 1
            world.cause_faults()
            for body in world.change(waits=False).joined:
                self._seen_at[body.process] = self._passed_at
            world.look(world.step)

    def _median_step(self) -> int:
        """Return the median of the robots' clocks; without any, that of the world until a robot comes."""
        world = self._world
        numbers = [body.process for body in self._bodies.bodies if not body.lost]
        ticks = [self._ticks[number] for number in numbers if number in self._ticks]
        last = world.plan.scenario.run.steps
        if ticks:
            return min(int(median(ticks)), last)
        if not world.plan.scenario.dynamic:
            return last
        return world.step + (time.monotonic() - self._passed_at >= 1.0 / world.plan.hz)
