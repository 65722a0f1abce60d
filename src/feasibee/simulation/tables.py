"""The arrays of a scenario that the engine works with: classes, skills, points, parameters and events."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from feasibee.engine.layout import Event, Int32s, Int64s, Tables
from feasibee.engine.params import ArenaParams, Params
from feasibee.model.codes import exact
from feasibee.scenario.fields import Robots, Tasks
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.fixed_point import probability, unit_of


def tables_of(scenario: Scenario, params: Params) -> Tables:
    """Return the arrays of a scenario: classes, sets of skills, given points, the strategy's parameters."""
    robots, tasks = scenario.robots, scenario.tasks
    return Tables(
        class_of=np.concatenate(
            [
                _numbers([each.count for each in robots.classes], scenario.most.robots),
                _numbers([each.count for each in tasks.classes], scenario.most.tasks),
            ]
        ),
        adds=_adds(scenario),
        points=np.concatenate(
            [
                _given_points(scenario, robots, params.robots.placement.margin, params.arena),
                _given_points(scenario, tasks, 0, params.arena),
            ]
        ),
        parameters=np.array(list(scenario.decision.parameters.values()), np.float64),
        events=_events(scenario),
    )


def _events(scenario: Scenario) -> Int64s:
    """Return the events in the order in which they happen: by step, then as in the file."""
    rows = [
        [
            event.step,
            event.tasks,
            event.robots,
            -1 if event.sensing.miss is None else int(probability(event.sensing.miss)),
            -1 if event.radio.loss is None else int(probability(event.radio.loss)),
        ]
        for event in sorted(scenario.events, key=lambda event: event.step)
    ]
    return np.array(rows, np.int64).reshape(-1, len(Event))


def _adds(scenario: Scenario) -> Any:
    """Return what each class adds to each set of skills: each subset of them, then all robots and places."""
    robots, tasks = scenario.robots.classes, scenario.tasks.classes
    skills = sorted({s for each in robots for s in each.skills} | {s for each in tasks for s in each.needs})
    subsets = range(1, 2 ** len(skills))
    has = [sum(2 ** skills.index(skill) for skill in set(each.skills)) for each in robots] or [0]
    robot_adds = [[int(mask & subset > 0) for mask in has] for subset in subsets]
    task_adds = [
        [
            sum(number for skill, number in each.needs.items() if subset >> skills.index(skill) & 1)
            for each in tasks
        ]
        or [0]
        for subset in subsets
    ]
    robot_adds.append([1] * len(has))
    task_adds.append([sum(each.needs.values()) for each in tasks] or [1])
    return np.hstack([np.array(robot_adds, np.int64), np.array(task_adds, np.int64)])


def _numbers(counts: list[int], total: int) -> Int32s:
    """Return the class of each robot or task: first those of class 0, then those of class 1, ...

    Those that aren't there at the start have class 0 until a run draws theirs.
    """
    kinds = np.zeros(total, np.int32)
    kinds[: sum(counts)] = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    return kinds


def _given_points(scenario: Scenario, section: Robots | Tasks, margin: int, arena: ArenaParams) -> Int32s:
    """Return given points in fixed point, off the walls by a margin."""
    if section.placement != "points":
        return np.zeros((section.count, 2), np.int32)
    sides, unit = (arena.width, arena.height), unit_of(scenario)
    places = [
        [
            min(max(math.floor(exact(p) / unit), margin), side - margin)
            for p, side in zip(point, sides, strict=True)
        ]
        for point in section.points
    ]
    return np.array(places, np.int64).astype(np.uint32).view(np.int32).reshape(-1, 2)
