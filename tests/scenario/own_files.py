"""Strategies of users, and how they are run in both implementations, for tests."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from following import SIGHTINGS

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
SET = (Path(__file__).parents[2] / "examples" / "strategies" / "roll_call.py").read_text(encoding="utf-8")
"""A grow-only set of the ids of robots and tasks."""
OPINIONS = SET.partition("\n\ndef words")[0]
HEAD = '''\
"""Names of tasks, which robots pass on until they are sure."""

BY_NAME = True
STARTS_NEUTRAL = True
NEEDS_COUNT = True
PARAMETERS = {"quiet": 12.0}


def quality(robots_known, tasks_known):
    return share(robots_known, tasks_known)


def share(robots, tasks):
    return robots / larger(robots + tasks, 1)


def larger(first, second):
    return max(first, second)


def dissemination(quality, gain):
    return gain


def say(mind):
    return larger(mind.opinion, 0)


def decide(mind, inbox):
    return kept(mind.opinion)


def kept(opinion):
    return opinion


def words(setting):
    return 3 + (setting.task_ids + 30) // 31


def start(known, me):
    known[2] = place(me)


def place(me):
    return int(1000 * me.x) * 31 + int(1000 * me.y) * 7 + me.explores
'''
QUIET = (
    HEAD
    + """

def observe(known, thing, me):
    if not thing.is_robot:
        known[3 + thing.id // 31] |= 1 << (thing.id % 31)
    known[2] = (known[2] + (int(1000 * thing.x) * 5 + int(1000 * thing.y)) % 97 * place(me)) % 99991


def merge(known, message, sender, me):
    for k in range(3, len(known)):
        known[k] |= message[k]
    known[2] = (known[2] + (message[2] + sender) % 89 * place(me)) % 99991


def count(known, counts, me):
    counts[0] = me.setting.robots
    counts[me.setting.robot_classes] = tasks_in(known) + me.explores


def tasks_in(known):
    total = 0
    for k in range(3, len(known)):
        total += known[k].bit_count()
    return total


def bits(message, me):
    return me.setting.id_bits + 33 * tasks_in(message) + message[2] % 1009 + place(me) % 11


def declare(known, me):
    known[2] = (known[2] + place(me)) % 99991
    tasks = tasks_in(known)
    if tasks > me.setting.robots:
        return 0
    if tasks != known[0]:
        known[0] = tasks
        known[1] = me.step
    return 1 if me.step - known[1] >= me.setting.parameters[0] else -1
"""
)
"""A strategy that uses all that the contract offers to those who declare; its bits depend on all of it."""
SURE = "    return 1 if me.step - known[1] >= me.setting.parameters[0] else -1"
FADING = (
    '''\
"""Names of tasks, each forgotten after a while; robots follow what they know in every step."""

BY_NAME = True
NEEDS_COUNT = True
PARAMETERS = {"lasts": 9.0}


'''
    + SIGHTINGS
    + """\


def start(known, me):
    known[me.id % len(known)] = 1


def count(known, counts, me):
    counts[0], counts[me.setting.robot_classes] = me.setting.robots, present(known)


def judge(known, me):
    for k in range(len(known)):
        known[k] = max(known[k] - 1, 0)
    if present(known) == me.id:
        return -1
    return 1 if present(known) <= me.id else 0
"""
)
"""A strategy without an `encode` of its own, so that `judge` must mark what it changes."""
JUDGED = "    return 1 if present(known) <= me.id else 0"
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
