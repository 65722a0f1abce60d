"""All fields of a scenario as controls of the page, derived from the scenario's JSON Schema."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Final

from feasibee.scenario.paths import inline_toml, read_value
from feasibee.scenario.plugins import registered
from feasibee.scenario.scenario import Scenario

EVENTS: Final = "events"
"""The only field that is no part of a section, and a list."""
STRATEGY: Final = "decision.strategy"


@cache
def form() -> list[dict[str, Any]]:
    """Return the sections of a scenario with their fields, in the order of its complete form.

    Each field has ``path``, ``name``, ``note`` and ``kind``: ``"number"``, ``"integer"``, ``"quantity"``
    (also with a unit), ``"boolean"``, ``"choice"`` (with ``choices``), or ``"value"``, which is typed as
    TOML. ``nullable`` says whether the field may be unset. The choices of a strategy are those of other
    packages; a page knows which built-in ones go with its scenario.
    """
    schema = Scenario.model_json_schema()
    alone = {"controller": "preset", EVENTS: EVENTS}
    sections = {name: [_field(path, schema["properties"][path])] for name, path in alone.items()}
    for name, each in schema["properties"].items():
        part = schema["$defs"].get(each.get("$ref", "").rpartition("/")[2], {})
        if found := part.get("properties"):
            sections[name] = [_field(f"{name}.{key}", field) for key, field in found.items()]
    return [{"name": name, "fields": fields} for name, fields in sections.items()]


def typed(path: str, value: Any) -> Any:
    """Return the value of a field that somebody typed on the page: text of some fields is TOML."""
    kinds = {field["path"]: field["kind"] for section in form() for field in section["fields"]}
    return read_value(value) if isinstance(value, str) and kinds.get(path) in ("quantity", "value") else value


def shown(value: Any) -> Any:
    """Return the value of a field as the page shows it: other values than numbers and words as TOML."""
    return value if isinstance(value, str | int | float | None) else inline_toml(value)


def _field(path: str, part: Mapping[str, Any]) -> dict[str, Any]:
    """Return the control of a field by its part of the schema."""
    given = part.get("anyOf", [part])
    kinds = [each for each in given if each.get("type") != "null"]
    name = path.rpartition(".")[2].replace("_", " ")
    found = {"path": path, "name": name, "note": part.get("description", "")}
    found["nullable"] = len(kinds) < len(given)
    only = kinds[0] if len(kinds) == 1 else {}
    choices = registered() if path == STRATEGY else only.get("enum")
    if choices is not None:
        return found | {"kind": "choice", "choices": choices}
    kind = "quantity" if isinstance(only.get("type"), list) else only.get("type")
    return found | {"kind": kind if kind in ("number", "integer", "quantity", "boolean") else "value"}
