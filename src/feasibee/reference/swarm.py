"""One run, step by step: the robots, the tasks, and the swarm's decision."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping

from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED, exact
from feasibee.model.purposes import (
    APPEARING_CLASS,
    FALSE_ROBOT,
    FALSE_ROBOT_CLASS,
    FALSE_TASK,
    FALSE_TASK_CLASS,
    FAULT,
    JOINING_CLASS,
    LOSS,
    MISNAME,
    MISS_ROBOT,
    MISS_TASK,
    PAIR,
)
from feasibee.model.record import Record
from feasibee.reference.draws import choose, philox, poisson, rounded, shuffle
from feasibee.reference.dynamics import Dynamics, Operator
from feasibee.reference.mind import BYZANTINE, HONEST, STOPPED, STUBBORN
from feasibee.reference.robot import Robot, steps_of
from feasibee.reference.world import Names, Place, World
from feasibee.robot.controller import Message
from feasibee.scenario.feasibility import explain_numbers
from feasibee.scenario.fields import Robots, Tasks
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Thing


def simulate(scenario: Scenario, runs: Runs, curves: bool = False) -> Record:
    """Simulate runs one after the other; return their record."""
    length = scenario.run.steps + 1
    lengths = length if curves else 0, length if scenario.dynamic else 0
    record = Record.empty(runs.first, runs.count, *lengths)
    for row in range(runs.count):
        for step, swarm in enumerate(play(scenario, runs.seed, runs.first + row)):
            if curves:
                record.feasible_count[row, step] = swarm.feasible_count
                record.infeasible_count[row, step] = swarm.infeasible_count
            if record.decision[row] == UNDECIDED:
                record.decision[row] = swarm.decision
                record.decision_step[row] = step if swarm.decision != UNDECIDED else -1
            if scenario.dynamic:
                record.truth[row, step] = swarm.truth
                record.held[row, step] = swarm.decision
                record.robots_present[row, step] = len(swarm.robots)
                record.tasks_present[row, step] = len(swarm.tasks)
            if record.declare_step[row] == -1 and swarm.has_declared:
                record.declare_step[row] = step
            if scenario.run.stop_at_decision and record.decision[row] != UNDECIDED:
                break
        record.bits_sent[row] = swarm.bits_sent
        record.declared_feasible[row] = swarm.declared(FEASIBLE)
        record.declared_infeasible[row] = swarm.declared(INFEASIBLE)
        record.feasible_at_end[row] = swarm.feasible_count
        record.infeasible_at_end[row] = swarm.infeasible_count
        if swarm.operator is not None:
            record.calls[row] = swarm.operator.calls
            record.robots_called[row] = swarm.operator.robots_called
            record.robots_released[row] = swarm.operator.robots_released
    return record


def play(scenario: Scenario, seed: int, run: int) -> Iterator[Swarm]:
    """Yield the swarm of one run at step 0 and after each step."""
    swarm = Swarm(scenario, seed, run)
    yield swarm
    for _ in range(scenario.run.steps):
        swarm.step()
        yield swarm


class Swarm:
    """The robots and tasks of one run."""

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        self.scenario = scenario
        self.time = 0
        self.world = World(scenario, seed, run)
        self._run = (seed, run)
        self.robot_kinds = _kinds(scenario.robots, scenario.most.robots, JOINING_CLASS, self._run)
        self.task_kinds = _kinds(scenario.tasks, scenario.most.tasks, APPEARING_CLASS, self._run)
        faults = _faults(scenario, lambda k: philox(seed, run, 0, k, FAULT)[0])
        self.names = Names(scenario, seed, run)
        self.bits_sent = 0
        self.miss, self.loss = scenario.sensing.miss, scenario.radio.loss
        self.tasks = {i: self.world.task_place(i) for i in range(scenario.tasks.count)}
        self.robots = [
            self.new_robot(i, place, faults[i]) for i, place in enumerate(self.world.robot_places())
        ]
        self._sight = self.world.squared(scenario.sensing.range)
        self._radio = self.world.squared(scenario.radio.range)
        self._dynamics = Dynamics(self, seed, run) if scenario.dynamic else None
        self._look_up_truth()

    @property
    def operator(self) -> Operator | None:
        """Who responds to what the swarm holds, if anybody does (model.md 6.19)."""
        return self._dynamics.operator if self._dynamics is not None else None

    def new_robot(self, number: int, place: Place, fault: str = HONEST, before: Robot | None = None) -> Robot:
        """Return a robot that begins at this step; ``before`` was the last one of this number."""
        kind = self.robot_kinds[number]
        return Robot(
            self.scenario, *self._run, number, self.world, place, kind, fault, self.names, before, self.time
        )

    def _look_up_truth(self) -> None:
        """Store the truth of this step (model.md 6.17.3); Byzantine robots know it."""
        robots = _by_kind((self.robot_kinds[robot.number] for robot in self.robots), self.scenario.robots)
        tasks = _by_kind((self.task_kinds[number] for number in self.tasks), self.scenario.tasks)
        self.truth = int(explain_numbers(self.scenario, robots, tasks).feasible)
        self.names.inform(self.truth, len(self.robots), len(self.tasks))

    def step(self) -> None:
        """Simulate one step: move, observe and receive, end the step (model.md 3)."""
        held = self.decision if self.operator else UNDECIDED
        self.time += 1
        if self._dynamics is not None and self._dynamics.change(held):
            self._look_up_truth()
        working = [robot for robot in self.robots if robot.works(self.time)]
        blocked = self.move(working)
        # What is said is fixed before anyone changes: the opinions held when the step began.
        messages = [(robot, robot.says(self.time)) for robot in working]
        self.bits_sent += sum(self._bits(sender, message) for sender, message in messages if message)
        for robot in working:
            if not robot.mind.disseminating:
                robot.mind.see(self.sightings(robot))
            if robot.mind.listens:
                for sender, message in messages:
                    if message and sender is not robot and self.hears(robot, sender):
                        robot.mind.hear(self.names.id(sender.number), message)
        for robot in working:
            robot.end_step(robot in blocked)

    def move(self, working: list[Robot]) -> set[Robot]:
        """Move at once all robots whose way is clear; return the blocked ones (model.md 3.1, 6.2)."""
        going = steps_of(self.scenario.robots, self.world, self.robots, working)
        for robot, step in going.items():
            robot.velocity = step
            robot.move_to(self.world.moved(robot.place, step))
        return set(working) - set(going)

    def sightings(self, robot: Robot) -> Iterator[tuple[Thing, int]]:
        """Yield all that a robot sees in this step, with the number of each thing; -1 if it isn't there."""
        sensing = self.scenario.sensing
        for other in self.robots:
            seen = other is not robot and self._sees(robot, other.place, MISS_ROBOT, other.number)
            if seen or (other is robot and sensing.count_self):
                where = self.world.in_units(other.place)
                yield self.names.robot(other.number, other.kind, *where), other.number
        for number, place in self.tasks.items():
            if self._sees(robot, place, MISS_TASK, number):
                where = self.world.in_units(place)
                wrong = robot.happens(self.time, MISNAME + PAIR * number, sensing.misname)
                name = self.names.misnamed if wrong else self.names.task
                yield name(number, self.task_kinds[number], *where), number
        false = (FALSE_ROBOT, FALSE_ROBOT_CLASS)
        kinds = self.robot_kinds[: self.scenario.robots.count]
        for kind, mark in self._false_sightings(robot, sensing.false_robots, kinds, *false):
            yield Thing(True, -1, kind, mark), -1
        false = (FALSE_TASK, FALSE_TASK_CLASS)
        kinds = self.task_kinds[: self.scenario.tasks.count]
        for kind, mark in self._false_sightings(robot, sensing.false_tasks, kinds, *false):
            yield Thing(False, -1, kind, mark), -1

    def _sees(self, robot: Robot, place: Place, purpose: int, number: int) -> bool:
        """Return whether a place is within range (inclusive) and not missed (model.md 1.4, 6.3)."""
        return self.world.squared_distance(robot.place, place) <= self._sight and not robot.happens(
            self.time, purpose + PAIR * number, self.miss
        )

    def hears(self, robot: Robot, sender: Robot) -> bool:
        """Return whether a sender's message arrives (model.md 6.5)."""
        distance = self.world.squared_distance(robot.place, sender.place)
        return distance <= self._radio and not robot.happens(
            self.time, LOSS + PAIR * sender.number, self.loss
        )

    def _false_sightings(
        self, robot: Robot, mean: float, kinds: list[int], number: int, kind: int
    ) -> Iterator[tuple[int, int]]:
        """Yield class and hash of a robot's false sightings: a class as of a thing drawn at random."""
        if mean > 0:
            for k in range(poisson(robot.draw(self.time, number), mean)):
                words = robot.draws(self.time, kind + PAIR * k)
                yield kinds[choose(words[0], len(kinds))] if kinds else 0, words[1]

    def _bits(self, sender: Robot, message: Message) -> int:
        """Return the length of a message in bits: id, opinion, value and declaration, or knowledge."""
        says_declared = self.scenario.decision.declare is not None
        if sender.mind.knowledge:
            bits = sender.mind.knowledge.bits(message.knowledge)
            return bits + (self.names.id_bits + 2 if says_declared else 0)
        return self.names.id_bits + 1 + sender.mind.strategy.value_bits + says_declared

    @property
    def counted(self) -> list[Robot]:
        """The counted robots: honest and still working (model.md 6.6)."""
        return [robot for robot in self.robots if robot.fault != BYZANTINE and robot.works(self.time)]

    def holding(self, opinion: int) -> list[Robot]:
        """Return the counted robots that hold an opinion."""
        return [robot for robot in self.counted if robot.mind.opinion == opinion]

    @property
    def feasible_count(self) -> int:
        """Number of counted robots with opinion 1."""
        return len(self.holding(FEASIBLE))

    @property
    def infeasible_count(self) -> int:
        """Number of counted robots with opinion 0."""
        return len(self.holding(INFEASIBLE))

    def declared(self, opinion: int) -> int:
        """Return how many counted robots have declared an opinion."""
        return sum(robot.mind.declared == opinion for robot in self.counted)

    @property
    def has_declared(self) -> bool:
        """Whether more than the threshold's share of the counted robots has declared (model.md 6.15)."""
        declared = self.declared(FEASIBLE) + self.declared(INFEASIBLE)
        return declared > exact(self.scenario.decision.threshold) * len(self.counted)

    @property
    def decision(self) -> int:
        """The opinion that more than the threshold's share of the counted robots holds (model.md 4.7)."""
        needed = exact(self.scenario.decision.threshold) * len(self.counted)
        if self.feasible_count > needed:
            return FEASIBLE
        if self.infeasible_count > needed:
            return INFEASIBLE
        return UNDECIDED


def _kinds(section: Robots | Tasks, most: int, purpose: int, run: tuple[int, int]) -> list[int]:
    """Return the class of each number; beyond those of the start, that of one drawn from them."""
    kinds = [i for i, count in enumerate(_counts(section)) for _ in range(count)]
    drawn = (philox(*run, number, 0, purpose)[0] for number in range(len(kinds), most))
    return kinds + [kinds[choose(word, len(kinds))] if kinds else 0 for word in drawn]


def _counts(section: Robots | Tasks) -> list[int]:
    """Return the numbers of the start by class, or all if there are no classes."""
    return [each.count for each in section.classes] or [section.count]


def _by_kind(kinds: Iterable[int], section: Robots | Tasks) -> list[int]:
    """Return how many there are of each class."""
    number = Counter(kinds)
    return [number[kind] for kind in range(max(1, len(section.classes)))]


def _faults(scenario: Scenario, draw: Callable[[int], int]) -> list[str]:
    """Return each robot's fault; the faulty robots are drawn at random (model.md 6.6)."""
    count = scenario.robots.count
    faults = [HONEST] * count
    numbers = [
        (fault, given["count"] if isinstance(given, Mapping) else rounded(exact(given), count))
        for fault, given in (
            (STOPPED, scenario.faults.stopped),
            (BYZANTINE, scenario.faults.byzantine),
            (STUBBORN, scenario.faults.stubborn),
        )
    ]
    if any(number for _, number in numbers):
        left = iter(shuffle(count, draw))
        for fault, number in numbers:
            for _ in range(number):
                faults[next(left)] = fault
    return faults
