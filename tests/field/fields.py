"""What tests of fields share: small scenarios, and fields of real processes."""

from __future__ import annotations

import json
import sys

import pytest

from feasibee import Scenario
from feasibee.field.plan import FieldPlan
from feasibee.field.supervisor import Field
from feasibee.reference import play

NEEDS_GROUPS = pytest.mark.skipif(
    sys.platform == "win32", reason="feasibee robot launch needs groups of processes"
)
MINE = """
def quality(robots_seen, tasks_seen):
    return 0.6
def dissemination(quality, gain):
    return gain * quality
def decide(mind, inbox):
    return 1 if inbox.chance < 0.5 else 0
"""
"""A user's strategy."""
STREAMS = {
    "tasks.arrival_rate": 0.1,
    "tasks.lifetime": 20.0,
    "robots.failure_rate": 0.05,
    "robots.arrival_rate": 0.2,
    "robots.most": 8,
    "decision.exploration": 3.0,
    "decision.gain": 3.0,
}
"""A world in which robots and tasks come and go."""
PUT = [
    {"step": 3, "tasks": 1, "at": [1.0, 4.0]},
    {"step": 4, "task": 1, "at": [2.0, 2.0]},
    {"step": 5, "robot": 2, "at": [3.0, 3.0]},
    {"step": 6, "robots": 1, "at": [6.0, 3.0]},
    {"step": 7, "task": 2},
    {"step": 9, "robot": 0},
]
"""Events that say where, and which robot or task."""


def small(robots=4, steps=40, **changes):
    arena = {"arena.side": 8.0, "robots.count": robots, "tasks.count": robots, "run.steps": steps}
    return Scenario().replace({**arena, **changes})


def a_plan(scenario, lockstep=True, **changes):
    usual = {"hz": 50.0, "drift": 0.0, "jitter": 0.0, "delay": 0.0, "faults": (), "patience": 20.0}
    return FieldPlan(scenario, 1, 0, lockstep, **{**usual, "wait": 60.0, **changes})


def run(plan, folder, follow=None, **options):
    """Run a field; return its result, its events and its world's log."""
    events = []

    def tell(event):
        events.append(event)
        if follow is not None:
            follow(event)

    folder.mkdir(exist_ok=True)
    result = Field(plan, folder, tell, **options).run()
    return result, events, steps_of(folder)


def steps_of(folder):
    lines = [json.loads(line) for line in (folder / "world.jsonl").read_text().splitlines()]
    return [line for line in lines if "minds" in line]


def change_line(log, at, **values):
    """Change values in a line of a log; the first line is number 1."""
    lines = log.read_text().splitlines()
    lines[at - 1] = json.dumps({**json.loads(lines[at - 1]), **values})
    log.write_text("\n".join(lines) + "\n")


def opinions(steps):
    return [[mind[0] for mind in step["minds"]] for step in steps]


def simulated(scenario):
    """Return the opinions of the reference at each step, and step and opinion of its decision."""
    found, decision = [], (-1, None)
    for step, swarm in enumerate(play(scenario, 1, 0)):
        found.append([robot.mind.opinion for robot in swarm.robots])
        if decision[1] is None and swarm.decision != -1:
            decision = (swarm.decision, step)
    return found, decision
