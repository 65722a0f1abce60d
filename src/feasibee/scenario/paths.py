"""Nested tables: read from TOML, and changed by dotted paths."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from feasibee.errors import FeasibeeError, Problem

DEEPEST = 8
"""Tables and lists that a path may lead through; robots.classes.0.skills.0 leads through four."""
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{4 * DEEPEST}}}")
"""A dotted key of so many parts takes tomllib a time and room that grow with their square."""


def toml_tables(text: str, source: str) -> dict[str, Any]:
    """Read tables from TOML; ``source`` names the text in errors.

    Raises
    ------
    FeasibeeError
        If it isn't TOML, or nested more deeply than any scenario or study.
    """
    try:
        if _LONG_KEY.search(text):
            raise RecursionError
        tables = tomllib.loads(text)
        _check_depth(tables)
    except RecursionError:
        raise FeasibeeError(f"{source}: nested too deeply; no table or list needs over {DEEPEST}") from None
    except ValueError as error:
        raise FeasibeeError(f"{source}: not TOML: {error}; mend it there") from None
    return tables


def _check_depth(tables: dict[str, Any]) -> None:
    """Raise a RecursionError if tables and lists are nested more deeply than `DEEPEST`."""
    level: list[Any] = [tables]
    for _ in range(DEEPEST + 1):
        inner = [each.values() if isinstance(each, dict) else each for each in level]
        level = [each for values in inner for each in values if isinstance(each, dict | list)]
    if level:
        raise RecursionError


def read_value(text: str) -> Any:
    """Read a value that somebody typed: TOML or else plain text."""
    try:
        return toml_value(text)
    except ValueError:
        return text.strip()


def toml_value(text: str) -> Any:
    """Read one value in TOML, with nothing before or after it.

    Between braces TOML allows neither a second line nor a comment; between brackets no brace may be closed.

    Raises
    ------
    ValueError
        If it isn't one.
    """
    try:
        braced, listed = tomllib.loads(f"it = {{ value = {text} }}"), tomllib.loads(f"it = [ {text}\n]")
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if braced.keys() != {"it"} or braced["it"].keys() != {"value"} or len(listed["it"]) != 1:
        raise ValueError("not one value")
    return braced["it"]["value"]


def value_at(tables: Any, path: str) -> Any:
    """Return the value at a dotted path through pydantic models, tables and tuples.

    Raises
    ------
    LookupError
        If the path leads nowhere. Attributes of a model that aren't fields are not found.
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
    if isinstance(value, BaseModel):
        if part not in type(value).model_fields:
            raise KeyError(part)
        return getattr(value, part)
    return value[place(part)] if isinstance(value, tuple) else value[part]


def with_changes(
    tables: Mapping[str, Any], changes: Mapping[str, Any]
) -> tuple[dict[str, Any], list[Problem]]:
    """Return nested tables with the values at some dotted paths replaced, and the paths that lead nowhere.

    A number in a path is a place in a list: ``robots.classes.0.count``.
    """
    changed = _open(tables)
    problems = []
    for path, value in changes.items():
        *way, last = path.split(".")
        if not (way or path == "preset") or "" in (*way, last) or len(way) > DEEPEST:
            rule = "isn't the path of a field"
            problems.append(Problem(path, value, rule, "write section.field, such as tasks.count"))
            continue
        try:
            table: Any = changed
            for part in way:
                table = _step_into(table, part)
            if isinstance(table, list):
                table[place(last)] = value
            else:
                table[last] = value
        except (AttributeError, LookupError, TypeError, ValueError):
            rule = "leads through something that isn't there"
            problems.append(Problem(path, value, rule, f"give {'.'.join(way)} first"))
    return changed, problems


def _open(value: Any) -> Any:
    """Return a copy of nested tables in which a place of any list can be changed."""
    if isinstance(value, Mapping):
        return {key: _open(each) for key, each in value.items()}
    return [_open(each) for each in value] if isinstance(value, tuple | list) else value


def place(part: str) -> int:
    """Return the place in a list that a part of a path names, from 0."""
    if not (part.isascii() and part.isdigit()):
        raise ValueError(part)
    return int(part)


def _step_into(table: Any, part: str) -> Any:
    """Return what is in a table or list, which has it from now on."""
    if isinstance(table, list):
        return table[place(part)]
    if table.get(part) is None:
        table[part] = {}
    return table[part]
