"""The sections of a scenario and their fields; the defaults are the paper's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import PydanticCustomError

from feasibee.errors import FeasibeeError
from feasibee.model.codes import exact
from feasibee.scenario.plugins import manifest_of, registered
from feasibee.strategies import STRATEGIES

Length = Annotated[float, Field(gt=0, le=1e6)]
Duration = Annotated[float, Field(gt=0, le=1e6)]


def _without_minus(value: float) -> float:
    """Return 0.0 for -0.0, which is equal but written otherwise."""
    return value + 0.0


def _printable(text: str) -> str:
    """Raise an error for file names with control characters or surrogates."""
    if not text.isprintable():
        raise PydanticCustomError("printable", "must have printable characters only")
    return text


Share = Annotated[float, Field(ge=0, le=1), AfterValidator(_without_minus)]
Sightings = Annotated[float, Field(ge=0, le=50), AfterValidator(_without_minus)]
Speed = Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus)]
Word = Annotated[str, Field(min_length=1, max_length=40), AfterValidator(_printable)]
Point = tuple[float, float]


def _without_default(schema: dict[str, Any]) -> None:
    """Leave a default that depends on another field out of the JSON Schema."""
    schema.pop("default", None)


def _as_side(value: Any) -> Any:
    """Take a length, or width and height."""
    lengths = value if isinstance(value, list | tuple) and len(value) == 2 else [value]
    if all(_is_number(each) and 0 < each <= 1e6 for each in lengths):
        return tuple(float(each) for each in lengths) if len(lengths) == 2 else float(lengths[0])
    raise PydanticCustomError("side", "must be > 0 and ≤ 1000000, or two such numbers [width, height]")


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond the largest float
        return False


def _as_points(value: Any) -> Any:
    """Take pairs of numbers; Scenario has read a file of them by now."""
    if isinstance(value, list | tuple) and all(
        isinstance(pair, list | tuple) and len(pair) == 2 and all(_is_number(each) for each in pair)
        for pair in value
    ):
        return tuple((float(x), float(y)) for x, y in value)
    raise PydanticCustomError("points", "must be the name of a CSV file, or pairs of numbers [x, y]")


def _as_listen(value: Any) -> Any:
    """Take a word, or {last = steps}."""
    if value in ("always", "dissemination"):
        return value
    steps = value.get("last") if isinstance(value, Mapping) and len(value) == 1 else None
    if isinstance(steps, int) and not isinstance(steps, bool) and 1 <= steps <= 1_000_000:
        return {"last": steps}
    rule = "must be 'always', 'dissemination', or {last = 3} for the last 3 steps of dissemination"
    raise PydanticCustomError("listen", rule)


def _known_strategy(name: str, info: ValidationInfo) -> str:
    """Find a strategy and read what its file declares."""
    try:
        manifest_of(name, **(info.context or {}))
    except FeasibeeError as error:
        known = [*STRATEGIES, *registered()]
        found = name.endswith(".py") or name in known
        rule = str(error) if found else f"must be the path of a .py file, or one of {', '.join(known)}"
        raise PydanticCustomError("strategy", "{rule}", {"rule": rule}) from None
    return name


def _short(value: float) -> float:
    """Refuse decimals so long that a share of an inbox couldn't be compared with them exactly."""
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
StrategyName = Annotated[str, AfterValidator(_known_strategy)]
Points = Annotated[Any, BeforeValidator(_as_points), WithJsonSchema({"anyOf": [{"type": "string"}, PAIRS]})]


class Section(BaseModel):
    """A part of a scenario: no unknown keys, no silent conversions, no NaN, no change."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, given: Any) -> Any:
        return plain(given) if isinstance(given, Mapping) else given


def plain(table: Mapping[Any, Any]) -> dict[Any, Any]:
    """Convert numpy's numbers and arrays to Python's: values of a varied field often come from an array."""
    return {key: _plain(value) for key, value in table.items()}


def _plain(value: Any) -> Any:
    if not hasattr(value, "dtype"):
        return value
    if getattr(value, "shape", None) == ():
        return value.item()
    return value.tolist() if hasattr(value, "tolist") else value


class Arena(Section):
    """The world (model.md 1.1, 6.1)."""

    side: Side = Field(20.0, description="Side of the square arena in units, or [width, height].")
    boundary: Literal["torus", "walls"] = Field(
        "torus", description="What happens at the edge: it meets the opposite one, or it is closed."
    )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, in units."""
        return self.side if isinstance(self.side, tuple) else (self.side, self.side)


class Placed(Section):
    """Where things stand at the start (model.md 6.4)."""

    placement: Literal["uniform", "clusters", "corner", "points"] = Field(
        "uniform",
        description="Uniform, about random centres, about the corner (0, 0), or at given points.",
    )
    clusters: int = Field(3, ge=1, le=1000, description="Number of centres, for clusters.")
    spread: Length = Field(1.5, description="Standard deviation about a centre or corner, in units.")
    points: Points = Field(
        (), description="For points: a CSV file of x and y in units, or the points themselves."
    )


class RobotClass(Section):
    """Robots that are alike (model.md 6.7)."""

    name: Word = Field(description="What to call them.")
    count: int = Field(ge=0, le=1_000_000, description="How many there are.")
    skills: Annotated[tuple[Word, ...], Strict(False)] = Field((), description="What each of them can do.")


class TaskClass(Section):
    """Tasks that are alike (model.md 6.7)."""

    name: Word = Field(description="What to call them.")
    count: int = Field(ge=0, le=10_000_000, description="How many there are.")
    needs: dict[Word, Annotated[int, Field(ge=1, le=1000)]] = Field(
        min_length=1, description="How many robots of each skill one of these tasks needs."
    )


class Robots(Placed):
    """The swarm (model.md 1.2, 6.2, 6.7)."""

    count: int = Field(20, ge=1, le=1_000_000, description="Number of robots, n.")
    speed: Speed = Field(1.0, description="Units a step.")
    diameter: Length = Field(1.0, description="Of a robot's disc, in units.")
    avoid_collisions: bool = Field(False, description="Whether discs never overlap.")
    classes: Annotated[tuple[RobotClass, ...], Strict(False), Field(max_length=16)] = Field(
        (), description="Unlike robots, instead of count."
    )


class Tasks(Placed):
    """What the swarm is asked to do (model.md 1.3, 6.7)."""

    count: int = Field(20, ge=0, le=10_000_000, description="Number of tasks, m, each for any one robot.")
    classes: Annotated[tuple[TaskClass, ...], Strict(False), Field(max_length=16)] = Field(
        (), description="Unlike tasks, instead of count."
    )


class Walk(Section):
    """How robots wander (model.md 2)."""

    mean_run: Duration = Field(
        10.0, description="Mean duration of a straight run, in steps, before it is rounded up: sigma."
    )


class Sensing(Section):
    """What robots see (model.md 1.4, 4.2, 6.3)."""

    range: Length = Field(2.0, description="Range of observation d, in units, centre to centre.")
    observation: Literal["repeated", "unique"] = Field(
        "repeated", description="Whether a thing counts again in each step, or once."
    )
    memory: Literal["exploration", "life"] = Field(
        "exploration", description="For how long a unique observation is remembered."
    )
    count_self: bool = Field(False, description="Whether a robot counts itself in each step.")
    miss: Share = Field(0.0, description="Probability that a thing in range isn't seen in a step.")
    false_robots: Sightings = Field(0.0, description="Expected false sightings of robots a step.")
    false_tasks: Sightings = Field(0.0, description="Expected false sightings of tasks a step.")


class Radio(Section):
    """What robots hear (model.md 1.4, 6.5)."""

    range: Length = Field(
        default=None,  # type: ignore[assignment]  # resolved by Scenario
        description="Range of messages, in units; by default that of sensing.",
        json_schema_extra=_without_default,
    )
    loss: Share = Field(0.0, description="Probability that one receiver misses one message.")
    id_bits: int | None = Field(
        None, ge=1, le=32, description="Random ids of so many bits, which may collide; by default exact ids."
    )


class Commit(Section):
    """When a robot knows that it has decided: from then on it keeps its opinion, and says so."""

    quorum: Annotated[Share, AfterValidator(_short)] = Field(
        0.9, description="Least share of its inbox that agrees with its decision,"
    )
    rounds: int = Field(3, ge=1, le=1_000_000, description="in so many decisions running,")
    heard: int = Field(3, ge=1, le=1_000_000, description="each upon at least so many messages.")


class Decision(Section):
    """The controller (model.md 4)."""

    strategy: StrategyName = Field(
        "dmmd", description="How opinions are rated, told and chosen: a name, or the path of a .py file."
    )
    parameters: dict[Word, float] = Field(
        default_factory=dict, description="The strategy's own parameters, if it has any."
    )
    exploration: Duration = Field(
        10.0, description="Mean duration of exploration, in steps, before it is rounded up: 10 gives 10.51."
    )
    gain: Duration = Field(
        10.0,
        description="Mean steps of dissemination for an opinion of quality 1, before they are rounded up: g. "
        "With 10, quality 0.9 is told 6.0 times as long as 0.1, not 9 times.",
    )
    dissemination_floor: int = Field(
        0, ge=0, le=1_000_000, description="Steps that each dissemination lasts longer."
    )
    quality_floor: int = Field(
        0, ge=0, le=1_000_000, description="Counts are taken for at least this when they are rated."
    )
    listen: Listen = Field(
        "always", description="When robots hear: always, while disseminating, or in its last steps."
    )
    inbox: Literal["latest-per-robot", "every-message"] = Field(
        "latest-per-robot", description="What the inbox keeps of a robot heard twice."
    )
    inbox_size: int | None = Field(
        None, ge=1, le=1_000_000, description="How many robots' messages the inbox keeps, the newest."
    )
    own_vote: bool = Field(True, description="Whether a robot's own opinion counts in its majority.")
    commit: Commit | None = Field(None, description="A robot's own rule to know that it has decided.")
    threshold: float = Field(
        0.9, ge=0.5, lt=1, description="The swarm has decided when more than this share of it agrees."
    )


class Faults(Section):
    """What goes wrong with robots (model.md 6.6); which ones is drawn per run."""

    stopped: Share = Field(0.0, description="Share of the robots that stop and fall silent.")
    stop_step: int = Field(0, ge=0, le=1_000_000_000, description="The step from which they do.")
    byzantine: Share = Field(0.0, description="Share of the robots that lie.")
    byzantine_says: Literal["opposite", "feasible", "infeasible", "random"] = Field(
        "opposite", description="What liars say."
    )
    stubborn: Share = Field(0.0, description="Share of the robots that never change their opinion.")


class Run(Section):
    """How long a run takes (model.md 4.7)."""

    steps: int = Field(1000, ge=1, le=1_000_000_000, description="Steps after which a run is undecided.")
    stop_at_decision: bool = Field(False, description="Whether a run ends at its decision.")


SECTIONS: Final[Mapping[str, type[Section]]] = {
    "arena": Arena,
    "robots": Robots,
    "tasks": Tasks,
    "walk": Walk,
    "sensing": Sensing,
    "radio": Radio,
    "decision": Decision,
    "faults": Faults,
    "run": Run,
}
"""The sections of a scenario, in their order there."""


def fields() -> list[str]:
    """Return the dotted paths of all fields of a scenario."""
    return [f"{name}.{key}" for name, section in SECTIONS.items() for key in section.model_fields]
