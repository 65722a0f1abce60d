"""What the functions of a strategy's knowledge are given: words, robots and tasks, and numbers."""

from __future__ import annotations

from numba import float64, int64, uint32

from feasibee.engine.bits import contains
from feasibee.engine.compile import inlined, spliced
from feasibee.engine.intrinsics import row_of
from feasibee.engine.layout import Copy, Point, Robot, Set
from feasibee.strategies.contract import Me, Setting, Thing


@spliced
def known_by(params, passing, i):
    """Return the words that a robot knows."""
    return row_of(passing.words, Copy.KNOWN, i, params.strategy.knowledge.words)


@spliced
def told_by(params, passing, i):
    """Return the words of a robot's message."""
    return row_of(passing.words, Copy.SENT, i, params.strategy.knowledge.message_words)


@inlined
def in_units(params, fixed):
    """Return a coordinate in units of length."""
    return float64(uint32(fixed)) * params.arena.unit


@inlined
def thing_seen(params, passing, number, column, mark):
    """Return a robot or task as robots see it.

    Robots are numbered first, then tasks, then tasks under their wrong names, with the hash given. One that
    isn't there has number -1, and the class and hash given.
    """
    if number < 0:
        is_robot = column < params.robots.classes
        kind = column if is_robot else column - params.robots.classes
        return Thing(is_robot, int64(-1), kind, int64(uint32(mark)), 0.0, 0.0)
    # Without a branch: a wrong guess whether robot or task follows costs more than the rest.
    misnamed = number >= params.robots.count + params.tasks.count
    number -= params.tasks.count if misnamed else 0
    is_robot, kind, task = (
        number < params.robots.count,
        int64(passing.class_of[number]),
        number - params.robots.count,
    )
    identity = int64(passing.robots[Robot.IDENTITY, number if is_robot else 0])
    own_mark = int64(passing.hashes[identity if is_robot else number])
    fixed_x = passing.robots[Robot.X, number] if is_robot else passing.tasks[Point.X, task]
    fixed_y = passing.robots[Robot.Y, number] if is_robot else passing.tasks[Point.Y, task]
    x, y = in_units(params, fixed_x), in_units(params, fixed_y)
    if misnamed:
        half = 0.5 * params.arena.sides.width
        wrong = params.strategy.knowledge.task_ids - params.tasks.count + task
        return Thing(False, wrong, kind, int64(uint32(mark)), x + half if x < half else x - half, y)
    return Thing(is_robot, identity if is_robot else task, kind, own_mark, x, y)


@inlined
def invented_robot(params, passing, k):
    """Return the robot of a number among those that Byzantine robots invent."""
    mark = int64(passing.hashes[params.robots.count + params.tasks.count + k])
    return Thing(True, params.robots.count + k, int64(0), mark, 0.0, 0.0)


@inlined
def invented_task(params, passing, k):
    """Return the task of a number among those that Byzantine robots invent."""
    mark = int64(passing.hashes[params.robots.count + 2 * params.tasks.count + k])
    return Thing(False, params.tasks.count + k, int64(0), mark, 0.0, 0.0)


@inlined
def setting_of(params, passing):
    """Return the numbers of the scenario that a function of the strategy is given.

    Read before a loop over robots, not in it: the compiler must assume that the functions change them.
    """
    knowledge = params.strategy.knowledge
    return Setting(
        params.robots.count,
        params.robots.at_start,
        params.tasks.count,
        knowledge.robot_ids,
        knowledge.task_ids,
        params.robots.classes,
        knowledge.task_classes,
        params.radio.id_bits,
        passing.parameters,
        params.robots.knows_count,
        params.faults.colluding,
        params.arena.sides.width,
        params.arena.sides.height,
        params.arena.walls,
        params.sensing.range,
        params.radio.range,
        params.robots.speed,
        params.decision.exploration,
        params.decision.gain + params.decision.dissemination_floor,
        params.walk.mean_run,
    )


@inlined
def me_of(params, passing, setting, now, i):
    """Return the robot that a function of the strategy works for."""
    identity = int64(passing.robots[Robot.IDENTITY, i])
    mark = int64(passing.hashes[identity])
    x, y = in_units(params, passing.robots[Robot.X, i]), in_units(params, passing.robots[Robot.Y, i])
    explores = not contains(passing.sets[Set.DISSEMINATING], i)
    return Me(identity, int64(passing.class_of[i]), mark, now, passing.memory[i, 1:], setting, explores, x, y)
