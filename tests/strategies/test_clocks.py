"""Clocks of robots count steps modulo 2**32: where they stand changes nothing of what robots do."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES, clock, roster
from feasibee.strategies.contract import Me

STEPS, BEFORE = 72, 32
EDGES = [2**15, 2**16, 2**30, 2**31, 2**32]
PARAMETERS = {
    "quiet-census": {"quiet": 20.0},
    "turns": {"quiet": 40.0},
    "roster": {"task_timeout": 30.0, "robot_timeout": 20.0},
}
"""Timeouts so short that they pass."""


def scenario_of(name, **parameters):
    """Return a world of 8 robots; it changes unless robots declare, which do so within the run."""
    strategy = STRATEGIES[name]
    changes = {"tasks.lifetime": 60.0, "tasks.arrival_rate": 0.1, "robots.failure_rate": 0.01}
    return Scenario().replace(
        {
            "robots.count": 8,
            "tasks.count": 6,
            "arena.side": 9.0,
            "run.steps": STEPS,
            "decision.strategy": name,
            "decision.parameters": PARAMETERS.get(name, {}) | parameters,
            "robots.know_count": strategy.needs_count,
            **({} if strategy.declares else changes),
        }
    )


def outcomes(scenario, monkeypatch, first):
    """Return what a swarm does whose clocks begin at a step."""

    class Later(Knowledge):
        def __init__(self, strategy, me):
            super().__init__(strategy, me._replace(step=(me.step + first) & clock.LAST))

    with monkeypatch.context() as patch:
        patch.setattr("feasibee.robot.controller.Knowledge", Later)
        record = simulate_record(scenario, Runs(1, 4), backend="reference", curves=True)
    return {key: value for key, value in vars(record).items() if isinstance(value, np.ndarray)}


KNOWLEDGE = [name for name, each in STRATEGIES.items() if each.knowledge]
TOLERANT = [name for name in KNOWLEDGE if "tolerates" in STRATEGIES[name].parameters]


@pytest.mark.quick(4)
@pytest.mark.parametrize(
    ("name", "changes"),
    [*((name, {}) for name in KNOWLEDGE), *((name, {"tolerates": 1.0}) for name in TOLERANT)],
)
def test_a_swarm_does_the_same_whatever_its_clocks_say(name, changes, monkeypatch):
    scenario = scenario_of(name, **changes)
    expected = outcomes(scenario, monkeypatch, 0)
    assert (expected["account"] > 0).any()
    for edge in EDGES:
        got = outcomes(scenario, monkeypatch, edge - BEFORE)
        assert all(np.array_equal(got[key], value) for key, value in expected.items()), edge


def test_robots_declare_within_these_runs():
    for name in ("quiet-census", "turns"):
        record = simulate_record(scenario_of(name), Runs(1, 4), backend="reference")
        assert record.declared_feasible[0] > 0


def test_steps_are_told_apart_across_the_end_of_the_clock():
    for now in (0, 5, 2**31 - 1, 2**31, 2**32 - 1):
        for ago in (0, 1, 2**20, 2**31 - 1, 2**31, 2**32 - 1):
            then = (now - ago) & clock.LAST
            word = then - 2**32 if then >= 2**31 else then
            assert clock.steps_since(word, now) == clock.steps_since(then, now) == ago
            assert clock.has_come(word, now) == (ago < 2**31)


def test_a_state_is_forgotten_before_it_seems_young_again():
    me = Me(0, 0, 1, 0, [], None)
    state = roster.state_at(0, 1)
    for age in (0, 10, 2**20, 2**30 - 1):
        later = me._replace(step=age)
        assert roster.entry_of(state, later) == 2 * age + 1
        assert roster.expired(state, 5, later) == (state if age <= 5 else state + 1)
    assert roster.expired(state, 5, me._replace(step=2**30)) == 0
    assert roster.entry_of(0, me) == clock.LAST
