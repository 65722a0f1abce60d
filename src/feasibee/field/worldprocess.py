"""The process of the world: its plan comes on standard input, its events go to standard output."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from feasibee.errors import FeasibeeError
from feasibee.field.connections import Server
from feasibee.field.faults import fault_from
from feasibee.field.free import FreeRunning
from feasibee.field.links import open_link
from feasibee.field.lockstep import Lockstep
from feasibee.field.plan import Plan
from feasibee.field.robot import KEY_VARIABLE
from feasibee.field.world import World, print_event
from feasibee.scenario.scenario import Scenario


def main() -> None:
    """Run the world of one field; report its result or its error as an event."""
    order = json.loads(sys.stdin.readline())
    try:
        print_event({"event": "result", **_run(order)})
    except BrokenPipeError:  # the field is gone
        os._exit(1)
    except FeasibeeError as error:
        print_event({"event": "error", "why": str(error)})
        sys.exit(2)


def _run(order: Mapping[str, Any]) -> dict[str, Any]:
    """Play the field of an order; return its result."""
    plan = plan_from(order["plan"])
    link = open_link(order["transport"], order["host"], order["port"], listens=True)
    try:
        server = Server(link, order["session"], os.environ.get(KEY_VARIABLE, "").encode())
        log, resumes = Path(order["log"]), order["resumes"]
        world = World(plan, server, print_event, log, resumes, _wait_for_go)
        robots = [body.process for body in world.bodies.bodies]
        print_event({"event": "listening", "address": link.address, "robots": robots})
        if not resumes:
            world.gather()
        (Lockstep(world) if plan.lockstep else FreeRunning(world)).play()
        return world.end()
    finally:
        link.close()


def _wait_for_go() -> None:
    """Wait until the field has caused a fault of processes."""
    sys.stdin.readline()


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
