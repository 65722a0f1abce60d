"""Messages of knowledge that repeat what a robot sent before: the same runs as in the reference."""

from __future__ import annotations

import inspect

import pytest
from own_files import assert_same

from feasibee import Scenario
from feasibee.strategies import tally

LARGE = Scenario(robots={"count": 130}, tasks={"count": 131}, arena={"side": 40.0}, run={"steps": 60})


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["census", "tally", "estimate"])
@pytest.mark.parametrize("liars", [0.1, 0.0])
def test_robots_that_learn_nothing_new_repeat_their_message(strategy, liars):
    scenario = LARGE.replace({"decision.strategy": strategy, "faults.byzantine": liars})
    assert_same(scenario, scenario, runs=1)


@pytest.mark.slow
@pytest.mark.parametrize(
    "length",
    [
        "len(message) + age(me)",
        "len(message) + me.step % 7",
        "len(message) + (1 if me.explores else 0) + int(me.x)",
    ],
)
def test_a_length_that_changes_with_the_robot_is_computed_in_each_step(tmp_path, monkeypatch, length):
    text = inspect.getsource(tally)
    start = text.index("def bits(")
    bits = f"def bits(message, me):\n    return {length}\n\n\ndef age(me):\n    return me.step\n"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(text[:start] + bits)
    scenario = LARGE.replace({"decision.strategy": "mine.py", "run.steps": 40})
    assert_same(scenario, scenario, runs=1)
