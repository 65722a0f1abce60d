"""Robots that act: who has which task, who arrives, and what comes of it (model.md 6.25)."""

from __future__ import annotations

import math
from functools import partial
from typing import Protocol

from feasibee.base.codes import exact
from feasibee.reference.mind import BYZANTINE
from feasibee.reference.place import QUARTERS, Pair
from feasibee.reference.robot import Robot
from feasibee.reference.way import Ways
from feasibee.reference.world import World
from feasibee.robot.acting import FREE, NONE
from feasibee.scenario.feasibility import can_do, most_taken, status_bits
from feasibee.scenario.scenario import Scenario

PLACE_BITS = 33
"""Bits of a message for a known task in addition to its status: one more follows, and its place."""


class Team(Protocol):
    """What acting needs of a swarm: its robots and tasks at this step."""

    scenario: Scenario
    world: World
    time: int
    truth: int
    robots: list[Robot]
    tasks: dict[int, Pair]
    task_kinds: list[int]

    @property
    def present(self) -> list[Robot]:
        """The robots that the truth is about."""

    @property
    def counted(self) -> list[Robot]:
        """The honest robots that still work."""


class Work:
    """The tasks of a swarm, those who have them, and the outcomes.

    Parameters
    ----------
    swarm : Team
        Its robots and tasks.
    """

    def __init__(self, swarm: Team) -> None:
        self._swarm, scenario = swarm, swarm.scenario
        self.places = dict(swarm.tasks)
        """Where tasks are or were."""
        self._reach = swarm.world.squared(exact(scenario.acting.reach))
        self._ways = Ways(swarm.world.ground, scenario.acting.reach) if swarm.world.ground else None
        self.can_do = can_do(scenario.robots, scenario.tasks)
        """For each class of robots whether it can do a task of each class."""
        self._status_bits = status_bits(scenario)
        self._sends_places = scenario.manifest.sends_positions
        self._most = 0
        self.holders: dict[int, Robot] = {}
        """Who stands at a task, or has marked it."""
        self._done_at: dict[int, int] = {}
        self.done: set[int] = set()
        """The tasks at which the work is done."""
        self.first_taken_step = self.all_taken_step = self.all_done_step = -1
        self.distance_walked = self.vain_arrivals = self.starts_in_vain = 0

    @property
    def tasks_taken(self) -> int:
        """Number of tasks at which robots stand, or that are done."""
        return len(self.done) + sum(robot.errand.task == task for task, robot in self.holders.items())

    def status(self, task: int) -> int | None:
        """Return whether a task is free, or else the rank of who has it; None if it vanished or is done."""
        if task not in self._swarm.tasks or task in self.done:
            return None
        holder = self.holders.get(task)
        return holder.errand.rules.rank if holder else FREE

    def bits(self, known: int) -> int:
        """Return how much longer a message is that names so many tasks (model.md 6.25.7)."""
        if self._sends_places:
            return known * self._status_bits
        return known * (PLACE_BITS + self._status_bits) + 1

    def begin(self) -> None:
        """Announce who joined; free tasks whose robots don't work, and robots whose tasks have vanished."""
        swarm = self._swarm
        self.places |= swarm.tasks
        if swarm.time in (1, swarm.scenario.faults.stop_step):
            self._most = most_taken(swarm.scenario, [robot.kind for robot in swarm.counted])
        for robot in swarm.present:
            robot.errand.announce(len(swarm.present))
        self.done &= swarm.tasks.keys()
        for task, robot in [*self.holders.items()]:
            if task not in swarm.tasks or robot not in swarm.robots or not robot.works(swarm.time):
                del self.holders[task]
                robot.errand.lose()
            elif self._done_at.get(task) == swarm.time and robot.errand.task == task:
                del self.holders[task]
                robot.errand.lose()
                self.done.add(task)
        if swarm.scenario.tasks.work and self.all_done_step == -1 and len(self.done) >= self.most:
            self.all_done_step = swarm.time

    @property
    def is_over(self) -> bool:
        """Whether all tasks are taken, or done if they take time (model.md 6.25.14, 6.26.5)."""
        return (self.all_done_step if self._swarm.scenario.tasks.work else self.all_taken_step) != -1

    @property
    def most(self) -> int:
        """How many tasks the counted robots can take, or have done and can do."""
        swarm = self._swarm
        if swarm.scenario.dynamic:
            tasks = len(swarm.tasks)
            return tasks if swarm.scenario.tasks.work else min(len(swarm.counted), tasks)
        if not swarm.scenario.tasks.work:
            return self._most
        able = [self.can_do[kind] for kind in {robot.kind for robot in swarm.counted}]
        can = [any(each[kind] for each in able) for kind in range(len(self.can_do[0]))]
        return sum(task in self.done or can[swarm.task_kinds[task]] for task in swarm.tasks)

    def course(self, robot: Robot) -> tuple[int, int]:
        """Return the step of a robot towards its target (model.md 6.25.2, 6.25.17)."""
        target = self.places[robot.errand.target]
        if self._ways:
            return self._ways.step(robot.place, target, robot.reach)
        x, y = self._swarm.world.way(robot.place, target)
        length = math.sqrt(float(x * x + y * y))
        if length == 0:
            return 0, 0
        reach = robot.reach
        return math.floor(reach * (x / length) + 0.5), math.floor(reach * (y / length) + 0.5)

    def way(self, robot: Robot, task: int) -> int | None:
        """Return how far a robot is from a task, squared or around walls; None if it can't do it."""
        if not self.can_do[robot.kind][self._swarm.task_kinds[task]]:
            return None
        if self._ways:
            return self._ways.length(robot.place, self.places[task])
        return self._swarm.world.squared_distance(robot.place, self.places[task])

    def _has_reached(self, place: Pair, task: int) -> bool:
        """Return whether a robot at a place has reached a task (model.md 6.25.3, 6.25.16)."""
        if self._ways:
            return self._ways.has_arrived(place, self.places[task])
        return self._swarm.world.squared_distance(place, self.places[task]) <= self._reach

    def may_shift(self, robot: Robot) -> bool:
        """Return whether a robot that stands may make the step of its run (model.md 6.25.12)."""
        ground, (x, y), (u, v) = self._swarm.world.ground, robot.place, robot.velocity
        if ground and ground.ends(robot.place, robot.velocity) < QUARTERS:
            return False
        return self._has_reached((x + u, y + v), robot.errand.task)

    def choose(self, robot: Robot) -> None:
        """Let a robot choose its target, if it acts (model.md 6.25.9)."""
        if robot.fault != BYZANTINE:
            robot.errand.choose(self._swarm.time, robot.mind.declared, partial(self.way, robot))

    def count(self, steps: int) -> None:
        """Count steps of robots, as long as there is a task left that they could take."""
        self.distance_walked += steps if self.all_taken_step == -1 else 0

    def arrive(self, working: list[Robot]) -> None:
        """Let robots take the tasks that they have reached, in the order of their numbers."""
        swarm = self._swarm
        for robot in working:
            if robot.errand.target != NONE and self._has_reached(robot.place, robot.errand.target):
                self._arrive(robot)
        if self.all_taken_step == -1 and self.tasks_taken >= self.most:
            self.all_taken_step = swarm.time

    def _arrive(self, robot: Robot) -> None:
        errand, task, swarm = robot.errand, robot.errand.target, self._swarm
        if not errand.arrive(self.status(task)):
            self.vain_arrivals += 1
            return
        self.holders[task] = robot
        if errand.task == task:
            self._done_at[task] = swarm.time + (swarm.scenario.tasks.work or 0)
            self.starts_in_vain += not swarm.truth
            if self.first_taken_step == -1:
                self.first_taken_step = swarm.time
