"""The edge of each rule about several fields: the last value that is valid, and the first that isn't."""

from __future__ import annotations

import numpy as np
import pytest
from places import rectangle
from remedies import check_remedies, problems_of, ways

from feasibee import Scenario
from feasibee.scenario.cells import image_of
from feasibee.scenario.paths import with_changes
from feasibee.scenario.setting import KNOWLEDGE_LIMIT, excess


def robots_of(count, skills=0):
    return [{"name": "a", "count": count, "skills": [f"s{k}" for k in range(skills)]}]


def tasks_of(count, needed=1):
    return [{"name": "x", "count": count, "needs": {"lift": needed}}]


def by(strategy):
    return {"decision.strategy": strategy, "robots.know_count": strategy in ("map", "turns")}


def event(**values):
    return {"events": [{"step": 5, **values}]}


def events(*pairs):
    return [{"step": step, "robots": robots} for step, robots in pairs]


WALLS, NARROW = {"arena.boundary": "walls"}, {"arena.side": [20.0, 8.0]}
BODIES, AT_POINTS = {"robots.avoid_collisions": True}, {"robots.placement": "points"}
TASKS_AT_POINTS = {"tasks.placement": "points"}
AT_ONE = {**TASKS_AT_POINTS, "tasks.points": [[1, 2]]}
DOCK = {"dock": [[2, 2], [6, 2], [6, 6], [2, 6]]}
PLACE = {"place.walls": [[[0, 0], [1, 0], [0, 1]]], "place.zones": DOCK}
PLACED, CELLS = {**PLACE, **WALLS}, image_of(np.zeros((32, 40), bool))
HALL, WEST = {**WALLS, "arena.side": 10.0}, rectangle(0, 0, 4, 4)
ZONES = {"west": WEST, "east": rectangle(6, 0, 10, 9), "nook": rectangle(0, 0, 0.5, 0.5)}
NOOKS, SPLIT = {**HALL, "place.zones": ZONES}, {**HALL, "place.walls": [rectangle(4.9, 0, 5.1, 10)]}
OPEN, SOLID = ({"cell": 1.0, "image": image_of(np.full((10, 10), closed))} for closed in (False, True))
MAP, COARSE, HUGE = ({"cell": cell, "image": CELLS} for cell in (0.25, 0.5, 1e6))
ACTS, LONELY = {"acting.start": 40}, {"robots.count": 1}
CHARGING, CROWD = {"robots.work": 60, "robots.charge": 9}, {"robots.count": 2**17}
JOINING, MORE = {"robots.most": 20, "robots.arrival_rate": 0.1}, event(tasks=1)["events"]
MANY, CENSUS_OF_4000 = {**by("map"), "robots.count": 2000}, {"robots.count": 4000, "tasks.count": 4000}
HALF, INSIDE = "must be at most half the side of the torus", "point 1: must be inside the arena"
APART, TAKES = "robots 1 and 2 must be more than 1 units apart", "takes away more than there are at step"
WHICH = "events.0 = 'step = 5': says where or which one, so it must have one of tasks > 0, robots > 0,"
AT, ZONE = "events.0.at = ", "must be the name of a zone of place.zones;"
NONE_JOINS = "robots.most = 20: lets none join: 20 robots are there, and none leaves"
HONEST = (
    "must leave an honest robot that works; of 20 robots there are 0 stopped, 20 byzantine, 0 stubborn; "
    "use faults.byzantine = {count = 19}"
)
RETURNING = {"robots.most": 25, "events": events((3, -4), (4, 1))}
EDGES = {
    # by path: other fields, the last valid value, the first invalid one, the error: a rule or the whole line
    "robots.classes": [
        ({}, robots_of(1), robots_of(0), "robots.classes = 0: must have at least 1 robot together"),
        ({}, robots_of(3, 8), robots_of(3, 9), "robots.classes = '9 skills': must be at most 8"),
        ({"robots.count": 4}, [], robots_of(4), "robots.count = 4: can't be combined with "),
        ({}, robots_of(1), robots_of(1) * 2, "robots.classes = 'a': is the name of two classes"),
        (by("map"), [], robots_of(4), "robots.classes = '1 classes': map compares one number of robots with"),
    ],
    "robots.count": [
        ({**NOOKS, **BODIES, "robots.zone": "west"}, 9, 10, "puts 10 robots into zone west, where 9"),
        ({**AT_POINTS, "robots.points": [[1, 1], [3, 3]]}, 2, 3, "robots.points = '2 points': must be"),
        ({**BODIES, "arena.side": 16.0}, 256, 257, "must be at most 256, the number of discs that"),
        (by("census"), 10_000, 10**6, "decision.strategy = 'census': what 1000000 robots know"),
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
        ({}, 4.0, 3.9, "sensing.range = 2.0: must be at most half the side of the torus, 1.95"),
        (PLACED, [409.6, 20.0], [409.7, 20.0], "place.cell = 0.1: makes 4097 x 200 cells, above 4096 x"),
    ],
    "place.cell": [
        ({**PLACED, "arena.side": [20.0, 2.0]}, 0.125, 0.001, "makes 20000 x 2000 cells, above 4096 x 4096"),
        (PLACED, 0.5, 0.3, "arena.side = 20.0: must be a whole number of cells of place.cell = 0.3 units"),
        ({}, 0.1, 0.2, "needs a place: this one has no map, walls, keepout or zones"),
    ],
    "place.keepout": [
        ({**HALL, "place.cell": 1.0}, OPEN, SOLID, "place.keepout = '100 closed cells of 100': leaves no"),
        ({"place.map": MAP}, MAP, COARSE, "place.keepout = '40 x 32 cells of 0.5': must have"),
        (PLACED, None, MAP, "place.keepout = '40 x 32 cells of 0.25': must have 200 x 200"),
    ],
    "place.map": [
        (WALLS, MAP, SOLID, "place.map = '100 closed cells of 100': leaves no cell in which a robot"),
        ({"arena.side": [10.0, 8.0]}, MAP, COARSE, "arena.side = [10.0, 8.0]: must be the size of"),
        ({}, MAP, HUGE, "arena.side = (40000000.0, 32000000.0): must be at most 1e6 units"),
    ],
    "robots.zone": [
        (NOOKS, "west", "nook", "has no cell in which a robot of diameter 1 could be"),
        (PLACED, "dock", "dok", f"{ZONE} did you mean dock?"),
        (PLACED, "dock", "shelves", f"{ZONE} use one of dock"),
        ({}, None, "dock", f"{ZONE} add it to place.zones, or leave robots.zone out"),
    ],
    "tasks.zone": [
        ({**NOOKS, **SPLIT, "robots.zone": "west"}, "west", "east", "has no cell that a robot re")
    ],
    "tasks.placement": [(PLACED, "uniform", "clusters", "can't be combined with a place")],
    "radio.delay": [
        ({"robots.count": 1_000_000}, 178, 179, "keeps 4.0 GiB of messages, above the limit of 4 GiB"),
        ({**by("census"), **CENSUS_OF_4000}, 535, 536, "decision.strategy = 'census': what 4000"),
    ],
    "radio.walls": [({}, 0.0, 0.5, "needs a place: without one, there are no walls on the way")],
    "robots.speed": [(WALLS, 10.0, 10.0001, "must be at most half the side of the arena per step, 10 units")],
    "robots.diameter": [
        ({**HALL, "place.walls": [rectangle(2, 2, 8, 8)]}, 1.0, 4.0, "place.walls = '3,600 closed cells of"),
        ({**HALL, "place.zones": {"dock": WEST}}, 9.5, 9.9, "leaves no cell in which a robot of di"),
        ({**WALLS, **NARROW}, 7.999, 8.0, "must be less than the arena's shorter side, 8 units"),
        ({**BODIES, "robots.count": 4}, 8.0, 8.0001, "diameter + 2 speed must be at most half"),
    ],
    "robots.contact": [({}, "stand", "deflect", "needs robots.avoid_collisions = true: without it, robots")],
    "robots.charge": [
        ({"robots.work": 60}, 9, None, "robots.work = 60: needs robots.charge: for how many steps"),
        ({}, None, 9, "needs robots.work: after how many steps a robot charges"),
    ],
    "robots.away": [({}, "counted", "missing", "needs robots.work: without it, no robot goes to charge")],
    "tasks.spread": [
        ({**NARROW, "tasks.placement": "clusters"}, 20.0, 20.0001, "must be at most the arena's longer si")
    ],
    "robots.points": [
        ({**SPLIT, **AT_POINTS}, [[4.0, 5]], [[4.6, 5]], "robots.points = (4.6, 5.0): point 1: a robot of"),
        (AT_POINTS, [[0, 19.999]], [[0, 20.0]], f"robots.points = (0, 20.0): {INSIDE}"),
        (
            {**WALLS, **AT_POINTS},
            [[0.5, 19.5]],
            [[0.4999, 19.5]],
            f"robots.points = (0.4999, 19.5): {INSIDE}, 0.5",
        ),
        *(
            ({**BODIES, **AT_POINTS, **edges}, far, near, f"robots.points = {(*near,)}: {APART}")
            for edges, far, near in (
                ({}, [[5, 5], [6.00001, 5]], [[5, 5], [6, 5]]),
                ({}, [[0.5, 5], [19.49999, 5]], [[0.5, 5], [19.5, 5]]),
                ({}, [[5, 0.5], [5, 19.49999]], [[5, 0.5], [5, 19.5]]),
                (WALLS, [[0.5, 5], [19.5, 5]], [[0.5, 5], [1.5, 5]]),
            )
        ),
        (AT_POINTS, [[1, 1]], [], "robots.points = '': is missing, but robots.placement is"),
    ],
    "tasks.points": [
        ({**SPLIT, **TASKS_AT_POINTS}, [[4.5, 5]], [[5, 5]], "tasks.points = (5.0, 5.0): point 1: is in"),
        ({**WALLS, **TASKS_AT_POINTS}, [[0, 20.0]], [[0, 20.0001]], f"tasks.points = (0, 20.0001): {INSIDE}"),
        ({**TASKS_AT_POINTS, "events": MORE}, [[1, 1]], [], "tasks.points = '': must have a point"),
    ],
    "tasks.count": [
        ({**ACTS, "robots.count": 2**14}, 2**15, 2**15 + 1, "acting.start = 'acting robots': needs 4.0 GiB"),
        (
            {**CROWD, "sensing.observation": "unique"},
            2**17,
            2**17 + 1,
            "sensing.observation = 'unique': needs 4.0 GiB for 13",
        ),
    ],
    "faults.byzantine.count": [({}, 19, 20, f"faults = '20 robots': {HONEST}")],
    "faults.stubborn.count": [({"faults.stopped": 0.5}, 10, 11, "faults = '21 robots': must be at most 20")],
    "robots.most": [
        ({}, 20, 19, "must be at least the number of robots at the start, 20"),
        ({"robots.arrival_rate": 0.1}, 21, 20, NONE_JOINS),
    ],
    "events": [
        (SPLIT, [], MORE, "place = '2 pieces': has parts that no robot leaves"),
        (JOINING, event(robots=-1)["events"], MORE, NONE_JOINS),
        (by("quiet-census"), [], MORE, "decision.strategy = 'quiet-census': declares, which is for good"),
        ({"decision.declare": {}}, [], MORE, "decision.declare = 'a rule': is for good, but the world"),
        ({"run.stop_at_decision": True}, [], MORE, "run.stop_at_decision = True: ends a run at its"),
        ({"run.stop_at_declarations": True}, [], MORE, "run.stop_at_declarations = True: ends a run once"),
    ],
    "acting.start": [
        ({}, "safe", "declared", '"declared" needs robots that declare'),
        *(
            ({**by("census"), f"sensing.{key}": 0.1}, None, 40, f"sensing.{key} = 0.1: must be 0 for ro")
            for key in ("misname", "position_error")
        ),
        (CHARGING, None, 40, "robots.work = 60: can't be combined with act"),
    ],
    "acting.reach": [
        ({}, 1.0, 0.9, "needs acting.start: without it, no robot acts"),
        ({**ACTS, "robots.diameter": 2.0}, 1.0, 0.9999, "must be at least robots.speed, or robots walk past"),
        ({**ACTS, **BODIES, "robots.diameter": 1.5}, 1.5, 1.4999, "must be at least robots.diameter, or"),
        ({**ACTS, **WALLS, "robots.diameter": 2.0}, 1.415, 1.414, "must be at least 0.71 diameters, or"),
    ],
    "acting.choose": [
        ({**ACTS, "radio.id_bits": 8}, "nearest", "rank", '"rank" needs the numbers of robots, but'),
        ({**ACTS, "acting.hold": "tag"}, "nearest", "rank", '"rank" gives each robot its task'),
    ],
    "tasks.work": [({}, None, 5, "needs acting.start: without it, no robot works at a task")],
    "run.stop_when_taken": [
        ({}, False, True, "needs acting.start: without it, no task is taken"),
        ({**ACTS, "events": MORE}, False, True, "ends a run once all tasks are taken, but more appear"),
    ],
    "run.steps": [
        ({"events": MORE}, 5, 4, "events.0.step = 5: is after the end of a run, run.steps = 4"),
        ({"tasks.arrival_rate": 10.0}, 10**5, 10**7, "tasks.arrival_rate = 10.0: lets up to 10008"),
    ],
    "events.0.radio.loss": [(event(), 0.0, None, "events.0 = 'step = 5': changes nothing")],
    "events.0.tasks": [
        (event(), -20, -21, f"{TAKES} 5: 20 tasks"),
        (event(), 9_999_980, 9_999_981, "tasks.arrival_rate = None: lets up to 10000001 tasks appear"),
    ],
    "events.0.robots": [
        (event(), -19, -20, f"{TAKES} 5: 20 robots"),
        ({"events": events((4, -1), (3, 5))}, -24, -25, f"{TAKES} 4: 25 robots"),
        ({**event(), "robots.most": 25}, 5, 6, "lets 26 robots be there at step 5, above robots.most = 25"),
    ],
    "events.0.task": [
        (event(task=0), 19, 20, "must be below 20: no more tasks than that ever come"),
        (event(tasks=1), None, 3, WHICH),
    ],
    "events.0.robot": [
        (event(robot=0), 19, 20, "must be below 20: no more robots than that ever come"),
        (event(task=1), None, 0, WHICH),
        ({**event(robot=0, at=[1, 1]), **LONELY}, 0, 1, "must be below 1: no more robots"),
    ],
    "events.0.at": [
        *(
            ({**HALL, "place.walls": [WEST], **event(**{kind: 1})}, [9, 9], at, f"{AT}{(*at,)}: is in a wall")
            for kind, at in (("tasks", [1.0, 1.0]), ("task", [0.5, 0.5]), ("robot", [4.1, 1.0]))
        ),
        (event(tasks=1), [0, 19.9], [0, 20], f"{AT}(0.0, 20.0): must be inside the arena"),
        (event(tasks=-1), None, [3, 3], WHICH),
        (event(radio={"loss": 0.1}), None, [3, 3], WHICH),
        ({**event(tasks=1), **WALLS}, [0, 20], [0, 20.1], f"{AT}(0.0, 20.1): must be inside the arena"),
        ({**event(robot=1), **WALLS}, [0.5, 19.5], [0.5, 19.6], f"{AT}(0.5, 19.6): must be inside the ar"),
        ({**ACTS, **event(robot=1)}, None, [3, 3], f"{AT}(3.0, 3.0): puts a robot elsewhere, but"),
        ({**event(robot=0), **LONELY}, [1, 1], None, "events.0.robot = 0: takes away more than there are"),
    ],
    "events.1.step": [
        ({"events": events((4, -24), (4, 5))}, 3, 4, f"events.0.robots = -24: {TAKES} 4: 20 robots")
    ],
    "events.1.robots": [(RETURNING, 9, 10, "lets 26 robots be there at step 4, above robots.most = 25")],
    "tasks.classes": [
        ({"tasks.count": 4}, [], tasks_of(4), "tasks.count = 4: can't be combined with "),
        (ACTS, tasks_of(3), tasks_of(3, 2), "must need one robot for each task if robots act"),
        ({}, tasks_of(1), tasks_of(1) * 2, "tasks.classes = 'x': is the name of two classes"),
        (by("map"), [], tasks_of(4), "tasks.classes = '1 classes': map compares one number of robots with"),
        (AT_ONE, tasks_of(1), tasks_of(3), "tasks.points = '1 points': must be as many as tasks, 3; give 3"),
    ],
    "decision.inbox_size": [
        ({"decision.inbox": "every-message"}, None, 3, "limits the number of robots, but")
    ],
    "decision.inbox": [(by("dc"), "latest-per-robot", "every-message", "dc broadcasts a value")],
    "decision.quality_floor": [(by("tally"), 0, 1, "tally rates what the swarm knows")],
    "decision.start": [
        (by(name), "coin", "first-sight", "needs robots that begin with a coin and pass on opinions;")
        for name in ("tally", "bayes")
    ],
    **{
        f"sensing.false_{kind}": [(by("census"), 0.0, 0.5, "census counts things by name")]
        for kind in ("robots", "tasks")
    },
    "sensing.view": [
        ({"robots.speed": 0.0}, 360.0, 359.9, "must be 360 for robots that never move"),
        (by("map"), 360.0, 120.0, "must be 360 for map, which concludes from what it"),
    ],
    "sensing.misname": [({}, 0.0, 0.5, "needs a strategy that counts tasks by name; dmmd doesn't")],
    "sensing.position_error": [
        (by("turns"), 0.0, 0.1, "must be 0 for turns, whose robots can't compare"),
        (event(tasks=1), 0.0, 0.1, "must be 0 in a world that changes"),
        (by("census"), 0.47, 0.471, "makes tasks one name that are farther apart than sensing.range"),
    ],
    "sensing.observation": [(by("roster"), "repeated", "unique", "roster must see")],
    "robots.know_count": [(by("map"), True, False, "map needs the number of robots")],
    "decision.parameters.cell": [
        (MANY, 2.0, 1e-9, "decision.strategy = 'map': what 2000 robots know would take"),
        (by("map"), 1e-9, 0, "must be > 0; leave it out for 1"),
    ],
    "decision.parameters": [
        ({}, {}, {"k": 2.0}, "decision.parameters.k = 2.0: dmmd has no such parameter; it has none"),
        (by("bayes"), {}, {"k": 2.0}, "decision.parameters.k = 2.0: bayes has no such parameter; it ha"),
    ],
    "decision.declare": [
        (by("quiet-census"), None, {"quorum": 0.9}, "quiet-census declares by its own word")
    ],
}
ROWS = [(path, *row) for path in EDGES for row in EDGES[path]]


@pytest.mark.parametrize(("path", "others", "valid", "invalid", "line"), ROWS)
def test_the_edge_of_a_rule_is_valid_and_what_is_just_beyond_it_is_an_error(
    path, others, valid, invalid, line
):
    """Catches a bound that is off by one, such as events that may not take the last task."""
    assert Scenario().replace({**others, path: valid})
    wrong = with_changes({}, {**others, path: invalid})[0]
    found = problems_of(wrong)
    assert str(found[-1]).startswith((line, f"{path} = {invalid!r}: {line}")), found
    for problem in found:
        check_remedies(problem, wrong)
    more = problems_of(with_changes(wrong, {"faults.stop_step": -1, "run.stop": 3})[0])
    assert set(map(str, found)) < set(map(str, more)), "a wrong field elsewhere hides no conflict"


def test_most_remedies_are_tried():
    wrong = [with_changes({}, {**others, path: invalid})[0] for path, others, _, invalid, _ in ROWS]
    tried = [any(ways(problem, each)) for each in wrong for problem in problems_of(each)]
    assert sum(tried) > 0.6 * len(tried)


def test_what_robots_know_may_take_exactly_the_memory_that_there_is():
    setting = Scenario().setting._replace(robots=2**20)
    words = KNOWLEDGE_LIMIT // 2**22
    assert excess(setting, words - 1, 1) == ""
    assert excess(setting, words, 1) != ""
