"""An operator who calls for robots, or releases them, by the opinion held (model.md 6.19)."""

from __future__ import annotations

from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.reference.robot import Robot
from feasibee.scenario.scenario import Scenario


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
