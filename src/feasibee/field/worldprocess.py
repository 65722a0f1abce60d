"""The process of the world, in lockstep or with robots that step by their own clocks.

Its plan comes on standard input, its events go to standard output.
"""

from __future__ import annotations

import heapq
import itertools
import os
import shutil
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from threading import Semaphore
from typing import Any

from feasibee.errors import FeasibeeError
from feasibee.field.bodies import Body
from feasibee.field.checks import END, HEARD, SAID, SIGHT, STEP, TICK
from feasibee.field.connections import Frame, Link, Server
from feasibee.field.node import Status
from feasibee.field.plan import plan_from
from feasibee.field.robot import KEY_VARIABLE, follow_parent, read_order
from feasibee.field.world import World, print_event

RESEND = 0.1
"""Seconds after which an order without an answer is sent again; loopback loses packets under load."""


class Lockstep:
    """The steps of a field in lockstep.

    In each step there are two exchanges. A robot begins the step with what it sees, and says its message. It
    ends the step with the messages that it heard, and reports its opinion.

    Parameters
    ----------
    world : World
        The world; its robots have joined.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._bodies = world.bodies
        self._begun = [body for body in self._bodies.bodies if world.step and body.works(world.step)]
        self._air: dict[int, list[tuple[Body, str]]] = {}

    def play(self) -> None:
        """Play all steps from the present one, which ends once more if the world has started again."""
        world = self._world
        while True:
            self._end()
            world.look(world.step)
            if world.is_over or world.step == world.plan.scenario.run.steps:
                return
            self._begin()

    def _begin(self) -> None:
        """Begin the next step: let the world change, move the bodies, and let each robot see and speak."""
        world, bodies = self._world, self._bodies
        world.step += 1
        world.cause_faults()
        world.change(waits=True)
        self._begun = [body for body in bodies.bodies if body.works(world.step)]
        bodies.advance(self._begun)
        world.said = self._ask(STEP, {body.process: bodies.sight_of(body) for body in self._begun})

    def _end(self) -> None:
        """End the step with its messages, or delayed ones; the robots report their opinions."""
        world = self._world
        delayed = self._air.setdefault(world.step + round(world.plan.delay), [])
        everyone = self._bodies.everyone
        delayed.extend(
            (everyone[each], text) for each, text in sorted(world.said.items()) if text is not None
        )
        arriving = self._air.pop(world.step, [])
        orders = {}
        for receiver in self._begun:
            if not receiver.lost:
                heard = [[each.number, text] for each, text in arriving if world.reaches(each, receiver)]
                orders[receiver.process] = {"heard": heard}
        self._ask(END, orders)

    def _ask(self, kind: int, orders: Mapping[int, dict[str, Any]]) -> dict[int, str | None]:
        """Send each robot its order until it answers or is lost; return the messages."""
        world, everyone = self._world, self._bodies.everyone
        said: dict[int, str | None] = {}
        waiting = set(orders)
        began = now = time.monotonic()
        resent = -RESEND
        while waiting:
            if now - resent > RESEND:
                resent = now
                for number in sorted(waiting):
                    world.send(everyone[number], kind, {"t": world.step, **orders[number]})
            frame = world.receive(RESEND)
            now = time.monotonic()
            if frame is not None and frame.kind == SAID:
                order = frame.body["t"], frame.body.get("ends", False)
                if frame.robot in waiting and order == (world.step, kind == END):
                    everyone[frame.robot].remote.report(Status(*frame.body["was"]))
                    said[frame.robot] = frame.body["said"]
                    waiting.discard(frame.robot)
                elif frame.robot not in orders:
                    world.answer(everyone[frame.robot])
            if now - began > world.plan.patience:
                for number in sorted(waiting):
                    world.lose(everyone[number])
                waiting.clear()
        return said


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


PATIENCE = 2.0
"""Seconds in which standard input ends after standard output has been closed."""


def main() -> None:
    """Run the world of one field; report its result or its error as an event."""
    order = read_order()
    ready = Semaphore(0)

    def remove_log() -> None:
        if order["temporary"]:
            shutil.rmtree(Path(order["log"]).parent, ignore_errors=True)

    follower = follow_parent(sys.stdin.fileno(), lambda read: ready.release(read.count(b"\n")), remove_log)
    try:
        try:
            event, status = {"event": "result", **_run(order, ready)}, 0
        except FeasibeeError as error:
            event, status = {"event": "error", "why": str(error)}, 2
        print_event(event)
    except BrokenPipeError:  # the field has ended
        follower.join(PATIENCE)
        os._exit(1)
    sys.exit(status)


def _run(order: Mapping[str, Any], ready: Semaphore) -> dict[str, Any]:
    """Play the field of an order; return its result. ``ready`` is released after each fault of processes."""
    plan = plan_from(order["plan"])
    link = Link(order["host"], order["port"], listens=True)
    try:
        server = Server(link, order["session"], os.environ.get(KEY_VARIABLE, "").encode())
        log, resumes = Path(order["log"]), order["resumes"]
        world = World(plan, server, print_event, log, resumes, ready.acquire)
        robots = [body.process for body in world.bodies.bodies]
        print_event({"event": "listening", "address": link.address, "robots": robots})
        if not resumes:
            world.gather()
        (Lockstep(world) if plan.lockstep else FreeRunning(world)).play()
        return world.end()
    finally:
        link.close()


if __name__ == "__main__":
    main()
