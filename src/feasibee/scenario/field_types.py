"""The types of a scenario's fields: their ranges, validation and JSON Schema."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any
from unicodedata import category

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo, WithJsonSchema
from pydantic_core import PydanticCustomError

from feasibee.errors import FeasibeeError
from feasibee.model.codes import exact, is_whole
from feasibee.scenario.plugins import manifest_of, registered
from feasibee.strategies import STRATEGIES

Length = Annotated[float, Field(gt=0, le=1e6)]
Duration = Annotated[float, Field(gt=0, le=1e6)]


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


Share = Annotated[float, Field(ge=0, le=1), AfterValidator(_without_minus)]
Sightings = Annotated[float, Field(ge=0, le=50), AfterValidator(_without_minus)]
Rate = Annotated[float, Field(ge=0, le=10), AfterValidator(_not_tiny)]
Lifetime = Annotated[float, Field(gt=0, le=1e9)]
Speed = Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus)]
Word = Annotated[str, Field(min_length=1, max_length=40), AfterValidator(_printable)]
Point = tuple[float, float]


def without_default(schema: dict[str, Any]) -> None:
    """Remove a default that depends on another field from the JSON Schema."""
    schema.pop("default", None)


def _as_side(value: Any) -> Any:
    """Validate the side of a square arena, or its width and height."""
    lengths = value if isinstance(value, list | tuple) and len(value) == 2 else [value]
    if all(_is_number(each) and 0 < each <= 1e6 for each in lengths):
        return tuple(float(each) for each in lengths) if len(lengths) == 2 else float(lengths[0])
    raise PydanticCustomError("side", "must be > 0 and ≤ 1000000, or two such numbers [width, height]")


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond the largest float
        return False


def _as_faulty(value: Any) -> Any:
    """Validate a share of the robots, or ``{count = robots}``; 1 could be meant as either, and is neither."""
    count = value.get("count") if isinstance(value, Mapping) and len(value) == 1 else None
    if is_whole(count, 1_000_000):
        return {"count": count}
    if _is_number(value) and 0 <= value < 1:
        return _without_minus(float(value))
    rule = "must be a share of the robots, a finite number ≥ 0 and < 1, or a count of them"
    raise PydanticCustomError("faulty", rule)


def _as_points(value: Any) -> Any:
    """Validate pairs of numbers; `Scenario` has already replaced the name of a file by its points."""
    if isinstance(value, list | tuple) and all(
        isinstance(pair, list | tuple) and len(pair) == 2 and all(_is_number(each) for each in pair)
        for pair in value
    ):
        return tuple((float(x), float(y)) for x, y in value)
    raise PydanticCustomError("points", "must be the name of a CSV file, or pairs of numbers [x, y]")


def _as_listen(value: Any) -> Any:
    """Validate ``"always"``, ``"dissemination"`` or ``{last = steps}``."""
    if value in ("always", "dissemination"):
        return value
    steps = value.get("last") if isinstance(value, Mapping) and len(value) == 1 else None
    if isinstance(steps, int) and not isinstance(steps, bool) and 1 <= steps <= 1_000_000:
        return {"last": steps}
    rule = "must be 'always', 'dissemination', or {last = 3} for the last 3 steps of dissemination"
    raise PydanticCustomError("listen", rule)


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


def few_decimals(value: float) -> float:
    """Raise an error for too many decimals: a share of an inbox is compared with the value exactly."""
    if exact(value).denominator > 10**9:
        raise PydanticCustomError("decimals", "must have at most 9 decimals")
    return value


POSITIVE = {"type": "number", "exclusiveMinimum": 0, "maximum": 1e6}
PAIRS = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}
Side = Annotated[
    Any,
    BeforeValidator(_as_side),
    WithJsonSchema({"anyOf": [POSITIVE, {"type": "array", "items": POSITIVE, "minItems": 2, "maxItems": 2}]}),
]
LAST = {
    "type": "object",
    "properties": {"last": {"type": "integer", "minimum": 1, "maximum": 1_000_000}},
    "required": ["last"],
    "additionalProperties": False,
}
Listen = Annotated[
    Any,
    BeforeValidator(_as_listen),
    WithJsonSchema({"anyOf": [{"enum": ["always", "dissemination"]}, LAST]}),
]
COUNTED = {
    "type": "object",
    "properties": {"count": {"type": "integer", "minimum": 0, "maximum": 1_000_000}},
    "required": ["count"],
    "additionalProperties": False,
}
Faulty = Annotated[
    Any,
    BeforeValidator(_as_faulty),
    WithJsonSchema({"anyOf": [{"type": "number", "minimum": 0, "exclusiveMaximum": 1}, COUNTED]}),
]
StrategyName = Annotated[str, AfterValidator(_known_strategy)]
Points = Annotated[Any, BeforeValidator(_as_points), WithJsonSchema({"anyOf": [{"type": "string"}, PAIRS]})]
