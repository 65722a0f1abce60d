"""Lengths, times and speeds that a scenario gives as texts, such as "6 m", as numbers of units and steps."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, Final

from feasibee.errors import Problem
from feasibee.model.codes import exact
from feasibee.scenario.fields import SECTIONS, Event, dimension_of, dimensions
from feasibee.scenario.tables import FILES
from feasibee.scenario.types import DIMENSIONS, NUMBER, Dimension, Section

QUANTITY: Final = re.compile(rf"(?=.{{,60}}$){NUMBER} *([^\s0-9.]\S*)")
"""A number and its unit. A space between them may be missing."""
DEEPEST: Final = 4
"""Depth of a coordinate: in a point of a polygon of a zone."""


def with_numbers(given: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem], dict[str, Any]]:
    """Replace quantities in tables by numbers; return the problems, and the given values by path.

    A text with a problem stays, and so does one that is no quantity: validation reports it.
    """
    tables, problems, texts = dict(given), dict[str, Problem](), dict[str, Any]()
    sizes = given["units"] if isinstance(given.get("units"), Mapping) else {}
    valid = {name for name, size in sizes.items() if type(size) in (int, float) and 1e-9 <= size <= 1e9}
    known = {name: exact(float(sizes[name])) for name in valid}

    def number(path: str, mark: Dimension, text: Any, is_name: bool = False, depth: int = DEEPEST) -> Any:
        if isinstance(text, list | tuple):
            ends = not depth or {*map(type, text)} <= {int, float}  # soon: a file may have many points
            return text if ends else type(text)(number(path, mark, each, False, depth - 1) for each in text)
        if isinstance(text, Mapping) and depth == DEEPEST:
            return {key: number(path, mark, each, is_name, depth - 1) for key, each in text.items()}
        is_text = isinstance(text, str) and not is_name
        found = QUANTITY.fullmatch(text.replace(" per ", "/")) if is_text else None
        if found is None:
            return text
        value = _converted(mark, found[1], found[2], known)
        if isinstance(value, tuple):
            problems.setdefault(path, Problem(path, text, *value))
            return text
        return value

    def table(path: str, section: type[Section], fields: Any) -> Any:
        if not isinstance(fields, Mapping):
            return fields
        new = dict(fields)
        for key in filter(fields.__contains__, dimensions(section)):
            at = f"{path}.{key}"
            new[key] = number(at, dimensions(section)[key], fields[key], at in FILES)
            if new[key] != fields[key]:
                texts[at] = fields[key]
        return new

    tables |= {name: table(name, SECTIONS[name], each) for name, each in given.items() if name in SECTIONS}
    if isinstance(tables.get("events"), list | tuple):
        tables["events"] = [table(f"events.{i}", Event, each) for i, each in enumerate(tables["events"])]
    return tables, list(problems.values()), texts


def _converted(mark: Dimension, amount: str, unit: str, known: Mapping[str, Any]) -> Any:
    """Return a quantity in units and steps, rounded if whole; or the rule that it breaks, and the remedy."""
    if unit not in mark.sizes:
        other = next((each.name for each in DIMENSIONS if unit in each.sizes), "")
        rule = f"must be {mark.name}, not {other}" if other else f"has the unknown unit {unit}"
        return rule, f"write {mark.name} {mark.such_as}"
    size = mark.size(known)
    if size is None:
        missing = [f"units.{each}" for each in mark.powers if each not in known]
        return f"needs {' and '.join(missing)}", f"set {' = 0.5 and '.join(missing)} = 0.5"
    value = Fraction(amount) * mark.sizes[unit] / size
    if not mark.whole:
        return float(value)
    steps = math.floor(value + Fraction(1, 2))
    shorter = "is shorter than half a step", "write a longer time, or lower units.seconds"
    return shorter if value > 0 and not steps else steps


def in_the_text(problem: Problem, texts: Mapping[str, Any]) -> Problem:
    """Return a problem of a number with the text that it was converted from, if any."""
    text, value = texts.get(problem.path), problem.value
    if text is None or not isinstance(value, int | float):
        return problem
    unit = dimension_of(problem.path).unit
    return problem._replace(value=text, rule=f"is {value:g} {unit}, and {problem.rule}")
