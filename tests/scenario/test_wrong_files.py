"""What is wrong with a user's strategy is told with function and line: by its text, a trial, or in a run."""

from __future__ import annotations

import pytest
from own_files import FADING, JUDGED, MINE, QUIET, SET, SURE, replaced, why_not

from feasibee import FeasibeeError, Scenario, ScenarioError, Swarm
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies.contract import ARGUMENTS, KNOWLEDGE

TEXTS = {"mine": MINE, "set": SET, "quiet": QUIET, "fading": FADING}
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

WRITTEN = {
    "mine": [
        ("def decide(", "def other(", ": has no function decide; write def decide(mind, inbox)"),
        (
            "decide(mind, inbox)",
            "decide(mind)",
            ", line 16: decide must take 2; write def decide(mind, inbox)",
        ),
        ("(robots_seen, tasks_seen):", "(*seen):", ", line 8: quality must take 2"),
        ("(quality, gain)", "(quality, gain, more=1)", ", line 12: dissemination must take 2"),
        ("import math", "import maths", ", line 3: imports maths; a strategy may import math only"),
        ("import math", "from . import math", ", line 3: imports .; a strategy may import math only"),
        ("import math", "import numpy", ", line 3: imports numpy; a strategy may import math only"),
        ("import math", "import feasibee.engine", ", line 3: imports feasibee.engine; a strategy may import"),
        ("    return gain * quality", "    return gain *", ", line 13: SyntaxError: invalid syntax"),
        ("    return gain * quality", "  return gain\n   + 3", ", line 14: IndentationError"),
        ("PARAMETERS = {", "PARAMETERS = {'late': 1 / 3} or {", ", line 5: PARAMETERS = {'late': 1 / 3} or"),
        ("", "def judge(known, me): pass", "has judge, by which robots pass on"),
        ("", "def declare(known, me): return 0", "has declare, by which robots pass on knowledge, but"),
        ("", "decide = 3", "decide isn't a plain function; write def decide(mind, inbox)"),
        ("", "say = max", "say isn't a plain function; write def say(mind)"),
        ("", "from math import exp as say", "say isn't a plain function; write def say(mind)"),
        ("", "@staticmethod\ndef say(mind): return 1", "say isn't a plain function; write def say(mind)"),
        ("", "def value(): return 1", "value must take 1; write def value(mind)"),
        ("", "MEMORY = -1", "MEMORY = -1 must be a whole number from 0 to 64"),
        ("", "MEMORY = 65", "MEMORY = 65 must be a whole number from 0 to 64"),
        ("", "MEMORY = True", "MEMORY = True must be a whole number"),
        ("", "MEMORY = 2.0", "MEMORY = 2.0 must be a whole number"),
        ("", "VALUE_BITS = 17", "VALUE_BITS = 17 must be a whole number from 0 to 16"),
        ("", "FORGETS = 1", "FORGETS = 1 must be True or False"),
        ("", "MODULATES = 1", "MODULATES = 1 must be True or False"),
        ("", "MODULATES = True", "both MODULATES = True and dissemination, which say for how long robots"),
        (
            "def dissemination(quality",
            "MODULATES = True\ndef lasting(mind",
            "both MODULATES = True and lasting",
        ),
        ("", "STARTS_NEUTRAL = 'no'", "STARTS_NEUTRAL = 'no' must be True or False"),
        ("", "ONE_CLASS = 1", "ONE_CLASS = 1 must be True or False"),
        ("", "MEMORY = 1 + 1", "MEMORY = 1 + 1 must be a whole number from 0 to 64, written out"),
        ("", "MEMORY: int", "MEMORY = ... must be a whole number"),
        ("", "PARAMETERS = ['weight']", "PARAMETERS = ['weight'] must be a dict of names and numbers"),
        ("", "PARAMETERS = {'weight': 'x'}", "must be a dict of names and numbers"),
        ("", "PARAMETERS = {'weight': float('nan')}", "must be a dict of names and numbers"),
        ("", "PARAMETERS = {3: 1.0}", "must be a dict of names and numbers"),
        ("", "PARAMETERS = {'\x1b[31m': 1.0}", r"PARAMETERS = {'\x1b[31m': 1.0} must be a dict of names"),
        *(
            ("", each, f"line 22: {shown} at the top level; write only imports, constants and functions")
            for each, shown in (
                ("print('\x1b[31m')", r"print('\x1b[31m')"),
                ("1 / 0", "1 / 0"),
                ("if math.pi > 3: MEMORY = 1", "if math.pi > 3:"),
                ("PARAMETERS['more'] = 1.0", "PARAMETERS['more'] = 1.0"),
                ("math.pi = 3", "math.pi = 3"),
                ("for k in range(3): pass", "for k in range(3):"),
            )
        ),
        *(
            ("    lead = ", f"    {each}\n    lead = ", f"line 17: has {what}, which no strategy has; {then}")
            for each, what, then in (
                ("global N", "global", "keep numbers in mind.memory"),
                ("raise GeneratorExit", "raise", "return a value"),
                ("raise KeyboardInterrupt", "raise", "return a value"),
                ("try: pass\n    finally: pass", "try", "test with if"),
                ("with mind: pass", "with", "write assignments"),
                ("class A: pass", "class", "write functions"),
                ("async def f(): await g()", "async", "write def"),
                ("import math", "import in a function", "import at the top level"),
                ("say = lambda: yes", "lambda", "write def"),
                ("yield 1", "yield", "write into the row"),
                ("del mind", "del", "leave it out"),
                ("print(1)", "print", "leave it out"),
                ("p = [print][0]", "print", "leave it out"),
                ("exit(1)", "exit", "leave it out"),
            )
        ),
        ("    lead = ", "    raise BaseException('x')\n    lead = ", "line 17: has raise"),
        ("", "X = 9223372036854775808", "line 22: a number leaves 64 bits; write one below 2**63"),
        ("", "raise BaseException('x')", "line 22: has raise, which no strategy has"),
        ("", f"X = {'-' * 50_000}1", "nests too deep for Python; write long expressions in several"),
        ("", f"X = {'-' * 500}1", "line 22: nests more than 150 levels deep; write long expressions"),
        ("", f"X = 1{' + 1' * 500}", "line 22: nests more than 150 levels deep; write long expressions"),
    ],
    "set": [
        *(
            (f"def {each}(", f"def other_{each}(", f"{each}; write def {each}({', '.join(ARGUMENTS[each])})")
            for each in KNOWLEDGE
        ),
        ("def merge(known, message, sender, me)", "def merge(known, me)", ", line 26: merge must take 4"),
        ("def bits(message, me)", "def bits(message, *me)", "bits must take 2; write def bits(message, me)"),
        ("BY_NAME = True", "BY_NAME = 1", ", line 3: BY_NAME = 1 must be True or False"),
        ("", "def message_words(setting): return 3", "has message_words, but no function encode"),
        ("def start(", "start = 3\n\n\ndef begin(", "start isn't a plain function; write def st"),
    ],
    "fading": [
        ("", "def declare(known, me): return -1", "remove def judge or def declare"),
    ],
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
        ("(tasks_seen -", "(9**9**9 + tasks_seen -", "line 9: quality(0, 0) fails: OverflowError: 9 ** 387"),
        ("(tasks_seen -", "(task_seen -", "line 9: quality(0, 0) fails: NameError: name 'task_seen'"),
        ("inbox.feasible_votes -", "inbox.votes -", "line 17: decide(", "fails: AttributeError: "),
        ("mind.parameters[0]", "mind.parameters[1]", "line 18: decide(", "fails: IndexError"),
        ("mind.parameters[0]", "mind.memory[0]", "line 18: decide(", "fails: IndexError"),
        ("math.exp(0.1", "math.log(-5 + 0 * 0.1", "line 9: quality(0, 0) fails: ValueError"),
        ("1.0 / (1.0 + ", "1.0 / (robots_seen + 0 * ", "line 9: quality(0, 0) fails: ZeroDivision"),
        ("    lead = ", "    return 2\n    lead = ", "line 16: ", "returns 2; must be 1, 0, or -1 for none"),
        ("    lead = ", "    return None\n    lead = ", "line 16: ", "returns None; must be 1, 0, or -1 for"),
        ("gain * quality", "None", "line 12: ", "returns None; must be a number of steps from 0"),
        ("gain * quality", "math.inf", "line 12: ", "returns inf; must be a number of steps from 0"),
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
        ("known[me.id] = 1", "known[len(known)] = 1", "line 18: ", "fails: IndexError"),
        ("known[me.id] = 1", "return [me.id]", "line 16: ", "returns [0]; must return nothing: it writes in"),
        ("known[thing.id if", "known[thing.name if", "line 23: ", "'Thing' object has no attribute 'name'"),
        ("known[k] = max(", "message[k] = max(", "line 29: ", "TypeError: 'tuple' object does not support"),
        ("] += known[k]", "] -= 1", "line 32: count writes [-3, -4] into counts; must be"),
        ("] += known[k]", "] += 0.5", "line 32: count writes [1.5, 2.0] into counts"),
        ("else 1] +=", "else 5] +=", "line 35: ", "IndexError: list index out of range"),
        ("return length", "return -1", "line 38: ", f"returns -1; {WHOLE}"),
        ("return length", "return length / 2", "line 38: ", WHOLE),
        ("return length", "return None", "line 38: ", f"returns None; {WHOLE}"),
    ],
    "quiet": [
        (SURE, "    return 2", DECLARE, "returns 2; must be 1, 0, or -1 for none"),
        (SURE, "    return me.y_coordinate", "declare(", "has no attribute 'y_coordinate'"),
        ("larger(robots + tasks, 1)", "(robots + tasks)", "line 14: quality(0, 0) fails: ZeroDiv"),
    ],
    "fading": [
        (JUDGED, "    return 2", JUDGE),
    ],
}


@pytest.mark.parametrize(("name", "row"), [(name, row) for name, rows in TRIED.items() for row in rows])
def test_what_fails_when_it_is_tried_is_told_with_its_line(spoil, name, row):
    old, new, *words = row
    text = why_not(spoil(name, old, new))
    assert text.startswith("mine.py"), text
    assert all(each in text for each in words), text


# --- When it is compiled ---

MERGING = "    for k in range(len(known)):\n        known[k] = max("
MAX = "known[k], message[k])\n"
COMPILED = {
    "mine": [
        (
            "    lead = inbox.f",
            "    lead = {1: inbox.feasible_votes}.get(2, 0)\n    lead = inbox.f",
            "17: decide doesn't compile: {1: inbox.feasible_votes}",
        ),
        (
            "    if abs(lead)",
            "    if lead > 100:\n        return inbox.voices\n    if abs(lead)",
            "19: decide doesn't compile: inbox.voices; use one of feasible_votes, infeasible_votes, heard_op",
        ),
        (
            "        return mind.opinion",
            "        return [mind.opinion, 1][0]",
            "19: decide doesn't compile: [mind.opinion, 1]; write it with numbers, rows and calls",
        ),
    ],
    "set": [
        ("known[me.id] = 1", "known[me.id] = {1: 1}[1]", "18: start"),
        (
            "known[me.id] = 1",
            "known[me.id] = len(list(known)) > 0",
            "18: start doesn't compile: list(...); keep numbers in the row of words",
        ),
        ("return length\n", "if length > 9999999:\n        return 0.5\n    return length\n", "38: bits"),
        (MERGING, f"    if me.step == 77:\n        return 1\n{MERGING}", "26: merge"),
        (MAX, f"{MAX}        if me.step == 77:\n            message[k] = 0\n", "31: merge"),
    ],
    "quiet": [
        (SURE, "    return 0.5 if me.step == 33 else -1", "declare"),
        (SURE, "    return [1, 0][0]", "declare"),
        ("    return opinion\n", "    return kept(opinion - 1) if opinion > 5 else opinion\n", "decide"),
    ],
    "fading": [
        (
            JUDGED,
            "    return 0.5 if me.step == 33 else -1",
            "judge doesn't compile: it must return a whole number",
        ),
    ],
}


@pytest.mark.parametrize(("name", "old", "new", "words"), cases(COMPILED, pytest.mark.slow))
def test_what_does_not_compile_is_told_with_function_and_line(spoil, name, old, new, words):
    scenario = spoil(name, old, new, **{"run.steps": 5})
    assert simulate_record(scenario, Runs(1, 0), backend="reference").runs == 1  # Python has no trouble
    text = why_not(scenario)
    assert "mine.py" in text
    assert words in text
    assert "doesn't compile" in text


# --- Only in a run ---

RARE, LATE = "0.0 < inbox.chance < 0.2", "20 < me.step < 1000"
"""No trial has such a chance or step."""


def rarely(line):
    return "    lead = inbox", f"    if {RARE}:\n        {line}\n    lead = inbox"


DECIDE = r"decide\(Mind\(opinion=\d.*"
RUN = {
    "mine": [
        (*rarely("lead = mind.memory[5]"), f"line 18: {DECIDE}fails: IndexError: "),
        (*rarely("lead = 1 / (mind.opinion - mind.opinion)"), f"line 18: {DECIDE}fails: ZeroDivisionError: "),
        (
            *rarely("lead = abs(mind.opinion - 3037000600) * (mind.opinion - 3037000600)"),
            rf"line 18: {DECIDE}fails: OverflowError: 30370\d+ \* -30370\d+ leaves 64 bits",
        ),
        (
            *rarely("lead = mind.opinion - 3 << 63"),
            rf"line 18: {DECIDE}OverflowError: -\d << 63 leaves 64 bits",
        ),
        (*rarely("return 7"), f"line 16: {DECIDE}returns 7; must be 1, 0, or -1 for none"),
        (*rarely("return 0.5"), f"line 16: {DECIDE}returns 0.5; must be 1, 0, or -1 for none"),
        (
            *rarely("return None if inbox.chance < 0.9 else 1"),
            f"line 16: {DECIDE}returns None; must be 1, 0,",
        ),
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
        (
            "        counts[0 if",
            f"        if {LATE}:\n            counts[1] = -5\n            return\n        counts[0 if",
            r"line 32: count writes \[0, -5\] into counts; must be whole numbers",
        ),
        (
            "    length = 2\n",
            f"    length = -me.step if {LATE} else 2\n    if length < 0:\n        return length\n",
            r"line 38: bits\(.*returns -\d+; must be a",
        ),
        (MERGING, MERGING.replace("known))", f"known) + ({LATE}))"), r"line 29: merge\(.*fails: IndexError"),
        (
            "known[thing.id if",
            f"known[1 // (1 - ({LATE})) * thing.id if",
            r"line 23: observe\(.*ZeroDivisionErr",
        ),
    ],
    "quiet": [
        (SURE, "    return 7 if me.step == 33 else -1", r"declare\(.*returns 7; must be 1, 0, or -1"),
        (SURE, "    return -1 // (1 - (me.step == 33))", r"declare\(.*fails: ZeroDivisionError"),
    ],
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
