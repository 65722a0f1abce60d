"""The search for the worst lie."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, simulate
from feasibee.studies.lies import _space, lying, worst_lie

pytest.importorskip("optuna")
WEAK = """
def decide(mind, inbox):
    return mind.opinion

def words(setting):
    return 2

def observe(known, thing, me):
    known[1] = 3

def encode(message, known, me):
    message[0], message[1] = 1, 3

def lie(message, feasible, me):
    message[0] = feasible

def message_words(setting):
    return 2

def merge(known, message, sender, me):
    if message[0] == 1 and message[1] == 0:
        known[0] = 1

def count(known, counts, me):
    counts[0], counts[1] = me.setting.robots, me.setting.tasks

def bits(message, me):
    return 3

def judge(known, me):
    right = 1 if me.setting.robots >= me.setting.tasks else 0
    return 1 - right if known[0] == 1 else right
"""


def test_the_lie_to_which_a_strategy_is_weak_is_found_again_and_again(tmp_path):
    """Robots turn wrong only by a 0 in the second word and a 1 in the first one."""
    file = tmp_path / "weak.py"
    file.write_text(WEAK)
    world = Scenario(tasks={"count": 10}, decision={"strategy": str(file)}, run={"steps": 200})
    found = worst_lie(world, str(file), 1, trials=16, runs=4, seed=3)
    assert (found.none.estimate, found.own.estimate) == (1, 1)
    assert found.worst.high < 0.5
    assert found.values["form_feasible"] % 4 in (1, 3)
    assert found == worst_lie(world, str(file), 1, trials=16, runs=4, seed=3)


def world_of(name, tasks):
    return Scenario(
        robots={"know_count": True},
        tasks={"count": tasks},
        decision={"strategy": name},
        faults={"byzantine": {"count": 2}, "byzantine_says": "colluding"},
        run={"steps": 200, "stop_at_decision": False},
    )


@pytest.mark.quick(2)
@pytest.mark.parametrize("tasks", [10, 40])
@pytest.mark.parametrize("name", ["census", "estimate", "turns"])
def test_the_default_is_the_own_lie_of_a_strategy(name, tasks):
    world = world_of(name, tasks)
    own, told = simulate(world, 5, seed=1), simulate(lying(world), 5, seed=1)
    assert all(np.array_equal(own[each], told[each]) for each in own)


def test_lies_that_cannot_be_sent_are_not_tried():
    forms = {}
    for name in ("roster", "turns"):
        world = world_of(name, 10)
        forms[name] = _space(world, lying(world), 0)[0].choices
    assert 16.0 in forms["roster"]
    assert len(forms["roster"]) < len(forms["turns"])


def test_opinions_have_no_words_to_forge():
    with pytest.raises(FeasibeeError, match=r"set faults\.byzantine_says"):
        lying(world_of("dmmd", 10))
