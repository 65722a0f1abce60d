"""One robot's knowledge: a row of words, by the functions of a strategy that passes on knowledge."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from feasibee.strategies.clock import LAST
from feasibee.strategies.contract import Me, Strategy, Thing
from feasibee.strategies.words import Words


class Knowledge:
    """What one robot, at first at step 0, knows and passes on by its strategy's functions (model.md 6.11)."""

    def __init__(self, strategy: Strategy, me: Me) -> None:
        functions: Any = strategy  # those for knowledge are None in other strategies only
        self._strategy = functions
        known, self._length = strategy.row_lengths(me.setting)
        self.me = me
        self.words = Words([0] * known)
        if functions.start is not None:
            functions.start(self.words, me)

    def observe(self, things: Iterable[Thing]) -> None:
        """Add the robots and tasks in sight to what is known."""
        for thing in things:
            self._strategy.observe(self.words, thing, self.me)

    def message(self) -> tuple[int, ...]:
        """Return the words to broadcast."""
        if self._strategy.encode is None:
            return tuple(self.words)
        message = Words([0] * self._length)
        self._strategy.encode(message, self.words, self.me)
        return tuple(message)

    def lie(self, message: Sequence[int], feasible: int, inventions: Iterable[Thing]) -> tuple[int, ...]:
        """Return the message of a Byzantine robot, made from its honest one (model.md 6.12)."""
        told = Words(message)
        if self._strategy.lie is not None:
            self._strategy.lie(told, feasible, self.me)
        else:
            if feasible and self.me.setting.colluding:
                told[:] = [0] * len(told)
            for thing in inventions:
                self._strategy.observe(told, thing, self.me)
        return tuple(told)

    def merge(self, message: Sequence[int], sender: int) -> None:
        """Add what a message says."""
        self._strategy.merge(self.words, tuple(message), sender, self.me)

    def counted(self) -> tuple[list[int], list[int]]:
        """Return the numbers of robots and of tasks, by class."""
        robots, tasks = self.me.setting.robot_classes, self.me.setting.task_classes
        counts = [0] * (robots + tasks)
        self._strategy.count(tuple(self.words), counts, self.me)
        return counts[:robots], counts[robots:]

    def bits(self, message: Sequence[int]) -> int:
        """Return the length of a message, in bits."""
        return int(self._strategy.bits(tuple(message), self.me))

    def move_to(self, x: float, y: float) -> None:
        """Store the robot's position in the frame that all robots share, in units."""
        self.me = self.me._replace(x=x, y=y)

    def declare(self) -> int:
        """Ask the robot what it is sure of: 1, 0, or -1 if it isn't sure (model.md 6.15)."""
        return int(self._strategy.declare(self.words, self.me))

    def judge(self) -> int:
        """Ask the robot for its opinion: 1, 0, or -1 to keep its own (model.md 6.11)."""
        return -1 if self._strategy.judge is None else int(self._strategy.judge(self.words, self.me))

    def end_step(self, explores: bool) -> None:
        """End a step; say whether the robot explores in the next one."""
        self.me = self.me._replace(step=(self.me.step + 1) & LAST, explores=explores)
