"""Changes to nested tables by dotted paths."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from feasibee.errors import Problem


def read_value(text: str) -> Any:
    """Read a value that somebody typed: TOML or else plain text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text.strip()


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
        if not (way or path == "preset") or "" in (*way, last):
            rule = "isn't the path of a field"
            problems.append(Problem(path, value, rule, "write section.field, such as tasks.count"))
            continue
        try:
            table: Any = changed
            for part in way:
                table = _step_into(table, part)
            if isinstance(table, list):
                table[int(last)] = value
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


def _step_into(table: Any, part: str) -> Any:
    """Return what is in a table or list, which has it from now on."""
    if isinstance(table, list):
        return table[int(part)]
    if table.get(part) is None:
        table[part] = {}
    return table[part]
