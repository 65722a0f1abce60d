"""How the world of a run changes: events, streams of tasks and robots, responses (model.md 6.17, 6.19)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.model.purposes import ARRIVAL, LEAVE, LIFETIME, RELEASE, VANISH
from feasibee.reference.draws import choose, duration, philox, poisson
from feasibee.reference.robot import Robot
from feasibee.reference.world import Place, World
from feasibee.scenario.scenario import Scenario


class Swarm(Protocol):
    """What changes of a swarm; see `feasibee.reference.swarm.Swarm`."""

    scenario: Scenario
    time: int
    world: World
    tasks: dict[int, Place]
    robots: list[Robot]
    miss: float
    loss: float

    @property
    def counted(self) -> list[Robot]:
        """The counted robots."""

    def new_robot(self, number: int, place: Place, *, before: Robot | None) -> Robot:
        """Return a robot that begins at this step."""


class Dynamics:
    """The changes of one swarm's world.

    Parameters
    ----------
    swarm : Swarm
        The swarm at step 0; events of that step happen at once.
    seed, run : int
        Seed and number of the run.
    """

    def __init__(self, swarm: Swarm, seed: int, run: int) -> None:
        self._swarm = swarm
        self._run = (seed, run)
        self._appeared = 0
        self._vanishes_at: dict[int, int] = {}
        self._gone: dict[int, Robot] = {}
        self.operator = Operator(swarm.scenario) if swarm.scenario.response.patience is not None else None
        for _ in swarm.tasks:
            self._begin_lifetime()
        self._happen()

    def change(self, held: int) -> bool:
        """Change the world at the beginning of a step; return whether robots or tasks came or went.

        ``held`` is the opinion that the swarm held after the step before.
        """
        before = set(self._swarm.tasks), set(self._swarm.robots)
        now = self._swarm.time
        if self.operator is not None:
            self._release(self.operator, self.operator.look(now, held, self._swarm.counted))
        self._take_tasks(number for number, step in self._vanishes_at.items() if step == now)
        self._take_robots(robot for robot in self._swarm.robots if robot.leaves_at == now)
        self._happen()
        tasks, robots, _, _ = self._draw(0, ARRIVAL)
        for _ in range(poisson(tasks, self._swarm.scenario.tasks.arrival_rate or 0.0)):
            self._appear()
        for _ in range(poisson(robots, self._swarm.scenario.robots.arrival_rate or 0.0)):
            self._join()
        for _ in range(self.operator.arriving(now) if self.operator else 0):
            self._join()
        return before != (set(self._swarm.tasks), set(self._swarm.robots))

    def _release(self, operator: Operator, number: int) -> None:
        """Release so many robots, but not the last one (model.md 6.19.6)."""
        for k in range(min(number, len(self._swarm.robots) - 1)):
            robots = self._swarm.robots
            self._take_robots([robots[self._chosen(k, RELEASE, len(robots))]])
            operator.robots_released += 1

    def _happen(self) -> None:
        """Let the events of this step happen (model.md 6.17.2)."""
        vanished = left = 0
        for event in self._swarm.scenario.events:
            if event.step != self._swarm.time:
                continue
            for _ in range(event.tasks):
                self._appear()
            for _ in range(min(-event.tasks, len(self._swarm.tasks))):
                there = list(self._swarm.tasks)
                self._take_tasks([there[self._chosen(vanished, VANISH, len(there))]])
                vanished += 1
            for _ in range(event.robots):
                self._join()
            for _ in range(min(-event.robots, len(self._swarm.robots))):
                robots = self._swarm.robots
                self._take_robots([robots[self._chosen(left, LEAVE, len(robots))]])
                left += 1
            if event.sensing.miss is not None:
                self._swarm.miss = event.sensing.miss
            if event.radio.loss is not None:
                self._swarm.loss = event.radio.loss

    def _appear(self) -> None:
        """Let the next task appear, unless all numbers have been used (model.md 6.17.4)."""
        if self._appeared < self._swarm.scenario.most.tasks:
            self._swarm.tasks[self._appeared] = self._swarm.world.task_place(self._appeared)
            self._begin_lifetime()

    def _begin_lifetime(self) -> None:
        mean = self._swarm.scenario.tasks.lifetime
        if mean is not None:
            word = philox(*self._run, self._appeared, 0, LIFETIME)[0]
            self._vanishes_at[self._appeared] = self._swarm.time + duration(word, mean)
        self._appeared += 1

    def _take_tasks(self, numbers: Iterable[int]) -> None:
        for number in list(numbers):
            del self._swarm.tasks[number]
            self._vanishes_at.pop(number, None)

    def _join(self) -> None:
        """Let a robot join, if a number and a place are free (model.md 6.17.6, 6.17.7)."""
        taken = {robot.number for robot in self._swarm.robots}
        number = next(i for i in range(len(taken) + 1) if i not in taken)
        if number >= self._swarm.scenario.most.robots:
            return
        before = self._gone.get(number)
        joined = before.joined + 1 if before else 0
        others = [robot.place for robot in self._swarm.robots]
        place = self._swarm.world.joining_place(number, joined, others)
        if place is not None:
            self._swarm.robots.append(self._swarm.new_robot(number, place, before=before))
            self._swarm.robots.sort(key=lambda robot: robot.number)

    def _take_robots(self, robots: Iterable[Robot]) -> None:
        for robot in list(robots):
            self._swarm.robots.remove(robot)
            self._gone[robot.number] = robot

    def _chosen(self, before: int, purpose: int, count: int) -> int:
        """Return one of so many, drawn at random."""
        return choose(self._draw(before, purpose)[0], count)

    def _draw(self, which: int, purpose: int) -> tuple[int, int, int, int]:
        return philox(*self._run, which, self._swarm.time, purpose)


class Operator:
    """The operator of one swarm.

    Parameters
    ----------
    scenario : Scenario
        What is simulated; its `response` has a patience.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._held = UNDECIDED
        self._steps = 0
        self._arrives_at = -1
        self._awaited = 0
        self.calls = self.robots_called = self.robots_released = 0

    def look(self, now: int, held: int, counted: list[Robot]) -> int:
        """Look at the opinion held after the step before; return how many robots are to spare."""
        if now <= self._arrives_at:
            self._steps = 0
            return 0
        if held == UNDECIDED:
            self._steps = 0
        else:
            self._steps = self._steps + 1 if held == self._held else 1
        self._held = held
        response = self._scenario.response
        if response.patience is None or self._steps < response.patience:
            return 0
        self._steps = 0
        gap = self._gap([robot for robot in counted if robot.mind.opinion == held])
        if held == INFEASIBLE:
            self._call(now, 1 if gap is None else gap + response.margin)
        if held == FEASIBLE and gap is not None:
            return max(0, -gap - response.margin)
        return 0

    def arriving(self, now: int) -> int:
        """Return how many called robots arrive at a step."""
        return self._awaited if now == self._arrives_at else 0

    def _call(self, now: int, robots: int) -> None:
        self._awaited = min(max(1, robots), self._scenario.most.robots)
        self._arrives_at = now + self._scenario.response.delay
        self.calls += 1
        self.robots_called += self._awaited

    def _gap(self, asked: list[Robot]) -> int | None:
        """Return the lower median of the gaps that robots believe in, or None if they know none."""
        if not self._scenario.manifest.knows_gap or not asked:
            return None
        gaps = sorted(robot.mind.knowledge.gap() for robot in asked if robot.mind.knowledge)
        return gaps[(len(gaps) - 1) // 2]
