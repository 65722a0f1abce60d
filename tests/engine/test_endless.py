"""A loop of a user's strategy that doesn't end is an error, in Python and in the engine."""

from __future__ import annotations

import pytest

from feasibee import FeasibeeError, Scenario, Swarm, simulate
from feasibee.engine import failing, own
from feasibee.strategies import overflow

LATER = """
def decide(mind, inbox):
    k = 0
    {loop}:
        k = 1 - k
    return 1
"""
NOT_IN_THE_TRIAL = "inbox.feasible_votes + inbox.infeasible_votes == 4"


@pytest.fixture
def strategy(tmp_path, monkeypatch):
    """Write a strategy with a loop, whose passes are limited to few."""
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "cache"))
    for module in (failing, own, overflow):
        monkeypatch.setattr(module, "PASSES", 1000)

    def write(loop):
        (tmp_path / "mine.py").write_text(LATER.format(loop=loop))
        return Scenario(decision={"strategy": str(tmp_path / "mine.py")}, run={"steps": 200})

    return write


@pytest.mark.parametrize("loop", ["while k >= 0", "for i in range(5 - 4, 10 ** 12)"])
def test_the_trial_ends(strategy, loop):
    with pytest.raises(FeasibeeError, match=r"mine.py, line 4: decide\(.* a loop has passed 1,000 times"):
        simulate(strategy(loop))


@pytest.mark.parametrize(
    "loop", [f"while {NOT_IN_THE_TRIAL}", f"for i in range(10 ** 12 if {NOT_IN_THE_TRIAL} else 0)"]
)
@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_the_run_ends_and_nothing_is_replayed(strategy, loop, boundary):
    scenario = strategy(loop).replace({"arena.boundary": boundary})
    told = r"^mine.py, line 4: a loop has passed 1,000 times; end it sooner \(in run 0 of seed 3\)$"
    with pytest.raises(FeasibeeError, match=told):
        simulate(scenario, 1, seed=3)
    with pytest.raises(FeasibeeError, match=told):
        Swarm(scenario, 3).advance(200)


def test_a_loop_that_is_left_may_have_a_long_range(strategy):
    scenario = strategy("for i in range(10 ** 12):\n        if i > 3:\n            break\n    while k > 0")
    assert simulate(scenario, 1).sizes["run"] == 1
