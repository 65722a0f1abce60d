"""A user's strategy in both implementations, for tests."""

from __future__ import annotations

import inspect
import re
from importlib import import_module

import numpy as np
import pytest

from feasibee import FeasibeeError, reference
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

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
