"""Scenario: a swarm and its world as one validated, immutable value, read from TOML and identified by a hash.

Defaults, which are the paper's, complete a short text. The complete form is hashed, stored and simulated.
"""

from __future__ import annotations

import copy
import dataclasses
import difflib
import json
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import (
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import ErrorDetails

from feasibee.base.errors import (
    PROBLEMS_LIMIT,
    FeasibeeError,
    Problem,
    ScenarioError,
    UnknownFieldError,
    quoted,
)
from feasibee.base.files import read_text
from feasibee.scenario.conflicts import conflicts
from feasibee.scenario.fields import (
    EVENT,
    SECTIONS,
    Acting,
    Arena,
    Decision,
    Event,
    Faults,
    Place,
    Radio,
    Robots,
    Run,
    Sensing,
    Tasks,
    Units,
    Walk,
    field_of,
    fields,
    table_of,
)
from feasibee.scenario.paths import inline_toml, toml_tables, toml_text, value_at, with_changes
from feasibee.scenario.plugins import manifest_of, strategy_of
from feasibee.scenario.sections import Sections
from feasibee.scenario.shown import show_scenario
from feasibee.scenario.tables import (
    FILES,
    complete_form,
    given_tables,
    hash_of,
    with_files,
    with_names,
    without,
)
from feasibee.scenario.units import in_the_text, with_numbers
from feasibee.strategies.contract import Strategy

WORDS: Final = {
    "Input should be": "must be",
    "greater than or equal to": "≥",
    "less than or equal to": "≤",
    "greater than": ">",
    "less than": "<",
    "a valid integer": "a whole number",
    "a valid boolean": "true or false",
    "a valid tuple": "a list",
    "a valid ": "a ",
    "Dictionary should have at least 1 item after validation": "must name a skill",
    "Tuple should have at most": "must have at most",
    "items after validation": "entries",
}
"""Phrases of pydantic's messages, and their replacements."""
REMEDIES: Final = {"faulty": "use {count = 1} for one robot"}
"""What to do about the errors of some types of fields, by the type of the error."""
REMOVED: Final = {
    "decision.commit": "write decision.declare: the rule has another name",
    "sensing.memory": 'leave it out: with observation "unique", each exploration counts anew',
}
"""Fields of earlier versions, and what to do."""
EVENTS: Final[Mapping[str, Mapping[str, Any]]] = {
    **{key: {"step": 500, key: number} for key, number in (("robots", 5), ("task", 3), ("robot", 3))},
    "at": {**EVENT, "at": [5.0, 2.5]},
    "sensing": {"step": 500, "sensing": {"miss": 0.1}},
    "radio": {"step": 500, "radio": {"loss": 0.1}},
}
"""An event with each field that `EVENT` lacks, for remedies."""


def _located(folder: Path, name: str) -> str:
    return str(folder / name)


def problem_of(details: ErrorDetails) -> Problem:
    """Translate one of pydantic's errors."""
    path = ".".join(str(part) for part in details["loc"])
    kind = details["type"]
    if kind == "extra_forbidden":
        return Problem(path, details["input"], "unknown key", suggestion(path))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Problem(path, details["input"], "must be a table", _table(path))
    if kind == "missing":
        return Problem(path, details["input"], "is missing", f"add {path.rpartition('.')[2]} to this table")
    rule = details["msg"]
    for theirs, ours in WORDS.items():
        rule = rule.replace(theirs, ours)
    return Problem(path, details["input"], rule, REMEDIES.get(kind) or _remedy(path))


def _table(path: str) -> str:
    return _event(path) if path.startswith("events") else f"write [{path}] and its fields below"


def _event(path: str) -> str:
    """Return a remedy with an event that has the field at a path."""
    event = EVENTS.get((*path.split("."), "", "")[2], EVENT)
    return f"such as {{ {', '.join(f'{key} = {inline_toml(value)}' for key, value in event.items())} }}"


def _remedy(path: str) -> str:
    """Return a remedy with the field's default, unless it depends on other fields, or with an example."""
    name, *keys = path.split(".")
    if name == "events":
        return _event(path)
    field = field_of(path) or field_of(path.rpartition(".")[0])
    if field is not None and field.is_required():
        of_classes = field_of(f"{name}.{keys[0]}")
        if of_classes is None or not of_classes.examples:
            return "name its file in place of this table"
        return f"such as {keys[2]} = {inline_toml(of_classes.examples[0][0][keys[2]])}"
    if field is None or field.default is None or len(keys) > 1:
        return "leave it out for the default"
    return f"the paper uses {json.dumps(field.default)}"


def suggestion(path: str) -> str:
    """Return a remedy that names the field meant or, if none is similar, those of the section."""
    if path in REMOVED:
        return REMOVED[path]
    table, _, last = path.rpartition(".")
    field = field_of(table)
    inner = table_of(field.annotation) if field else None
    if inner and last not in inner.model_fields:
        alike = difflib.get_close_matches(last, inner.model_fields, 1)
        listed = f"the fields of {table} are {', '.join(inner.model_fields)}"
        return f"did you mean {table}.{alike[0]}?" if alike else listed
    written, _, rest = path.partition(".")
    section = next(iter(difflib.get_close_matches(written, ["preset", *SECTIONS, "events"], 1)), "")
    key = rest.partition(".")[0] or written
    own = SECTIONS[section].model_fields if section in SECTIONS else {}
    alike = [f"{section}.{key}"] if key in own else [name for name in fields() if name.endswith(f".{key}")]
    if not alike and rest:
        alike = [f"{section}.{name}" for name in difflib.get_close_matches(key, own, 1)]
    elif not alike and section:
        alike = [section]
    if rest and section == "events":
        return f"the fields of an event are {', '.join(Event.model_fields)}, {_event(path)}"
    if alike:
        return f"did you mean {' or '.join(alike)}?"
    if own:
        return f"the fields of [{section}] are {', '.join(own)}"
    return f"the sections are {', '.join(SECTIONS)}, and events"


def _again(kind: type[Scenario], given: tuple[Any, ...], flooding: int | None) -> Scenario:
    """Return the scenario that was pickled."""
    scenario = kind.from_tables(*given)
    return scenario if flooding is None else scenario.with_flooding(flooding)


class Scenario(Sections):
    """A swarm, its world and its controller; the defaults are the paper's.

    Parameters
    ----------
    arena, place, robots, tasks, walk, sensing, radio, decision, faults, run, units : mapping, optional
        Fields that differ from the paper, such as ``tasks={"count": 50}``.
    preset : str, optional
        Name of a published controller, whose values replace the paper's: ``"valentini-2016"``,
        ``"minimize-surprise"``, ``"ros2swarm-majority"`` or ``"ros2swarm-voter"``.

    Raises
    ------
    ScenarioError
        With all problems at once: unknown keys, wrong types, invalid values and combinations.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> Scenario(tasks={"count": 50}).tasks.count
    50
    """

    if TYPE_CHECKING:  # pydantic accepts a table for a section, which its derived signature doesn't show

        def __init__(
            self,
            *,
            preset: str | None = ...,
            arena: Arena | Mapping[str, Any] = ...,
            place: Place | Mapping[str, Any] = ...,
            robots: Robots | Mapping[str, Any] = ...,
            tasks: Tasks | Mapping[str, Any] = ...,
            walk: Walk | Mapping[str, Any] = ...,
            sensing: Sensing | Mapping[str, Any] = ...,
            radio: Radio | Mapping[str, Any] = ...,
            decision: Decision | Mapping[str, Any] = ...,
            faults: Faults | Mapping[str, Any] = ...,
            run: Run | Mapping[str, Any] = ...,
            acting: Acting | Mapping[str, Any] = ...,
            units: Units | Mapping[str, Any] = ...,
            events: Sequence[Event | Mapping[str, Any]] = ...,
        ) -> None: ...

    @model_validator(mode="wrap")
    @classmethod
    def _check(cls, given: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        """Raise the problems of single fields and of combinations together, or fill in the defaults."""
        if isinstance(given, cls):
            return given
        if not isinstance(given, Mapping):
            raise ScenarioError(
                [Problem("", given, "must be a table of sections", "run `feasibee show scenario` to see all")]
            )
        given, problems, texts = with_numbers(given_tables(given))
        given, unread = with_files(given)
        problems += unread
        wrong: set[tuple[Any, ...]] = {tuple(problem.path.split(".")) for problem in problems}
        try:
            scenario = handler(given)
        except ValidationError as error:
            found = error.errors(include_url=False, include_context=False)
            new = (details for details in found if tuple(map(str, details["loc"])) not in wrong)
            problems += map(problem_of, islice(new, PROBLEMS_LIMIT))
            wrong |= {details["loc"][:2] for details in found}
            scenario = handler(without(given, wrong))
        scenario.__dict__["_texts"] = texts
        scenario.resolve(wrong, partial(manifest_of, **(info.context or {})))
        problems += islice(conflicts(scenario, given, partly=bool(wrong)), PROBLEMS_LIMIT)
        if problems:
            raise ScenarioError(in_the_text(each, texts) for each in problems)
        return scenario

    def __hash__(self) -> int:
        return hash(self.hash)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle with the text of the strategy's file, which may differ on another machine."""
        source, trusted = self.manifest.source or None, self.manifest.trusted
        return _again, (type(self), (self._given(), None, source, trusted), self.flooding)

    @property
    def strategy(self) -> Strategy:
        """Functions that rate, disseminate and choose opinions.

        The first access runs the text that a user's file had when the scenario was made.
        """
        return strategy_of(self._manifest)

    def with_trust(self) -> Self:
        """Return this scenario with permission to run its strategy's text, whatever its origin."""
        trusted = self.model_copy()
        trusted._manifest = dataclasses.replace(self.manifest, trusted=True)
        return trusted

    def with_flooding(self, steps: int) -> Self:
        """Return this scenario with the step by which names flood its place (model.md 6.20.14)."""
        timed = self.model_copy()
        timed.__dict__["_flooding"] = steps
        return timed

    @property
    def declares(self) -> bool:
        """Whether robots declare, by their strategy or by votes (model.md 6.14, 6.15)."""
        return self.manifest.declares or self.decision.declare is not None

    @property
    def gives_probability(self) -> bool:
        """Whether robots are asked at the end how probable *feasible* is (model.md 6.15.9)."""
        classes = self.robots.classes or self.tasks.classes
        return self.manifest.gives_probability and not (classes or self.dynamic)

    def counted(self, step: int) -> int:
        """Return the number of robots that count in the decision: honest and working (model.md 6.6)."""
        stopped, byzantine, _ = self.faulty
        return self.robots.count - byzantine - (stopped if step >= self.faults.stop_step else 0)

    @classmethod
    def from_toml(cls, text: str, source: str = "") -> Self:
        """Parse a scenario from TOML text; ``source`` names the text in errors."""
        if not isinstance(text, str):
            raise FeasibeeError(
                f"text = {quoted(text)}: must be TOML text; to read a file, use Scenario.read"
            )
        tables = toml_tables(text, source or "scenario")
        try:
            return cls.from_tables(tables, Path(source).parent if source else None)
        except ScenarioError as error:
            raise ScenarioError(error.problems, source) from None

    @classmethod
    def from_tables(
        cls,
        tables: Mapping[str, Any],
        folder: Path | None = None,
        source: str | None = None,
        trusted: bool = True,
    ) -> Self:
        """Validate nested tables as a scenario.

        Parameters
        ----------
        tables : mapping
            Sections and their fields.
        folder : path, optional
            Folder of the files that the tables name; by default the working folder.
        source : str, optional
            Stored text of the strategy's file; by default the file is read.
        trusted : bool
            Whether the stored text may be run even if it differs from the user's own file at that path.
        """
        if not isinstance(tables, Mapping):
            return cls.model_validate(tables)
        given = copy.deepcopy(dict(tables))
        for path in FILES:
            name, key = path.split(".")
            table: Any = given.get(name)
            if folder and isinstance(table, dict) and key in table:
                table[key] = with_names(path, table[key], partial(_located, folder))
        return cls.model_validate(given, context={"source": source, "trusted": trusted})

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a scenario from a TOML file."""
        smaller = "one that names a CSV file for its points"
        return cls.from_toml(read_text(path, "a scenario in TOML", smaller=smaller), source=str(path))

    def get(self, path: str) -> Any:
        """Return the value of a field, or a whole section, by its dotted path.

        Parameters
        ----------
        path : str
            Such as ``"tasks.count"``; a number is a place in a list: ``"robots.classes.0.count"``.

        Raises
        ------
        UnknownFieldError
            If the scenario has no such field.

        Examples
        --------
        >>> from feasibee import Scenario
        >>> Scenario().get("tasks.count")
        20
        """
        try:
            return value_at(self, path)
        except (AttributeError, LookupError):
            rule = "isn't the path of a field"
            raise UnknownFieldError(f"{quoted(path)}: {rule}; {suggestion(str(path))}") from None

    def _given(self) -> dict[str, Any]:
        """Return the fields that were set, with their texts, which new sizes of units convert anew."""
        return with_changes(self.model_dump(exclude_unset=True), self.__dict__["_texts"])[0]

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """Return a scenario with some values replaced.

        Parameters
        ----------
        changes : mapping of str to value
            New values by dotted path, such as ``{"tasks.count": 50}``. Unset fields keep following their
            defaults: an unset ``radio.range`` follows a new ``sensing.range``. The text of a strategy's file
            stays the same, unless ``decision.strategy`` is among the changes.
        """
        if not isinstance(changes, Mapping) or not all(isinstance(path, str) for path in changes):
            rule = "must be a mapping of dotted paths to values"
            raise ScenarioError([Problem("changes", changes, rule, 'such as {"tasks.count": 50}')])
        keeps = "decision.strategy" not in changes and self.manifest.source
        kept = {"source": self.manifest.source, "trusted": self.manifest.trusted} if keeps else None
        tables, problems = with_changes(self._given(), changes)
        try:
            changed = type(self).model_validate(tables, context=kept)
        except ScenarioError as error:
            raise ScenarioError([*problems, *error.problems]) from None
        if problems:
            raise ScenarioError(problems)
        return changed

    def to_dict(self) -> dict[str, Any]:
        """Return the complete form as nested dicts."""
        return complete_form(self.model_dump())

    def to_toml(self) -> str:
        """Return the complete form as TOML text; parsing it gives an equal scenario."""
        return toml_text(self.to_dict())

    @property
    def hash(self) -> str:
        """SHA-256 of the complete form in hexadecimal: equal for equal scenarios, however they were written.

        A user's own strategy enters with the text of its file, not with its path.
        """
        found: str | None = self.__dict__.get("_hash")
        if found is None:
            found = self.__dict__["_hash"] = hash_of(self.to_dict(), self.manifest.source)
        return found

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy, as pydantic does; with ``update``, the copy computes its own hash."""
        copied = super().model_copy(update=update, deep=deep)
        if update:
            copied.__dict__.pop("_hash", None)
            copied.__dict__.pop("_flooding", None)
            copied.__dict__["_texts"] = {}
        return copied

    def _repr_html_(self) -> str:
        """Return the scenario as HTML for notebooks."""
        return show_scenario(self)
