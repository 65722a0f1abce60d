"""Nested tables: parse them from TOML, and read or change values by dotted paths."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import tomli_w

from feasibee.base.errors import FeasibeeError, Problem

DEEPEST = 8
"""Largest depth of nested tables and lists; robots.classes.0.skills.0 has depth 4."""
WHOLE = ("preset", "events")
"""What a scenario has besides sections with fields."""
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{4 * DEEPEST}}}")
"""Dotted keys of very many parts: tomllib needs time and memory that grow with their number squared."""
_OTHERS = {
    ".py": "use it as --set decision.strategy={}",
    **dict.fromkeys((".yaml", ".geojson"), "use it as --set place.map={}"),
}
"""Remedies by the suffix of a file that isn't a scenario but may be a part of one."""
_POINT = re.compile(r"\[\n +(-?[\d.e+-]+),\n +(-?[\d.e+-]+),\n +\]")
"""A point as tomli_w writes it within a list: each number on a line."""


def toml_tables(text: str, source: str) -> dict[str, Any]:
    """Parse TOML; ``source`` names the text in errors.

    Raise a FeasibeeError if the text isn't TOML, or is nested more than `DEEPEST` levels deep.
    """
    try:
        if _LONG_KEY.search(text):
            raise RecursionError
        tables = tomllib.loads(text)
        _check_depth(tables)
    except RecursionError:
        raise FeasibeeError(f"{source}: nested too deeply; use at most {DEEPEST} levels") from None
    except ValueError as error:
        remedy = _OTHERS.get(Path(source).suffix, "correct that line").format(source)
        raise FeasibeeError(f"{source}: not TOML: {error}; {remedy}") from None
    return tables


def _check_depth(tables: dict[str, Any]) -> None:
    """Raise a RecursionError if tables and lists are nested more than `DEEPEST` levels deep."""
    level: list[Any] = [tables]
    for _ in range(DEEPEST + 1):
        inner = [each.values() if isinstance(each, dict) else each for each in level]
        level = [each for values in inner for each in values if isinstance(each, dict | list)]
    if level:
        raise RecursionError


def read_value(text: str) -> Any:
    """Parse a value that a user typed: TOML, another number such as .5, or else plain text."""
    for parse in (toml_value, float):
        with suppress(ValueError):
            return parse(text)
    return text.strip()


def toml_value(text: str) -> Any:
    """Parse exactly one TOML value.

    The text is parsed twice: braces exclude a second line or comment, brackets exclude a closing brace. Raise
    a ValueError if the text isn't exactly one TOML value.
    """
    try:
        braced, listed = tomllib.loads(f"it = {{ value = {text} }}"), tomllib.loads(f"it = [ {text}\n]")
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if braced.keys() != {"it"} or braced["it"].keys() != {"value"} or len(listed["it"]) != 1:
        raise ValueError("not one value")
    return braced["it"]["value"]


def toml_text(tables: Mapping[str, Any]) -> str:
    """Return tables as TOML, with a point of a list on a line."""
    return _POINT.sub(r"[\1, \2]", tomli_w.dumps(tables))


def inline_toml(value: Any) -> str:
    """Return a value as TOML on one line."""
    if isinstance(value, Mapping):
        pairs = (f"{_key(key)} = {inline_toml(each)}" for key, each in value.items() if each is not None)
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(inline_toml, value))}]"
    return json.dumps(value, ensure_ascii=False)


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else json.dumps(key, ensure_ascii=False)


def value_at(tables: Any, path: str) -> Any:
    """Return the value at a dotted path through pydantic models, tables and tuples.

    Raise a LookupError if the path leads nowhere. Attributes of a model that aren't fields are not found.
    """
    value = tables
    for part in path.split("."):
        try:
            value = _within(value, part)
        except (IndexError, KeyError, TypeError, ValueError):
            raise LookupError(path) from None
    return value


def _within(value: Any, part: str) -> Any:
    """Return a field of a model, an item of a list or a value of a table."""
    fields = getattr(type(value), "model_fields", None)  # a name that needs no pydantic: the CLI loads this
    if fields is not None:
        if part not in fields:
            raise KeyError(part)
        return getattr(value, part)
    return value[place(part)] if isinstance(value, tuple) else value[part]


def with_changes(
    tables: Mapping[str, Any], changes: Mapping[str, Any]
) -> tuple[dict[str, Any], list[Problem]]:
    """Return a copy of nested tables with values replaced by dotted paths, and a problem per invalid path.

    A number in a path is an index in a list: ``robots.classes.0.count``.
    """
    changed = _open(tables)
    problems = []
    for path, value in changes.items():
        *way, last = path.split(".")
        if not (way or path in WHOLE) or "" in (*way, last) or len(way) > DEEPEST:
            rule = "isn't the path of a field"
            problems.append(Problem(path, value, rule, "write section.field, such as tasks.count"))
            continue
        try:
            table: Any = changed
            for part in way:
                table = _step_into(table, part)
            table[place(last) if isinstance(table, list) else last] = _open(value)  # the user's own stays
        except (AttributeError, LookupError, TypeError, ValueError):
            rule = f"can't be set: {'.'.join(way)} is missing or has no such field"
            problems.append(Problem(path, value, rule, f"set {'.'.join(way)} first"))
    return changed, problems


def _open(value: Any) -> Any:
    """Return a copy of nested tables with tuples as lists, so that their items can be changed."""
    if isinstance(value, Mapping):
        return {key: _open(each) for key, each in value.items()}
    return [_open(each) for each in value] if isinstance(value, tuple | list) else value


def place(part: str) -> int:
    """Return the index in a list, from 0, that a part of a path names."""
    if not (part.isascii() and part.isdigit()):
        raise ValueError(part)
    return int(part)


def _step_into(table: Any, part: str) -> Any:
    """Return an item of a list, or a value of a table; a missing value becomes an empty table."""
    if isinstance(table, list):
        return table[place(part)]
    if table.get(part) is None:
        table[part] = {}
    return table[part]
