"""Lengths, times and speeds that a scenario gives as texts, such as "6 m", as numbers of units and steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any, Final

from feasibee.errors import Problem
from feasibee.model.codes import exact
from feasibee.scenario.fields import SECTIONS, Event, dimension_of, unit_of
from feasibee.scenario.types import DIMENSIONS, LONGEST, QUANTITY, Dimension, Section

MOST: Final = 1e18
"""Absolute value beyond which a number is replaced by this: no field takes either."""
SIZES: Final = {"metres": "0.5 (metres per unit)", "seconds": "1.0 (seconds per step)"}
"""For remedies: values of `Units`."""


class _WrongError(Exception):
    """A quantity that a field can't have: the rule, and the remedy."""


def with_numbers(given: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem], dict[str, str]]:
    """Replace quantities in the tables of a scenario by numbers; return the problems and all texts by path.

    A text with a problem stays, and so does one that is no quantity: validation reports it.
    """
    tables, problems, texts = dict(given), dict[str, Problem](), dict[str, str]()
    sizes = given.get("units")
    known = sizes if isinstance(sizes, Mapping) else {}

    def number(path: str, mark: Dimension, text: Any) -> Any:
        if isinstance(text, list | tuple):
            return [number(path, mark, each) for each in text]
        found = QUANTITY.fullmatch(text) if isinstance(text, str) and len(text) <= LONGEST else None
        if found is None:
            return text
        try:
            value = _converted(mark, float(found[1]), found[2], known)
        except _WrongError as error:
            problems.setdefault(path, Problem(path, text, *error.args))
            return text
        texts[path] = text
        return value

    def table(path: str, section: type[Section], fields: Any) -> Any:
        if not isinstance(fields, Mapping):
            return fields
        marks = _marks(section)
        return {
            key: number(f"{path}.{key}", marks[key], value) if key in marks else value
            for key, value in fields.items()
        }

    tables |= {name: table(name, SECTIONS[name], each) for name, each in given.items() if name in SECTIONS}
    if isinstance(tables.get("events"), list | tuple):
        tables["events"] = [table(f"events.{i}", Event, each) for i, each in enumerate(tables["events"])]
    return tables, list(problems.values()), texts


@cache
def _marks(section: type[Section]) -> dict[str, Dimension]:
    """Return the dimensions of the fields of a section that have one."""
    found = {key: dimension_of(field) for key, field in section.model_fields.items()}
    return {key: mark for key, mark in found.items() if mark is not None}


def _converted(mark: Dimension, amount: float, unit: str, known: Mapping[str, Any]) -> float:
    """Return a quantity as a number of units, steps, or units per step; round whole steps."""
    if unit not in mark.sizes:
        other = next((each.name for each in DIMENSIONS if unit in each.sizes), "")
        rule = f"must be {mark.name}, not {other}" if other else f"has the unknown unit {unit}"
        raise _WrongError(rule, f"write {mark.name} {mark.such_as}")
    missing = [size for size in mark.needs if not _is_size(known.get(size))]
    if missing:
        rule = f"needs {' and '.join(f'units.{size}' for size in missing)}"
        raise _WrongError(rule, f"set {' and '.join(f'units.{size} = {SIZES[size]}' for size in missing)}")
    value = exact(_within(amount)) * mark.sizes[unit]
    for size, power in mark.needs.items():
        value *= exact(float(known[size])) ** power
    value = _within(value)
    if not mark.whole:
        return float(value)
    steps: int = math.floor(value + Fraction(1, 2))
    if value > 0 and not steps:
        raise _WrongError("is shorter than half a step", "write a longer time, or lower units.seconds")
    return steps


def _within(value: Any) -> Any:
    return max(-MOST, min(MOST, value))


def _is_size(value: object) -> bool:
    """Return whether a value of `Units`, not yet validated, is one."""
    return isinstance(value, int | float) and not isinstance(value, bool) and 1e-9 <= value <= 1e9


def in_the_text(problem: Problem, texts: Mapping[str, str]) -> Problem:
    """Return a problem of a number with the text that it was converted from, if any."""
    text, value = texts.get(problem.path), problem.value
    if text is None or not isinstance(value, int | float):
        return problem
    return problem._replace(value=text, rule=f"is {value:g} {unit_of(problem.path)}, and {problem.rule}")
