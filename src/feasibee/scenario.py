"""Scenario: all that defines a swarm and its world, checked, frozen, in TOML, with a hash.

A short text resolves to one complete form, which is hashed, stored and run. The defaults are the paper's.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, cast

import tomli_w
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)
from pydantic_core import ErrorDetails

from feasibee.errors import FeasibeeError, Problem, ScenarioError

Length = Annotated[float, Field(gt=0, le=1e6)]
Duration = Annotated[float, Field(gt=0, le=1e6)]


def _without_default(schema: dict[str, Any]) -> None:
    """Leave a default that depends on another field out of the JSON Schema."""
    schema.pop("default", None)


def _without_minus(value: float) -> float:
    """Return 0.0 for -0.0, which is equal but written otherwise."""
    return value + 0.0


class Section(BaseModel):
    """A part of a scenario: no unknown keys, no silent conversions, no NaN, no change."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Arena(Section):
    """The world (model.md 1.1)."""

    side: Length = Field(20.0, description="Side of the square arena, in units.")
    boundary: Literal["torus"] = Field(
        "torus", description="What happens at the edge: it meets the opposite one."
    )


class Robots(Section):
    """The swarm (model.md 1.2)."""

    count: int = Field(20, ge=1, le=1_000_000, description="Number of robots, n.")
    speed: Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus)] = Field(
        1.0, description="Units a step."
    )


class Tasks(Section):
    """What the swarm is asked to do (model.md 1.3)."""

    count: int = Field(20, ge=0, le=10_000_000, description="Number of tasks, m.")


class Walk(Section):
    """How robots wander (model.md 2)."""

    mean_run: Duration = Field(10.0, description="Mean duration of a straight run, in steps: sigma.")


class Sensing(Section):
    """What robots see (model.md 1.4, 4.2)."""

    range: Length = Field(2.0, description="Range of observation d, in units, centre to centre.")
    observation: Literal["repeated"] = Field(
        "repeated", description="Whether a thing counts again in each step."
    )
    count_self: bool = Field(False, description="Whether a robot counts itself in each step.")


class Radio(Section):
    """What robots hear (model.md 1.4)."""

    range: Length = Field(
        default=None,  # type: ignore[assignment]  # resolved by Scenario
        description="Range of messages, in units; by default that of sensing.",
        json_schema_extra=_without_default,
    )


class Decision(Section):
    """The controller (model.md 4)."""

    strategy: Literal["dmmd"] = Field("dmmd", description="How opinions are rated and chosen.")
    exploration: Duration = Field(10.0, description="Mean duration of exploration, in steps.")
    gain: Duration = Field(10.0, description="Mean steps of dissemination for an opinion of quality 1: g.")
    listen: Literal["always", "dissemination"] = Field("always", description="In which phases robots hear.")
    inbox: Literal["latest-per-robot", "every-message"] = Field(
        "latest-per-robot", description="What the inbox keeps of a robot heard twice."
    )
    own_vote: bool = Field(True, description="Whether a robot's own opinion counts in its majority.")
    threshold: float = Field(
        0.9, ge=0.5, lt=1, description="The swarm has decided when more than this share of it agrees."
    )


class Run(Section):
    """How long a run takes (model.md 4.7)."""

    steps: int = Field(
        1000, ge=1, le=1_000_000_000, description="Steps after which an undecided run stays so."
    )
    stop_at_decision: bool = Field(False, description="Whether a run ends at its decision.")


class Scenario(BaseModel):
    """A swarm, its world and its controller; the defaults are the paper's.

    Parameters
    ----------
    arena, robots, tasks, walk, sensing, radio, decision, run : mapping or section, optional
        What differs from the paper, such as ``tasks={"count": 50}``.

    Raises
    ------
    ScenarioError
        With every problem at once: unknown keys, wrong types, impossible values and combinations.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> Scenario(tasks={"count": 50}).tasks.count
    50
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    arena: Arena = Arena()
    robots: Robots = Robots()
    tasks: Tasks = Tasks()
    walk: Walk = Walk()
    sensing: Sensing = Sensing()
    radio: Radio = Field(default_factory=Radio)  # not a default in the schema: it depends on sensing
    decision: Decision = Decision()
    run: Run = Run()

    if TYPE_CHECKING:  # pydantic takes a table for a section, which its derived signature doesn't say

        def __init__(
            self,
            *,
            arena: Arena | Mapping[str, Any] = ...,
            robots: Robots | Mapping[str, Any] = ...,
            tasks: Tasks | Mapping[str, Any] = ...,
            walk: Walk | Mapping[str, Any] = ...,
            sensing: Sensing | Mapping[str, Any] = ...,
            radio: Radio | Mapping[str, Any] = ...,
            decision: Decision | Mapping[str, Any] = ...,
            run: Run | Mapping[str, Any] = ...,
        ) -> None: ...

    @model_validator(mode="wrap")
    @classmethod
    def _check(cls, given: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Gather the problems of single fields and of combinations, or resolve the defaults."""
        if isinstance(given, cls):
            return given
        if not isinstance(given, Mapping):
            raise ScenarioError(
                [Problem("", given, "must be a table of sections", "see `feasibee scenario`")]
            )
        try:
            scenario = handler(given)
        except ValidationError as error:
            problems = [_problem(details) for details in error.errors()]
            wrong = {problem.path for problem in problems}
        else:
            problems, wrong = [], set()
        problems += _conflicts(_explicit(given), wrong)
        if problems:
            raise ScenarioError(problems)
        if scenario.radio.range is None:
            radio = Radio.model_construct(_fields_set=set(), range=scenario.sensing.range)
            scenario.__dict__["radio"] = radio
        return scenario

    @classmethod
    def from_toml(cls, text: str, source: str = "") -> Self:
        """Read a scenario from TOML text; ``source`` names it in errors."""
        try:
            return cls.model_validate(tomllib.loads(text))
        except ScenarioError as error:
            raise ScenarioError(error.problems, source) from None
        except (ValueError, RecursionError) as error:
            raise FeasibeeError(f"{source or 'scenario'}: not TOML: {error}; mend it there") from None

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a scenario from a TOML file."""
        try:
            text = Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            why = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
            raise FeasibeeError(f"{path}: can't be read: {why}; name a scenario in TOML") from None
        return cls.from_toml(text, source=str(path))

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """Return this scenario with other values.

        Parameters
        ----------
        changes : mapping of str to value
            By dotted path, such as ``{"tasks.count": 50}``. What was left to its default stays so: a new
            ``sensing.range`` takes an unset ``radio.range`` along.
        """
        tables, problems = _changed(self.model_dump(exclude_unset=True), changes)
        try:
            changed = type(self).model_validate(tables)
        except ScenarioError as error:
            raise ScenarioError([*problems, *error.problems]) from None
        if problems:
            raise ScenarioError(problems)
        return changed

    def to_dict(self) -> dict[str, Any]:
        """Return the complete form as plain tables."""
        return self.model_dump()

    def to_toml(self) -> str:
        """Return the complete form as TOML; reading it gives an equal scenario."""
        return tomli_w.dumps(self.to_dict())

    @property
    def hash(self) -> str:
        """SHA-256 of the complete form: equal for equal scenarios, however they were written."""
        text = json.dumps(self.to_dict(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


def _changed(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Return nested tables with the values at some dotted paths replaced, and the paths that lead nowhere."""
    changed = {name: dict(table) for name, table in tables.items()}
    problems = []
    for path, value in changes.items():
        section, _, key = path.partition(".")
        if key:
            changed.setdefault(section, {})[key] = value
        else:
            rule = "isn't the path of a field"
            problems.append(Problem(path, value, rule, "write section.field, such as tasks.count"))
    return changed, problems


def _explicit(given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the raw values laid over the defaults, for the rules about several fields."""
    explicit: dict[str, dict[str, Any]] = {}
    for name, field in Scenario.model_fields.items():
        table = given.get(name, {})
        if isinstance(table, Section):
            table = table.model_dump(exclude_unset=True)
        explicit[name] = {
            **field.get_default(call_default_factory=True).model_dump(),
            **(table if isinstance(table, Mapping) else {}),
        }
    if explicit["radio"]["range"] is None:
        explicit["radio"]["range"] = explicit["sensing"]["range"]
    return explicit


def _conflicts(explicit: dict[str, dict[str, Any]], wrong: set[str]) -> Iterator[Problem]:
    """Find values that are fine alone but not together, leaving out those that are wrong by themselves."""

    def unfit(*paths: str) -> bool:
        return any(path in wrong or path.split(".")[0] in wrong for path in paths)

    side = explicit["arena"]["side"]
    for path in ("sensing.range", "radio.range"):
        section = path.split(".")[0]
        value = explicit[section]["range"]
        implied = path == "radio.range" and value == explicit["sensing"]["range"]
        if not unfit(path, "arena.side") and not implied and value > side / 2:
            rule = f"must be at most half the side of the torus, {side / 2:g} units"
            yield Problem(path, value, rule, "a larger range would reach round the torus: enlarge arena.side")
    speed = explicit["robots"]["speed"]
    if not unfit("robots.speed", "arena.side") and speed > side / 2:
        rule = f"must be at most half the side of the torus a step, {side / 2:g} units"
        yield Problem(
            "robots.speed", speed, rule, "a faster robot would seem to go backwards: enlarge arena.side"
        )


def _problem(details: ErrorDetails) -> Problem:
    """Say in our words what pydantic found."""
    path = ".".join(str(part) for part in details["loc"])
    field = _field(path)
    kind = details["type"]
    if kind == "extra_forbidden":
        return Problem(path, details["input"], "unknown key", _suggestion(path))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Problem(path, details["input"], "must be a table", f"write [{path}] and its fields below")
    rule = details["msg"]
    for theirs, ours in _WORDS.items():
        rule = rule.replace(theirs, ours)
    remedy = (
        f"the paper uses {_toml(field.default)}" if field is not None and field.default is not None else ""
    )
    return Problem(path, details["input"], rule, remedy or "leave it out for the default")


_WORDS = {
    "Input should be": "must be",
    "greater than or equal to": "≥",
    "less than or equal to": "≤",
    "greater than": ">",
    "less than": "<",
    "a valid integer": "a whole number",
    "a valid boolean": "true or false",
    "a valid ": "a ",
}


def _field(path: str) -> Any:
    section, _, key = path.partition(".")
    outer = Scenario.model_fields.get(section)
    return cast(type[Section], outer.annotation).model_fields.get(key) if outer and outer.annotation else None


def _suggestion(path: str) -> str:
    """Name the field that was most likely meant."""
    known = [
        f"{name}.{key}"
        for name, field in Scenario.model_fields.items()
        for key in cast(type[Section], field.annotation).model_fields
    ]
    names = known if "." in path else list(Scenario.model_fields)
    close = difflib.get_close_matches(path, names, 1, 0.6)
    section = path.split(".", maxsplit=1)[0]
    siblings = [name.split(".")[1] for name in known if name.startswith(f"{section}.")]
    if close:
        return f"did you mean {close[0]}?"
    if "." in path and siblings:
        return f"[{section}] has {', '.join(siblings)}"
    return f"the sections are {', '.join(Scenario.model_fields)}"


def _toml(value: object) -> str:
    return json.dumps(value)
