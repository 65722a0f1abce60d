"""Lockstep: the world waits for all robots in each step, so that a field equals ``feasibee run``."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from feasibee.field.bodies import Body
from feasibee.field.checks import END, SAID, STEP
from feasibee.field.node import Status
from feasibee.field.world import World

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
