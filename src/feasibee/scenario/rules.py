"""The form of a rule between fields of a scenario, and of what it finds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Final, NamedTuple

from feasibee.scenario.fields import SECTIONS
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


def never(
    path: str, breaks: Callable[[Sections], object], rule: str, remedy: str, value: object = AS_GIVEN
) -> Rule:
    """Return a rule about one field; ``{strategy}`` in its text becomes the strategy's name."""

    def find(scenario: Sections) -> Iterator[Conflict]:
        if breaks(scenario):
            named = rule.replace("{strategy}", scenario.manifest.name) if "{" in rule else rule
            yield Conflict(path, named, remedy, value)

    return find


def default_unless(path: str, enabled: Callable[[Sections], bool], rule: str, remedy: str) -> Rule:
    """Return a rule that a field has its default unless what it belongs to is enabled."""
    name, key = path.split(".")
    default = SECTIONS[name].model_fields[key].default
    return never(path, lambda s: not enabled(s) and getattr(getattr(s, name), key) != default, rule, remedy)


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
