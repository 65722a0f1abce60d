"""A scenario as TOML text with the meaning and unit of each field in comments."""

from __future__ import annotations

import re
import textwrap
from typing import Final

from feasibee.scenario.fields import EVENT, SECTIONS, TABLES, field_of
from feasibee.scenario.paths import inline_toml, toml_text
from feasibee.scenario.scenario import Scenario

COMMENT: Final = textwrap.TextWrapper(
    100, initial_indent="# ", subsequent_indent="# ", break_long_words=False, break_on_hyphens=False
)
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
    if "." not in path:
        return (TABLES[path].__doc__ or "").partition("\n")[0] if path in TABLES else ""
    field = field_of(path)
    return (field.description or "") if field else ""
