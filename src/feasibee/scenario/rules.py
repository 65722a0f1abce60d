"""The form of a rule between fields of a scenario, and of what it finds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Final, NamedTuple

from feasibee.scenario.sections import Sections

AS_GIVEN: Final = object()
BOTH: Final = ("robots", "tasks")


class Conflict(NamedTuple):
    """What a rule finds: a problem whose value, unless it says another, is that of its path."""

    path: str
    rule: str
    remedy: str
    value: object = AS_GIVEN


Rule = Callable[[Sections], Iterator[Conflict]]
Breaks = Callable[[Sections], object]
"""Whether a scenario breaks a rule; or, if it does, the numbers for the rule's text."""


def rows(table: Mapping[str, Breaks]) -> Iterator[Rule]:
    """Yield a rule per row: its problem as users read it, ``path: rule; remedy``, and when it is one.

    A path may have a value: ``path = value``. In the text, ``{0}`` is the first of the numbers that the
    condition returns, and ``{strategy}`` the strategy's name.
    """
    for text, breaks in table.items():
        where, _, rest = text.partition(": ")
        (path, _, value), (rule, _, remedy) = where.partition(" = "), rest.rpartition("; ")
        yield partial(_find, breaks=breaks, conflict=Conflict(path, rule, remedy, value or AS_GIVEN))


def _find(scenario: Sections, breaks: Breaks, conflict: Conflict) -> Iterator[Conflict]:
    found = breaks(scenario)
    if found:
        numbers = found if isinstance(found, tuple) else ()
        names = {"strategy": scenario.manifest.name} if "{strategy}" in conflict.rule else {}
        parts = (each.format(*numbers, **names) if isinstance(each, str) else each for each in conflict)
        yield Conflict(*parts)  # type: ignore[arg-type]  # as many texts, and a value


def broken(rules: Iterable[Rule], scenario: Sections) -> bool:
    """Return whether a scenario breaks one of some rules."""
    return any(True for rule in rules for _ in rule(scenario))


def after(first: Iterable[Rule], rule: Rule) -> Rule:
    """Return a rule that is skipped if a first rule is broken: it computes with what they ensure."""

    def find(scenario: Sections) -> Iterator[Conflict]:
        if not broken(first, scenario):
            yield from rule(scenario)

    return find


def both(*rules: Callable[..., Iterator[Conflict]]) -> Iterator[Rule]:
    """Yield rules about the robots, and then the same about the tasks."""
    for name in BOTH:
        yield from (partial(rule, name=name) for rule in rules)
