"""Robots: place, walk, senses, faults and controller of one, and which of them go in a step."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import combinations
from typing import Any, Final

from feasibee.base.codes import COS_EIGHTH, exact
from feasibee.base.purposes import BATTERY, FAILURE, WALK
from feasibee.reference.draws import choose, cos_sin, duration, happens
from feasibee.reference.mind import STOPPED, Mind, MindSettings
from feasibee.reference.place import QUARTERS, Ground
from feasibee.reference.world import Names, Place, World
from feasibee.robot import controller
from feasibee.robot.acting import NONE, Errand, Rules
from feasibee.robot.controller import Declare, Message
from feasibee.scenario.feasibility import ranks_of
from feasibee.scenario.fields import Robots
from feasibee.scenario.scenario import Scenario

Said = tuple[Message | None, int]
"""A message, if any, and its length in bits."""
SILENCE: Said = (None, 0)
DETOUR: Final = 3
"""Most steps that a blocked robot walks another way before it heads for its target again."""


class Robot:
    """A robot of a simulated swarm, at a place of its world, with a class and a fault (model.md 6.6).

    ``step`` is the one at which it comes; ``before`` was the last robot of its number, whose draws go on
    (model.md 6.17.6).
    """

    errand_type: type[Errand] = Errand

    def __init__(
        self,
        world: World,
        names: Names,
        number: int,
        place: Place,
        kind: int,
        fault: str,
        before: Robot | None = None,
        step: int = 0,
    ) -> None:
        self.number = number
        self.place = place
        self.kind = kind
        self.fault = fault
        self._scenario = world.scenario
        self._world = world
        self.reach = float(exact(self._scenario.robots.speed) / world.unit)
        """Length of its step."""
        self.joined: int = before.joined + 1 if before else 0
        self._walks: int = before._walks if before else 0
        self.velocity = STAND
        self._turn()
        self.heading = self.velocity
        self._names = names
        rate = self._scenario.robots.failure_rate
        self.leaves_at = step + duration(self.draw(self.joined, FAILURE), 1 / rate) if rate else None
        work = self._scenario.robots.work
        self.switches_at = max(step, 1) + 1 + choose(self.draw(self.joined, BATTERY), work) if work else None
        phases = before.mind.phases if before else 0
        self.mind: Mind = self.mind_of(self._settings(phases, step))
        self._waiting = deque([SILENCE] * self._scenario.radio.delay)
        self.errand = self.errand_type(rules_of(self._scenario, number, kind))
        self.detour = 0
        """Number of steps for which it walks another way than to its target."""
        self._run: Place | None = None
        self._waits = True

    def mind_of(self, settings: MindSettings) -> Mind:
        """Return the robot's mind; that of a robot of ``feasibee robot launch`` is in another process."""
        return Mind(self._scenario.strategy, settings)

    def works(self, step: int) -> bool:
        """Return whether the robot still works at a step."""
        return self.fault != STOPPED or step < self._scenario.faults.stop_step

    def says(self, step: int) -> Message | None:
        """Return the message that the robot broadcasts in a step, if any; a Byzantine robot lies."""
        return self.mind.says(step, self._names.truth, self._names.inventions)

    def delayed(self, said: Said) -> Said:
        """Return what it broadcasts: what it said ``radio.delay`` steps before (model.md 6.21.2)."""
        self._waiting.append(said)
        return self._waiting.popleft()

    def move_to(self, place: Place) -> None:
        """Move to a place."""
        self.place = place
        self.mind.move_to(*self._world.in_units(place))

    def come_back(self, place: Place, switches_at: int) -> None:
        """Enter the arena again with a charged battery (model.md 6.23)."""
        self.move_to(place)
        self._turn()
        self._waiting = deque([SILENCE] * self._scenario.radio.delay)
        self.switches_at = switches_at

    def set_out(self, course: Callable[[Robot], Place], may_shift: Callable[[Robot], bool]) -> None:
        """Head for its target, unless it is on a detour, or stand; its run waits (model.md 6.25.2)."""
        self._run, self._waits = None, True
        if self.errand.task != NONE:
            bodies = self._scenario.robots.avoid_collisions
            if not (bodies and may_shift(self)):
                self._run, self.velocity, self._waits = self.velocity, STAND, not bodies
        elif self.errand.target != NONE:
            if self.detour:
                self.detour -= 1
            else:
                self._run, self.velocity = self.velocity, course(self)

    def end_step(self, blocked: bool) -> None:
        """Advance the timers of heading and phase; a blocked robot turns (model.md 3.3, 6.2)."""
        if self._run is None or not self._waits:
            self._walk_left -= 1
        if self._run is not None:
            self.velocity = self._run
        turns = blocked or self._walk_left == 0
        if turns:
            self._turn()
        if turns or self.errand.target == NONE:
            self.detour = DETOUR if blocked and self.errand.target != NONE else 0
        self.mind.end_step()

    def happens(self, step: int, purpose: int, probability: float) -> bool:
        """Return whether an event of this probability happens to the robot in a step."""
        return probability > 0 and happens(self.draw(step, purpose), probability)

    def draw(self, counter: int, purpose: int) -> int:
        """Return the first random word of a coordinate of this robot."""
        return self.draws(counter, purpose)[0]

    def draws(self, counter: int, purpose: int) -> tuple[int, int, int, int]:
        """Return the random words of a coordinate of this robot."""
        return self._world.draw(self.number, counter, purpose)

    def _turn(self) -> None:
        """Draw a heading and how long it lasts (model.md 2.1)."""
        heading, lasting, _, _ = self.draws(self._walks, WALK)
        self._walks += 1
        cosine, sine = cos_sin(heading)
        self.velocity = (math.floor(self.reach * cosine + 0.5), math.floor(self.reach * sine + 0.5))
        self._walk_left = duration(lasting, self._scenario.walk.mean_run)

    def _settings(self, phases: int, step: int) -> MindSettings:
        """Return the settings of the robot's mind."""
        own = {
            "me": self._names.me(self.number, self.kind),
            "place": self._world.in_units(self.place),
            "step": max(0, step - 1),
        }
        return MindSettings(
            **vars(settings_of(self._scenario)) | own,
            coordinates=(*self._world.run, self.number),
            joined=self.joined,
            phases=phases,
            fault=self.fault,
            byzantine_says=self._scenario.faults.byzantine_says,
            repeated=self._scenario.sensing.observation == "repeated",
        )


def settings_of(scenario: Scenario) -> controller.Settings:
    """Return what a scenario sets for the controller of each robot."""
    assert scenario.flooding is not None or not scenario.waits_for_names, "call flooded first"
    decision, rule = scenario.decision, scenario.decision.declare
    return controller.Settings(
        exploration=decision.exploration,
        gain=decision.gain,
        dissemination_floor=decision.dissemination_floor,
        quality_floor=decision.quality_floor,
        own_vote=decision.own_vote,
        random_ties=decision.ties == "random-message",
        first_sight=decision.start == "first-sight",
        listens_for=_listening(decision.listen),
        every_message=decision.inbox == "every-message",
        inbox_size=decision.inbox_size,
        parameters=list(decision.parameters.values()),
        declare=Declare(exact(rule.quorum), rule.rounds, rule.heard) if rule else None,
        sets=_hall_sets(scenario),
        setting=scenario.setting,
    )


def rules_of(scenario: Scenario, number: int, kind: int) -> Rules:
    """Return the rules by which a robot of a class acts."""
    acting, ranks = scenario.acting, ranks_of(scenario.robots)
    return Rules(
        start=scenario.acts_from,
        by_word=acting.start == "declared",
        by_rank=acting.choose == "rank",
        tags=acting.hold == "tag",
        comes_free=scenario.may_come_free,
        number=number,
        rank=ranks[kind],
        ranks=max(ranks),
        count=scenario.robots.count if scenario.robots.know_count and not scenario.tasks.work else None,
    )


def _listening(listen: Any) -> int | None:
    """Return the number of last steps of dissemination in which a robot listens.

    0 stands for all of them, None for exploration, too.
    """
    if listen == "always":
        return None
    return 0 if listen == "dissemination" else int(listen["last"])


def _hall_sets(scenario: Scenario) -> list[tuple[list[int], list[int]]]:
    """Return what each class of robots and of tasks adds to each set of skills (model.md 6.7).

    A robot counts if it has a skill of the set; a task counts its places that ask for one. The last set is
    that of all skills: to it every robot counts, and a task of no class, which any robot can do.
    """
    robots, tasks = scenario.robots.classes, scenario.tasks.classes
    skills = sorted(
        {skill for each in robots for skill in each.skills} | {s for each in tasks for s in each.needs}
    )
    sets = [
        (
            [int(not chosen.isdisjoint(each.skills)) for each in robots] or [0],
            [sum(number for skill, number in each.needs.items() if skill in chosen) for each in tasks] or [0],
        )
        for size in range(1, len(skills) + 1)
        for chosen in map(set, combinations(skills, size))
    ]
    everything = [sum(each.needs.values()) for each in tasks] or [1]
    return [*sets, ([1] * max(1, len(robots)), everything)]


# --- Bodies: discs never overlap (model.md 6.1, 6.2) ---

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
    for robot in blocked:
        robot.velocity = tried[robot]  # it looks where it tried to go (model.md 6.22.1)
    return going


def obstacles(world: World, robot: Robot, step: Place, others: Steps) -> Iterator[Place]:
    """Yield the way to each robot, and the direction of each wall, that blocks a step of a robot."""
    if world.ground:
        if world.ground.ends(robot.place, step) < QUARTERS:
            yield way_to_place(world.ground, robot.place, step)
    elif not world.is_torus:
        for axis, (place, side) in enumerate(zip(world.moved(robot.place, step), world.size, strict=True)):
            for wall, beyond in ((-1, place < world.radius), (1, place > side - world.radius)):
                if beyond:
                    yield (wall, 0) if axis == 0 else (0, wall)
    for other, steps in others.items():
        if other is not robot:
            way = world.way(robot.place, other.place)
            if any(world.meet(way, (dx - step[0], dy - step[1])) for dx, dy in steps):
                yield way


def way_to_place(ground: Ground, place: Place, step: Place) -> Place:
    """Return the way to what blocks a step in a place: left or right of it, or ahead (model.md 6.20.5)."""
    u, v = step
    left, right = (ground.ends(place, eighth(step, is_left)) for is_left in (True, False))
    if left == right:
        return step
    return (-v, u) if right > left else (v, -u)


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
