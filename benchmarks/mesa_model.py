"""The paper's swarm in Mesa 3: a general framework, as a baseline for the speed.

Robots and tasks are agents in one ``mesa.space.ContinuousSpace``, and a step is three stages of
``AgentSet.do``. Of the ways in Mesa's documentation this is the fastest here. Two spaces, or the
``ContinuousSpaceAgent`` of its flocking example, take 1.3 to 1.8 times as long. Nothing collects data.

``python benchmarks/mesa_model.py`` simulates some runs and prints the rates of their decisions.
"""

from __future__ import annotations

import math
import statistics

import mesa

SPEED, SENSING_RANGE = 1.0, 2.0
MEAN_RUN = EXPLORATION = GAIN = 10.0
FEASIBLE, INFEASIBLE, UNDECIDED = 1, 0, -1


class Task(mesa.Agent):
    """A task for one robot: a fixed point."""


class Robot(mesa.Agent):
    """A robot that moves, explores, disseminates and decides (DMMD)."""

    def __init__(self, model: FeasibilityModel) -> None:
        super().__init__(model)
        self.opinion = self.random.choice((FEASIBLE, INFEASIBLE))
        self.turn()
        self.explore()

    def move(self) -> None:
        """Move one step straight on; the space wraps the position."""
        x, y = self.pos
        dx, dy = self.velocity
        self.model.space.move_agent(self, (x + dx, y + dy))

    def sense(self) -> None:
        """Hear the disseminating neighbours, and count robots and tasks in range."""
        for neighbor in self.model.space.get_neighbors(self.pos, SENSING_RANGE):
            if isinstance(neighbor, Task):
                self.tasks_seen += 1
            elif neighbor is not self:
                self.robots_seen += 1
                if neighbor.disseminating:
                    self.inbox[neighbor.unique_id] = neighbor.opinion

    def advance(self) -> None:
        """Advance the timers; a phase that ends affects other robots from the next step on."""
        self.walk_left -= 1
        if self.walk_left == 0:
            self.turn()
        self.phase_left -= 1
        if self.phase_left == 0:
            if self.disseminating:
                self.decide()
                self.explore()
            else:
                self.disseminate()

    def turn(self) -> None:
        """Draw a new heading, and the number of steps until the next."""
        heading = self.random.uniform(0, 2 * math.pi)
        self.velocity = (SPEED * math.cos(heading), SPEED * math.sin(heading))
        self.walk_left = self.duration(MEAN_RUN)

    def explore(self) -> None:
        """Start exploring with empty counts and inbox; counts from dissemination are discarded."""
        self.disseminating = False
        self.robots_seen = 0
        self.tasks_seen = 0
        self.inbox: dict[int, int] = {}
        self.phase_left = self.duration(EXPLORATION)

    def disseminate(self) -> None:
        """Broadcast the robot's opinion for a time in proportion to its quality."""
        seen = self.robots_seen + self.tasks_seen
        feasible = self.robots_seen / seen if seen else 0.5
        quality = feasible if self.opinion == FEASIBLE else 1 - feasible
        self.disseminating = True
        self.phase_left = self.duration(GAIN * quality)

    def decide(self) -> None:
        """Adopt the majority of the inbox and the robot's own opinion; a tie keeps its own."""
        voters = len(self.inbox) + 1
        feasible = sum(self.inbox.values()) + self.opinion
        if 2 * feasible != voters:
            self.opinion = FEASIBLE if 2 * feasible > voters else INFEASIBLE

    def duration(self, mean: float) -> int:
        """Draw an exponential duration as a number of steps, at least 1."""
        return max(1, math.ceil(self.random.expovariate(1 / mean))) if mean > 0 else 1


class FeasibilityModel(mesa.Model):
    """A swarm that decides whether its tasks are feasible."""

    def __init__(
        self, robots: int = 20, tasks: int = 20, side: float = 20.0, seed: int | None = None
    ) -> None:
        super().__init__(seed=seed)
        self.space = mesa.space.ContinuousSpace(side, side, torus=True)
        self.robots = Robot.create_agents(self, robots)
        Task.create_agents(self, tasks)
        for agent in self.agents:
            self.space.place_agent(agent, (self.random.uniform(0, side), self.random.uniform(0, side)))
        self.decision = UNDECIDED
        self.decision_step = -1
        self.record_decision()

    def step(self) -> None:
        """Simulate one step. No stage reads what it writes of other robots, so their order has no effect."""
        self.robots.do("move")
        self.robots.do("sense")
        self.robots.do("advance")
        self.record_decision()

    def record_decision(self) -> None:
        """Record the first step at which more than 90 % of the robots agree."""
        if self.decision == UNDECIDED:
            feasible = self.robots.agg("opinion", sum)
            for opinion, holders in ((FEASIBLE, feasible), (INFEASIBLE, len(self.robots) - feasible)):
                if 10 * holders > 9 * len(self.robots):
                    self.decision, self.decision_step = opinion, self.steps


def decision(model: FeasibilityModel) -> int:
    """Return the swarm's decision: 1 feasible, 0 infeasible, -1 undecided."""
    return model.decision


def play(
    tasks: int = 100, steps: int = 1000, seed: int = 1, stop_at_decision: bool = False
) -> FeasibilityModel:
    """Simulate one run."""
    model = FeasibilityModel(tasks=tasks, seed=seed)
    for _ in range(steps):
        if stop_at_decision and decision(model) != UNDECIDED:
            break
        model.step()
    return model


def print_rates(tasks: int, runs: int) -> None:
    """Print rates and times of decisions, for comparison with tests/test_laws.py."""
    models = [play(tasks, seed=seed, stop_at_decision=True) for seed in range(1, runs + 1)]
    share = statistics.mean(decision(model) == FEASIBLE for model in models)
    steps = [model.decision_step for model in models if decision(model) != UNDECIDED]
    quartiles = statistics.quantiles(steps, n=4)
    print(f"{tasks} tasks, {runs} runs: feasible {share:.3f}; decision step, quartiles: {quartiles}")


if __name__ == "__main__":
    print_rates(tasks=10, runs=200)
    print_rates(tasks=100, runs=200)
