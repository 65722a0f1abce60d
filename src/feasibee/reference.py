"""The model in plain Python, to be read beside the paper: the oracle that the engine must equal bit for bit.

It shares with the engine the scenario, the vocabulary, the record and the strategies, and no line of code
that computes. Every robot is an object, driven by the controller of ``robot.py``, the one for real robots.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from feasibee.record import Record
from feasibee.robot import Controller
from feasibee.scenario import Scenario
from feasibee.strategies import STRATEGIES
from feasibee.vocabulary import (
    FEASIBLE,
    FIRST_OPINION,
    INFEASIBLE,
    PHASE,
    PLACE_ROBOT,
    PLACE_TASK,
    UNDECIDED,
    WALK,
    exact,
)

TURN = 2**32
"""The side of the torus, and a full turn of a heading, in the units of a 32-bit word."""


def simulate(scenario: Scenario, runs: int, seed: int, first_run: int = 0, curves: bool = False) -> Record:
    """Play some runs, one after the other."""
    record = Record.empty(first_run, runs, scenario.run.steps + 1 if curves else 0)
    for row in range(runs):
        for step, swarm in enumerate(play(scenario, seed, first_run + row)):
            count = swarm.feasible_count
            if curves:
                record.feasible_count[row, step] = count
            if record.decision[row] == UNDECIDED:
                record.decision[row] = swarm.decision
                record.decision_step[row] = step if swarm.decision != UNDECIDED else -1
            if scenario.run.stop_at_decision and swarm.decision != UNDECIDED:
                break
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
        unit = exact(scenario.arena.side) / TURN
        self._sight = math.floor((exact(scenario.sensing.range) / unit) ** 2)
        self._radio = math.floor((exact(scenario.radio.range) / unit) ** 2)
        self.robots = [Robot(scenario, seed, run, i) for i in range(scenario.robots.count)]
        self.tasks = [philox(seed, run, i, 0, PLACE_TASK)[:2] for i in range(scenario.tasks.count)]

    def step(self) -> None:
        """Let one step pass: move, observe and hear, end the step (model.md 3)."""
        for robot in self.robots:
            robot.move()
        # What is said is fixed before anyone changes: the opinions held when the step began.
        messages = [(robot, robot.mind.message) for robot in self.robots if robot.mind.message is not None]
        for robot in self.robots:
            if not robot.mind.disseminating:
                robot.mind.observe(
                    robots=sum(self.sees(robot, other.place) for other in self.robots if other is not robot),
                    tasks=sum(self.sees(robot, task) for task in self.tasks),
                )
            if robot.mind.listens:
                for sender, opinion in messages:
                    if sender is not robot and self.hears(robot, sender):
                        robot.mind.hear(sender.number, opinion)
        for robot in self.robots:
            robot.end_step()

    def sees(self, robot: Robot, place: tuple[int, int]) -> bool:
        """Tell whether a place is in a robot's range of observation, closed (model.md 1.4)."""
        return squared_distance(robot.place, place) <= self._sight

    def hears(self, robot: Robot, sender: Robot) -> bool:
        """Tell whether a sender is in radio range."""
        return squared_distance(robot.place, sender.place) <= self._radio

    @property
    def feasible_count(self) -> int:
        """Number of robots with opinion 1."""
        return sum(robot.mind.opinion for robot in self.robots)

    @property
    def decision(self) -> int:
        """What strictly more than the threshold's share of the robots holds (model.md 4.7)."""
        needed = exact(self.scenario.decision.threshold) * len(self.robots)
        if self.feasible_count > needed:
            return FEASIBLE
        if len(self.robots) - self.feasible_count > needed:
            return INFEASIBLE
        return UNDECIDED


class Robot:
    """A body that wanders, and a mind."""

    def __init__(self, scenario: Scenario, seed: int, run: int, number: int) -> None:
        self.number = number
        self._coordinates = (seed, run, number)
        self._mean_run = scenario.walk.mean_run
        self._reach = scenario.robots.speed / scenario.arena.side * TURN
        self._walks = 0
        self._phases = 0
        x, y, _, _ = self._draw(0, PLACE_ROBOT)
        self.place = (x, y)
        self._turn()
        decision = scenario.decision
        self.mind = Controller(
            STRATEGIES[decision.strategy],
            opinion=self._draw(0, FIRST_OPINION)[0] >> 31,
            draw_duration=self._draw_phase,
            exploration=decision.exploration,
            gain=decision.gain,
            count_self=scenario.sensing.count_self,
            own_vote=decision.own_vote,
            listen_always=decision.listen == "always",
            every_message=decision.inbox == "every-message",
        )

    def move(self) -> None:
        """Go one step straight on, round the torus (model.md 2.1)."""
        x, y = self.place
        dx, dy = self.velocity
        self.place = ((x + dx) % TURN, (y + dy) % TURN)

    def end_step(self) -> None:
        """Let the timers of heading and phase advance (model.md 3.3)."""
        self._walk_left -= 1
        if self._walk_left == 0:
            self._turn()
        self.mind.end_step()

    def _turn(self) -> None:
        """Take a new heading for a while."""
        heading, lasting, _, _ = self._draw(self._walks, WALK)
        self._walks += 1
        cosine, sine = cos_sin(heading)
        self.velocity = (math.floor(self._reach * cosine + 0.5), math.floor(self._reach * sine + 0.5))
        self._walk_left = duration(lasting, self._mean_run)

    def _draw_phase(self, mean: float) -> int:
        """Draw how long the next phase lasts."""
        word = self._draw(self._phases, PHASE)[0]
        self._phases += 1
        return duration(word, mean)

    def _draw(self, counter: int, purpose: int) -> tuple[int, int, int, int]:
        return philox(*self._coordinates, counter, purpose)


def squared_distance(a: tuple[int, int], b: tuple[int, int]) -> int:
    """Return the square of the shortest distance on the torus (model.md 1.1), exactly."""
    return sum(min((p - q) % TURN, (q - p) % TURN) ** 2 for p, q in zip(a, b, strict=True))


def duration(word: int, mean: float) -> int:
    """Return an exponential duration in whole steps, at least 1 (model.md 3.4)."""
    uniform = (word + 1) / TURN
    return max(1, math.ceil(-mean * math.log(uniform)))


def cos_sin(heading: int) -> tuple[float, float]:
    """Return cosine and sine of a heading, 2**32 being a full turn.

    Not ``math.cos``: its last bit differs between platforms. This is Taylor's polynomial about the nearest
    quarter turn, innermost term first; its error is below the last bit.
    """
    quarter, rest = divmod(heading + TURN // 8, TURN // 4)
    angle = (rest - TURN // 8) * (math.pi / 2 / (TURN // 4))
    square = angle * angle
    sine = cosine = 1.0
    for k in range(16, 0, -2):
        sine = 1.0 - square * (1.0 / (k * (k + 1))) * sine
        cosine = 1.0 - square * (1.0 / (k * (k - 1))) * cosine
    sine *= angle
    return [(cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine)][quarter % 4]


def philox(seed: int, run: int, robot: int, counter: int, purpose: int) -> tuple[int, int, int, int]:
    """Return four random 32-bit words: Philox4x32-10 (Salmon et al., SC 2011, section 4.3)."""
    mask = 0xFFFFFFFF
    a, b, c, d = counter, robot, run, purpose
    low, high = seed & mask, seed >> 32
    for _ in range(10):
        left, right = a * 0xD2511F53, c * 0xCD9E8D57
        a, b, c, d = (right >> 32) ^ b ^ low, right & mask, (left >> 32) ^ d ^ high, left & mask
        low, high = (low + 0x9E3779B9) & mask, (high + 0xBB67AE85) & mask
    return a, b, c, d
