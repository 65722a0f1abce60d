"""A robot's own numbers of tasks, for messages that name them by position."""

from __future__ import annotations

from itertools import chain
from typing import Any, Final

from feasibee.strategies import STRATEGIES, roster
from feasibee.strategies.contract import Setting, Strategy, Thing

ROSTER: Final[Any] = roster
"""The strategy's file, whose functions have no types."""


class TaskNames:
    """The numbers that a robot gives to tasks, in the order in which it meets them.

    Parameters
    ----------
    setting : Setting
        That of the strategy; it says how many tasks there may be.
    """

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        invented = setting.robots + 1 if setting.robot_ids > setting.robots else 0
        wrong = setting.tasks + invented
        self._names = {ROSTER.invented_place(k): k for k in range(setting.tasks, wrong)}
        self._free = chain(range(setting.tasks), range(wrong, setting.task_ids))

    def of_position(self, position: int) -> int:
        """Return the number of the task at a position; -1 if there can't be another task."""
        if position not in self._names and (number := next(self._free, -1)) >= 0:
            self._names[position] = number
        return self._names.get(position, -1)

    def named(self, thing: Thing) -> Thing:
        """Return a task in sight with its number here; robots and nameless tasks stay as they are."""
        if thing.is_robot or thing.id < 0:
            return thing
        return thing._replace(id=self.of_position(ROSTER.place_of(thing, self._setting)))


def names_of(strategy: Strategy, setting: Setting) -> TaskNames | None:
    """Return the names of a strategy whose messages name tasks by position; None for the other ones."""
    return TaskNames(setting) if strategy is STRATEGIES["roster"] else None
