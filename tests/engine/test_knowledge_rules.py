"""Knowledge in the engine's C: what robots know, say and count is what Python's functions compute."""

from __future__ import annotations

from pathlib import Path

import pytest
from knowing import Swarm

from feasibee import FeasibeeError
from feasibee.engine.generate import is_steady, own_strategy
from feasibee.engine.own import Failure, explained, kind_of
from feasibee.robot.definitions import Text
from feasibee.scenario.plugins import manifest_of
from feasibee.scenario.setting import setting_from
from feasibee.scenario.trial import tried
from feasibee.strategies import STRATEGIES
from tests.engine.compiled import (
    SANITIZED,
    Draws,
    Rules,
    bits,
    library,
)

KNOWING = [name for name, each in STRATEGIES.items() if each.knowledge]
EXAMPLES = Path(__file__).parents[2] / "examples" / "strategies"
OWN = [each.name for each in sorted(EXAMPLES.glob("*.py")) if "def merge" in each.read_text(encoding="utf-8")]
PLAN = {"plan": bytes([16] * 30 + [1, 17, 0, 16, 16, 1] + [16] * 64), "columns": 10, "walled": True}
WORLDS = {
    "paper": {},
    "walls": {"walled": True, "sight": 4.0, "radio": 1.5, "knows_count": False, "delay": 3.0},
    "place": {**PLAN, "flooding": 700.0},
    "charging": {"work": 500.0, "charge": 80.0, "count": 5, "mean_run": 3.0, "size": (40.0, 10.0)},
    "liars": {"liars": True, "colluding": True},
    "classes": {"classes": (2, 3), "liars": True, "knows_count": False},
    "misnamed": {"misnames": True},
}
PARAMETERS = {
    "quiet-census": [{"tolerates": 2.0}, {"quiet": 30.0}, {"lasts": 40.0}],
    "map": [{"cell": 4.0, "rows": 2.0}, {"cell": 5.0, "tolerates": 1.0}],
    "turns": [{"names": -1.0}, {"names": 2.0, "tolerates": 1.0}, {"names": 0.0}, {"looks": 2.0}],
    "roster": [{"tolerates": 1.0}, {"task_timeout": 9.0, "looks": 1.0}],
}
CASES = [(name, world, {}) for name in KNOWING for world in WORLDS]
CASES += [
    (name, world, each) for name, all_ in PARAMETERS.items() for each in all_ for world in ("paper", "place")
]


def own_rules(calls, folder, text):
    """Return the rules of a user's text."""
    own = calls[0].dlopen(str(library(folder, "own", own_strategy("mine.py", text), *SANITIZED)))
    own.feasibee_bind(calls[0].addressof(calls[1], "feasibee_fail"))
    return Rules(*calls, own.feasibee_rules(b""))


def setting_of(strategy, world, parameters=None):
    """Return a setting of a world, as far as the strategy has it."""
    numbers = {"classes": (0, 0), "liars": False, **WORLDS[world]}
    if strategy.one_class:
        numbers["classes"] = (0, 0)
    if strategy.needs_count:
        numbers.pop("knows_count", None)
    given = {**strategy.parameters, **(parameters or {})}
    return setting_from((6, 9), numbers.pop("classes"), numbers.pop("liars"), None, given.values(), **numbers)


def play(swarm, liars):
    """Let robots know, see, say, hear and count at random."""
    for _ in range(12):
        swarm.step()
        found, expected = swarm.speak(liars)
        assert found == expected
        swarm.assert_same()
        swarm.observe(15)
        swarm.assert_same()
        swarm.merge(10)
        swarm.assert_same()
        if swarm.strategy.declare or swarm.strategy.judge:
            _, answers, expected = swarm.ask()
            assert answers == expected
            swarm.assert_same()
        _, counts, expected = swarm.count()
        assert counts == expected


@pytest.mark.parametrize(("name", "world", "parameters"), CASES)
def test_built_in_knowledge_is_that_of_python(calls, built_in, name, world, parameters):
    rules, strategy = Rules(*calls, built_in.feasibee_rules(name.encode())), STRATEGIES[name]
    setting = setting_of(strategy, world, parameters)
    swarm = Swarm(calls[0], rules, strategy, setting, CASES.index((name, world, parameters)))
    play(swarm, 2 * ("liars" in WORLDS[world]))
    for mind in (
        swarm.minds if strategy.gives_probability and not any(WORLDS[world].get("classes", ())) else ()
    ):
        arguments = Draws(1).mind(0, []), tuple(mind.words), setting
        assert bits(rules("probability", arguments)) == bits(float(strategy.probability(*arguments)))


@pytest.mark.parametrize("name", OWN)
def test_examples_know_what_they_know_in_python(calls, tmp_path, name):
    manifest = manifest_of(str(EXAMPLES / name))
    strategy, rules = tried(manifest), own_rules(calls, tmp_path, manifest.source)
    for world in ("paper", "walls", "liars"):
        play(Swarm(calls[0], rules, strategy, setting_of(strategy, world), 1), 2 * (world == "liars"))


# --- A user's strategy that fails ---

CALL = (EXAMPLES / "roll_call.py").read_text(encoding="utf-8")
LATE = 77_777
JUDGE = f"""

def judge(known, me):
    \"\"\"Fail late.\"\"\"
    if me.step == {LATE}:
        return known[me.id] * 2
    return -1
"""
FAILING = {
    "observe": ("known[thing.id if", "known[1000 * (me.step // 77777) + thing.id if", "IndexError: place 10"),
    "merge": (
        "known[k] = max(known[k], message[k])",
        "known[k] = max(known[k], 2**62 * (1 + me.step // 77777) >> 63)",
        "OverflowError: 4611686018427387904 * 2 leaves 64 bits; compute with real numbers",
    ),
    "start": (
        "known[me.id] = 1",
        "known[me.id] = 1 + 5 // (77777 - me.step)",
        "ZeroDivisionError: 5 // 0; test",
    ),
    "count": (
        "+= known[k]",
        "-= me.step // 77777",
        "count writes -6 into counts; must be whole numbers from 0 to",
    ),
    "bits": (
        "return length\n",
        "return length - 9999 * (me.step // 77777)\n",
        "must be a whole number from 0 to 1",
    ),
    "judge": ("", "", "judge returns 2; must be 1, 0, or -1 for none"),
}


@pytest.mark.parametrize("name", FAILING)
def test_a_failure_is_that_of_python(calls, tmp_path, name):
    old, new, words = FAILING[name]
    text = CALL.replace(old, new) if old else CALL + JUDGE
    assert text != CALL
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    manifest = manifest_of(str(tmp_path / "mine.py"))
    strategy = tried(manifest)
    swarm = Swarm(calls[0], own_rules(calls, tmp_path, text), strategy, setting_of(strategy, "paper"), 3)
    swarm.step()
    swarm.speak(0)
    swarm.clock.step = LATE
    for each in swarm.minds:
        each.me = each.me._replace(step=LATE)
    found = swarm.fail(name)
    assert isinstance(found, Failure)
    told = explained(manifest, found)
    with pytest.raises(FeasibeeError) as caught:
        swarm.fail_in_python(name)
    assert told.startswith(f"mine.py, line {found.line}: ")
    assert words in told
    assert str(caught.value).startswith(f"mine.py, line {found.line}: ")
    assert kind_of(found) in str(caught.value)


def test_words_wrap_and_places_count_from_the_end(calls, tmp_path):
    text = CALL.replace("known[me.id] = 1", "known[-1] = 2**31 + me.id\n    known[0] = -2**31 - 1 - me.id")
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    strategy = tried(manifest_of(str(tmp_path / "mine.py")))
    swarm = Swarm(calls[0], own_rules(calls, tmp_path, text), strategy, setting_of(strategy, "paper"), 3)
    assert swarm.minds[0].words[-1] == -(2**31)
    for i, mind in enumerate(swarm.minds):
        assert swarm.known(i) == list(mind.words)


REFUSED = {
    (
        "known[k] = max(known[k], message[k])",
        "message[k] = 0",
    ): "merge doesn't compile: an assignment to message[k];",
    (
        "known[me.id] = 1",
        "known[me.id] = 0.5",
    ): "start doesn't compile: known[me.id] is given a real number; write",
    ("known[me.id] = 1", "known[me.id] = me.colour"): "start doesn't compile: me.colour; use one of id, kind",
    ("known[me.id] = 1", "return 1"): "start doesn't compile: it must return nothing, whatever it is given",
    (
        "return length\n",
        "return length / 2\n",
    ): "bits doesn't compile: it must return a whole number, whatever",
    ("known[me.id] = 1", "known[:] = 1"): "start doesn't compile: an assignment to known[:]",
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
