"""One run, step by step: the robots, the tasks, the swarm's decision, and how the world changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping

from feasibee.base import purposes
from feasibee.base.codes import CERTAIN, FEASIBLE, INFEASIBLE, MOST_WALLS, UNDECIDED, exact
from feasibee.base.outcomes import ACTS, OUTCOMES, WORKS
from feasibee.base.record import Record
from feasibee.reference.acting import Work
from feasibee.reference.draws import choose, cos_sin, duration, poisson, rounded, shuffle
from feasibee.reference.mind import BYZANTINE, HONEST, STOPPED, STUBBORN
from feasibee.reference.robot import SILENCE, STAND, Robot, Said, steps_of
from feasibee.reference.world import Names, Place, World
from feasibee.robot.acting import NONE
from feasibee.scenario.feasibility import explain_kinds, kinds_of
from feasibee.scenario.fields import Event, Point, Robots, Tasks
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Thing

WORKED = [each.name for each in OUTCOMES if each.needs in (ACTS, WORKS)]
"""Outcomes of robots that act."""


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
                record.robots_present[row, step] = len(swarm.present)
                record.tasks_present[row, step] = len(swarm.tasks)
            if record.declare_step[row] == -1 and swarm.has_declared:
                record.declare_step[row] = step
            record.last_step[row] = step
            if swarm.is_over(bool(record.decision[row] != UNDECIDED)):
                break
        record.bits_sent[row] = swarm.bits_sent
        record.declared_feasible[row] = swarm.declared(FEASIBLE)
        record.declared_infeasible[row] = swarm.declared(INFEASIBLE)
        record.feasible_at_end[row] = swarm.feasible_count
        record.infeasible_at_end[row] = swarm.infeasible_count
        if scenario.gives_probability:
            record.said_at_end[row] = swarm.said
        for name in WORKED if swarm.work else ():
            getattr(record, name)[row] = getattr(swarm.work, name)
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

    robot_type: type[Robot] = Robot

    def __init__(self, scenario: Scenario, seed: int, run: int) -> None:
        self.scenario = scenario
        self.time = 0
        self.world = World(scenario, seed, run)
        self.robot_kinds = _kinds(scenario.robots, scenario.most.robots, purposes.JOINING_CLASS, self.world)
        self.task_kinds = _kinds(scenario.tasks, scenario.most.tasks, purposes.APPEARING_CLASS, self.world)
        faults = _faults(scenario, lambda k: self.world.draw(0, k, purposes.FAULT)[0])
        self.names = Names(self.world)
        self.bits_sent = 0
        self.miss, self.loss = scenario.sensing.miss, scenario.radio.loss
        self.tasks = {i: self.world.task_place(i) for i in range(scenario.tasks.count)}
        self._called = self.world.chains(self.tasks) if scenario.sensing.position_error else {}
        self.robots = [
            self.new_robot(i, place, faults[i]) for i, place in enumerate(self.world.robot_places())
        ]
        radio, walls = exact(scenario.radio.range), exact(scenario.radio.walls)
        self._sight = [self.world.squared(exact(scenario.sensing.range)), -1]
        self._radio = [
            self.world.squared(radio * walls**k) if walls or not k else -1 for k in range(MOST_WALLS + 1)
        ]
        half = cos_sin(math.floor(scenario.sensing.view * 2**32 / 720 + 0.5))
        self._view = [math.floor(2**30 * part + 0.5) for part in half]
        self.away: list[Robot] = []
        self.work = Work(self) if scenario.acts else None
        self._dynamics = Dynamics(self) if scenario.in_motion else None
        self._look_up_truth()

    @property
    def present(self) -> list[Robot]:
        """The robots that the truth is about, by number (model.md 6.17.3, 6.23.4)."""
        if self.scenario.robots.away == "missing":
            return self.robots
        return sorted([*self.robots, *self.away], key=lambda robot: robot.number)

    def new_robot(self, number: int, place: Place, fault: str = HONEST, before: Robot | None = None) -> Robot:
        """Return a robot that begins at this step; ``before`` was the last one of this number."""
        kind = self.robot_kinds[number]
        return self.robot_type(self.world, self.names, number, place, kind, fault, before, self.time)

    def _look_up_truth(self) -> None:
        """Store the truth of this step (model.md 6.17.3); Byzantine robots know it."""
        self.truth = int(all(self._is_feasible(piece) for piece in self._pieces()))
        self.names.inform(self.truth, len(self.present), len(self.tasks))

    def _pieces(self) -> set[int]:
        """Return the pieces that have robots or tasks; without a place, one."""
        ground = self.world.ground
        return {*ground.robot_pieces, *ground.task_pieces} if ground else {0}

    def _is_feasible(self, piece: int) -> bool:
        """Return whether the tasks in a piece are feasible for its robots.

        Robots and tasks beyond the start are in it: a world that changes has one piece.
        """
        ground = self.world.ground
        robot_pieces, task_pieces = (ground.robot_pieces, ground.task_pieces) if ground else ([], [])

        def kinds(kinds: list[int], there: Iterable[int], pieces: list[int]) -> list[int]:
            return [kinds[i] for i in there if i >= len(pieces) or pieces[i] == piece]

        robots = kinds(self.robot_kinds, (robot.number for robot in self.present), robot_pieces)
        return explain_kinds(self.scenario, robots, kinds(self.task_kinds, self.tasks, task_pieces)).feasible

    def step(self) -> None:
        """Simulate one step: move, observe and receive, end the step (model.md 3)."""
        self.time += 1
        if self._dynamics is not None and self._dynamics.change():
            self._look_up_truth()
        working = [robot for robot in self.robots if robot.works(self.time)]
        blocked = self.move(working)
        # What is said is fixed before anyone changes: the opinions held when the step began.
        messages = [(robot, *robot.delayed(self._said_by(robot))) for robot in working]
        self.bits_sent += sum(bits for _, _, bits in messages)
        if self.work:
            self.work.arrive(working)
        for robot in working:
            if not robot.mind.disseminating:
                self._see(robot)
            if robot.mind.listens:
                for sender, message, _ in messages:
                    if message and sender is not robot and self.hears(robot, sender):
                        named = self.names.id(sender.number)
                        robot.mind.hear(named, message)
                        robot.errand.hear(dict(message.news))
        for robot in working:
            robot.end_step(robot in blocked)
            if self.work:
                self.work.choose(robot)
        for robot in self.away:
            robot.mind.rest()

    def move(self, working: list[Robot]) -> set[Robot]:
        """Move at once all robots whose way is clear; return the blocked ones (model.md 3.1, 6.2)."""
        if self.work:
            self.work.begin()
            for robot in working:
                robot.set_out(self.work.course, self.work.may_shift)
        going = steps_of(self.scenario.robots, self.world, self.robots, working)
        for robot, step in going.items():
            robot.velocity = step
            robot.move_to(self.world.moved(robot.place, step))
        for robot in working:
            robot.heading = robot.velocity  # until it turns at the end of the step (model.md 6.22.1)
        if self.work:
            self.work.count(sum(robot.errand.task == NONE and step != STAND for robot, step in going.items()))
        return set(working) - set(going)

    def _see(self, robot: Robot) -> None:
        """Let an exploring robot see what is in sight, and how the tasks are."""
        seen = list(self.sightings(robot))
        robot.mind.see(seen)
        for thing, number in seen:
            if self.work and not thing.is_robot and number >= 0:
                robot.errand.see(number, self.work.status(number))

    def sightings(self, robot: Robot) -> Iterator[tuple[Thing, int]]:
        """Yield all that a robot sees in this step, with the number of each thing; -1 if it isn't there."""
        sensing = self.scenario.sensing
        for other in self.robots:
            seen = other is not robot and self._sees(robot, other.place, purposes.MISS_ROBOT, other.number)
            if seen or (other is robot and sensing.count_self):
                where = self.world.in_units(other.place)
                yield self.names.robot(other.number, other.kind, *where), other.number
        for number, place in self.tasks.items():
            if self._sees(robot, place, purposes.MISS_TASK, number):
                called = self._called.get(number, number)
                where = self.world.in_units(self.tasks[called])
                wrong = robot.happens(self.time, purposes.MISNAME + purposes.PAIR * number, sensing.wrong)
                name = self.names.misnamed if wrong else self.names.task
                yield name(called, self.task_kinds[called], *where), number
        robots, tasks = self.scenario.robots.count, self.scenario.tasks.count
        for is_robot, mean, kinds, number, kind in (
            (
                True,
                sensing.false_robots,
                self.robot_kinds[:robots],
                purposes.FALSE_ROBOT,
                purposes.FALSE_ROBOT_CLASS,
            ),
            (
                False,
                sensing.false_tasks,
                self.task_kinds[:tasks],
                purposes.FALSE_TASK,
                purposes.FALSE_TASK_CLASS,
            ),
        ):
            for k in range(poisson(robot.draw(self.time, number), mean) if mean > 0 else 0):
                word, mark, _, _ = robot.draws(self.time, kind + purposes.PAIR * k)
                yield Thing(is_robot, -1, kinds[choose(word, len(kinds))] if kinds else 0, mark), -1

    def _sees(self, robot: Robot, place: Place, purpose: int, number: int) -> bool:
        """Return whether a place is within range (inclusive) and not missed (model.md 1.4, 6.3)."""
        seen = self._reaches(robot.place, place, self._sight) and self._is_in_view(robot, place)
        return seen and not robot.happens(self.time, purpose + purposes.PAIR * number, self.miss)

    def _is_in_view(self, robot: Robot, place: Place) -> bool:
        """Return whether a place is ahead of a robot, within half the angle of view (model.md 6.22.2)."""
        cosine, sine = self._view
        (u, v), (x, y) = robot.heading, self.world.way(robot.place, place)
        return float(u * x + v * y) * sine >= float(abs(u * y - v * x)) * cosine

    def hears(self, robot: Robot, sender: Robot) -> bool:
        """Return whether a sender's message arrives (model.md 6.5)."""
        return self._reaches(robot.place, sender.place, self._radio) and not robot.happens(
            self.time, purposes.LOSS + purposes.PAIR * sender.number, self.loss
        )

    def _reaches(self, place: Place, other: Place, limits: list[int]) -> bool:
        """Return whether two places are in range; the limit depends on the number of walls between them."""
        distance = self.world.squared_distance(place, other)
        if self.world.ground is None or distance > limits[0]:
            return distance <= limits[0]
        walls = self.world.ground.walls_between(place, other)
        return distance <= limits[min(walls, len(limits) - 1)]

    def _said_by(self, sender: Robot) -> Said:
        """Return what a robot says, and its length: id, opinion, value and declaration, or knowledge."""
        message = sender.says(self.time)
        if message is None:
            return SILENCE
        says_declared = self.scenario.decision.declare is not None
        if sender.mind.knowledge:
            bits = sender.mind.knowledge.bits(message.knowledge)
            bits += self.names.id_bits + 2 if says_declared else 0
        else:
            bits = self.names.id_bits + 1 + sender.mind.strategy.value_bits + says_declared
        if self.work is None:
            return message, bits
        news = sender.errand.news(lies=sender.fault == BYZANTINE)
        return message._replace(news=tuple(news.items())), bits + self.work.bits(len(news))

    @property
    def counted(self) -> list[Robot]:
        """The counted robots: honest and still working (model.md 6.6)."""
        return [robot for robot in self.present if robot.fault != BYZANTINE and robot.works(self.time)]

    @property
    def feasible_count(self) -> int:
        """Number of counted robots with opinion 1."""
        return sum(robot.mind.opinion == FEASIBLE for robot in self.counted)

    @property
    def infeasible_count(self) -> int:
        """Number of counted robots with opinion 0."""
        return sum(robot.mind.opinion == INFEASIBLE for robot in self.counted)

    def declared(self, opinion: int) -> int:
        """Return how many counted robots have declared an opinion."""
        return sum(robot.mind.declared == opinion for robot in self.counted)

    @property
    def said(self) -> int:
        """Sum of the probabilities that the counted robots give to *feasible* (model.md 6.15.9)."""
        return sum(math.floor(robot.mind.probability() * CERTAIN + 0.5) for robot in self.counted)

    @property
    def has_declared(self) -> bool:
        """Whether more than the threshold's share of the counted robots has declared (model.md 6.15)."""
        declared = self.declared(FEASIBLE) + self.declared(INFEASIBLE)
        return declared > exact(self.scenario.decision.threshold) * len(self.counted)

    @property
    def have_all_declared(self) -> bool:
        """Whether all counted robots have declared, and none of them stops later (model.md 6.15.8)."""
        some_left = any(robot.mind.declared == UNDECIDED for robot in self.counted)
        return not some_left and self.time >= self.scenario.faults.stop_step

    def is_over(self, has_decided: bool) -> bool:
        """Return whether the run ends, given whether the swarm has ever decided."""
        run = self.scenario.run
        if (run.stop_at_decision and has_decided) or (run.stop_at_declarations and self.have_all_declared):
            return True
        return run.stop_when_taken and self.work is not None and self.work.is_over

    @property
    def decision(self) -> int:
        """The opinion that more than the threshold's share of the counted robots holds (model.md 4.7)."""
        needed = exact(self.scenario.decision.threshold) * len(self.counted)
        if self.feasible_count > needed:
            return FEASIBLE
        if self.infeasible_count > needed:
            return INFEASIBLE
        return UNDECIDED


class Dynamics:
    """How the world of one swarm changes: events and streams (model.md 6.17).

    Parameters
    ----------
    swarm : Swarm
        The swarm at step 0; events of that step happen at once.
    """

    def __init__(self, swarm: Swarm) -> None:
        self._swarm = swarm
        self._appeared = 0
        self._vanishes_at: dict[int, int] = {}
        self._gone: dict[int, Robot] = {}
        for _ in swarm.tasks:
            self._begin_lifetime()
        self._happen()

    def change(self) -> bool:
        """Change the world at the beginning of a step; return whether robots or tasks came or went."""
        before = set(self._swarm.tasks), set(self._swarm.robots)
        now = self._swarm.time
        self._take_tasks(number for number, step in self._vanishes_at.items() if step == now)
        existing = [*self._swarm.robots, *self._swarm.away]
        self._take_robots(robot for robot in existing if robot.leaves_at == now)
        self._charge()
        self._happen()
        tasks, robots, _, _ = self._draw(0, purposes.ARRIVAL)
        for _ in range(poisson(tasks, self._swarm.scenario.tasks.arrival_rate or 0.0)):
            self._appear()
        for _ in range(poisson(robots, self._swarm.scenario.robots.arrival_rate or 0.0)):
            self._join()
        return before != (set(self._swarm.tasks), set(self._swarm.robots))

    def _happen(self) -> None:
        """Let the events of this step happen (model.md 6.17.2)."""
        vanished = left = 0
        for event in self._swarm.scenario.events:
            if event.step != self._swarm.time:
                continue
            for _ in range(event.tasks):
                self._appear(event.at)
            for _ in range(min(-event.tasks, len(self._swarm.tasks))):
                there = list(self._swarm.tasks)
                self._take_tasks([there[self._chosen(vanished, purposes.VANISH, len(there))]])
                vanished += 1
            for _ in range(event.robots):
                self._join(event.at)
            for _ in range(min(-event.robots, len(self._swarm.present))):
                robots = self._swarm.present
                self._take_robots([robots[self._chosen(left, purposes.LEAVE, len(robots))]])
                left += 1
            self._name(event)
            if event.sensing.miss is not None:
                self._swarm.miss = event.sensing.miss
            if event.radio.loss is not None:
                self._swarm.loss = event.radio.loss

    def _name(self, event: Event) -> None:
        """Remove the robot or task that an event numbers, or put it at a point (model.md 6.17.12)."""
        swarm = self._swarm
        if event.task in swarm.tasks:
            if event.at is None:
                self._take_tasks([event.task])
            else:
                swarm.tasks[event.task] = swarm.world.place_at(event.at)
        if event.at is None:
            self._take_robots(robot for robot in swarm.present if robot.number == event.robot)
            return
        for robot in swarm.robots:
            if robot.number == event.robot:
                others = [other.place for other in swarm.robots if other is not robot]
                robot.move_to(swarm.world.free_place_at(event.at, others) or robot.place)

    def _appear(self, at: Point | None = None) -> None:
        """Let the next task appear, unless all numbers have been used (model.md 6.17.4)."""
        number, world = self._appeared, self._swarm.world
        if number < self._swarm.scenario.most.tasks:
            self._swarm.tasks[number] = world.place_at(at) if at else world.task_place(number)
            self._begin_lifetime()

    def _begin_lifetime(self) -> None:
        mean = self._swarm.scenario.tasks.lifetime
        if mean is not None:
            word = self._swarm.world.draw(self._appeared, 0, purposes.LIFETIME)[0]
            self._vanishes_at[self._appeared] = self._swarm.time + duration(word, mean)
        self._appeared += 1

    def _take_tasks(self, numbers: Iterable[int]) -> None:
        for number in list(numbers):
            del self._swarm.tasks[number]
            self._vanishes_at.pop(number, None)

    def _join(self, at: Point | None = None) -> None:
        """Let a robot join, if a number and a place are free (model.md 6.17.6, 6.17.7)."""
        taken = {robot.number for robot in [*self._swarm.robots, *self._swarm.away]}
        number = next(i for i in range(len(taken) + 1) if i not in taken)
        if number >= self._swarm.scenario.most.robots:
            return
        before = self._gone.get(number)
        place = self._free_place(number, before.joined + 1 if before else 0, at)
        if place is not None:
            self._enter(self._swarm.new_robot(number, place, before=before))

    def _free_place(self, number: int, joined: int, at: Point | None = None) -> Place | None:
        others, world = [robot.place for robot in self._swarm.robots], self._swarm.world
        return world.free_place_at(at, others) if at else world.joining_place(number, joined, others)

    def _enter(self, robot: Robot) -> None:
        self._swarm.robots.append(robot)
        self._swarm.robots.sort(key=lambda robot: robot.number)

    def _charge(self) -> None:
        """Let robots go whose battery is empty, then those come back that have charged it (model.md 6.23)."""
        section, now = self._swarm.scenario.robots, self._swarm.time
        due = [robot for robot in self._swarm.robots if robot.switches_at == now and robot.works(now)]
        back = [robot for robot in self._swarm.away if robot.switches_at == now and robot.works(now)]
        for robot in due:
            self._swarm.robots.remove(robot)
            self._swarm.away.append(robot)
            robot.switches_at = now + (section.charge or 0)
        for robot in sorted(back, key=lambda robot: robot.number):
            robot.joined += 1  # each attempt has draws of its own
            place = self._free_place(robot.number, robot.joined)
            if place is None:
                robot.switches_at = now + 1
                continue
            self._swarm.away.remove(robot)
            robot.come_back(place, now + (section.work or 0))
            self._enter(robot)

    def _take_robots(self, robots: Iterable[Robot]) -> None:
        for robot in list(robots):
            (self._swarm.away if robot in self._swarm.away else self._swarm.robots).remove(robot)
            self._gone[robot.number] = robot

    def _chosen(self, before: int, purpose: int, count: int) -> int:
        """Return one of so many, drawn at random."""
        return choose(self._draw(before, purpose)[0], count)

    def _draw(self, which: int, purpose: int) -> tuple[int, int, int, int]:
        return self._swarm.world.draw(which, self._swarm.time, purpose)


def _kinds(section: Robots | Tasks, most: int, purpose: int, world: World) -> list[int]:
    """Return the class of each number; beyond those of the start, that of one drawn from them."""
    kinds = kinds_of(section)
    drawn = (world.draw(number, 0, purpose)[0] for number in range(len(kinds), most))
    return kinds + [kinds[choose(word, len(kinds))] if kinds else 0 for word in drawn]


def _faults(scenario: Scenario, draw: Callable[[int], int]) -> list[str]:
    """Return each robot's fault; the faulty robots are drawn at random (model.md 6.6)."""
    count = scenario.robots.count
    faults, left = [HONEST] * count, iter(shuffle(count, draw))
    for fault in (STOPPED, BYZANTINE, STUBBORN):
        given = getattr(scenario.faults, fault)
        for _ in range(given["count"] if isinstance(given, Mapping) else rounded(exact(given), count)):
            faults[next(left)] = fault
    return faults
