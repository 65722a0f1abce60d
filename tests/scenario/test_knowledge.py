"""Knowledge in a user's file: equal in both implementations, at speed; errors name function and line."""

from __future__ import annotations

import numpy as np
import pytest
from own_files import OPINIONS, SET, assert_same, copy_of, replaced, why_not

from feasibee import Scenario, ScenarioError
from feasibee.strategies.words import Words

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
    message[0] = known[1]
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
    return me.setting.id_bits + 33 * (len(message) - 1) + me.step % 3 + message[0] % 7
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
"""The reference takes seconds, so the fast tests have two worlds."""


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


@pytest.mark.quick(1)
@pytest.mark.parametrize("changes", [{}, {"tasks.count": 0}, {"robots.count": 40}])
def test_false_sightings_are_things_without_an_id_and_with_hashes_of_their_own(write, changes):
    changes = {**changes, "sensing.false_robots": 0.5, "sensing.false_tasks": 0.7, "sensing.miss": 0.1}
    assert_same(*2 * [scenario_of(write(TURNS), **changes)])
    with pytest.raises(ScenarioError, match=r"sensing\.false_robots = 0\.5: .*counts things by name"):
        scenario_of(write(SET, "set.py"), **changes)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["census", "tally"])
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
