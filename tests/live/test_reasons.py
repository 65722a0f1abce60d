"""What the page says of a robot: its own state, and what its own controller does next."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from playing import swarm_at

from feasibee import FeasibeeError, Scenario, Swarm
from feasibee.live.reasons import OPINIONS, opinion_of, reasons_of, sentence_of
from feasibee.live.timeline import BACK, History, Timeline
from feasibee.scenario.units import duration
from feasibee.simulation.snapshot import FLAGS
from feasibee.strategies import STRATEGIES, census


def said(swarm, robot):
    return dict(reasons_of(swarm, robot))


def test_each_strategy_is_told_in_words():
    for name in STRATEGIES:
        swarm = Swarm(Scenario(decision={"strategy": name}, robots={"know_count": True}), 1)
        for steps in (0, 1, 40):
            swarm.advance(steps)
            for robot in range(20):
                words = said(swarm, robot)
                assert words.keys() >= {"Phase", "Quality", "Next", f"Rule of {name}"}, (name, words)
                assert "Error" not in words
                assert ("Knows" in words) == STRATEGIES[name].knowledge == ("Saw" not in words)
                assert all(text and "None" not in text for text in words.values()), words


def test_the_words_are_those_of_the_state():
    swarm = swarm_at(57, Scenario(), 1)
    state, words = swarm.robot(4), said(swarm, 4)
    assert words["Phase"] == f"exploring, {state.phase_left} steps left"
    assert words["Saw"].startswith(f"{state.robots_seen[0]} robots and {state.tasks_seen[0]} tasks so far")
    for opinion, votes in ((1, state.votes[0]), (0, state.votes[1])):
        names = ", ".join(str(sender) for sender, heard, _ in state.heard if heard == opinion)
        assert f"{votes} {OPINIONS[opinion]} (robots {names})" in words["Heard"]
    assert f"at step {57 + state.phase_left} it begins to disseminate" in words["Next"]


def test_the_words_have_seconds_and_metres_if_the_scenario_has_them():
    hall = Scenario(
        units={"metres": 0.5, "seconds": 2.0}, decision={"strategy": "census"}, acting={"start": 5}
    )
    plain, swarm = (
        swarm_at(9, hall.replace({"units.metres": None, "units.seconds": None}), 1),
        swarm_at(9, hall, 1),
    )
    timeline = Timeline(Swarm(hall, 1))
    timeline.advance(9)
    history = History(timeline)
    told = " ".join(sentence_of(swarm, each, history) for each in range(20))
    assert re.search(r"Holds \w+ since step (\d) \(\d+ s\)\. Knows: ", told)
    walks = 0
    for robot in range(20):
        words, left = said(swarm, robot), swarm.robot(robot).phase_left
        assert f"{left} step{'s' * (left > 1)} ({duration(2.0 * left)}) left" in words["Phase"]
        assert f"at step {9 + left} ({duration(2.0 * (9 + left))}) it" in words["Next"]
        away = re.search(r" ([\d.]+) units \(([\d.]+) m\) away: ", words["Acts"])
        walks += bool(away)
        assert not away or float(away[2]) == pytest.approx(float(away[1]) / 2, abs=0.03)
        bare = re.sub(r" \([\d.]+ (?:m|s|min|min \d+ s)\)", "", " ".join(words.values()))
        assert bare == " ".join(said(plain, robot).values())
    assert walks


ALONE = {"radio.range": 0.01, "robots.know_count": True, "tasks.count": 16}


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", ["dmmd", "bayes", "estimate", "tally", "census"])
def test_what_it_will_decide_is_what_it_decides(strategy):
    """Without messages, nothing that a robot knows changes while it disseminates."""
    swarm = Swarm(Scenario().replace({**ALONE, "decision.strategy": strategy}), 2)
    expected, met = {}, 0
    for _ in range(150):
        for robot in range(20):
            state = swarm.robot(robot)
            if not state.flags >> FLAGS.index("disseminating") & 1:
                continue
            words = said(swarm, robot)["Next"]
            assert f"at step {swarm.step + state.phase_left} it decides" in words
            expected[swarm.step + state.phase_left, robot] = words.rpartition(": ")[2]
        swarm.advance()
        for (step, robot), opinion in expected.items():
            if step == swarm.step:
                assert OPINIONS[opinion_of(swarm.robot(robot))] == opinion
                met += 1
    assert met > 100


def test_only_a_first_exploration_is_told_to_give_the_opinion():
    """What is said in the last step of each exploration is what the robot then holds."""
    swarm = Swarm(Scenario().replace({"decision.start": "first-sight", "tasks.count": 40}), 2)
    changed = 0
    for _ in range(60):
        ending = [
            (robot, opinion_of(state), said(swarm, robot)["Next"])
            for robot, state in ((robot, swarm.robot(robot)) for robot in range(20))
            if state.phase_left == 1 and not state.flags >> FLAGS.index("disseminating") & 1
        ]
        swarm.advance()
        for robot, before, words in ending:
            after = opinion_of(swarm.robot(robot))
            assert f"{OPINIONS[after]} has quality" in words
            changed += before != after
    assert changed > 5


def test_a_decision_by_chance_is_told_as_such():
    swarm = swarm_at(60, Scenario(decision={"strategy": "voter", "gain": 40.0}, radio={"range": 8.0}), 2)
    texts = [said(swarm, robot)["Next"] for robot in range(20)]
    assert any("by chance" in text for text in texts)


def test_robots_that_are_out_of_order_are_told_as_such():
    faults = {"stopped": 0.2, "byzantine": 0.2, "stubborn": 0.2}
    swarm = swarm_at(200, Scenario(faults=faults, decision={"declare": {}}), 2)
    texts = [said(swarm, robot) for robot in range(20)]
    assert sum(words["Phase"] == "stopped" for words in texts) == 4
    special = [words.get("Special", "") for words in texts]
    assert sum("Byzantine: it broadcasts what is false" in each for each in special) == 4
    assert sum(each.startswith("stubborn") and "keeps its opinion" in each for each in special) == 4


def test_classes_are_counted_by_name():
    robots = {"classes": [{"name": "arm", "count": 9, "skills": ["lift"]}, {"name": "eye", "count": 4}]}
    tasks = {"classes": [{"name": "carry", "count": 3, "needs": {"lift": 2}}]}
    swarm = swarm_at(30, Scenario(robots=robots, tasks=tasks, arena={"side": 8.0}), 2)
    assert "(arm " in said(swarm, 3)["Saw"]
    assert "(carry " in said(swarm, 3)["Saw"]


def test_an_error_in_a_users_strategy_is_told(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "def quality(robots_seen, tasks_seen):\n    return 0.5 + 0.1 * (1 / (robots_seen - 7.5) > 9)\n"
        "def decide(mind, inbox):\n    return mind.opinion\n"
    )
    words = said(Swarm(Scenario(decision={"strategy": str(file)}), 2), 3)
    assert words["Next"]
    assert not any(title.startswith("Rule") for title in words)  # its functions have no docstrings


@pytest.mark.parametrize("told", ["'mine: ' + str(len(known))", "None", "3", "1 / 0"])
def test_a_users_strategy_describes_what_is_known(tmp_path, told):
    file = tmp_path / "mine.py"
    file.write_text(f"{Path(census.__file__).read_text()}\n\ndef describe(known, me):\n    return {told}\n")
    scenario = Scenario(decision={"strategy": str(file)})
    if told.startswith("'"):
        assert said(Swarm(scenario, 1), 3)["Knows"] == "mine: 2"
    else:
        with pytest.raises(FeasibeeError, match=r"mine\.py, line \d+: describe"):
            Swarm(scenario, 1)


def test_an_opinion_that_follows_knowledge_is_told_as_such():
    swarm = swarm_at(60, Scenario(decision={"strategy": "roster"}), seed=3)
    lines = [dict(reasons_of(swarm, robot)) for robot in np.flatnonzero(swarm.disseminating)]
    assert lines
    assert all("its opinion follows what it knows in any step" in each["Next"] for each in lines)


@pytest.mark.parametrize("steps", [300, 700])
def test_a_sentence_says_since_when_an_opinion_is_held_and_what_was_heard_since(steps):
    """Steps beyond the last 400 are not looked at: what was so then is said to be so since before."""
    swarm, walk = Swarm(Scenario(tasks={"count": 50}), 1), Swarm(Scenario(tasks={"count": 50}), 1)
    timeline = Timeline(swarm)
    history = History(timeline)
    timeline.advance(steps)
    opinions, sends = [walk.opinions], [walk.disseminating]
    for _ in range(steps):
        walk.advance()
        opinions.append(walk.opinions)
        sends.append(walk.disseminating)
    first = max(0, steps - BACK)
    for robot in range(20):
        held = max(
            (k for k in range(first + 1, steps + 1) if opinions[k][robot] != opinions[k - 1][robot]),
            default=first,
        )
        decided = max(
            (k for k in range(first + 1, steps + 1) if sends[k - 1][robot] > sends[k][robot]), default=first
        )
        said = sentence_of(swarm, robot, history)
        since = f"step {held}" if held > first else f"step {first} or before" if first else "the start"
        assert said.startswith(f"Holds {OPINIONS[opinions[steps][robot]]} since {since}. Heard ")
        assert said.endswith(f" since its decision at step {decided}.")
        for votes, opinion in zip(swarm.robot(robot).votes, (1, 0), strict=True):
            assert (f"{votes} {OPINIONS[opinion]}" in said.partition("Heard")[2]) == bool(votes)
    assert swarm.step == steps


def test_a_sentence_follows_a_run_back_and_forth():
    swarm = Swarm(Scenario(decision={"strategy": "census"}), 1)
    timeline = Timeline(swarm)
    history, seen = History(timeline), {}
    for step in (20, 60, 20, 61, 60):
        timeline.rewind(step)
        timeline.advance(step)
        said = [sentence_of(swarm, robot, history) for robot in range(20)]
        assert seen.setdefault(step, said) == said
    assert "Knows: 20 robots and 20 tasks" in " ".join(seen[61])


def test_a_broadcast_lasts_at_least_one_step():
    """A duration is rounded up to whole steps (model.md 3.4)."""
    scenario = Scenario(decision={"strategy": "dmmd", "gain": 0.1}, tasks={"count": 0})
    for robot in range(20):
        words = said(swarm_at(5, scenario, 1), robot)
        if "broadcasts for" in words["Next"]:
            assert float(words["Next"].partition("broadcasts for ")[2].split()[0]) >= 1
        assert "rho" not in words["Rule of dmmd"]
