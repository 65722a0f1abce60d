"""What can go wrong for a user: each error says path, value, rule and remedy, in one short line."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from reprlib import Repr
from typing import Any, NamedTuple

LINE_LIMIT = 400
"""Characters of a line of an error: a longer one loses its middle, and keeps its beginning and its remedy."""
PART_LIMIT = 100
"""Characters of a path or a value within it."""
PROBLEMS_SHOWN = 20
PROBLEMS_LIMIT = 100
"""Problems of one scenario that are looked for: a file may have millions, and nobody reads them."""


class FeasibeeError(Exception):
    """An error of the input or the surroundings, not of the program; the command line exits with 2.

    Parameters
    ----------
    message : str
        Which may quote what a user wrote: it becomes one printable line of at most ``LINE_LIMIT`` characters.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))


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
        shown = f"{one_line(self.path, PART_LIMIT)} = {quoted(self.value)}" if self.path else "scenario"
        return one_line(f"{shown}: {self.rule}; {self.remedy}")


class UnknownFieldError(FeasibeeError, LookupError):
    """A dotted path that names no field of a scenario."""


class ScenarioError(FeasibeeError):
    """A scenario that can't be run.

    Parameters
    ----------
    problems : iterable of Problem
        All that is wrong with it, not only the first; of more than ``PROBLEMS_LIMIT``, so many.
    source : str, optional
        The file that it came from.
    """

    def __init__(self, problems: Iterable[Problem], source: str = "") -> None:
        self.problems = tuple(itertools.islice(problems, PROBLEMS_LIMIT))
        self.source = source
        Exception.__init__(self, "\n".join(self._lines()))

    def __reduce__(self) -> tuple[type[ScenarioError], tuple[tuple[Problem, ...], str]]:
        return type(self), (self.problems, self.source)  # a worker's error must reach the sweep whole

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
    """Return text as one line that any terminal can show, without its middle if it is long."""
    printable = "".join(
        each if each.isprintable() else each.encode("unicode_escape").decode()
        for each in _cut(text, 2 * limit)
    )
    return _cut(printable, limit)


def quoted(value: object) -> str:
    """Return a value as Python writes it, cut short if it is long or deep."""
    try:
        return one_line(_SHORT.repr(value), PART_LIMIT)
    except ValueError:  # Python prints no number of thousands of digits
        return "a number too long to print"


def _cut(text: str, limit: int) -> str:
    half = limit // 2 - 2
    return text if len(text) <= limit else f"{text[:half]}...{text[-half:]}"


class _Short(Repr):
    """Writes values as Python does, but no more of them than a line has room for."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = self.maxlong = PART_LIMIT
        self.maxlist = self.maxtuple = self.maxdict = self.maxset = 20
        self.maxlevel = 3

    def repr_dict(self, x: dict[Any, Any], level: int) -> str:
        """Write a table in its order; reprlib would sort it."""
        if level <= 0:
            return "{...}"
        some = itertools.islice(x.items(), self.maxdict)
        pairs = [f"{self.repr1(key, level - 1)}: {self.repr1(value, level - 1)}" for key, value in some]
        return f"{{{', '.join(pairs + ['...'] * (len(x) > self.maxdict))}}}"


_SHORT = _Short()
