"""What a page says of a robot: numbers of the engine in WebAssembly, and the words of reasons.js."""

from __future__ import annotations

import pytest
from in_node import told_in_node

from feasibee import Scenario
from feasibee.simulation.snapshot import FLAGS

EYES = [{"name": "eye", "count": 6, "skills": ["see"]}, {"name": "arm", "count": 9, "skills": ["grip"]}]
JOBS = [{"name": "look", "count": 5, "needs": {"see": 1}}, {"name": "lift", "count": 4, "needs": {"grip": 2}}]
WORLDS = {
    "dmmd": {"units.metres": 0.5, "units.seconds": 2.0},
    "acting": {
        "decision.strategy": "quiet-census",
        "robots.know_count": True,
        "tasks.count": 18,
        "acting.start": 40,
    },
    "classes": {
        "robots.classes": EYES,
        "tasks.classes": JOBS,
        "faults.byzantine": 0.2,
        "faults.stubborn": 0.2,
        "arena.side": 10.0,
    },
}
KNOWS = "20 robots and 18 tasks, by name"
FOUND = {
    ("dmmd", 2): {
        "Phase": "exploring, 5 steps (10 s) left",
        "Saw": "16 robots and 34 tasks so far in this exploration, each counted in every step",
        "Heard": "2 feasible (robots 1, 18), 2 infeasible (robots 11, 17)",
        "Quality": "0.31 for feasible, so 0.69 for its opinion, as it last rated it",
        "Next": "at step 60 (2 min 0 s) it begins to broadcast for 12 steps (24 s), and holds feasible",
        "Rule of dmmd": "how it rates",
    },
    ("dmmd", 12): {
        "Phase": "disseminating, 1 step (2 s) left; broadcasts feasible",
        "Saw": "1 robot and 10 tasks in its last exploration, each counted in every step",
        "Heard": "nobody since its last decision",
        "Quality": "0.09 for feasible, as it last rated it",
        "Next": "at step 60 (2 min 0 s) it decides: feasible, and explores again for 12 steps (24 s)",
        "Rule of dmmd": "how it decides",
    },
    ("acting", 1): {
        "Phase": "exploring, 2 steps left",
        "Acts": "walks to task 0, 2.4 units away: it saw or heard that it is free, but robot 11 has it; "
        "knows 18 tasks, 11 of them as free",
        "Quality": "0.53 for feasible, as it last rated it",
        "Knows": KNOWS,
        "Next": "at step 60 it begins to broadcast for 12 steps, and holds feasible",
        "Rule of quiet-census": "how it rates",
    },
    ("acting", 4): {
        "Phase": "disseminating, 14 steps left; broadcasts what it knows",
        "Acts": "stands at task 5; knows 18 tasks, 5 of them as free",
        "Quality": "0.53 for feasible, as it last rated it",
        "Knows": KNOWS,
        "Next": "at step 60 it decides: feasible, and explores again for 12 steps",
        "Rule of quiet-census": "how it decides",
    },
    ("classes", 1): {
        "Phase": "disseminating, 3 steps left; broadcasts infeasible",
        "Saw": "6 robots (eye 3, arm 3) and 2 tasks (look 2, lift 0) in its last exploration, "
        "each counted in every step",
        "Heard": "5 feasible (robots 6, 8, 9, 10, 14), 0 infeasible",
        "Quality": "0.60 for feasible, so 0.40 for its opinion, as it last rated it",
        "Next": "at step 60 it decides: feasible, and explores again for 12 steps",
        "Rule of dmmd": "how it decides",
        "Special": "Byzantine: it broadcasts what is false",
    },
    ("classes", 13): {
        "Phase": "exploring, 30 steps left",
        "Saw": "26 robots (eye 6, arm 20) and 30 tasks (look 14, lift 16) so far in this exploration, "
        "each counted in every step",
        "Heard": "3 feasible (robots 1, 10, 14), 0 infeasible",
        "Quality": "0.33 for feasible, so 0.67 for its opinion, as it last rated it",
        "Next": "at step 60 it begins to broadcast for 12 steps, and holds feasible",
        "Rule of dmmd": "how it rates",
        "Special": "stubborn; it keeps its opinion",
    },
}
SENTENCES = {
    ("dmmd", 5): "Holds feasible since step 40 (1 min 20 s) and broadcasts since the start. "
    "Heard 2 feasible, 4 infeasible since its last decision.",
    ("dmmd", 9): "Holds feasible since step 40 (1 min 20 s) and explores since the start. "
    "Heard nobody since its last decision.",
    ("acting", 1): f"Holds no opinion since step 40 and explores since the start. Knows {KNOWS}.",
}


def flags(*names):
    return sum(1 << FLAGS.index(each) for each in names)


NEXT = {"step": 60, "flags": flags("there", "working", "feasible"), "lasts": 12}


@pytest.mark.parametrize("name", WORLDS)
def test_a_page_says_what_a_robot_knows_and_what_comes(name):
    scenario = Scenario().replace(WORLDS[name])
    (told,) = told_in_node(scenario, 1, [57], next=NEXT, since={"held": 40, "begun": 0})
    rows = {each: dict(told[each[1]]["reasons"]) for each in FOUND if each[0] == name}
    assert rows == {each: FOUND[each] for each in rows}
    sentences = {each: told[each[1]]["sentence"] for each in SENTENCES if each[0] == name}
    assert sentences == {each: SENTENCES[each] for each in sentences}


@pytest.mark.parametrize(
    ("after", "said"),
    [
        (None, "decides and explores again"),
        (
            {"step": 58, "flags": flags("there", "working", "neutral"), "lasts": None},
            "decides: no opinion, and",
        ),
        ({"step": 58, "flags": flags("there"), "lasts": 3}, "it stops"),
        ({"step": 58, "flags": 0, "lasts": 3}, "it leaves"),
        (NEXT | {"flags": flags("there", "working", "declared")}, "; by then it has declared infeasible"),
    ],
)
def test_what_comes_next_may_be_another_thing(after, said):
    (told,) = told_in_node(Scenario(), 1, [57], next=after)
    words = dict(told[12]["reasons"])["Next"]
    assert words.startswith(f"at step {after['step'] if after else 58} ")
    assert said in words


def test_a_robot_that_stopped_or_is_missing_is_told_as_such():
    scenario = Scenario().replace({"faults.stopped": 0.2, "events": [{"step": 9, "robots": -3}]})
    (told,) = told_in_node(scenario, 2, [200])
    phases = [each["reasons"][0][1] for each in told]
    assert phases.count("no robot has this number at this step") == 3
    assert phases.count("stopped") in range(1, 5)


def test_to_look_at_robots_changes_no_run():
    scenario = Scenario().replace({"decision.strategy": "census", "run.steps": 60})
    often = told_in_node(scenario, 1, range(61))
    assert told_in_node(scenario, 1, [60]) == often[-1:]
