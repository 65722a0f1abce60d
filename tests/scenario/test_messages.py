"""Messages of knowledge that repeat what a robot sent before: the same runs as in the reference."""

from __future__ import annotations

import inspect

import pytest
from own_files import assert_same

from feasibee import Scenario
from feasibee.engine.compile import reads_only
from feasibee.strategies import census, estimate, quiet_census, tally

LARGE = Scenario(robots={"count": 130}, tasks={"count": 131}, arena={"side": 40.0}, run={"steps": 60})
FIELDS = ("id", "kind", "hash", "setting")


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


def test_a_function_reads_only_fields_that_stay():
    for module in (census, estimate, tally, quiet_census):
        assert reads_only(module.bits, "me", FIELDS), module.__name__


@pytest.mark.parametrize(
    "function",
    [
        lambda message, me: me.step,
        lambda message, me: me[3],
        lambda message, me: len(me),
        lambda message, me: max(len(message), me),
        lambda message, me: [me for _ in message],
        lambda message, me: (me.setting, me.memory),
    ],
)
def test_a_function_that_may_read_more_is_found(function):
    assert not reads_only(function, "me", FIELDS)
