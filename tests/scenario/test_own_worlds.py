"""Users' strategies in many worlds: the engine gives the runs of the reference, to the bit."""

from __future__ import annotations

import inspect

import pytest
from own_files import FADING, MINE, QUIET, SET, assert_same, copy_of, replaced, why_not

from feasibee import Scenario, ScenarioError
from feasibee.strategies import STRATEGIES
from feasibee.strategies.words import Words

SMALL = {"arena.side": 8.0, "run.steps": 60, "tasks.count": 12, "robots.know_count": True}
LIARS = {"faults.byzantine": 0.2}
COLLUDERS = {"faults.byzantine": 0.15, "faults.byzantine_says": "colluding"}
BODIES = {"arena.boundary": "walls", "robots.avoid_collisions": True}
FAULTY = {"faults.stopped": 0.2, "faults.stop_step": 25, "faults.stubborn": 0.2}
CLASSES = {
    "robots.classes": [{"name": "a", "count": 9, "skills": ["x"]}, {"name": "b", "count": 8}],
    "tasks.classes": [
        {"name": "c", "count": 5, "needs": {"x": 1}},
        {"name": "d", "count": 4, "needs": {"x": 2}},
    ],
    "tasks.count": None,
}
FALSE = {"sensing.false_robots": 0.5, "sensing.false_tasks": 0.7, "sensing.miss": 0.1}
LEAD = "    lead = "
MIND = f"""
    if mind.quality + mind.feasible_quality + mind.own_vote + inbox.heard_value < 0.0:
        return -1
    if inbox.chance < 0.1 and inbox.heard_opinion >= 0 and inbox.mean_value < 0.9:
        return inbox.heard_opinion
    mind.memory[1] += 1.0
    if mind.memory[1] > 3.0:
        return -1
{LEAD}"""
ALL = """
MEMORY = 2
VALUE_BITS = 3
FORGETS = False
STARTS_NEUTRAL = False


def say(mind):
    return 1 if mind.memory[1] > 1.0 else mind.opinion


def value(mind):
    return mind.memory[1] / 4.0


def lasting(mind, gain):
    return gain * mind.parameters[0] * mind.feasible_quality
"""
LYING = f"""{FADING}

def lie(message, feasible, me):
    message[feasible] = 99 + me.step % 7 + me.hash % 5
"""
WORLDS = [
    # users' texts, each with a world; the slow tests of conformance try more
    (replaced(MINE, LEAD, MIND) + ALL, {}),
    (replaced(QUIET, '{"quiet": 100.0}', '{"quiet": 12.0}'), COLLUDERS),
    (LYING, {"decision.gain": 5.0, **FAULTY, **LIARS, "decision.declare": {"quorum": 0.7, "rounds": 2}}),
    (LYING, {**FALSE, **BODIES, "robots.count": 40, "tasks.count": 60, "arena.side": 14.0}),
]


def scenario_of(strategy, changes):
    changes = {**SMALL, "decision.strategy": str(strategy), **changes}
    return Scenario().replace({key: value for key, value in changes.items() if value is not None})


@pytest.mark.parametrize(("text", "changes"), WORLDS)
def test_all_that_the_contract_offers_is_equal_in_engine_and_reference(write, text, changes):
    scenario = scenario_of(write(text), changes)
    assert_same(scenario, scenario)


MODULATED = replaced(MINE, "def dissemination(quality, gain):\n    return gain * quality", "MODULATES = True")
SAME = [
    # a strategy by its name or text, its text in a file, and a world
    (MINE, MODULATED, {}),
    ("voter", inspect.getsource(STRATEGIES["voter"].decide), {}),
    ("dmmd", "copy", {**LIARS, "radio.loss": 0.1, "robots.count": 40}),
    ("bayes", "copy", {**LIARS, "decision.parameters": {"credence": 0.8}}),
    ("census", SET, {}),
    ("tally", "copy", {**CLASSES, **LIARS, "faults.byzantine_says": "random", "radio.id_bits": 3}),
]


@pytest.mark.parametrize(("name", "text", "changes"), SAME)
def test_a_file_with_the_rules_of_a_built_in_strategy_is_that_strategy(write, name, text, changes):
    """Values, parameters, words, and robots without an opinion, all by the constants of the file."""
    path = write(copy_of(name) if text == "copy" else text)
    named = name if name in STRATEGIES else write(name, "named.py")
    record = assert_same(scenario_of(named, changes), scenario_of(path, changes))
    assert (record.bits_sent > 0).all()


# --- Words ---


def test_words_wrap_as_in_the_engine_and_a_row_keeps_its_length():
    words = Words([0, 0])
    for value, word in ((2**31, -(2**31)), (-1, -1), (2**32 + 5, 5), (-(2**31) - 1, 2**31 - 1), (True, 1)):
        words[1] = value
        assert words == [0, word]
        words[:] = (value, 7)
        assert words == [word, 7]
        words[:] = (0, 0)
    for value in (0.5, 1.0, "1", None, [1]):
        with pytest.raises(TypeError):
            words[0] = value
    with pytest.raises(ValueError, match="3 words don't fit 2"):
        words[:] = (1, 2, 3)


def test_liars_with_a_message_of_its_own_need_a_function(write):
    with pytest.raises(
        ScenarioError, match=r"faults\.byzantine = 0\.2: .*mine\.py has encode, but no .*def lie"
    ):
        scenario_of(write(FADING), LIARS)


def test_knowledge_that_does_not_fit_is_told_when_it_runs(write):
    text = replaced(SET, "return setting.robot_ids + setting.task_ids", "return 1000 * setting.robots")
    changes = {"robots.count": 1000, "arena.side": 100.0}
    text = why_not(scenario_of(write(text), changes))
    assert "what 1000 robots know would take 7 GiB, over 4; take fewer robots" in text
