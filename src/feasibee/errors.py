"""What can go wrong for a user: each error says path, value, rule and remedy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class FeasibeeError(Exception):
    """An error of the input or the surroundings, not of the program; the command line exits with 2."""


class Problem(NamedTuple):
    """One thing wrong with a scenario."""

    path: str
    """Dotted path of the field, such as ``radio.range``."""
    value: object
    """What stands there."""
    rule: str
    """What must hold."""
    remedy: str
    """What to do."""

    def __str__(self) -> str:
        shown = f"{self.path} = {self.value!r}" if self.path else "scenario"
        return f"{shown}: {self.rule}; {self.remedy}"


class ScenarioError(FeasibeeError):
    """A scenario that can't be run.

    Parameters
    ----------
    problems : sequence of Problem
        All that is wrong with it, not only the first.
    source : str, optional
        The file that it came from.
    """

    def __init__(self, problems: Sequence[Problem], source: str = "") -> None:
        self.problems = tuple(problems)
        self.source = source
        prefix = f"{source}: " if source else ""
        super().__init__("\n".join(f"{prefix}{problem}" for problem in self.problems))
