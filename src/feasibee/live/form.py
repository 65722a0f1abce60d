"""All fields of a scenario as controls of the page, derived from the scenario's JSON Schema."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, Final

from feasibee.scenario.paths import inline_toml, read_value
from feasibee.scenario.scenario import Scenario

EVENTS: Final = "events"
"""The only field that is no part of a section, and a list."""
BOUNDS: Final = {
    "minimum": "min",
    "exclusiveMinimum": "min",
    "maximum": "max",
    "exclusiveMaximum": "max",
}
"""Bounds in a schema, and in HTML; only the server checks whether a bound itself is valid."""


@cache
def form() -> list[dict[str, Any]]:
    """Return the sections of a scenario with their fields, in the order of its complete form.

    Each field has ``path``, ``name``, ``note`` and ``kind``: ``"number"``, ``"integer"``, ``"boolean"``,
    ``"choice"`` (with ``choices``), or ``"value"``, which is typed as TOML. ``nullable`` says whether the
    field may be unset.
    """
    schema = Scenario.model_json_schema()
    parts = schema["$defs"]
    sections: list[dict[str, Any]] = [
        {"name": "controller", "fields": [_field("preset", schema["properties"]["preset"])]}
    ]
    sections.append({"name": EVENTS, "fields": [_field(EVENTS, schema["properties"][EVENTS])]})
    for name, each in schema["properties"].items():
        found = _resolved(each, parts).get("properties")
        if found:
            fields = [_field(f"{name}.{key}", part) for key, part in found.items()]
            sections.append({"name": name, "fields": fields})
    return sections


def typed(path: str, value: Any) -> Any:
    """Return the value of a field that somebody typed on the page: text of some fields is TOML."""
    kinds = {field["path"]: field["kind"] for section in form() for field in section["fields"]}
    return read_value(value) if isinstance(value, str) and kinds.get(path) == "value" else value


def shown(value: Any) -> Any:
    """Return the value of a field as the page shows it: other values than numbers and words as TOML."""
    return value if isinstance(value, str | int | float | None) else inline_toml(value)


def _resolved(part: Mapping[str, Any], parts: Mapping[str, Any]) -> Mapping[str, Any]:
    reference = part.get("$ref", "")
    resolved: Mapping[str, Any] = parts[reference.rsplit("/", 1)[1]] if reference else part
    return resolved


def _field(path: str, part: Mapping[str, Any]) -> dict[str, Any]:
    """Return the control of a field by its part of the schema."""
    given = part.get("anyOf", [part])
    kinds = [each for each in given if each.get("type") != "null"]
    name = path.rpartition(".")[2].replace("_", " ")
    found = {
        "path": path,
        "name": name,
        "note": part.get("description", ""),
        "nullable": len(kinds) < len(given),
    }
    return found | (dict(_control(kinds[0])) if len(kinds) == 1 else {"kind": "value"})


def _control(part: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    if "enum" in part:
        yield from {"kind": "choice", "choices": part["enum"]}.items()
    elif part.get("type") in ("number", "integer", "boolean"):
        yield "kind", part["type"]
        yield from ((html, part[bound]) for bound, html in BOUNDS.items() if bound in part)
    else:
        yield "kind", "value"
