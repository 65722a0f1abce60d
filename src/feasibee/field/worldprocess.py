"""The process of the world: its plan comes on standard input, its events go to standard output."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from threading import Semaphore
from typing import Any

from feasibee.errors import FeasibeeError
from feasibee.field.connections import Server
from feasibee.field.faults import fault_from
from feasibee.field.free import FreeRunning
from feasibee.field.links import Link
from feasibee.field.lockstep import Lockstep
from feasibee.field.parent import follow_parent, read_order
from feasibee.field.plan import Plan
from feasibee.field.robot import KEY_VARIABLE
from feasibee.field.world import World, print_event
from feasibee.scenario.scenario import Scenario

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


def plan_from(plain: Mapping[str, Any]) -> Plan:
    """Return a plan from its plain form, as `plain_plan` makes it."""
    scenario = Scenario.from_toml(plain["scenario"])
    faults = tuple(fault_from(each) for each in plain["faults"])
    return Plan(**{**plain, "scenario": scenario, "faults": faults})


def plain_plan(plan: Plan) -> dict[str, Any]:
    """Return a plan as plain values."""
    faults = [fault._asdict() for fault in plan.faults]
    return {**plan._asdict(), "scenario": plan.scenario.to_toml(), "faults": faults}


if __name__ == "__main__":
    main()
