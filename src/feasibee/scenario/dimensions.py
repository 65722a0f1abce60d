"""What fields measure: lengths, times, speeds and rates, as numbers of units and steps or as texts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Final

from pydantic import GetJsonSchemaHandler


@dataclass(frozen=True, eq=False)
class Dimension:
    """What a field measures: in units and steps as a number, in metres and seconds as a text."""

    unit: str
    name: str
    such_as: str
    sizes: Mapping[str, Fraction]
    """Each unit of a text, in metres and seconds."""
    powers: Mapping[str, int]
    """Of which fields of `Units` a number is multiplied by which powers to be in metres and seconds."""
    whole: bool = False

    def size(self, units: Mapping[str, Any]) -> Any:
        """Return what 1 is in metres and seconds; None if ``units`` don't say it."""
        is_known = units.keys() >= self.powers.keys()
        return math.prod(units[each] ** power for each, power in self.powers.items()) if is_known else None

    def __get_pydantic_json_schema__(self, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the schema of numbers, with texts in addition."""
        schema = handler(core)
        if not isinstance(schema.get("type"), str):
            return schema
        pattern = f"^{NUMBER} *({'|'.join(self.sizes)})$".replace("/", "( per |/)")
        return {**schema, "type": [schema["type"], "string"], "pattern": pattern}


NUMBER: Final = r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2})?)"
LENGTHS: Final = {"m": Fraction(1), "cm": Fraction(1, 100), "mm": Fraction(1, 1000), "km": Fraction(1000)}
TIMES: Final = {"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60), "h": Fraction(3600)}
RATES: Final = {f"/{b}": 1 / TIMES[b] for b in TIMES}
SPEEDS: Final = {f"{a}/{b}": LENGTHS[a] / TIMES[b] for a in LENGTHS for b in TIMES}
LENGTH: Final = Dimension("units", "a length", 'in m, cm, mm or km, such as "6 m"', LENGTHS, {"metres": 1})
DURATION: Final = Dimension("steps", "a time", 'in s, ms, min or h, such as "10 min"', TIMES, {"seconds": 1})
TIME: Final = replace(DURATION, whole=True)
SPEED: Final = Dimension(
    "units per step", "a speed", 'such as "0.5 m/s" or "20 cm/s"', SPEEDS, {"metres": 1, "seconds": -1}
)
RATE: Final = Dimension("per step", "a rate", 'such as "0.2/min" or "3 per h"', RATES, {"seconds": -1})
NO_UNIT: Final = Dimension("", "a number", "", {"": Fraction(1)}, {})
DIMENSIONS: Final = (LENGTH, DURATION, SPEED, RATE)


def converted(mark: Dimension, amount: str, unit: str, known: Mapping[str, Any]) -> Any:
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
