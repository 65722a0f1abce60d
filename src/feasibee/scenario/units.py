"""Lengths and times of a scenario: given as texts, such as "6 m", and shown with metres and seconds."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from feasibee.base.codes import exact
from feasibee.base.errors import Problem
from feasibee.scenario.dimensions import NUMBER, TIME, Dimension, converted
from feasibee.scenario.fields import SECTIONS, Event, Section, dimension_of
from feasibee.scenario.sections import Sections
from feasibee.scenario.tables import FILES

QUANTITY: Final = re.compile(rf"(?=.{{,60}}$){NUMBER} *([^\s0-9.]\S*)")
"""A number and its unit. A space between them may be missing."""
DEEPEST: Final = 4
"""Depth of a coordinate: in a point of a polygon of a zone."""
HOUR, MINUTE = 3600, 60
SYMBOLS: Final[Mapping[str, str]] = {
    "arena.side": "L",
    "robots.count": "n",
    "robots.speed": "v",
    "tasks.count": "m",
    "walk.mean_run": "\N{GREEK SMALL LETTER SIGMA}",
    "sensing.range": "d",
    "sensing.miss": "p_miss",
    "sensing.misname": "p_name",
    "radio.range": "d_radio",
    "radio.loss": "p_loss",
    "decision.gain": "g",
    "faults.stopped": "f_stopped",
    "faults.byzantine": "f_lying",
    "run.steps": "T",
}
"""Symbols of fields: those of the paper, as far as it has them."""


# --- From texts ---


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
        value = converted(mark, found[1], found[2], known)
        if isinstance(value, tuple):
            problems.setdefault(path, Problem(path, text, *value))
            return text
        return value

    def table(path: str, section: type[Section], fields: Any) -> Any:
        if not isinstance(fields, Mapping):
            return fields
        new = dict(fields)
        for key in filter(fields.__contains__, section.model_fields):
            at, mark = f"{path}.{key}", dimension_of(f"{path}.{key}")
            new[key] = number(at, mark, fields[key], at in FILES) if mark.unit else fields[key]
            if mark.unit and new[key] != fields[key]:
                texts[at] = fields[key]
        return new

    tables |= {name: table(name, SECTIONS[name], each) for name, each in given.items() if name in SECTIONS}
    if isinstance(tables.get("events"), list | tuple):
        tables["events"] = [table(f"events.{i}", Event, each) for i, each in enumerate(tables["events"])]
    return tables, list(problems.values()), texts


def in_the_text(problem: Problem, texts: Mapping[str, Any]) -> Problem:
    """Return a problem of a number with the text that it was converted from, if any."""
    text, value = texts.get(problem.path), problem.value
    if text is None or not isinstance(value, int | float):
        return problem
    unit = dimension_of(problem.path).unit
    return problem._replace(value=text, rule=f"is {value:g} {unit}, and {problem.rule}")


# --- In words ---


def steps_in_words(scenario: Sections, steps: float) -> str:
    """Return a number of steps, and the time if the scenario says how long a step is."""
    return _in_words(scenario, TIME, steps)


def step_in_words(scenario: Sections, step: int) -> str:
    """Return the number of a step, and the time at which it ends if the scenario says how long a step is."""
    return f"step {step}{in_brackets(scenario, TIME, step)}"


def when_in_words(scenario: Sections, step: int | None) -> str:
    """Return by which step something has happened, or "never"."""
    return "never" if step is None else f"by {step_in_words(scenario, step)}"


def _in_words(scenario: Sections, dimension: Dimension, value: float) -> str:
    unit = re.sub(r"s\b", "", dimension.unit, count=1) if value == 1 else dimension.unit
    return f"{value:g} {unit}{in_brackets(scenario, dimension, value)}"


def in_brackets(scenario: Sections, dimension: Dimension, value: float) -> str:
    """Return a value in metres and seconds, in brackets, if the scenario says how long these are."""
    name, size = outside(scenario, dimension)
    if name == dimension.unit or not isinstance(value, int | float):
        return ""
    return f" ({duration(value * size) if name == 's' else f'{value * size:.4g} {name}'})"


def outside(scenario: Sections, dimension: Dimension) -> tuple[str, float]:
    """Return the unit that readers get, of metres and seconds if the scenario has them, and its size."""
    size = dimension.size(scenario.units.model_dump(exclude_none=True))
    name = dimension.unit if size is None else re.sub("^/", "per ", next(iter(dimension.sizes)))
    return name, size or 1.0


def duration(seconds: float) -> str:
    """Return a time in words, to two of its largest parts, such as ``7 min 30 s``."""
    whole = round(seconds)
    if whole < MINUTE:
        return f"{seconds:.3g} s"
    if whole < HOUR:
        return f"{whole // MINUTE} min" + (f" {whole % MINUTE} s" if whole % MINUTE else "")
    minutes = round(seconds / MINUTE)
    return f"{minutes // MINUTE} h" + (f" {minutes % MINUTE} min" if minutes % MINUTE else "")


def value_in_words(scenario: Sections, path: str, value: Any) -> str:
    """Return a field and its value, with its unit if it has one: ``radio.range = 3 units (1.5 m)``."""
    dimension = dimension_of(path)
    return f"{path} = {_in_words(scenario, dimension, value) if dimension.unit else value}"


def symbol_of(path: str) -> str:
    """Return the symbol of a field, or its key as words."""
    return SYMBOLS.get(path) or path.rpartition(".")[2].replace("_", " ")
