"""The edge of each rule about several fields: the last value that is valid, and the first that isn't."""

from __future__ import annotations

import pytest

from feasibee import Scenario, ScenarioError
from feasibee.scenario.setting import KNOWLEDGE_LIMIT, excess

WALLS, NARROW = {"arena.boundary": "walls"}, {"arena.side": [20.0, 8.0]}
BODIES, AT_POINTS = {"robots.avoid_collisions": True}, {"robots.placement": "points"}
TASKS_AT_POINTS = {"tasks.placement": "points"}
TWO_POINTS = {**AT_POINTS, "robots.points": [[1, 1], [3, 3]]}
CLUSTERS = {**NARROW, "tasks.placement": "clusters"}
UNIQUE = {"sensing.observation": "unique", "robots.count": 2**17}
JOINING = {"robots.most": 20, "robots.arrival_rate": 0.1}
QUIET = {"decision.strategy": "quiet-census"}
FEWER, MORE = {"step": 5, "robots": -1}, {"step": 5, "tasks": 1}
EVENT, CROWDED = {"events": [{"step": 5}]}, {"robots.most": 25, "events": [{"step": 5}]}
HALF, INSIDE = "must be at most half the side of the torus", "point 1: must be inside the arena"
APART, TAKES = "robots 1 and 2 must be more than 1 units apart", "takes away more than there are at step"


def robots_of(count, skills=0):
    return [{"name": "a", "count": count, "skills": [f"s{k}" for k in range(skills)]}]


def events(*pairs):
    return [{"step": step, "robots": robots} for step, robots in pairs]


RETURNING = {"robots.most": 25, "events": events((3, -4), (4, 1))}
EDGES = [
    # other fields, a path, its last valid value, its first invalid one, the error: a rule or the whole line
    ({}, "robots.classes", robots_of(1), robots_of(0), "robots.classes = 0: must have at least 1 robot tog"),
    (
        {},
        "robots.classes",
        robots_of(3, 8),
        robots_of(3, 9),
        "robots.classes = '9 skills': must be at most 8",
    ),
    (TWO_POINTS, "robots.count", 2, 3, "robots.points = '2 points': must be as many as robots, 3"),
    ({}, "sensing.range", 10.0, 10.0001, f"{HALF}, 10 units"),
    (NARROW, "radio.range", 4.0, 4.0001, f"{HALF}, 4 units"),
    ({"radio.range": 50.0}, "arena.boundary", "walls", "torus", f"radio.range = 50.0: {HALF}, 10 units"),
    (WALLS, "robots.speed", 10.0, 10.0001, "must be at most half the side of the arena per step, 10 units"),
    ({**WALLS, **NARROW}, "robots.diameter", 7.999, 8.0, "must be less than the arena's shorter side, 8 un"),
    (
        {**BODIES, "robots.count": 4},
        "robots.diameter",
        8.0,
        8.0001,
        "diameter + 2 speed must be at most half",
    ),
    (
        {**BODIES, "arena.side": 16.0},
        "robots.count",
        256,
        257,
        "must be at most 256, the number of discs that",
    ),
    (BODIES, "robots.contact", "deflect", "turn", "must be 'stand' or 'deflect'"),
    ({}, "robots.contact", "stand", "deflect", "needs robots.avoid_collisions = true: without it, robots"),
    (CLUSTERS, "tasks.spread", 20.0, 20.0001, "must be at most the arena's longer side, 20 units"),
    (AT_POINTS, "robots.points", [[0, 19.999]], [[0, 20.0]], f"robots.points = (0, 20.0): {INSIDE}"),
    (
        {**WALLS, **TASKS_AT_POINTS},
        "tasks.points",
        [[0, 20.0]],
        [[0, 20.0001]],
        f"tasks.points = (0, 20.0001): {INSIDE}",
    ),
    (
        {**WALLS, **AT_POINTS},
        "robots.points",
        [[0.5, 19.5]],
        [[0.4999, 19.5]],
        f"robots.points = (0.4999, 19.5): {INSIDE}, 0.5 units from its",
    ),
    (
        {**BODIES, **AT_POINTS},
        "robots.points",
        [[5, 5], [6.00001, 5]],
        [[5, 5], [6, 5]],
        f"robots.points = ([5, 5], [6, 5]): {APART}",
    ),
    (
        {**BODIES, **AT_POINTS},
        "robots.points",
        [[0.5, 5], [19.49999, 5]],
        [[0.5, 5], [19.5, 5]],
        f"robots.points = ([0.5, 5], [19.5, 5]): {APART}",
    ),
    (
        {**BODIES, **WALLS, **AT_POINTS},
        "robots.points",
        [[0.5, 5], [19.5, 5]],
        [[0.5, 5], [1.5, 5]],
        f"robots.points = ([0.5, 5], [1.5, 5]): {APART}",
    ),
    (UNIQUE, "tasks.count", 2**17, 2**17 + 1, "sensing.observation = 'unique': needs 4.0 GiB for 131072 rob"),
    ({}, "faults.byzantine.count", 19, 20, "faults = '20 robots': must leave an honest robot that works"),
    (
        {"faults.stopped": 0.5},
        "faults.stubborn.count",
        10,
        11,
        "faults = '21 robots': must be at most 20, si",
    ),
    ({}, "robots.most", 20, 19, "must be at least the number of robots at the start, 20"),
    (
        {"robots.arrival_rate": 0.1},
        "robots.most",
        21,
        20,
        "lets none join: 20 robots are there, and none lea",
    ),
    (JOINING, "events", [FEWER], [MORE], "robots.most = 20: lets none join: 20 robots are there, and none"),
    ({"run.steps": 50}, "response.patience", 50, 51, "is longer than a run, run.steps = 50: nobody would be"),
    ({}, "response.margin", 2, 3, "needs response.patience: without it, nobody responds"),
    ({"events": [MORE]}, "run.steps", 5, 4, "events.0.step = 5: is after the end of a run, run.steps = 4"),
    (EVENT, "events.0.radio.loss", 0.0, None, "events.0 = 'step = 5': changes nothing"),
    (EVENT, "events.0.tasks", -20, -21, f"{TAKES} 5: 20 tasks"),
    (EVENT, "events.0.robots", -19, -20, f"{TAKES} 5: 20 robots"),
    ({"events": events((4, -1), (3, 5))}, "events.0.robots", -24, -25, f"{TAKES} 4: 25 robots"),
    (
        {"events": events((4, -24), (4, 5))},
        "events.1.step",
        3,
        4,
        f"events.0.robots = -24: {TAKES} 4: 20 robots",
    ),
    (CROWDED, "events.0.robots", 5, 6, "lets 26 robots be there at step 5, above robots.most = 25"),
    (RETURNING, "events.1.robots", 9, 10, "lets 26 robots be there at step 4, above robots.most = 25"),
    (
        EVENT,
        "events.0.tasks",
        9_999_980,
        9_999_981,
        "tasks.arrival_rate = None: lets up to 10000001 tasks ap",
    ),
    (
        {**TASKS_AT_POINTS, "events": [MORE]},
        "tasks.points",
        [[1, 1]],
        [],
        "tasks.points = '': must have a point",
    ),
    (QUIET, "events", [], [MORE], "decision.strategy = 'quiet-census': declares, which is for good, but the"),
]


@pytest.mark.parametrize(("others", "path", "valid", "invalid", "line"), EDGES)
def test_the_edge_of_a_rule_is_valid_and_what_is_just_beyond_it_is_an_error(
    others, path, valid, invalid, line
):
    """Catches a bound that is off by one, such as events that may not take the last task."""
    assert Scenario().replace({**others, path: valid})
    wrong = {**others, path: invalid}
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace(wrong)
    found = caught.value.problems
    shown = f"{path} = {invalid!r}: {line}"
    assert str(found[-1]).startswith((line, shown)), found
    assert all(problem.rule and problem.remedy for problem in found)
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace({**wrong, "walk.mean_run": -1.0, "run.stop": 3})
    assert set(map(str, found)) < set(map(str, caught.value.problems)), (
        "a wrong field elsewhere hides no conflict"
    )


def test_what_robots_know_may_take_exactly_the_memory_that_there_is():
    setting = Scenario().setting._replace(robots=2**20)
    words = KNOWLEDGE_LIMIT // 2**22
    assert excess(setting, words - 1, 1) == ""
    assert excess(setting, words, 1) != ""
