"""What is wrong with a user's strategy is told with function and line: by its text, a trial, or in a run."""

from __future__ import annotations

import pytest
from own_files import FADING, JUDGED, LAID_OUT, MINE, QUIET, SET, SURE, replaced, why_not

from feasibee import FeasibeeError, Scenario, ScenarioError, Swarm
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies.contract import ARGUMENTS, KNOWLEDGE

TEXTS = {"mine": MINE, "set": SET, "quiet": QUIET, "fading": FADING, "layout": LAID_OUT}
DECLARE, JUDGE = (
    f"line {text.partition(f'def {name}')[0].count(chr(10)) + 1}: {name}("
    for text, name in ((QUIET, "declare"), (FADING, "judge"))
)


def cases(table, slow=()):
    """Return the rows of a table, each with its text's name; to compile knowledge takes seconds."""
    return [
        pytest.param(name, *row, marks=slow if name != "mine" else ())
        for name, rows in table.items()
        for row in rows
    ]


@pytest.fixture
def spoil(write):
    """Write a strategy's file with a part replaced, or with a line more; return a scenario with it."""

    def to(name, old, new, **changes):
        text = replaced(TEXTS[name], old, new) if old else f"{TEXTS[name]}\n{new}\n"
        small = {"arena.side": 8.0, "run.steps": 60, "tasks.count": 12, "robots.know_count": True}
        return Scenario().replace({**small, "decision.strategy": str(write(text)), **changes})

    return to


# --- By the text ---

LEAD = "    lead = "
FLAG = "must be True or False"
ONLY = "at the top level; write only imports, constants and functions"
NAMES = "must be a dict of names and numbers"
WRITTEN = {
    "mine": [
        ("def decide(", "def other(", ": has no function decide; write def decide(mind, inbox)"),
        ("decide(mind, inbox)", "decide(mind)", "16: decide must take 2; write def decide(mind, inbox)"),
        ("(robots_seen, tasks_seen):", "(*seen):", ", line 8: quality must take 2"),
        ("(quality, gain)", "(quality, gain, more=1)", ", line 12: dissemination must take 2"),
        ("(quality, gain)", "(quality, gain, *, more=1)", ", line 12: dissemination must take 2"),
        ("import math", "import numpy", ", line 3: imports numpy; a strategy may import math only"),
        ("import math", "from . import math", ", line 3: imports .; a strategy may import math only"),
        ("    return gain * quality", "    return gain *", ", line 13: SyntaxError: invalid syntax"),
        ("", "def judge(known, me): pass", "has judge, by which robots pass on knowledge, but no"),
        ("", "decide = 3", "decide isn't a plain function; write def decide(mind, inbox)"),
        ("", "from math import exp as say", "say isn't a plain function; write def say(mind)"),
        ("", "@staticmethod\ndef say(mind): return 1", "say isn't a plain function; write def say(mind)"),
        *(
            ("", f"MEMORY = {value}", f"MEMORY = {value} must be a whole number from 0 to 64, written out")
            for value in ("-1", "65", "True", "2.0", "1 + 1")
        ),
        ("", "MEMORY: int", "MEMORY = ... must be a whole number"),
        ("", "VALUE_BITS = 17", "VALUE_BITS = 17 must be a whole number from 0 to 16"),
        *(("", f"{each} = 1", f"{each} = 1 {FLAG}") for each in ("FORGETS", "MODULATES", "ONE_CLASS")),
        ("", "NEEDS_IDS = 'wait'", "NEEDS_IDS = 'wait' must be True, False or the name of a parameter; it"),
        ("", "POSITIVE = ('wait',)", "POSITIVE must have names of parameters; it has weight"),
        ("", "MODULATES = True", "both MODULATES = True and dissemination, which say for how long"),
        (
            "def dissemination(quality",
            "MODULATES = True\ndef lasting(mind",
            "both MODULATES = True and lasting",
        ),
        *(
            ("", f"PARAMETERS = {value}", f"PARAMETERS = {value} {NAMES}")
            for value in (
                "['weight']",
                "{'weight': 'x'}",
                "{'weight': True}",
                "{3: 1.0}",
                r"{'\x1b[31m': 1.0}",
            )
        ),
        ("", "PARAMETERS = {'weight': 1e999}", NAMES),
        *(
            ("", each, f"line 22: {each.partition(' MEMORY')[0]} {ONLY}")
            for each in (
                r"print('\x1b[31m')",
                "if math.pi > 3: MEMORY = 1",
                "PARAMETERS['more'] = 1.0",
                "math.pi = 3",
            )
        ),
        *(
            (LEAD, f"    {each}\n{LEAD}", f"line 17: has {what}, which no strategy has; {then}")
            for each, what, then in (
                ("global N", "global", "keep numbers in mind.memory"),
                ("raise GeneratorExit", "raise", "return a value"),
                ("class A: pass", "class", "write functions"),
                ("import math", "import in a function", "import at the top level"),
                ("say = lambda: yes", "lambda", "write def"),
                ("p = [print][0]", "print", "leave it out"),
            )
        ),
        ("", "X = 9223372036854775808", "line 22: a number leaves 64 bits; write one below 2**63"),
        ("", f"X = {'-' * 50_000}1", "nests too deep for Python; write long expressions in several"),
        ("", f"X = {'-' * 500}1", "line 22: nests more than 150 levels deep; write long expressions"),
        ("", f"X = 1{' + 1' * 500}", "line 22: nests more than 150 levels deep; write long expressions"),
    ],
    "set": [
        *(
            (f"def {each}(", f"def other_{each}(", f"{each}; write def {each}({', '.join(ARGUMENTS[each])})")
            for each in KNOWLEDGE
        ),
        ("", "def message_words(setting): return 3", "has message_words, but no function encode"),
    ],
    "layout": [
        ("", "def pack(writer, message, sender, me): pass", "has both layout and pack or unpack, which"),
        ("(wire, ", "(", "layout must take 4; write def layout"),
    ],
    "fading": [("", "def declare(known, me): return -1", "remove def judge or def declare")],
}


@pytest.mark.parametrize(("name", "old", "new", "words"), cases(WRITTEN))
def test_what_is_wrong_with_the_text_is_told(spoil, name, old, new, words):
    with pytest.raises(ScenarioError) as caught:
        spoil(name, old, new)
    (problem,) = caught.value.problems
    assert problem.path == "decision.strategy"
    assert problem.rule.startswith("mine.py"), problem.rule
    assert words in problem.rule


# --- By a trial ---

WHOLE = "must be a whole number from 0 to 1099511627776"
TRIED = {
    "mine": [
        ("PARAMETERS = {", "X = 1 / 0; PARAMETERS = {", "line 5: ZeroDivisionError: division by zero"),
        ("PARAMETERS = {", "X = 9**9**9; PARAMETERS = {", "line 5: OverflowError: 9 ** 387420489 leaves 64"),
        ("(tasks_seen -", "(task_seen -", "line 9: quality(0, 0) fails: NameError: name 'task_seen'"),
        ("mind.parameters[0]", "mind.memory[0]", "line 18: decide(", "fails: IndexError"),
        (LEAD, f"    return 2\n{LEAD}", "line 16: ", "returns 2; must be 1, 0, or -1 for none"),
        ("gain * quality", "None", "line 12: ", "returns None; must be a number of steps from 0"),
        ("gain * quality", "quality - 1", "line 12: ", " returns -"),
        ("gain * quality", "gain * 1e9", "line 12: ", "10.0) returns 10000000000.0;"),
        ("return 1.0 / ", "return [1.0] or ", "line 8: quality(0, 0) returns [1.0]; must be a number from 0"),
        ("return 1.0 / ", "return 1.0 + robots_seen or ", "line 8: quality(1, 0) returns 2.0; must be a num"),
        ("return 1.0 / ", "return -1 / ", "line 8: quality(0, 0) returns -0.5; must be a number from 0 to 1"),
        ("", "def lasting(mind, gain): return -1.0", "line 22: lasting(", "-1.0; must be a number of steps"),
        ("", "def value(mind): return 'x'", "line 22: value(", "returns 'x'; must be a number"),
        ("", "def say(mind): return 5", "line 22: say(", "returns 5; must be 1, 0, or -1 for none"),
        ("", "X = PARAMETERS.pop('weight')", "PARAMETERS changes while the file runs; write its value out"),
    ],
    "set": [
        ("setting.robot_ids + setting.task_ids", "0", "line 11: words(Setting("),
        ("setting.robot_ids + setting.task_ids", "0.5", "line 11: ", "returns 0.5; must be a whole"),
        ("known[me.id] = 1", "known[me.id] = 0.5", "line 18: start(["),
        ("known[me.id] = 1", "return [me.id]", "line 16: ", "returns [0]; must return nothing: it writes in"),
        ("known[thing.id if", "known[thing.name if", "line 23: ", "'Thing' object has no attribute 'name'"),
        ("known[k] = max(", "message[k] = max(", "line 29: ", "TypeError: 'tuple' object does not support"),
        ("] += known[k]", "] -= 1", "line 32: count writes [-3, -4] into counts; must be"),
        ("] += known[k]", "] += 0.5", "line 32: count writes [1.5, 2.0] into counts"),
        ("return length", "return -1", "line 38: ", f"returns -1; {WHOLE}"),
        ("return length", "return length / 2", "line 38: ", WHOLE),
    ],
    "quiet": [(SURE, "    return 2", DECLARE, "returns 2; must be 1, 0, or -1 for none")],
    "fading": [(JUDGED, "    return 2", JUDGE)],
    "layout": [
        ("[k], 1)", "[k], 2)", "mine.py: layout writes 14 bits of ", "bits returns 7; they must be"),
        ("message[k] = wire", "wire", "mine.py: layout reads ", "from what layout wrote of"),
        ("return -1", "return -2", "line 47: layout(", "returns -2; must be the sender's id, or"),
        ("(len(message)):\n        message", "(9):\n        message", "49: layout(", "IndexError"),
        ("(message[k], 1", "(message[k] + 1, 1", "layout of ", "2 doesn't fit 1 bits"),
    ],
}


@pytest.mark.parametrize(("name", "row"), [(name, row) for name, rows in TRIED.items() for row in rows])
def test_what_fails_when_it_is_tried_is_told_with_its_line(spoil, name, row):
    old, new, *words = row
    text = why_not(spoil(name, old, new))
    assert text.startswith("mine.py"), text
    assert all(each in text for each in words), text


# --- When it is compiled, or only in a run: tests/engine has each rule by itself ---

MERGING = "    for k in range(len(known)):\n        known[k] = max("
LATE = "20 < me.step < 1000"
"""No trial has such a step."""
COMPILED = {
    "mine": [(LEAD, f"    p = {{1: inbox.chance}}\n{LEAD}", "17: decide doesn't compile: {1: inbox.chance}")],
    "set": [(MERGING, f"    if me.step == 77:\n        return 1\n{MERGING}", "26: merge doesn't compile")],
}


@pytest.mark.parametrize(("name", "old", "new", "words"), cases(COMPILED, pytest.mark.slow))
def test_what_does_not_compile_is_told_with_function_and_line(spoil, name, old, new, words):
    scenario = spoil(name, old, new, **{"run.steps": 5})
    assert simulate_record(scenario, Runs(1, 0), backend="reference").runs == 1  # Python has no trouble
    text = why_not(scenario)
    assert "mine.py" in text
    assert words in text


def rarely(line):
    """Return a line that runs at a chance that no trial has."""
    return LEAD, f"    if 0.0 < inbox.chance < 0.2:\n        {line}\n{LEAD}"


DECIDE = r"decide\(Mind\(opinion=\d.*"
RUN = {
    "mine": [
        (*rarely("lead = mind.memory[5]"), f"line 18: {DECIDE}fails: IndexError: "),
        (*rarely("return 7"), f"line 16: {DECIDE}returns 7; must be 1, 0, or -1 for none"),
        (
            "return 1.0 /",
            "return 1.5 if robots_seen == 4 else 1.0 /",
            r"line 8: quality\(4, \d+\) returns 1.5;",
        ),
        (
            "return gain",
            "return -9 if gain == 10.0 and 0.2 < quality < 0.4 else gain",
            "line 12: .* returns -9;",
        ),
    ],
    "set": [
        (MERGING, MERGING.replace("known))", f"known) + ({LATE}))"), r"line 29: merge\(.*fails: IndexError")
    ],
    "quiet": [(SURE, "    return 7 if me.step == 33 else -1", r"declare\(.*returns 7; must be 1, 0, or -1")],
    "fading": [(JUDGED, "    return 7 if me.step == 33 else -1", r"judge\(.*returns 7; ")],
}


@pytest.mark.parametrize(("name", "old", "new", "why"), cases(RUN, pytest.mark.slow))
def test_what_fails_only_in_a_run_is_told_with_line_arguments_and_run(spoil, name, old, new, why):
    scenario = spoil(name, old, new)
    with pytest.raises(FeasibeeError, match=rf"^mine\.py, .*{why}.*\(in run \d of seed 1\)$") as engine:
        simulate_record(scenario, Runs(5, 1), threads=1)
    with pytest.raises(FeasibeeError) as reference:
        simulate_record(scenario, Runs(5, 1), backend="reference")
    assert str(engine.value)[:60] == str(reference.value)[:60]  # long arguments are shortened
    with pytest.raises(FeasibeeError, match=rf"^mine\.py, .*{why}.*\(in run 0 of seed 1\)$"):
        Swarm(scenario, seed=1).advance(200)
