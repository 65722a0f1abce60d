"""Bodies: which robots go in a step and how, since discs never overlap (model.md 6.1, 6.2)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from feasibee.model.codes import COS_EIGHTH
from feasibee.reference.robot import Robot
from feasibee.reference.world import Place, World
from feasibee.scenario.fields import Robots

STAND = (0, 0)
Steps = Mapping[Robot, Collection[Place]]
"""The steps that each robot may make, one of which it will."""


def steps_of(section: Robots, world: World, robots: list[Robot], working: list[Robot]) -> dict[Robot, Place]:
    """Return the step of each robot that goes; the other ones stand (model.md 6.2.1 to 6.2.5)."""
    possible: dict[Robot, tuple[Place, ...]] = dict.fromkeys(robots, (STAND,))
    tried = {robot: robot.velocity for robot in working}
    possible |= {robot: (STAND, step) for robot, step in tried.items()}
    others = possible if section.avoid_collisions else {}
    blocked = [robot for robot, step in tried.items() if any(obstacles(world, robot, step, others))]
    going = {robot: step for robot, step in tried.items() if robot not in blocked}
    if section.contact == "stand":
        return going
    left = {robot: turns_left(world, robot, possible) for robot in blocked}
    for _ in range(2):
        possible |= {robot: (step,) for robot, step in going.items()}
        tried = {robot: eighth(tried[robot], left[robot]) for robot in blocked}
        possible |= {robot: (STAND, step) for robot, step in tried.items()}
        clear = [robot for robot in blocked if not any(obstacles(world, robot, tried[robot], possible))]
        going |= {robot: tried[robot] for robot in clear}
        blocked = [robot for robot in blocked if robot not in clear]
    return going


def obstacles(world: World, robot: Robot, step: Place, others: Steps) -> Iterator[Place]:
    """Yield the way to each robot, and the direction of each wall, that blocks a step of a robot."""
    if not world.is_torus:
        for axis, (place, side) in enumerate(zip(world.moved(robot.place, step), world.size, strict=True)):
            for wall, beyond in ((-1, place < world.radius), (1, place > side - world.radius)):
                if beyond:
                    yield (wall, 0) if axis == 0 else (0, wall)
    for other, steps in others.items():
        if other is not robot:
            way = world.way(robot.place, other.place)
            if any(world.meet(way, (dx - step[0], dy - step[1])) for dx, dy in steps):
                yield way


def turns_left(world: World, robot: Robot, possible: Steps) -> bool:
    """Return whether a blocked robot turns left: unless all that blocks it lies left of its heading."""
    u, v = robot.velocity
    sides = [u * y - v * x for x, y in obstacles(world, robot, robot.velocity, possible)]
    return any(side < 0 for side in sides) or not any(side > 0 for side in sides)


def eighth(step: Place, left: bool) -> Place:
    """Return a step turned by an eighth of a turn, rounded towards 0 (model.md 6.2.4)."""
    u, v = step
    return (shortened(u - v), shortened(u + v)) if left else (shortened(u + v), shortened(v - u))


def shortened(sum_of_both: int) -> int:
    """Return a number times the cosine of an eighth of a turn, rounded towards 0."""
    size = abs(sum_of_both) * COS_EIGHTH // 2**32
    return size if sum_of_both >= 0 else -size
