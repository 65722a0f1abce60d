"""Strategies of users, and how they are run in both implementations, for tests."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from feasibee import FeasibeeError, reference
from feasibee.robot.controller import Controller, Settings
from feasibee.scenario.plugins import load
from feasibee.scenario.runs import Runs
from feasibee.scenario.setting import setting_from
from feasibee.simulation.ensemble import simulate_record

MINE = '''\
"""A strategy of mine."""

import math

PARAMETERS = {"weight": 2.0}


def quality(robots_seen, tasks_seen):
    return 1.0 / (1.0 + math.exp(0.1 * (tasks_seen - robots_seen)))


def dissemination(quality, gain):
    return gain * quality


def decide(mind, inbox):
    lead = inbox.feasible_votes - inbox.infeasible_votes
    if abs(lead) < mind.parameters[0]:
        return mind.opinion
    return 1 if lead > 0 else 0
'''
"""Opinions by the lead of one over the other."""
SET, QUIET, FADING = (
    (Path(__file__).parents[2] / "examples" / "strategies" / f"{name}.py").read_text(encoding="utf-8")
    for name in ("roll_call", "quiet_census", "fading")
)
"""A set of the ids of robots and tasks; one that declares; counts that robots judge in each step."""
SURE = "    return 1 if me.step - me.memory[1] >= me.setting.parameters[0] else -1"
JUDGED = "    return 1 if (me.setting.robots - 1) * tasks <= (me.setting.robots + 0.5) * robots else 0"
LAID_OUT = (
    SET.replace("    length = 2\n", "    return len(message)\n    length = 2\n")
    + """

def layout(wire, message, sender, setting):
    for k in range(len(message)):
        message[k] = wire.number(message[k], 1)
    return -1
"""
)
"""The set, which says by one function how its messages are packed and unpacked."""
ARRAYS = ("decision", "decision_step", "feasible_count", "infeasible_count", "account")


def assert_same(first, second, runs=3, seed=2):
    """See that the engine gives two scenarios the same runs, as does the reference; return their record."""
    one = simulate_record(first, Runs(runs, seed), curves=True)
    for other in (
        simulate_record(second, Runs(runs, seed), curves=True),
        simulate_record(second, Runs(1, seed), curves=True, backend="reference"),
    ):
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(one, name)[: other.runs], getattr(other, name), name)
    return one


def copy_of(name):
    """Return the text of a built-in strategy, with the functions that it takes of others in their place."""
    text = inspect.getsource(import_module(f"feasibee.strategies.{name.replace('-', '_')}"))
    return re.sub(r"from (feasibee\.strategies\.\w+) import (.*)", _functions_of, text)


def _functions_of(found):
    module = import_module(found[1])
    return "\n\n".join(inspect.getsource(getattr(module, each)) for each in found[2].split(", "))


def replaced(text, old, new):
    """Return a text with another part in place of one that it has once."""
    assert text.count(old) == 1, old
    return text.replace(old, new)


def played(scenario, seed=3):
    """Yield a swarm of the reference after each step."""
    swarm = reference.Swarm(scenario, seed=seed, run=0)
    for _ in range(scenario.run.steps):
        swarm.step()
        yield swarm


def why_not(scenario):
    """Return the line that simulating a scenario ends with."""
    with pytest.raises(FeasibeeError) as caught:
        simulate_record(scenario, Runs(1, 0))
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


def controller(path, parameter, **settings):
    """Return the controller of robot 2 of 5 that knows of 9 tasks; its phases last 3 steps."""
    settings |= {"me": (2, 0, 77), "setting": setting_from((5, 9), (0, 0), False, None, [parameter])}
    return Controller(load(str(path)), 1, lambda mean: 3, lambda: (0.5, 0.5), Settings(**settings))
