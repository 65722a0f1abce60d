"""Lengths and times of a scenario in words: with metres and seconds if `Units` are given."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from feasibee.scenario.fields import dimension_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.types import LENGTH, TIME, Dimension

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


def length_in_words(scenario: Scenario, value: float) -> str:
    """Return a length in units, and in metres if the scenario says how long a unit is."""
    return _in_words(scenario, LENGTH, value)


def steps_in_words(scenario: Scenario, steps: float) -> str:
    """Return a number of steps, and the time if the scenario says how long a step is."""
    return _in_words(scenario, TIME, steps)


def step_in_words(scenario: Scenario, step: int) -> str:
    """Return the number of a step, and the time at which it ends if the scenario says how long a step is."""
    return f"step {step}{in_brackets(scenario, TIME, step)}"


def when_in_words(scenario: Scenario, step: int | None) -> str:
    """Return by which step something has happened, or "never"."""
    return "never" if step is None else f"by {step_in_words(scenario, step)}"


def _in_words(scenario: Scenario, dimension: Dimension, value: float) -> str:
    unit = re.sub(r"s\b", "", dimension.unit, count=1) if value == 1 else dimension.unit
    return f"{value:g} {unit}{in_brackets(scenario, dimension, value)}"


def in_brackets(scenario: Scenario, dimension: Dimension, value: float) -> str:
    """Return a value in metres and seconds, in brackets, if the scenario says how long these are."""
    name, size = outside(scenario, dimension)
    if name == dimension.unit or not isinstance(value, int | float):
        return ""
    return f" ({duration(value * size) if name == 's' else f'{value * size:.4g} {name}'})"


def outside(scenario: Scenario, dimension: Dimension) -> tuple[str, float]:
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


def value_in_words(scenario: Scenario, path: str, value: Any) -> str:
    """Return a field and its value, with its unit if it has one: ``radio.range = 3 units (1.5 m)``."""
    dimension = dimension_of(path)
    return f"{path} = {_in_words(scenario, dimension, value) if dimension.unit else value}"


def symbol_of(path: str) -> str:
    """Return the symbol of a field, or its key as words."""
    return SYMBOLS.get(path) or path.rpartition(".")[2].replace("_", " ")
