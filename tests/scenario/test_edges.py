"""The edge of each rule about several fields: the last value that is valid, and the first that isn't."""

from __future__ import annotations

import pytest

from feasibee import Scenario, ScenarioError
from feasibee.scenario.setting import KNOWLEDGE_LIMIT, excess

TORUS, WALLS = {"arena.boundary": "torus"}, {"arena.boundary": "walls"}
BODIES = {"robots.avoid_collisions": True}


def at_points(section, *points):
    return {f"{section}.placement": "points", f"{section}.points": [list(point) for point in points]}


def robots_of(count):
    return {"robots.classes": [{"name": "a", "count": count}]}


def skilled(skills):
    return {"robots.classes": [{"name": "a", "count": 3, "skills": [f"s{k}" for k in range(skills)]}]}


def event(**changes):
    return {"events": [{"step": 5, **changes}]}


def events(*pairs):
    return {"events": [{"step": step, "robots": robots} for step, robots in pairs]}


EDGES = {
    "classes have a robot": (
        robots_of(1),
        robots_of(0),
        "robots.classes = 0: must have at least 1 robot together",
    ),
    "as many points as robots": (
        {**at_points("robots", (1, 1), (3, 3)), "robots.count": 2},
        {**at_points("robots", (1, 1), (3, 3)), "robots.count": 3},
        "robots.points = '2 points': must be as many as robots, 3",
    ),
    "skills": (
        skilled(8),
        skilled(9),
        "robots.classes = '9 skills': must be at most 8 skills of robots and tasks together",
    ),
    "range on a torus": (
        {"sensing.range": 10.0},
        {"sensing.range": 10.0001},
        "sensing.range = 10.0001: must be at most half the side of the torus, 10 units",
    ),
    "range on a narrow torus": (
        {"arena.side": [20.0, 8.0], "radio.range": 4.0},
        {"arena.side": [20.0, 8.0], "radio.range": 4.0001},
        "radio.range = 4.0001: must be at most half the side of the torus, 4 units",
    ),
    "range within walls": (
        {**WALLS, "radio.range": 50.0},
        {**TORUS, "radio.range": 50.0},
        "radio.range = 50.0: must be at most half the side of the torus, 10 units",
    ),
    "speed": (
        {**WALLS, "robots.speed": 10.0},
        {**WALLS, "robots.speed": 10.0001},
        "robots.speed = 10.0001: must be at most half the side of the arena per step, 10 units",
    ),
    "a disc within walls": (
        {**WALLS, "arena.side": [20.0, 5.0], "robots.diameter": 4.999},
        {**WALLS, "arena.side": [20.0, 5.0], "robots.diameter": 5.0},
        "robots.diameter = 5.0: must be less than the arena's shorter side, 5 units",
    ),
    "discs that move on a torus": (
        {**BODIES, "robots.diameter": 8.0, "robots.count": 4},
        {**BODIES, "robots.diameter": 8.0001, "robots.count": 4},
        "robots.diameter = 8.0001: diameter + 2 speed must be at most half the side of the",
    ),
    "room for discs": (
        {**BODIES, "arena.side": 16.0, "robots.count": 256},
        {**BODIES, "arena.side": 16.0, "robots.count": 257},
        "robots.count = 257: must be at most 256, the number of discs that fit on a square grid",
    ),
    "contact": (
        {**BODIES, "robots.contact": "deflect"},
        {"robots.contact": "deflect"},
        "robots.contact = 'deflect': needs robots.avoid_collisions = true: without it, robots",
    ),
    "spread": (
        {"arena.side": [20.0, 8.0], "tasks.placement": "clusters", "tasks.spread": 20.0},
        {"arena.side": [20.0, 8.0], "tasks.placement": "clusters", "tasks.spread": 20.0001},
        "tasks.spread = 20.0001: must be at most the arena's longer side, 20 units",
    ),
    "points on a torus": (
        at_points("robots", (0, 19.999)),
        at_points("robots", (0, 20.0)),
        "robots.points = (0, 20.0): point 1: must be inside the arena",
    ),
    "tasks at a wall": (
        {**WALLS, **at_points("tasks", (0, 20.0))},
        {**WALLS, **at_points("tasks", (0, 20.0001))},
        "tasks.points = (0, 20.0001): point 1: must be inside the arena",
    ),
    "robots at a wall": (
        {**WALLS, **at_points("robots", (0.5, 19.5))},
        {**WALLS, **at_points("robots", (0.4999, 19.5))},
        "robots.points = (0.4999, 19.5): point 1: must be inside the arena, 0.5 units from its",
    ),
    "robots apart": (
        {**BODIES, **at_points("robots", (5, 5), (6.00001, 5))},
        {**BODIES, **at_points("robots", (5, 5), (6, 5))},
        "robots.points = ([5, 5], [6, 5]): robots 1 and 2 must be more than 1 units apart",
    ),
    "robots apart across the edge": (
        {**BODIES, **at_points("robots", (0.5, 5), (19.49999, 5))},
        {**BODIES, **at_points("robots", (0.5, 5), (19.5, 5))},
        "robots.points = ([0.5, 5], [19.5, 5]): robots 1 and 2 must be more than 1 units apart",
    ),
    "robots apart along walls": (
        {**BODIES, **WALLS, **at_points("robots", (0.5, 5), (19.5, 5))},
        {**BODIES, **WALLS, **at_points("robots", (0.5, 5), (1.5, 5))},
        "robots.points = ([0.5, 5], [1.5, 5]): robots 1 and 2 must be more than 1 units apart",
    ),
    "memory of unique observation": (
        {"sensing.observation": "unique", "robots.count": 2**17, "tasks.count": 2**17},
        {"sensing.observation": "unique", "robots.count": 2**17, "tasks.count": 2**17 + 1},
        "sensing.observation = 'unique': needs 4.0 GiB for 131072 robots and 131073 tasks, above",
    ),
    "all robots but one are Byzantine": (
        {"faults.byzantine": {"count": 19}},
        {"faults.byzantine": {"count": 20}},
        "faults = '20 robots': must leave an honest robot that works",
    ),
    "all robots are faulty": (
        {"faults.stopped": 0.5, "faults.stubborn": {"count": 10}},
        {"faults.stopped": 0.5, "faults.stubborn": {"count": 11}},
        "faults = '21 robots': must be at most 20, since a robot has one fault at most",
    ),
    "most robots": (
        {"robots.most": 20},
        {"robots.most": 19},
        "robots.most = 19: must be at least the number of robots at the start, 20",
    ),
    "room for a robot that joins": (
        {"robots.most": 21, "robots.arrival_rate": 0.1},
        {"robots.most": 20, "robots.arrival_rate": 0.1},
        "robots.most = 20: lets none join: 20 robots are there, and none leaves",
    ),
    "a number that becomes free": (
        {"robots.most": 20, "robots.arrival_rate": 0.1, **events((5, -1))},
        {"robots.most": 20, "robots.arrival_rate": 0.1, **event(tasks=-1)},
        "robots.most = 20: lets none join: 20 robots are there, and none leaves",
    ),
    "patience": (
        {"response.patience": 50, "run.steps": 50},
        {"response.patience": 51, "run.steps": 50},
        "response.patience = 51: is longer than a run, run.steps = 50: nobody would be called",
    ),
    "fields of no response": (
        {"response.margin": 2},
        {"response.margin": 3},
        "response.margin = 3: needs response.patience: without it, nobody responds",
    ),
    "an event at the end": (
        {**event(tasks=1), "run.steps": 5},
        {**event(tasks=1), "run.steps": 4},
        "events.0.step = 5: is after the end of a run, run.steps = 4",
    ),
    "an event that changes something": (
        event(radio={"loss": 0.0}),
        event(tasks=0),
        "events.0 = 'step = 5': changes nothing",
    ),
    "the last task goes": (
        event(tasks=-20),
        event(tasks=-21),
        "events.0.tasks = -21: takes away more than there are at step 5: 20 tasks",
    ),
    "one robot stays": (
        event(robots=-19),
        event(robots=-20),
        "events.0.robots = -20: takes away more than there are at step 5: 20 robots",
    ),
    "one of those that joined stays": (
        events((4, -24), (3, 5)),
        events((4, -25), (3, 5)),
        "events.0.robots = -25: takes away more than there are at step 4: 25 robots",
    ),
    "events of a step in the order of the file": (
        events((4, 5), (4, -24)),
        events((4, -24), (4, 5)),
        "events.0.robots = -24: takes away more than there are at step 4: 20 robots",
    ),
    "as many join as there may be": (
        {**event(robots=5), "robots.most": 25},
        {**event(robots=6), "robots.most": 25},
        "events.0.robots = 6: lets 26 robots be there at step 5, above robots.most = 25",
    ),
    "as many join as have left": (
        {**events((3, -4), (4, 9)), "robots.most": 25},
        {**events((3, -4), (4, 10)), "robots.most": 25},
        "events.1.robots = 10: lets 26 robots be there at step 4, above robots.most = 25",
    ),
    "tasks of a run": (
        event(tasks=9_999_980),
        event(tasks=9_999_981),
        "tasks.arrival_rate = None: lets up to 10000001 tasks appear in a run, above 10000000",
    ),
    "points for tasks that appear": (
        {**at_points("tasks", (1, 1)), **event(tasks=1)},
        {"tasks.placement": "points", **event(tasks=1)},
        "tasks.points = '': must have a point at which tasks may appear",
    ),
    "declarations need a world that stays": (
        {"decision.strategy": "quiet-census"},
        {"decision.strategy": "quiet-census", **event(tasks=1)},
        "decision.strategy = 'quiet-census': declares, which is for good, but the world of this",
    ),
}


@pytest.mark.parametrize("edge", EDGES)
def test_the_edge_of_a_rule_is_valid_and_what_is_just_beyond_it_is_an_error(edge):
    """Catches a bound that is off by one, such as events that may not take the last task."""
    valid, invalid, line = EDGES[edge]
    assert Scenario().replace(valid)
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace(invalid)
    found = caught.value.problems
    assert str(found[-1]).startswith(line), found
    assert all(problem.rule and problem.remedy for problem in found)
    with pytest.raises(ScenarioError) as caught:
        Scenario().replace({**invalid, "walk.mean_run": -1.0, "run.stop": 3})
    assert set(map(str, found)) < set(map(str, caught.value.problems)), (
        "a wrong field elsewhere hides no conflict"
    )


def test_what_robots_know_may_take_exactly_the_memory_that_there_is():
    setting = Scenario().setting._replace(robots=2**20)
    words = KNOWLEDGE_LIMIT // 2**22
    assert excess(setting, words - 1, 1) == ""
    assert excess(setting, words, 1) != ""
