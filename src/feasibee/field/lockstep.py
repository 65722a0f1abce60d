"""Lockstep: the world waits for all robots in each step, so that a field equals ``feasibee run``."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from feasibee.field.bodies import Body
from feasibee.field.checks import SAID, STEP
from feasibee.field.node import Status
from feasibee.field.world import World

RESEND = 0.1
"""Seconds after which an order without an answer is sent again; loopback loses packets under load."""


class Lockstep:
    """The steps of a field in lockstep.

    In one exchange a robot ends the step before, with the messages heard in it, and begins the next one.

    Parameters
    ----------
    world : World
        The world; its robots have joined.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._bodies = world.bodies
        bodies = self._bodies.bodies
        self._begun = {body.number for body in bodies if world.step and body.works(world.step)}
        self._air: dict[int, list[tuple[Body, str]]] = {}

    def play(self) -> None:
        """Play all steps from the world's present one."""
        world = self._world
        last = world.plan.scenario.run.steps
        while not world.is_over and world.step <= last:
            self._step(ends=world.step == last)
        world.step = min(world.step, last)

    def _step(self, *, ends: bool) -> None:
        """End a step and begin the next one, if this wasn't the last."""
        world, bodies = self._world, self._bodies
        heard = self._heard()
        places = [body.state() for body in bodies.bodies]
        done = world.step
        world.step = bodies.time = done + 1
        if not ends:
            world.cause_faults()
        said = self._ask(self._orders(heard, ends=ends))
        world.look(done, places)
        world.said = said

    def _orders(self, heard: Mapping[int, list[list[Any]]], *, ends: bool) -> dict[int, dict[str, Any]]:
        """Move the bodies; return what each robot is sent."""
        bodies, step = self._bodies, self._world.step
        working = [] if ends else [body for body in bodies.bodies if body.works(step)]
        bodies.advance(working)
        orders = {}
        for body in bodies.bodies:
            if body in working:
                here: dict[str, Any] = {"place": bodies.place_of(body), "see": bodies.seen_by(body)}
            elif body.number in self._begun and not body.lost:
                here = {"end": True}
            else:
                continue
            orders[body.number] = {"t": step, "heard": heard[body.number], **here}
        self._begun = {body.number for body in working}
        return orders

    def _ask(self, orders: Mapping[int, dict[str, Any]]) -> dict[int, str | None]:
        """Send each robot its order until it answers or is lost; return the messages."""
        world, bodies = self._world, self._bodies.bodies
        said: dict[int, str | None] = {}
        waiting = set(orders)
        began = now = time.monotonic()
        resent = -RESEND
        while waiting:
            if now - resent > RESEND:
                resent = now
                for number in sorted(waiting):
                    world.send(bodies[number], STEP, orders[number])
            frame = world.receive(RESEND)
            now = time.monotonic()
            if frame is not None and frame.kind == SAID:
                body = world.body(frame)
                if frame.robot in waiting and frame.body["t"] == world.step:
                    body.remote.report(Status(*frame.body["was"]))
                    said[frame.robot] = frame.body["said"]
                    waiting.discard(frame.robot)
                elif frame.robot not in orders:
                    world.answer(body)
            if now - began > world.plan.patience:
                for number in sorted(waiting):
                    world.lose(bodies[number])
                waiting.clear()
        return said

    def _heard(self) -> dict[int, list[list[Any]]]:
        """Return what each robot hears in this step: messages of this one, or delayed ones."""
        world, bodies = self._world, self._bodies.bodies
        now = self._bodies.time = world.step
        delayed = self._air.setdefault(now + round(world.plan.delay), [])
        delayed.extend(
            (bodies[number], text) for number, text in sorted(world.said.items()) if text is not None
        )
        arriving = self._air.pop(now, [])
        return {
            receiver.number: [
                [sender.number, text] for sender, text in arriving if world.reaches(sender, receiver)
            ]
            for receiver in bodies
        }
