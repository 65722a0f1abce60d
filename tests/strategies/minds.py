"""Robots that pass on knowledge, one by one: what they see, count and declare, step by step."""

from __future__ import annotations

from feasibee import Scenario
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.runs import Runs
from feasibee.scenario.setting import setting_from
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Me, Thing


def knowing(
    name, counts=(20, 20), number=0, *, classes=(1, 1), liars=True, id_bits=None, kind=0, mark=0, step=0,
    place=(5.0, 5.0), **changes,
):  # fmt: skip
    """Return what a robot knows that explores; the changes are parameters, or numbers of the setting."""
    strategy = STRATEGIES[name]
    values = tuple(float(changes.pop(each, default)) for each, default in strategy.parameters.items())
    setting = setting_from(counts, classes, liars, id_bits, values, **changes)
    return Knowledge(strategy, Me(number, kind, mark, step, [0.0] * strategy.memory, setting, True, *place))


def task(number, x=5.0, y=5.0):
    """Return a task in sight at a place."""
    return Thing(False, number, 0, 77 * number, x, y)


def step(own, *things, explores=True):
    """Let a robot see things for a step; return its opinion."""
    own.observe(things)
    opinion = own.judge()
    own.end_step(explores=explores)
    return opinion


def counted(own):
    """Return how many robots and how many tasks a robot counts."""
    (robots,), (tasks,) = own.counted()
    return robots, tasks


def right_by_step(name, before, after, runs=20, robots=0, **changes):
    """Return whether each swarm is right at each step; tasks and robots change at step 500."""
    event = {"step": 500, "tasks": after - before, "robots": robots}
    scenario = Scenario(events=[event], tasks={"count": before}, run={"steps": 900})
    record = simulate_record(scenario.replace({"decision.strategy": name, **changes}), Runs(runs, 1))
    return record.held == record.truth


def declared(own, steps):
    """Let a robot pass so many steps; return what it declares in the last, or -1."""
    said = -1
    for _ in range(steps):
        said = own.declare()
        own.end_step(explores=True)
    return said
