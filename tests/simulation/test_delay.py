"""Messages that are late: a robot broadcasts what it would have said some steps before (model.md 6.21.2)."""

from __future__ import annotations

import pytest

from feasibee import Scenario, Swarm, simulate


def late(changes, delay):
    return Scenario().replace({"arena.side": 8.0, "run.steps": 40, **changes, "radio.delay": delay})


@pytest.mark.parametrize("robots", [20, 140])
def test_robots_hear_what_others_would_have_said_some_steps_before(robots):
    """All hear all; so an inbox has the latest message of each sender up to so many steps before."""
    world = late({"arena.boundary": "walls", "radio.range": 20.0, "robots.count": robots}, delay := 4)
    swarm, said, inboxes, changed = Swarm(world, seed=3), [], [{} for _ in range(robots)], 0
    for step in range(40 if robots == 20 else 15):
        robots_before = [swarm.robot(i) for i in range(robots)]
        said.append({i: each.broadcasts for i, each in enumerate(robots_before) if each.broadcasts >= 0})
        swarm.advance()
        arriving = said[step - delay] if step >= delay else {}
        changed += arriving != said[step]
        for i, before in enumerate(robots_before):
            others = {sender: opinion for sender, opinion in arriving.items() if sender != i}
            ends = before.phase_left == 1 and before.flags >> 2 & 1
            inboxes[i] = {} if ends else inboxes[i] | others
            assert {sender: opinion for sender, opinion, _ in swarm.robot(i).heard} == inboxes[i], (step, i)
    assert changed > 8


@pytest.mark.parametrize("strategy", ["voter", "census"])
def test_bits_count_when_they_are_broadcast(strategy):
    """Phases of these strategies don't depend on messages; what isn't heard changes none, either."""
    world = {"decision.strategy": strategy, "radio.range": 1e-3}
    early, delayed = (Swarm(late(world, delay), seed=5) for delay in (0, 7))
    early.advance(23)
    delayed.advance(30)
    assert delayed.bits_sent == early.bits_sent > 0


@pytest.mark.quick(2)
def test_a_quiet_time_is_long_enough_for_late_messages():
    """Without the delay in the quiet time, 20 of these swarms declare wrongly."""
    changes = {"decision.strategy": "quiet-census", "robots.know_count": True, "tasks.count": 21}
    ends = {"run.steps": 600, "run.stop_at_declarations": True, "radio.delay": 100}
    scenario = Scenario().replace({**changes, **ends})
    assert (simulate(scenario, runs=300, seed=5).declared_feasible.values > 0).sum() <= 2


def test_ages_are_those_at_arrival():
    """Else robots make each other's news of a task that vanished younger, and never forget it."""
    changes = {"decision.strategy": "roster", "robots.know_count": True, "decision.parameters.looks": 1e6}
    world = {"tasks.count": 25, "events": [{"step": 100, "tasks": -10}], "run.steps": 450}
    scenario = Scenario().replace({**changes, **world, "radio.delay": 20, "run.stop_at_decision": False})
    assert (simulate(scenario, runs=20, seed=5).feasible_at_end.values > 18).sum() >= 19
