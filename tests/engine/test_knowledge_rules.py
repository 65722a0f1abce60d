"""Knowledge of users' strategies in the engine's C: it fails where Python fails, and refuses what has no C.

What robots know, say and count is compared in test_conformance.py.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from feasibee import FeasibeeError, Scenario, simulate
from feasibee.engine.generate import is_steady, own_strategy
from feasibee.robot.definitions import Text
from feasibee.simulation import ensemble
from tests.equal import assert_equal

CALL = (Path(__file__).parents[2] / "examples" / "strategies" / "roll_call.py").read_text(encoding="utf-8")
START, MERGE, BITS = "known[me.id] = 1", "known[k] = max(known[k], message[k])", "return length\n"
JUDGE = "return length\n\n\ndef judge(known, me):\n    return known[me.id] * 2 if me.step == 17 else -1\n"
FAILING = {  # what is written in place of what, line, words of the engine's error, and of the reference's
    "observe": (
        "known[thing.id if",
        "known[999 * (me.step == 17) + thing.id if",
        23,
        "IndexError: place 999",
    ),
    "merge": (
        *(MERGE, "known[k] = max(known[k], 2**62 * (1 + (me.step == 17)) >> 63)", 29),
        "OverflowError: 4611686018427387904 * 2 leaves 64 bits; compute with real numbers",
    ),
    "start": (START, "known[me.id] = 1 + 5 // (9 - me.id)", 18, "ZeroDivisionError: 5 // 0; test"),
    "count": (*("+= known[k]", "-= me.step > 15", 32), "into counts; must be whole numbers from 0 to"),
    "bits": (BITS, "return length - 9999 * (me.step == 17)\n", 38, "must be a whole number from 0 to 1"),
    "judge": (BITS, JUDGE, 46, "returns 2; must be 1, 0, or -1 for none"),
}


@pytest.mark.parametrize("name", FAILING)
def test_a_failure_is_that_of_python(tmp_path, monkeypatch, name):
    monkeypatch.setattr(ensemble, "REPLAY_LIMIT", 0)  # so the engine explains it
    old, new, line, words = FAILING[name]
    (tmp_path / "mine.py").write_text(CALL.replace(old, new), encoding="utf-8")
    scenario = Scenario(decision={"strategy": str(tmp_path / "mine.py")}, run={"steps": 40})
    for backend, said in (("engine", words), ("reference", words.partition(": ")[0])):
        with pytest.raises(FeasibeeError, match=rf"^mine\.py, line {line}: ") as caught:
            simulate(scenario, 1, seed=1, backend=backend)
        assert said in str(caught.value)


def test_words_wrap_and_places_count_from_the_end(tmp_path):
    text = CALL.replace(START, "known[-1] = 2**31 + me.id\n    known[0] = -2**31 - 1 - me.id")
    text = text.replace("+= known[k]", "+= known[k] > 0").replace(BITS, "return 9 + message[0] % 1000\n")
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    changes = {"robots.count": 5, "arena.side": 8.0, "decision.strategy": str(tmp_path / "mine.py")}
    assert_equal(Scenario().replace({**changes, "run.steps": 40}), 1)


REFUSED = {
    (MERGE, "message[k] = 0"): "merge doesn't compile: an assignment to message[k];",
    (START, "known[me.id] = 0.5"): "start doesn't compile: known[me.id] is given a real number; write",
    (START, "known[me.id] = me.colour"): "start doesn't compile: me.colour; use one of id, kind",
    (START, "return 1"): "start doesn't compile: it must return nothing, whatever it is given",
    (BITS, "return length / 2\n"): "bits doesn't compile: it must return a whole number, whatever",
    (START, "known[:] = 1"): "start doesn't compile: an assignment to known[:]",
}


@pytest.mark.parametrize(("old", "new"), REFUSED)
def test_what_has_no_c_is_told_with_function_and_line(old, new):
    with pytest.raises(FeasibeeError, match=r"^mine\.py, line \d+: ") as caught:
        own_strategy("mine.py", CALL.replace(old, new))
    assert REFUSED[old, new] in str(caught.value)


@pytest.mark.parametrize(
    ("body", "steady"),
    [
        ("return me.setting.id_bits + me.id", True),
        ("return message[0]", True),
        ("return me.step", False),
        ("return other(me)", False),
        ("you = me\n    return you.setting.id_bits", False),
    ],
)
def test_a_length_that_may_change_is_found(body, steady):
    assert is_steady(Text("mine.py", f"def bits(message, me):\n    {body}\n")["bits"]) == steady
