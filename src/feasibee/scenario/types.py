"""Types of the fields of a scenario: ranges, units, and errors that state one rule."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Annotated, Any, Final, Literal, LiteralString
from unicodedata import category

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    Strict,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from feasibee.errors import FeasibeeError
from feasibee.model.codes import exact
from feasibee.scenario.plugins import manifest_of, registered
from feasibee.strategies import STRATEGIES


class Section(BaseModel):
    """A section of a scenario: immutable, without unknown keys, silent conversions or NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, given: Any) -> Any:
        return plain(given) if isinstance(given, Mapping) else given


def plain(table: Mapping[Any, Any]) -> dict[Any, Any]:
    """Convert numpy's numbers and arrays to Python's: values of a sweep often come from an array."""
    return {key: _plain(value) for key, value in table.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return plain(value)
    if not hasattr(value, "dtype"):
        return value
    if getattr(value, "shape", None) == ():
        return value.item()
    return value.tolist() if hasattr(value, "tolist") else value


def _without_minus(value: float) -> float:
    """Return 0.0 for -0.0, so that equal scenarios have equal texts and hashes."""
    return value + 0.0


def _not_tiny(value: float) -> float:
    """Raise an error for a rate whose mean time is longer than any run."""
    if 0 < value < 1e-9:
        raise PydanticCustomError("rate", "must be 0, or at least 1e-9 per step")
    return _without_minus(value)


def _printable(text: str) -> str:
    """Raise an error for a name with control characters or surrogates."""
    if not text.isprintable():
        raise PydanticCustomError("printable", "must contain printable characters only")
    return text


def _few_decimals(value: float) -> float:
    """Raise an error for too many decimals: a share of an inbox is compared with the value exactly."""
    if exact(value).denominator > 10**9:
        raise PydanticCustomError("decimals", "must have at most 9 decimals")
    return value


def _known_strategy(name: str, info: ValidationInfo) -> str:
    """Raise an error unless a strategy of this name exists and its file declares what it must."""
    if any(category(each) == "Cc" for each in name):
        raise PydanticCustomError("strategy", "must be a name without control characters")
    try:
        manifest_of(name, **(info.context or {}))
    except FeasibeeError as error:
        known = [*STRATEGIES, *registered()]
        found = name.endswith(".py") or name in known
        rule = str(error) if found else f"must be the path of a .py file, or one of {', '.join(known)}"
        raise PydanticCustomError("strategy", "{rule}", {"rule": rule}) from None
    return name


def _one_rule(kind: LiteralString, rule: LiteralString) -> WrapValidator:
    """Return a validator that raises one error in place of those about each type of a union."""

    def validate(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
        try:
            return handler(value)
        except ValidationError:
            raise PydanticCustomError(kind, rule) from None

    return WrapValidator(validate)


def _polygons(value: Any) -> Any:
    """Return a zone of one polygon as a list of polygons."""
    is_one = isinstance(value, list | tuple) and value and isinstance(value[0], list | tuple) and value[0]
    return [value] if is_one and isinstance(value[0][0], int | float) else value


def without_default(schema: dict[str, Any]) -> None:
    """Remove a default that depends on another field from the JSON Schema."""
    schema.pop("default", None)


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

Million = Annotated[int, Field(ge=0, le=1_000_000)]
Some = Annotated[int, Field(ge=1, le=1_000_000)]
ManyTasks = Annotated[int, Field(ge=0, le=10_000_000)]
Step = Annotated[int, Field(ge=0, le=1_000_000_000), TIME]
Steps = Annotated[int, Field(ge=1, le=1_000_000_000), TIME]
Late = Annotated[int, Field(ge=0, le=1_000), TIME]
Bits = Annotated[int, Field(ge=1, le=32)]
Length = Annotated[float, Field(gt=0, le=1e6), LENGTH]
Wait = Annotated[int, Field(ge=0, le=1_000_000), TIME]
Duration = Annotated[float, Field(gt=0, le=1e6), DURATION]
Share = Annotated[float, Field(ge=0, le=1), AfterValidator(_without_minus)]
Sightings = Annotated[float, Field(ge=0, le=50), AfterValidator(_without_minus), RATE]
Rate = Annotated[float, Field(ge=0, le=10), AfterValidator(_not_tiny), RATE]
Lifetime = Annotated[float, Field(gt=0, le=1e9), DURATION]
Speed = Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus), SPEED]
Angle = Annotated[float, Field(gt=0, le=360)]
Deviation = Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus), LENGTH]
Word = Annotated[str, Field(min_length=1, max_length=40), AfterValidator(_printable)]
Quorum = Annotated[Share, AfterValidator(_few_decimals)]
Lie = Literal["opposite", "feasible", "infeasible", "random", "colluding"]
StrategyName = Annotated[str, AfterValidator(_known_strategy)]
Point = tuple[Annotated[float, LENGTH], Annotated[float, LENGTH]]
Side = Annotated[
    Length | Annotated[tuple[Length, Length], Strict(False)],
    _one_rule("side", "must be > 0 and ≤ 1000000, or two such numbers [width, height]"),
]
Listen = Annotated[
    Literal["always", "dissemination"] | Annotated[dict[Literal["last"], Some], Field(min_length=1)],
    _one_rule(
        "listen", "must be 'always', 'dissemination', or {last = 3} for the last 3 steps of dissemination"
    ),
]
Start = Annotated[
    Step | Literal["declared", "search", "safe"],
    _one_rule("start", "must be a step, or 'declared', 'search' or 'safe'"),
    TIME,
]
Faulty = Annotated[
    Annotated[float, Field(ge=0, lt=1), AfterValidator(_without_minus)]
    | Annotated[dict[Literal["count"], Million], Field(min_length=1)],
    _one_rule("faulty", "must be a share of the robots, a finite number ≥ 0 and < 1, or a count of them"),
]
"""A share of the robots, or ``{count = robots}``; 1 could be meant as either, and is neither."""
Points = Annotated[
    tuple[Annotated[Point, Strict(False)], ...],
    Strict(False),
    _one_rule("points", "must be the name of a CSV file, or pairs of numbers [x, y]"),
    WithJsonSchema({"anyOf": [{"type": "string"}, TypeAdapter(tuple[Point, ...]).json_schema()]}),
]
"""Pairs of numbers; `Scenario` has already replaced the name of a file by its points."""


Polygon = Annotated[tuple[Annotated[Point, Strict(False)], ...], Strict(False), Field(min_length=3)]
Polygons = Annotated[
    tuple[Polygon, ...],
    Strict(False),
    _one_rule("polygons", "must be a list of polygons, each a list of 3 or more points [x, y]"),
]
Zone = Annotated[
    Polygons, BeforeValidator(_polygons), WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array"}]})
]
"""Polygons, or one of them; `Scenario` has already replaced the name of a file by its polygons."""
