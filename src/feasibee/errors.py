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
        path = self.path if self.path.isprintable() else repr(self.path)
        shown = f"{path} = {_shown(self.value)}" if path else "scenario"
        return f"{shown}: {self.rule}; {self.remedy}"


def _shown(value: object) -> str:
    """Return a value on a line, cut short if it is long."""
    try:
        text = repr(value)
    except ValueError:  # Python prints no number of thousands of digits
        return "a number too long to print"
    return text if len(text) <= 100 else f"{text[:100]}..."


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
