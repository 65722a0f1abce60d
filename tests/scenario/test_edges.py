"""The edge of each rule about several fields: the last value that is valid, and the first that isn't."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError
from feasibee.scenario.bitmaps import image_of
from feasibee.scenario.setting import KNOWLEDGE_LIMIT, excess

WALLS, NARROW = {"arena.boundary": "walls"}, {"arena.side": [20.0, 8.0]}
BODIES, AT_POINTS = {"robots.avoid_collisions": True}, {"robots.placement": "points"}
TASKS_AT_POINTS = {"tasks.placement": "points"}
TWO_POINTS = {**AT_POINTS, "robots.points": [[1, 1], [3, 3]]}
CLUSTERS = {**NARROW, "tasks.placement": "clusters"}
BODIES_AT, WALLS_AT = {**BODIES, **AT_POINTS}, {**WALLS, **AT_POINTS}
PLACE = {
    "place.walls": [[[0, 0], [1, 0], [0, 1]]],
    "place.zones": {"dock": [[2, 2], [6, 2], [6, 6], [2, 6]]},
}
PLACED, MAP = {**PLACE, **WALLS}, {"cell": 0.25, "image": image_of(np.zeros((32, 40), bool))}
UNIQUE = {"sensing.observation": "unique", "robots.count": 2**17}
ACTS, CHARGING = {"acting.start": 40}, {"robots.work": 60, "robots.charge": 9}
SKILLED = [{"name": "b", "count": 1, "skills": ["lift"]}]
JOINING = {"robots.most": 20, "robots.arrival_rate": 0.1}
FEWER, MORE = {"step": 5, "robots": -1}, {"step": 5, "tasks": 1}
EVENT, CROWDED = {"events": [{"step": 5}]}, {"robots.most": 25, "events": [{"step": 5}]}
HALF, INSIDE = "must be at most half the side of the torus", "point 1: must be inside the arena"
APART, TAKES = "robots 1 and 2 must be more than 1 units apart", "takes away more than there are at step"


def robots_of(count, skills=0):
    return [{"name": "a", "count": count, "skills": [f"s{k}" for k in range(skills)]}]


def tasks_of(count, needed=1):
    return [{"name": "x", "count": count, "needs": {"lift": needed}}]


def by(strategy):
    return {"decision.strategy": strategy}


def events(*pairs):
    return [{"step": step, "robots": robots} for step, robots in pairs]


ONE_OF = "says where or which one, so it must have one of tasks > 0, robots > 0, task and robot"
WALLED, LONELY = {"arena.boundary": "walls"}, {"robots.count": 1}
OFF_WALLS = "must be inside the arena, 0.5 units from its walls"
EVENT_TASKS, EVENT_ROBOT = {"events": [{"step": 5, "tasks": 1}]}, {"events": [{"step": 5, "robot": 1}]}
TASK_POINT = {**TASKS_AT_POINTS, "tasks.points": [[1, 2]]}
MANY = {**by("map"), "robots.count": 2000, "robots.know_count": True}
CENSUS_OF_4000 = {**by("census"), "robots.count": 4000, "tasks.count": 4000}
NAMING = ("census", "quiet-census")
KNOWING = ("tally", "estimate", *NAMING)
RETURNING = {"robots.most": 25, "events": events((3, -4), (4, 1))}
EDGES = {
    # by path: other fields, the last valid value, the first invalid one, the error: a rule or the whole line
    "robots.classes": [
        ({}, robots_of(1), robots_of(0), "robots.classes = 0: must have at least 1 robot together"),
        ({}, robots_of(3, 8), robots_of(3, 9), "robots.classes = '9 skills': must be at most 8"),
        ({"robots.count": 4}, [], robots_of(4), "robots.count = 4: can't be combined with "),
        ({}, robots_of(1), robots_of(1) * 2, "robots.classes = 'a': is the name of two classes"),
    ],
    "robots.count": [
        ({}, 1, 0, "must be ≥ 1"),
        (TWO_POINTS, 2, 3, "robots.points = '2 points': must be as many as robots, 3"),
        ({**BODIES, "arena.side": 16.0}, 256, 257, "must be at most 256, the number of discs that"),
        (by("census"), 10_000, 10**6, "decision.strategy = 'census': what 1000000 robots know"),
        (by("dc"), 10**6, 10**6 + 1, "must be ≤ 1000000"),
    ],
    "sensing.range": [({}, 10.0, 10.0001, f"{HALF}, 10 units")],
    "radio.range": [(NARROW, 4.0, 4.0001, f"{HALF}, 4 units")],
    "arena.boundary": [
        ({"radio.range": 50.0}, "walls", "torus", f"radio.range = 50.0: {HALF}, 10 units"),
        (PLACE, "walls", "torus", 'must be "walls" around a place'),
    ],
    "arena.side": [
        (PLACED, [20.1, 20.2], [20.1, 20.05], "must be a whole number of cells of place.cell = 0.1 units"),
        ({"place.map": MAP}, [10.0, 8.0], [10.0, 8.1], "must be the size of the map, 10 x 8 units"),
    ],
    "place.cell": [
        (PLACED, 0.125, 0.001, "makes 20000 x 20000 cells, above 4096 x 4096"),
        (PLACED, 0.5, 0.3, "arena.side = 20.0: must be a whole number of cells of place.cell = 0.3 units"),
        ({}, 0.1, 0.2, "needs a place: this one has no map, walls, keepout or zones"),
    ],
    "place.keepout": [
        ({"place.map": MAP}, MAP, {**MAP, "cell": 0.5}, "place.keepout = '40 x 32 cells of 0.5': must have"),
        (
            PLACED,
            None,
            MAP,
            "place.keepout = '40 x 32 cells of 0.25': must have 200 x 200 cells of 0.1 units",
        ),
    ],
    "place.map": [
        (
            {"arena.side": [10.0, 8.0]},
            MAP,
            {**MAP, "cell": 0.5},
            "arena.side = [10.0, 8.0]: must be the size of",
        ),
        ({}, MAP, {**MAP, "cell": 1e6}, "arena.side = (40000000.0, 32000000.0): must be at most 1e6 units"),
    ],
    "robots.zone": [
        (PLACED, "dock", "dok", "must be the name of a zone of place.zones; did you mean dock?"),
        (PLACED, "dock", "shelves", "must be the name of a zone of place.zones; use one of dock"),
        (
            {},
            None,
            "dock",
            "must be the name of a zone of place.zones; add it to place.zones, or leave robots.zone out",
        ),
    ],
    "tasks.placement": [(PLACED, "uniform", "clusters", "can't be combined with a place")],
    "radio.delay": [
        ({}, 1000, 1001, "must be ≤ 1000"),
        ({"robots.count": 1_000_000}, 178, 179, "keeps 4.0 GiB of messages, above the limit of 4 GiB"),
        (CENSUS_OF_4000, 535, 536, "decision.strategy = 'census': what 4000 robots know and say within"),
    ],
    "radio.walls": [({}, 0.0, 0.5, "needs a place: without one, there are no walls on the way")],
    "robots.speed": [(WALLS, 10.0, 10.0001, "must be at most half the side of the arena per step, 10 units")],
    "robots.diameter": [
        ({**WALLS, **NARROW}, 7.999, 8.0, "must be less than the arena's shorter side, 8 units"),
        ({**BODIES, "robots.count": 4}, 8.0, 8.0001, "diameter + 2 speed must be at most half"),
    ],
    "robots.contact": [
        (BODIES, "deflect", "turn", "must be 'stand' or 'deflect'"),
        ({}, "stand", "deflect", "needs robots.avoid_collisions = true: without it, robots"),
    ],
    "tasks.spread": [(CLUSTERS, 20.0, 20.0001, "must be at most the arena's longer side, 20 units")],
    "robots.points": [
        (AT_POINTS, [[0, 19.999]], [[0, 20.0]], f"robots.points = (0, 20.0): {INSIDE}"),
        (WALLS_AT, [[0.5, 19.5]], [[0.4999, 19.5]], f"robots.points = (0.4999, 19.5): {INSIDE}, 0.5 units"),
        (BODIES_AT, [[5, 5], [6.00001, 5]], [[5, 5], [6, 5]], f"robots.points = ([5, 5], [6, 5]): {APART}"),
        (
            BODIES_AT,
            [[0.5, 5], [19.49999, 5]],
            [[0.5, 5], [19.5, 5]],
            f"robots.points = ([0.5, 5], [19.5, 5]): {APART}",
        ),
        (
            {**BODIES_AT, **WALLS},
            [[0.5, 5], [19.5, 5]],
            [[0.5, 5], [1.5, 5]],
            f"robots.points = ([0.5, 5], [1.5, 5]): {APART}",
        ),
        (AT_POINTS, [[1, 1]], [], "robots.points = '': is missing, but robots.placement is"),
    ],
    "tasks.points": [
        ({**WALLS, **TASKS_AT_POINTS}, [[0, 20.0]], [[0, 20.0001]], f"tasks.points = (0, 20.0001): {INSIDE}"),
        ({**TASKS_AT_POINTS, "events": [MORE]}, [[1, 1]], [], "tasks.points = '': must have a point"),
    ],
    "tasks.count": [
        ({**ACTS, "robots.count": 2**14}, 2**15, 2**15 + 1, "acting.start = 'acting robots': needs 4.0 GiB"),
        ({}, 0, -1, "must be ≥ 0"),
        (UNIQUE, 2**17, 2**17 + 1, "sensing.observation = 'unique': needs 4.0 GiB for 131072 robots"),
    ],
    "faults.byzantine.count": [({}, 19, 20, "faults = '20 robots': must leave an honest robot that works")],
    "faults.stubborn.count": [({"faults.stopped": 0.5}, 10, 11, "faults = '21 robots': must be at most 20")],
    "robots.most": [
        ({}, 20, 19, "must be at least the number of robots at the start, 20"),
        ({"robots.arrival_rate": 0.1}, 21, 20, "lets none join: 20 robots are there, and none"),
    ],
    "events": [
        (JOINING, [FEWER], [MORE], "robots.most = 20: lets none join: 20 robots are there, and none"),
        (by("quiet-census"), [], [MORE], "decision.strategy = 'quiet-census': declares, which is for good"),
        ({"decision.declare": {}}, [], [MORE], "decision.declare = 'a rule': is for good, but the world"),
        ({"run.stop_at_decision": True}, [], [MORE], "run.stop_at_decision = True: ends a run at its"),
        ({"run.stop_at_declarations": True}, [], [MORE], "run.stop_at_declarations = True: ends a run once"),
    ],
    "acting.start": [
        ({}, "safe", "declared", '"declared" needs robots that declare'),
        (
            {"sensing.misname": 0.1, **by("census")},
            None,
            40,
            "sensing.misname = 0.1: must be 0 for robots that act",
        ),
        (
            {"sensing.position_error": 0.1, **by("census")},
            None,
            40,
            "sensing.position_error = 0.1: must be 0 for",
        ),
        (CHARGING, None, 40, "robots.work = 60: can't be combined with acting.start"),
        ({}, 10**9, 10**9 + 1, "must be a step, or 'declared', 'search' or 'safe'"),
    ],
    "acting.reach": [
        ({}, 1.0, 0.9, "needs acting.start: without it, no robot acts"),
        (ACTS, 1.0, 0.9999, "must be at least robots.speed, or robots walk past"),
        (
            {**ACTS, **BODIES, "robots.diameter": 1.5},
            1.5,
            1.4999,
            "must be at least robots.diameter, or a robot",
        ),
        (
            {**ACTS, **WALLS, "robots.diameter": 2.0},
            1.415,
            1.414,
            "must be at least 0.71 diameters, or walls",
        ),
    ],
    "acting.choose": [
        (
            {**ACTS, "radio.id_bits": 8},
            "nearest",
            "rank",
            '"rank" needs the numbers of robots, but radio.id_bits',
        ),
        ({**ACTS, "acting.hold": "tag"}, "nearest", "rank", '"rank" gives each robot its task'),
    ],
    "run.stop_when_taken": [
        ({}, False, True, "needs acting.start: without it, no task is taken"),
        ({**ACTS, "events": [MORE]}, False, True, "ends a run once all tasks are taken, but more appear"),
    ],
    "run.steps": [
        ({}, 1, 0, "must be ≥ 1"),
        ({"events": [MORE]}, 5, 4, "events.0.step = 5: is after the end of a run, run.steps = 4"),
        ({"tasks.arrival_rate": 10.0}, 10**5, 10**7, "tasks.arrival_rate = 10.0: lets up to 10008"),
    ],
    "events.0.radio.loss": [(EVENT, 0.0, None, "events.0 = 'step = 5': changes nothing")],
    "events.0.tasks": [
        (EVENT, -20, -21, f"{TAKES} 5: 20 tasks"),
        (EVENT, 9_999_980, 9_999_981, "tasks.arrival_rate = None: lets up to 10000001 tasks appear"),
    ],
    "events.0.robots": [
        (EVENT, -19, -20, f"{TAKES} 5: 20 robots"),
        ({"events": events((4, -1), (3, 5))}, -24, -25, f"{TAKES} 4: 25 robots"),
        ({**LONELY, "events": [{"step": 5, "robots": 1}]}, 1, -1, f"{TAKES} 5: 1 robots"),
        (CROWDED, 5, 6, "lets 26 robots be there at step 5, above robots.most = 25"),
    ],
    "events.0.task": [
        ({"events": [{"step": 5, "task": 0}]}, 19, 20, "must be below 20: no more tasks than that ever come"),
        (EVENT_TASKS, None, 3, f"events.0 = 'step = 5': {ONE_OF}"),
    ],
    "events.0.robot": [
        (
            {"events": [{"step": 5, "robot": 0}]},
            19,
            20,
            "must be below 20: no more robots than that ever come",
        ),
        ({"events": [{"step": 5, "task": 1}]}, None, 0, f"events.0 = 'step = 5': {ONE_OF}"),
        (
            {**LONELY, "events": [{"step": 5, "robot": 0, "at": [1, 1]}]},
            0,
            1,
            "must be below 1: no more robots",
        ),
    ],
    "events.0.at": [
        (EVENT_TASKS, [0, 19.9], [0, 20], "events.0.at = (0.0, 20.0): must be inside the arena"),
        ({"events": [{"step": 5, "tasks": -1}]}, None, [3, 3], f"events.0 = 'step = 5': {ONE_OF}"),
        ({"events": [{"step": 5, "radio": {"loss": 0.1}}]}, None, [3, 3], f"events.0 = 'step = 5': {ONE_OF}"),
        (
            {**EVENT_TASKS, **WALLED},
            [0, 20],
            [0, 20.1],
            "events.0.at = (0.0, 20.1): must be inside the arena",
        ),
        ({**EVENT_ROBOT, **WALLED}, [0.5, 19.5], [0.5, 19.6], f"events.0.at = (0.5, 19.6): {OFF_WALLS}"),
        ({**ACTS, **EVENT_ROBOT}, None, [3, 3], "events.0.at = (3.0, 3.0): puts a robot elsewhere, but"),
    ],
    "events.1.step": [
        ({"events": events((4, -24), (4, 5))}, 3, 4, f"events.0.robots = -24: {TAKES} 4: 20 robots")
    ],
    "events.1.robots": [(RETURNING, 9, 10, "lets 26 robots be there at step 4, above robots.most = 25")],
    "tasks.classes": [
        ({"tasks.count": 4}, [], tasks_of(4), "tasks.count = 4: can't be combined with "),
        (ACTS, tasks_of(3), tasks_of(3, 2), "must need one robot for each task if robots act"),
        ({}, tasks_of(1), tasks_of(1) * 2, "tasks.classes = 'x': is the name of two classes"),
        (TASK_POINT, tasks_of(1), tasks_of(3), "tasks.points = '1 points': must be as many as tasks"),
    ],
    "decision.threshold": [({}, 0.5, 0.49, "must be ≥ 0.5"), ({}, 0.9999, 1.0, "must be < 1")],
    "decision.inbox_size": [
        ({"decision.inbox": "every-message"}, None, 3, "limits the number of robots, but")
    ],
    "decision.inbox": [(by("dc"), "latest-per-robot", "every-message", "dc broadcasts a value")],
    "decision.quality_floor": [*((by(name), 0, 1, f"{name} rates what the swarm knows") for name in KNOWING)],
    "decision.start": [
        (
            by(name),
            "coin",
            "first-sight",
            f"needs robots that begin with a coin and pass on opinions; those of {name} don't",
        )
        for name in ("tally", "quiet-census", "bayes")
    ],
    "sensing.false_robots": [*((by(name), 0.0, 0.5, f"{name} counts things by name") for name in NAMING)],
    "sensing.false_tasks": [*((by(name), 0.0, 0.5, f"{name} counts things by name") for name in NAMING)],
    "sensing.view": [
        ({}, 360.0, 360.0001, "must be ≤ 360"),
        ({"robots.speed": 0.0}, 360.0, 359.9, "must be 360 for robots that never move"),
        (
            {**by("map"), "robots.know_count": True},
            360.0,
            120.0,
            "must be 360 for map, which concludes from what it",
        ),
    ],
    "sensing.misname": [({}, 0.0, 0.5, "needs a strategy that counts tasks by name; dmmd doesn't")],
    "sensing.position_error": [
        *(
            (
                {**by(name), "robots.know_count": True},
                0.0,
                0.1,
                f"must be 0 for {name}, whose robots can't compare",
            )
            for name in ("turns", "map")
        ),
        ({"events": [{"step": 5, "tasks": 1}]}, 0.0, 0.1, "must be 0 in a world that changes"),
        (by("census"), 0.47, 0.471, "makes tasks one name that are farther apart than sensing.range"),
    ],
    "sensing.observation": [(by("roster"), "repeated", "unique", "roster must see")],
    "robots.know_count": [
        *((by(name), True, False, f"{name} needs the number of robots") for name in ("map", "turns"))
    ],
    "decision.parameters.cell": [
        (MANY, 2.0, 1e-9, "decision.strategy = 'map': what 2000 robots know would take")
    ],
    "decision.parameters": [
        ({}, {}, {"k": 2.0}, "decision.parameters.k = 2.0: dmmd has no such parameter; it has none"),
        (by("bayes"), {}, {"k": 2.0}, "decision.parameters.k = 2.0: bayes has no such parameter"),
    ],
    "decision.declare": [
        (by("quiet-census"), None, {"quorum": 0.9}, "quiet-census declares by its own word")
    ],
    "decision.strategy": [
        ({"decision.quality_floor": 1}, "dmmd", "census", "decision.quality_floor = 1: census rates")
    ],
}


@pytest.mark.parametrize(
    ("path", "others", "valid", "invalid", "line"), [(path, *row) for path in EDGES for row in EDGES[path]]
)
def test_the_edge_of_a_rule_is_valid_and_what_is_just_beyond_it_is_an_error(
    path, others, valid, invalid, line
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
        Scenario().replace({**wrong, "faults.stop_step": -1, "run.stop": 3})
    assert set(map(str, found)) < set(map(str, caught.value.problems)), (
        "a wrong field elsewhere hides no conflict"
    )


def test_what_robots_know_may_take_exactly_the_memory_that_there_is():
    setting = Scenario().setting._replace(robots=2**20)
    words = KNOWLEDGE_LIMIT // 2**22
    assert excess(setting, words - 1, 1) == ""
    assert excess(setting, words, 1) != ""
