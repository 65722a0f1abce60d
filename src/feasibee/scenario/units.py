"""Lengths and times of a scenario in words: with metres and seconds if `Units` are given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from feasibee.scenario.fields import unit_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.types import LENGTH, SPEED, TIME

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
    "decision.switching": "p_switch",
    "faults.stopped": "f_stopped",
    "faults.byzantine": "f_lying",
    "run.steps": "T",
}
"""Symbols of fields: those of the paper, as far as it has them."""


def length_in_words(scenario: Scenario, value: float) -> str:
    """Return a length in units, and in metres if the scenario says how long a unit is.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.units import length_in_words
    >>> length_in_words(Scenario(), 2.0), length_in_words(Scenario(units={"metres": 0.5}), 2.0)
    ('2 units', '2 units (1 m)')
    """
    metres = scenario.units.metres
    return f"{value:g} {'unit' if value == 1 else 'units'}" + (
        "" if metres is None else f" ({value * metres:.4g} m)"
    )


def steps_in_words(scenario: Scenario, steps: float) -> str:
    """Return a number of steps, and the time if the scenario says how long a step is.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.units import steps_in_words
    >>> steps_in_words(Scenario(units={"seconds": 0.5}), 900)
    '900 steps (7 min 30 s)'
    """
    return f"{steps:g} {'step' if steps == 1 else 'steps'}{_time(scenario, steps)}"


def step_in_words(scenario: Scenario, step: int) -> str:
    """Return the number of a step, and the time at which it ends if the scenario says how long a step is."""
    return f"step {step}{_time(scenario, step)}"


def when_in_words(scenario: Scenario, step: int | None) -> str:
    """Return by which step something has happened, or "never"."""
    return "never" if step is None else f"by {step_in_words(scenario, step)}"


def _time(scenario: Scenario, steps: float) -> str:
    seconds = scenario.units.seconds
    return "" if seconds is None else f" ({duration(steps * seconds)})"


def duration(seconds: float) -> str:
    """Return a time in words, to two of its largest parts.

    Examples
    --------
    >>> from feasibee.scenario.units import duration
    >>> duration(0.5), duration(450), duration(7260)
    ('0.5 s', '7 min 30 s', '2 h 1 min')
    """
    whole = round(seconds)
    if whole < MINUTE:
        return f"{seconds:.3g} s"
    if whole < HOUR:
        return f"{whole // MINUTE} min" + (f" {whole % MINUTE} s" if whole % MINUTE else "")
    minutes = round(seconds / MINUTE)
    return f"{minutes // MINUTE} h" + (f" {minutes % MINUTE} min" if minutes % MINUTE else "")


def value_in_words(scenario: Scenario, path: str, value: Any) -> str:
    """Return a field and its value, with the unit if the field has one.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.units import value_in_words
    >>> value_in_words(Scenario(units={"metres": 0.5}), "radio.range", 3.0)
    'radio.range = 3 units (1.5 m)'
    """
    units, unit = scenario.units, unit_of(path)
    if unit == LENGTH:
        return f"{path} = {length_in_words(scenario, value)}"
    if unit == TIME:
        return f"{path} = {steps_in_words(scenario, value)}"
    if unit == SPEED:
        known = units.metres is not None and units.seconds is not None
        speed = f" ({value * units.metres / units.seconds:.4g} m/s)" if known else ""
        return f"{path} = {value:g} {'unit' if value == 1 else 'units'} per step{speed}"
    return f"{path} = {value}"


def axis_of(scenario: Scenario, path: str) -> tuple[str, float]:
    """Return the label of a field's axis, and by what to multiply its values.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.units import axis_of
    >>> axis_of(Scenario(units={"metres": 0.5}), "radio.range"), axis_of(Scenario(), "radio.range")
    (('radio.range (m)', 0.5), ('radio.range (units)', 1.0))
    """
    sizes: dict[str, tuple[str, float | None]] = {
        LENGTH: ("m", scenario.units.metres),
        TIME: ("s", scenario.units.seconds),
    }
    unit = unit_of(path)
    if unit not in sizes:
        return path, 1.0
    name, size = sizes[unit]
    return (f"{path} ({unit})", 1.0) if size is None else (f"{path} ({name})", size)


def symbol_of(path: str) -> str:
    """Return the symbol of a field, or its key as words."""
    return SYMBOLS.get(path) or path.rpartition(".")[2].replace("_", " ")
