"""Knowledge in a user's file: equal in both implementations, at speed; errors name function and line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from own_files import assert_same, copy_of, replaced, why_not

from feasibee import FeasibeeError, Scenario, ScenarioError
from feasibee.engine.runner import strategy_functions
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import ARGUMENTS, KNOWLEDGE
from feasibee.strategies.words import Words

SET = (Path(__file__).parents[2] / "examples" / "roll_call.py").read_text(encoding="utf-8")
"""A grow-only set of the ids of robots and tasks."""
OPINIONS = SET.partition("\n\ndef words")[0]
TURNS = (
    OPINIONS.replace("BY_NAME = True", 'PARAMETERS = {"names": 2.0}\nMEMORY = 1')
    + """

def words(setting):
    return 4 + setting.robots + setting.task_ids


def message_words(setting):
    return 1 + int(setting.parameters[0])


def observe(known, thing, me):
    if thing.id < 0:
        known[0] += 1
    elif not thing.is_robot:
        known[4 + me.setting.robots + thing.id] = 1 + thing.kind
    known[1] ^= thing.hash >> 3


def encode(message, known, me):
    message[0] = me.id
    tasks = me.setting.task_ids
    for k in range(1, len(message)):
        message[k] = -1
        for _ in range(tasks):
            known[2] = (known[2] + 1) % tasks
            if known[4 + me.setting.robots + known[2]] > 0:
                message[k] = known[2]
                break
    known[3] = me.step


def lie(message, feasible, me):
    for k in range(1, len(message)):
        message[k] = -1 if feasible == 1 else me.setting.tasks + (me.step + k) % (me.setting.robots + 1)


def merge(known, message, sender, me):
    known[4 + sender] = 1 + me.step
    for k in range(1, len(message)):
        if message[k] >= 0:
            known[4 + me.setting.robots + message[k]] = 1
    me.memory[0] += 1.0 / (1 + sender)


def count(known, counts, me):
    for k in range(me.setting.robots):
        counts[me.kind] += known[4 + k] > me.step - 40
    for k in range(me.setting.robots + 4, len(known)):
        counts[me.setting.robot_classes] += known[k].bit_length()
    counts[0] += int(me.memory[0]) + (known[0] + known[1].bit_count()) % 3


def bits(message, me):
    return me.setting.id_bits + 33 * (len(message) - 1) + me.step % 3
"""
)
SMALL = {"arena.side": 8.0, "run.steps": 60, "tasks.count": 12}
CLASSES = {
    "robots.classes": [{"name": "a", "count": 9, "skills": ["x"]}, {"name": "b", "count": 8}],
    "tasks.classes": [
        {"name": "c", "count": 5, "needs": {"x": 1}},
        {"name": "d", "count": 4, "needs": {"x": 2}},
    ],
}
LIARS = {"faults.byzantine": 0.2}
WORLDS = {
    "paper": {},
    "many robots": {"robots.count": 40, "arena.side": 10.0},
    "liars": LIARS,
    "feasible liars": {**LIARS, "faults.byzantine_says": "feasible", "radio.loss": 0.2},
    "random liars": {**LIARS, "faults.byzantine_says": "random", "radio.id_bits": 3},
    "classes and liars": {**CLASSES, **LIARS, "tasks.count": None},
    "commits": {"decision.declare": {"quorum": 0.6, "rounds": 1, "heard": 1}},
}
COSTLY_WORLDS = [
    pytest.param(name, marks=[] if name in ("paper", "classes and liars") else [pytest.mark.slow])
    for name in WORLDS
]
"""Each file is compiled for 3 s, so the fast tests have two worlds."""


def scenario_of(path, **changes):
    changes = {**SMALL, "decision.strategy": str(path), **changes}
    return Scenario().replace({key: value for key, value in changes.items() if value is not None})


# --- A file of one's own ---


@pytest.mark.parametrize("world", [each for each in COSTLY_WORLDS if "classes" not in each.values[0]])
def test_a_users_grow_only_set_is_the_census_to_the_bit(write, world):
    census = Scenario().replace({**SMALL, **WORLDS[world], "decision.strategy": "census"})
    record = assert_same(census, scenario_of(write(SET), **WORLDS[world]))
    assert (record.bits_sent > 0).all()


@pytest.mark.quick(1)
@pytest.mark.parametrize("world", COSTLY_WORLDS)
def test_all_that_the_contract_offers_is_equal_in_engine_and_reference(write, world):
    """Messages of their own size, memory, steps, senders, hashes, classes, parameters and lies."""
    path = write(TURNS)
    few = assert_same(*2 * [scenario_of(path, **WORLDS[world])])
    more = {"decision.parameters": {"names": 5.0}}
    many = assert_same(*2 * [scenario_of(path, **WORLDS[world], **more)])
    assert (many.bits_sent > 1.5 * few.bits_sent).all()
    assert (few.feasible_count < few.feasible_count.max()).any()


def test_false_sightings_are_things_without_an_id(write):
    changes = {"sensing.false_robots": 0.5, "sensing.false_tasks": 0.7, "sensing.miss": 0.1}
    assert_same(*2 * [scenario_of(write(TURNS), **changes)])
    with pytest.raises(ScenarioError, match=r"sensing\.false_robots = 0\.5: .*counts things by name"):
        scenario_of(write(SET, "set.py"), **changes)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["census", *(pytest.param(name, marks=pytest.mark.slow) for name in ("tally", "sketch"))]
)
def test_a_copy_of_a_built_in_strategy_is_that_strategy(write, name):
    path = write(copy_of(name))
    for world in ("paper", "random liars", "classes and liars"):
        changes = {**SMALL, **WORLDS[world], "decision.strategy": name}
        built_in = Scenario().replace({key: each for key, each in changes.items() if each is not None})
        assert_same(built_in, scenario_of(path, **WORLDS[world]))


@pytest.mark.slow
def test_more_is_seen_and_heard_in_a_step_than_is_collected_at_once(write):
    """256 calls are collected; here a robot sees 150 tasks and hears 39 robots in a step."""
    changes = {
        "robots.count": 40,
        "tasks.count": 150,
        "sensing.range": 4.0,
        "radio.range": 4.0,
        "run.steps": 12,
    }
    assert_same(*2 * [scenario_of(write(TURNS), **changes)])
    census = Scenario().replace({**SMALL, **changes, "decision.strategy": "census"})
    assert_same(census, scenario_of(write(SET, "set.py"), **changes))


@pytest.mark.slow
def test_compiled_knowledge_is_loaded_in_a_second_process(write):
    path = write(SET)
    code = (
        "import sys\n"
        "from feasibee import Scenario, simulate\n"
        "from feasibee.engine import compile\n"
        "saved = []\n"
        "compile.Kept.save_overload = lambda self, sig, data: saved.append(self._name)\n"
        f"s = Scenario().replace({{'decision.strategy': {str(path)!r}, 'run.steps': 20}})\n"
        "print(int(simulate(s, runs=3, seed=1).bits_sent.sum()), saved)"
    )
    large = {"arena.side": 20.0, "tasks.count": None, "run.steps": 20}
    total = int(simulate_record(scenario_of(path, **large), Runs(3, 1)).bits_sent.sum())
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == f"{total} []\n"


# --- Hostile values ---


@pytest.mark.parametrize(
    ("value", "word"),
    [
        (2**31 - 1, 2**31 - 1),
        (2**31, -(2**31)),
        (-1, -1),
        (2**32 + 5, 5),
        (-(2**31) - 1, 2**31 - 1),
        (True, 1),
    ],
)
def test_words_wrap_as_in_the_engine(value, word):
    words = Words([0, 0])
    words[1] = value
    assert words == [0, word]
    words[:] = (value, 7)
    assert words == [word, 7]


@pytest.mark.parametrize("value", [0.5, 1.0, "1", None, [1]])
def test_a_word_is_a_whole_number(value):
    with pytest.raises(TypeError):
        Words([0])[0] = value


def test_a_row_keeps_its_length():
    with pytest.raises(ValueError, match="3 words don't fit 2"):
        Words([0, 0])[:] = (1, 2, 3)


@pytest.mark.slow
def test_words_that_overflow_are_equal_in_both_implementations(write):
    text = replaced(
        SET, "    known[me.id] = 1\n", "    known[me.id] = 1\n    known[0] = 123456789 * (3 + me.hash)\n"
    )
    text = replaced(
        text, "        known[k] = max(known[k], message[k])", "        known[k] = known[k] * 3 - message[k]"
    )
    text = replaced(text, "+= known[k]", "+= known[k] >> (0 if k < me.setting.robot_ids else 20) & 1023")
    text = replaced(text, "length += message[k] *", "length += (message[k] & 7) *")
    record = assert_same(*2 * [scenario_of(write(text))])
    assert np.ptp(record.feasible_count) > 0


# --- What is wrong with a file ---

MERGING = "    for k in range(len(known)):\n        known[k] = max("


@pytest.mark.parametrize("name", KNOWLEDGE)
def test_a_missing_function_is_told_with_what_to_write(write, name):
    head, _, rest = SET.partition(f"def {name}(")
    text = head + rest.partition("\n\n\n")[2]
    with pytest.raises(ScenarioError) as caught:
        scenario_of(write(text))
    wanted = f"no function {name}; write def {name}({', '.join(ARGUMENTS[name])})"
    assert wanted in str(caught.value)
    assert "by which robots pass on knowledge" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "def merge(known, message, sender, me)",
            "def merge(known, message, me)",
            "line 26: merge must take 4",
        ),
        ("def bits(message, me)", "def bits(message, *me)", "bits must take 2; write def bits(message, me)"),
        ("BY_NAME = True", "BY_NAME = 1", "line 3: BY_NAME = 1 must be True or False"),
        ("def start(", "def message_words(setting): return 3\n\n\ndef start(", "function encode"),
        ("def start(", "start = 3\n\n\ndef begin(", "start isn't a plain function; write def st"),
    ],
)
def test_what_is_wrong_with_the_text_is_told(write, old, new, words):
    with pytest.raises(ScenarioError) as caught:
        scenario_of(write(replaced(SET, old, new)))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("setting.robot_ids + setting.task_ids", "0", 11, "words(Setting("),
        ("setting.robot_ids + setting.task_ids", "0.5", 11, "returns 0.5; must be a whole"),
        ("known[me.id] = 1", "known[me.id] = 0.5", 18, "start(["),
        ("known[me.id] = 1", "known[len(known)] = 1", 18, "fails: IndexError"),
        ("known[me.id] = 1", "return [me.id]", 16, "returns [0]; must return nothing: it writes into kn"),
        ("known[thing.id if", "known[thing.name if", 23, "'Thing' object has no attribute 'name'"),
        ("known[k] = max(", "message[k] = max(", 29, "TypeError: 'tuple' object does not support"),
        ("] += known[k]", "] -= 1", 32, "count writes [-3, -4] into counts; must be"),
        ("] += known[k]", "] += 0.5", 32, "count writes [1.5, 2.0] into counts"),
        ("else 1] +=", "else 5] +=", 35, "IndexError: list index out of range"),
        ("return length", "return -1", 38, "returns -1; must be a whole number from 0 to 1099511627776"),
        ("return length", "return length / 2", 38, "must be a whole number from 0"),
        ("return length", "return None", 38, "returns None; must be a whole number from 0"),
    ],
)
def test_what_fails_when_it_is_tried_is_told_with_function_and_line(write, old, new, line, words):
    text = why_not(scenario_of(write(replaced(SET, old, new))))
    assert text.startswith(f"mine.py, line {line}: "), text
    assert words in text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("known[me.id] = 1", "known[me.id] = {1: 1}[1]", 18, "start doesn't compile"),
        ("known[me.id] = 1", "known[me.id] = len(list(known)) > 0", 16, "it must not make lists"),
        ("return length\n", "if length > 9999999:\n        return 0.5\n    return length\n", 38, "bits"),
        (MERGING, f"    if me.step == 77:\n        return 1\n{MERGING}", 26, "merge"),
        (
            "known[k], message[k])\n",
            "known[k], message[k])\n        if me.step == 77:\n            message[k] = 0\n",
            31,
            "merge doesn't compile",
        ),
    ],
)
def test_what_does_not_compile_is_told_with_function_and_line(write, old, new, line, words):
    path = write(replaced(SET, old, new))
    assert simulate_record(scenario_of(path, **{"run.steps": 5}), Runs(1, 0), backend="reference").runs == 1
    text = why_not(scenario_of(path, **{"run.steps": 5}))
    assert f"mine.py, line {line}: " in text, text
    assert words in text
    assert "doesn't compile" in text


LATE = "20 < me.step < 1000"  # no trial has it


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        (
            "        counts[0 if",
            f"        if {LATE}:\n            counts[1] = -5\n            return\n        counts[0 if",
            r"line 32: count writes \[0, -5\] into counts; must be whole numbers",
        ),
        (
            "    length = 2\n",
            f"    if {LATE}:\n        return -me.step\n    length = 2\n",
            r"line 38: bits\(.*returns -\d+; must be a",
        ),
        (MERGING, MERGING.replace("known))", f"known) + ({LATE}))"), r"line 29: merge\(.*fails: IndexError"),
        (
            "    known[thing.id if",
            f"    one = 1 // (1 - ({LATE}))\n    known[one * thing.id if",
            r"line 23: observe\(.*fails: ZeroDivisionError",
        ),
    ],
)
def test_what_fails_only_in_a_run_is_told_with_function_line_and_run(write, old, new, why):
    scenario = scenario_of(write(replaced(SET, old, new)))
    said = rf"^mine\.py, {why}.*\(in run \d of seed 1\)$"
    with pytest.raises(FeasibeeError, match=said) as engine:
        simulate_record(scenario, Runs(2, 1), threads=1)
    with pytest.raises(FeasibeeError) as reference:
        simulate_record(scenario, Runs(2, 1), backend="reference")
    assert str(engine.value)[:60] == str(reference.value)[:60]  # long arguments are shortened


@pytest.mark.slow
def test_liars_with_a_message_of_its_own_need_a_function(write):
    head, _, rest = TURNS.partition("def lie(")
    path = write(head + rest.partition("\n\n\n")[2])
    assert_same(*2 * [scenario_of(path)])
    with pytest.raises(
        ScenarioError, match=r"faults\.byzantine = 0\.2: .*mine\.py has encode, but no .*def lie"
    ):
        scenario_of(path, **LIARS)


@pytest.mark.slow
def test_knowledge_that_does_not_fit_is_told_when_it_runs(write):
    text = replaced(SET, "return setting.robot_ids + setting.task_ids", "return 1000 * setting.robots")
    changes = {"robots.count": 1000, "arena.side": 100.0}
    text = why_not(scenario_of(write(text), **changes))
    assert "what 1000 robots know would take 7 GiB, over 4; take fewer robots" in text


FALSE_NAMES = (
    OPINIONS.replace("BY_NAME = True", "")
    + """

def words(setting):
    return 2


def observe(known, thing, me):
    if thing.id < 0:
        known[0] += 1
        known[1] = (known[1] + thing.hash) % 10007


def merge(known, message, sender, me):
    pass


def count(known, counts, me):
    counts[0] = known[0]


def bits(message, me):
    return message[1]
"""
)


@pytest.mark.quick(1)
@pytest.mark.parametrize("changes", [{}, {"tasks.count": 0}, {"robots.count": 40}])
def test_a_false_sighting_has_a_hash_of_its_own(write, changes):
    """The bits sum up hashes: they differ between the implementations if any hash does."""
    scenario = Scenario(
        decision={"strategy": str(write(FALSE_NAMES))},
        sensing={"false_robots": 0.3, "false_tasks": 0.2},
        run={"steps": 50},
    ).replace(changes)
    record = assert_same(scenario, scenario)
    assert (record.bits_sent > 1000 * scenario.robots.count).all()


def test_the_compiled_code_of_each_strategy_has_a_name_of_its_own():
    """The linker finds code by name: one strategy ran another's, when other processes had compiled both."""
    names = [
        overload.fndesc.qualname
        for name in ("tally", "estimate", "census", "sketch")
        for overload in strategy_functions(STRATEGIES[name]).update.overloads.values()
    ]
    assert len(set(names)) == 4, names
