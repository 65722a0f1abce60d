"""A scenario as TOML text with the meaning and unit of each field in comments."""

from __future__ import annotations

import re
import textwrap
import typing
from collections.abc import Mapping
from typing import Any, Final

from pydantic import BaseModel

from feasibee.scenario.fields import SECTIONS, Event
from feasibee.scenario.paths import inline_toml, toml_text
from feasibee.scenario.scenario import Scenario

COMMENT: Final = textwrap.TextWrapper(
    100, initial_indent="# ", subsequent_indent="# ", break_long_words=False, break_on_hyphens=False
)
TABLES: Final[Mapping[str, type[BaseModel]]] = {**SECTIONS, "events": Event}
"""The sections and the table of an event, by name."""
EVENT: Final = {"step": 500, "tasks": 15}
"""An event, as an example."""
HEADER: Final = re.compile(r"\[+([\w.-]+)\]+")
KEY: Final = re.compile(r"([\w-]+) = ")


def commented_toml(scenario: Scenario, *more: str) -> str:
    """Return all fields of a scenario as TOML text with comments; parsing it gives an equal scenario.

    TOML has no value for a field that is off: its line is a comment with an example. ``more`` are comments
    at the end.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> print("".join(commented_toml(Scenario()).splitlines(keepends=True)[:3]), end="")
    # The arena in which the robots move (model.md 1.1, 6.1).
    [arena]
    # Side of the square arena in units; or [width, height] of a rectangle.
    """
    complete = scenario.to_dict()
    table, said = "", set()
    lines: list[str] = []
    for line in [*toml_text(complete).splitlines(), ""]:
        header, key = HEADER.match(line), KEY.match(line)
        if not line and table in SECTIONS:  # fields that the section's table lacks, each with an example
            for name, field in SECTIONS[table].model_fields.items():
                if name not in complete[table]:
                    example = inline_toml((field.examples or [field.default])[0])
                    lines += [*COMMENT.wrap(field.description or ""), f"# {name} = {example}"]
        if header:
            table = header[1]
        path = table if header else f"{table}.{key[1]}".lstrip(".") if key else ""
        if path not in said:
            said.add(path)
            lines += COMMENT.wrap(meaning_of(path))
        lines.append(line)
    if "events" not in complete:
        lines += [*COMMENT.wrap(meaning_of("events")), "# [[events]]"]
        lines += [f"# {key} = {value}" for key, value in EVENT.items()]
    lines += [part for text in more for part in COMMENT.wrap(text)]
    return "".join(f"{line}\n" for line in lines)


def meaning_of(path: str) -> str:
    """Return what a section or field means, with its unit, by its dotted path; empty for a user's name."""
    name, *keys = path.split(".")
    model = TABLES.get(name)
    text = (model.__doc__ or "").partition("\n")[0] if model else ""
    for key in keys:
        field = model.model_fields.get(key) if model else None
        if field is None:
            return ""
        text, model = field.description or "", _table_of(field.annotation)
    return text


def _table_of(annotation: Any) -> type[BaseModel] | None:
    """Return the model of a field's tables, if it has any."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_table_of(each) for each in typing.get_args(annotation))
    return next((each for each in found if each is not None), None)
