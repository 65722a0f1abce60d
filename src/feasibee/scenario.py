"""Scenario: all that defines a swarm and its world, checked, frozen, in TOML, with a hash.

A short text resolves to one complete form, which is hashed, stored and run. The defaults are the paper's.
"""

from __future__ import annotations

import copy
import difflib
import hashlib
import json
import math
import tomllib
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, cast

import tomli_w
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from feasibee.changes import with_changes
from feasibee.display import show_scenario
from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.feasibility import truth
from feasibee.files import read_text
from feasibee.points import read_points
from feasibee.presets import PRESETS, with_preset
from feasibee.rules import conflicts
from feasibee.sections import (
    Arena,
    Decision,
    Faults,
    Radio,
    Robots,
    Run,
    Section,
    Sensing,
    Tasks,
    Walk,
    strategy_of,
)
from feasibee.strategies.contract import Strategy
from feasibee.vocabulary import exact


class Scenario(BaseModel):
    """A swarm, its world and its controller; the defaults are the paper's.

    Parameters
    ----------
    arena, robots, tasks, walk, sensing, radio, decision, faults, run : mapping or section, optional
        What differs from the paper, such as ``tasks={"count": 50}``.
    preset : str, optional
        A public controller of the field, whose values stand in for the paper's: ``"valentini-2016"``,
        ``"minimize-surprise"`` or ``"subcdm-2025"``.

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

    preset: Literal[*PRESETS] | None = Field(  # type: ignore[valid-type]
        None, exclude=True, description="A public controller whose values stand in for the paper's."
    )
    arena: Arena = Arena()
    robots: Robots = Robots()
    tasks: Tasks = Tasks()
    walk: Walk = Walk()
    sensing: Sensing = Sensing()
    radio: Radio = Field(default_factory=Radio)  # not a default in the schema: it depends on sensing
    decision: Decision = Decision()
    faults: Faults = Faults()
    run: Run = Run()
    _strategy: Strategy = PrivateAttr()

    if TYPE_CHECKING:  # pydantic takes a table for a section, which its derived signature doesn't say

        def __init__(
            self,
            *,
            preset: str | None = ...,
            arena: Arena | Mapping[str, Any] = ...,
            robots: Robots | Mapping[str, Any] = ...,
            tasks: Tasks | Mapping[str, Any] = ...,
            walk: Walk | Mapping[str, Any] = ...,
            sensing: Sensing | Mapping[str, Any] = ...,
            radio: Radio | Mapping[str, Any] = ...,
            decision: Decision | Mapping[str, Any] = ...,
            faults: Faults | Mapping[str, Any] = ...,
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
        given, places, problems = _with_points(with_preset(given))
        try:
            scenario = handler(given)
        except ValidationError as error:
            problems += [_problem(details) for details in error.errors()]
        problems += conflicts(_explicit(given), given, places, {problem.path for problem in problems})
        if problems:
            raise ScenarioError(problems)
        scenario._resolve()
        return scenario

    def _resolve(self) -> None:
        """Fill in what follows from other fields, without marking it as set."""
        self.__dict__["preset"] = None  # its values are in their places: it is no other scenario without
        if self.radio.range is None:
            self._put("radio", range=self.sensing.range)
        self._strategy = strategy_of(self.decision.strategy)
        parameters = {**self.strategy.parameters, **self.decision.parameters}
        self._put("decision", parameters={name: float(value) for name, value in parameters.items()})
        for name in ("robots", "tasks"):
            section = getattr(self, name)
            if section.classes:
                self._put(name, count=sum(each.count for each in section.classes))
            elif section.placement == "points":
                self._put(name, count=len(section.points))

    def _put(self, name: str, **values: Any) -> None:
        section = getattr(self, name)
        changed = section.model_construct(_fields_set=section.model_fields_set, **{**dict(section), **values})
        self.__dict__[name] = changed

    def __hash__(self) -> int:
        return hash(self.hash)

    @property
    def strategy(self) -> Strategy:
        """How opinions are rated, told and chosen; a file as it was when the scenario was made."""
        return self._strategy

    def counted(self, step: int) -> int:
        """Return over how many robots the decision is taken: the honest that still work (model.md 6.6)."""
        left = count = self.robots.count
        faulty = []
        for share in (self.faults.stopped, self.faults.byzantine):
            faulty.append(min(left, math.floor(exact(share) * count + Fraction(1, 2))))
            left -= faulty[-1]
        return count - faulty[1] - (faulty[0] if step >= self.faults.stop_step else 0)

    @classmethod
    def from_toml(cls, text: str, source: str = "") -> Self:
        """Read a scenario from TOML text; ``source`` names it in errors."""
        try:
            return cls.from_tables(tomllib.loads(text), Path(source).parent if source else None)
        except ScenarioError as error:
            raise ScenarioError(error.problems, source) from None
        except (ValueError, RecursionError) as error:
            raise FeasibeeError(f"{source or 'scenario'}: not TOML: {error}; mend it there") from None

    @classmethod
    def from_tables(cls, tables: Mapping[str, Any], folder: Path | None = None) -> Self:
        """Make a scenario of tables; files that they name are found from ``folder``."""
        given = copy.deepcopy(dict(tables))
        for name, key, suffix in (
            ("robots", "points", ""),
            ("tasks", "points", ""),
            ("decision", "strategy", ".py"),
        ):
            table = given.get(name)
            if (
                folder
                and isinstance(table, dict)
                and isinstance(table.get(key), str)
                and table[key].endswith(suffix)
            ):
                table[key] = str(folder / table[key])
        return cls.model_validate(given)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a scenario from a TOML file."""
        return cls.from_toml(read_text(path, "a scenario in TOML"), source=str(path))

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """Return this scenario with other values.

        Parameters
        ----------
        changes : mapping of str to value
            By dotted path, such as ``{"tasks.count": 50}``. What was left to its default stays so: a new
            ``sensing.range`` takes an unset ``radio.range`` along.
        """
        tables, problems = with_changes(self.model_dump(exclude_unset=True), changes)
        try:
            changed = type(self).model_validate(tables)
        except ScenarioError as error:
            raise ScenarioError([*problems, *error.problems]) from None
        if problems:
            raise ScenarioError(problems)
        return changed

    def to_dict(self) -> dict[str, Any]:
        """Return the complete form as plain tables."""
        tables = self.model_dump()
        for name in ("robots", "tasks"):
            table = tables[name]
            del table["count" if table["classes"] else "classes"]
            if not table["points"]:
                del table["points"]
        return {
            name: {key: value for key, value in table.items() if value not in (None, {})}
            for name, table in tables.items()
        }

    def to_toml(self) -> str:
        """Return the complete form as TOML; reading it gives an equal scenario."""
        return tomli_w.dumps(self.to_dict())

    @property
    def hash(self) -> str:
        """SHA-256 of the complete form: equal for equal scenarios, however they were written.

        A strategy of the user's own counts by the text of its file, not by its path.
        """
        tables = self.to_dict()
        if self.strategy.source:
            tables["decision"]["strategy"] = self.strategy.source
        text = json.dumps(tables, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        notes = {
            f"{name}.{key}": each.description or ""
            for name, field in _sections().items()
            for key, each in cast(type[Section], field.annotation).model_fields.items()
        }
        return show_scenario(self.to_dict(), type(self)().to_dict(), notes, truth(self), self.hash)


def _with_points(
    given: Mapping[str, Any],
) -> tuple[dict[str, Any], dict[str, list[str]], list[Problem]]:
    """Read the files of points, so that the complete form holds the points themselves.

    Returns the tables, where each point of a section stands, and the problems.
    """
    tables, places, problems = dict(given), {}, []
    for name, section in (("robots", Robots), ("tasks", Tasks)):
        table = tables.get(name)
        if isinstance(table, section):
            table = table.model_dump(exclude_unset=True)
        if isinstance(table, Mapping) and isinstance(table.get("points"), str):
            points, places[name], found = read_points(table["points"], f"{name}.points")
            problems += found
            table = {**table, "points": points}
        if table is not None:
            tables[name] = table
    return tables, places, problems


def _explicit(given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the raw values laid over the defaults, for the rules about several fields."""
    explicit: dict[str, dict[str, Any]] = {}
    for name, field in _sections().items():
        table = given.get(name, {})
        if isinstance(table, Section):
            table = table.model_dump(exclude_unset=True)
        explicit[name] = {
            **field.get_default(call_default_factory=True).model_dump(),
            **(table if isinstance(table, Mapping) else {}),
        }
    if explicit["radio"]["range"] is None:
        explicit["radio"]["range"] = explicit["sensing"]["range"]
    for name in ("robots", "tasks"):
        given_table = given.get(name)
        counted = isinstance(given_table, Mapping) and "count" in given_table
        if explicit[name]["placement"] == "points" and not counted and not explicit[name]["classes"]:
            explicit[name]["count"] = len(explicit[name]["points"])
    return explicit


def _problem(details: ErrorDetails) -> Problem:
    """Say in our words what pydantic found."""
    path = ".".join(str(part) for part in details["loc"])
    field = _field(path)
    kind = details["type"]
    if kind == "extra_forbidden":
        return Problem(path, details["input"], "unknown key", _suggestion(path))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Problem(path, details["input"], "must be a table", f"write [{path}] and its fields below")
    if kind == "missing":
        return Problem(path, details["input"], "is missing", "write it beside what is there")
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
    "Dictionary should have at least 1 item after validation": "must name a skill",
    "Tuple should have at most": "must be at most",
    "items after validation": "classes",
}


def _field(path: str) -> Any:
    section, _, key = path.partition(".")
    outer = _sections().get(section)
    return cast(type[Section], outer.annotation).model_fields.get(key) if outer and outer.annotation else None


def _sections() -> dict[str, FieldInfo]:
    return {name: field for name, field in Scenario.model_fields.items() if name != "preset"}


def fields() -> list[str]:
    """Return the dotted paths of all fields of a scenario."""
    return [
        f"{name}.{key}"
        for name, field in _sections().items()
        for key in cast(type[Section], field.annotation).model_fields
    ]


def _suggestion(path: str) -> str:
    """Name the field that was most likely meant."""
    known = fields()
    names = known if "." in path else list(Scenario.model_fields)
    close = difflib.get_close_matches(path, names, 1, 0.6)
    section = path.split(".", maxsplit=1)[0]
    siblings = [name.split(".")[1] for name in known if name.startswith(f"{section}.")]
    if close:
        return f"did you mean {close[0]}?"
    if "." in path and siblings:
        return f"[{section}] has {', '.join(siblings)}"
    return f"the sections are {', '.join(_sections())}"


def _toml(value: object) -> str:
    return json.dumps(value)
