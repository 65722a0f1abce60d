"""Errors that users see: each states path, value, rule and remedy in one line."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from reprlib import Repr
from typing import Any, NamedTuple

LINE_LIMIT = 400
"""Largest length of an error's line in characters; a longer line is shortened in its middle."""
PART_LIMIT = 100
"""Largest length of a path or a value in an error, in characters."""
PROBLEMS_SHOWN = 20
"""Largest number of problems that an error's text lists."""
PROBLEMS_LIMIT = 100
"""Largest number of problems that are searched for in one scenario; a file of points may have millions."""


class FeasibeeError(Exception):
    """An error in the input or the environment, not in the program; the command line exits with code 2.

    Parameters
    ----------
    message : str
        Text of the error. It becomes one printable line of at most ``LINE_LIMIT`` characters, since it may
        quote a user's input.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))


class Problem(NamedTuple):
    """One problem of a scenario: a path, its value, the rule that it breaks, and a remedy."""

    path: str
    """Dotted path of the field, such as ``radio.range``."""
    value: object
    """The invalid value."""
    rule: str
    """The rule that the value breaks, such as ``must be > 0``."""
    remedy: str
    """An instruction that removes the problem."""

    def __str__(self) -> str:
        shown = f"{one_line(self.path, PART_LIMIT)} = {quoted(self.value)}" if self.path else "scenario"
        return one_line(f"{shown}: {self.rule}; {self.remedy}")


class UnknownFieldError(FeasibeeError, LookupError):
    """A dotted path that names no field of a scenario."""


class ScenarioError(FeasibeeError):
    """An invalid scenario, with all its problems.

    Parameters
    ----------
    problems : iterable of Problem
        The problems, of which the first ``PROBLEMS_LIMIT`` are kept.
    source : str, optional
        The file that the scenario was read from.
    """

    def __init__(self, problems: Iterable[Problem], source: str = "") -> None:
        self.problems = tuple(itertools.islice(problems, PROBLEMS_LIMIT))
        self.source = source
        Exception.__init__(self, "\n".join(self._lines()))

    def __reduce__(self) -> tuple[type[ScenarioError], tuple[tuple[Problem, ...], str]]:
        return type(self), (self.problems, self.source)  # a worker process pickles its error

    def _lines(self) -> Iterable[str]:
        prefix = f"{one_line(self.source, 2 * PART_LIMIT)}: " if self.source else ""
        for problem in self.problems[:PROBLEMS_SHOWN]:
            yield f"{prefix}{problem}"
        more = len(self.problems) - PROBLEMS_SHOWN
        if more > 0:
            least = "at least " if len(self.problems) == PROBLEMS_LIMIT else ""
            yield f"{prefix}and {least}{more} more"


def how_to_install(extra: str) -> str:
    """Return the remedy for a missing package: the command that installs an extra of pyproject.toml."""
    return f'in a checkout of feasibee, run: python -m pip install ".[{extra}]"'


def one_line(text: str, limit: int = LINE_LIMIT) -> str:
    """Return text as one printable line, shortened in its middle if it is long."""
    printable = "".join(
        each if each.isprintable() else each.encode("unicode_escape").decode()
        for each in _cut(text, 2 * limit)
    )
    return _cut(printable, limit)


def quoted(value: object) -> str:
    """Return the repr of a value, shortened if it is long or deep."""
    try:
        return one_line(_SHORT.repr(value), PART_LIMIT)
    except ValueError:  # Python refuses to print integers of thousands of digits
        return "a number too long to print"


def _cut(text: str, limit: int) -> str:
    half = limit // 2 - 2
    return text if len(text) <= limit else f"{text[:half]}...{text[-half:]}"


class _Short(Repr):
    """Writes the repr of values, limited to what fits on a line."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = self.maxlong = PART_LIMIT
        self.maxlist = self.maxtuple = self.maxdict = self.maxset = 20
        self.maxlevel = 3

    def repr_dict(self, x: dict[Any, Any], level: int) -> str:
        """Write a dict in its own order, which reprlib would sort."""
        if level <= 0:
            return "{...}"
        some = itertools.islice(x.items(), self.maxdict)
        pairs = [f"{self.repr1(key, level - 1)}: {self.repr1(value, level - 1)}" for key, value in some]
        return f"{{{', '.join(pairs + ['...'] * (len(x) > self.maxdict))}}}"


_SHORT = _Short()
