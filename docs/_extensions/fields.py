"""Generate the tables of a scenario's fields from their definitions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import tomli_w
from docutils import nodes
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from feasibee.scenario.fields import Declare, Event, NewRadio, NewSensing, RobotClass, TaskClass
from feasibee.scenario.scenario import Scenario

LISTS = {"robots.classes": RobotClass, "tasks.classes": TaskClass, "events": Event}
"""Sections of which there may be several."""
TABLES = {"decision.declare": Declare, **LISTS, "events.sensing": NewSensing, "events.radio": NewRadio}
"""Nested sections, which the paper's scenario doesn't have."""


class ScenarioFields(SphinxDirective):
    """All fields, with one table per section."""

    def run(self) -> list[nodes.Node]:
        """Return the tables."""
        text = "\n".join(_lines())
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def _lines() -> Iterator[str]:
    schema = Scenario.model_json_schema()
    for name, field in Scenario.model_fields.items():
        if name == "preset":
            choices = _rule(schema["properties"][name])
            yield from _table("preset", [("preset", choices, "none", field.description or "")])
            continue
        section: Any = LISTS.get(name, field.annotation)
        yield from _section(name, section, schema)
        for path, table in TABLES.items():
            if path.startswith(f"{name}."):
                yield from _section(path, table, schema)


def _section(path: str, section: Any, schema: dict[str, Any]) -> Iterator[str]:
    properties = schema["$defs"][section.__name__]["properties"]
    title = f"[[{path}]]" if path in LISTS else f"[{path}]"
    rows = [
        (name, _rule(properties[name]), _default(f"{path}.{name}", field), field.description or "")
        for name, field in section.model_fields.items()
    ]
    yield from _table(title, rows, section.__doc__.strip().replace("model.md ", "[model](model.md) "))


def _table(title: str, rows: list[tuple[str, str, str, str]], about: str = "") -> Iterator[str]:
    """Yield the lines of a table in Markdown (MyST)."""
    name = title.strip("[]")
    yield from (f"({name}-fields)=", f"## `{title}`", "", about, "")
    yield from ("| field | allowed values | default | meaning |", "|---|---|---|---|")
    for field, rule, default, description in rows:
        yield f"| `{field}` | {rule} | {default} | {description} |"
    yield ""


def _default(path: str, field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    if path == "radio.range":
        return "`sensing.range`"
    default = field.get_default(call_default_factory=True)
    if default is None or default in ((), {}) or isinstance(default, BaseModel):
        return "none"
    return f"`{tomli_w.dumps({'x': default}).partition('=')[2].strip()}`"


def _rule(schema: dict[str, Any]) -> str:
    """Return the rule of a field's JSON Schema in words."""
    if "anyOf" in schema:
        return ", or ".join(_rule(each) for each in schema["anyOf"] if each.get("type") != "null")
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"] if value is not None)
    if "const" in schema:
        return f"`{schema['const']}`"
    if "$ref" in schema:
        return f"a table, [below](#{_place(schema['$ref'])})"
    kind = schema.get("type")
    if kind == "array":
        if schema.get("minItems") == schema.get("maxItems") == 2:
            is_place = "exclusiveMinimum" not in schema["prefixItems"][0]
            return "a pair `[x, y]`" if is_place else "two such numbers, `[width, height]`"
        if "items" not in schema:
            return "polygons"
        if schema["items"].get("type") == "array":
            pairs = "a list of pairs `[x, y]`"
            return pairs if "prefixItems" in schema["items"] else f"a list of polygons, each {pairs}"
        most = f" of {schema['maxItems']} at most" if "maxItems" in schema else ""
        return f"a list{most}, each {_rule(schema['items'])}"
    if kind == "object" and "additionalProperties" not in schema:
        return "the cells of such a map"
    if kind == "object":
        name, values = schema.get("propertyNames", {}).get("const"), _rule(schema["additionalProperties"])
        return f"`{{...}}` with {name} = {values}" if name else f"a table of names, each with {values}"
    words = {"number": "a number", "integer": "an integer", "boolean": "`true` or `false`"}
    of_units = ", or text with a unit" if isinstance(kind, list) else ""
    return words.get(kind[0] if of_units else str(kind), "text") + _bounds(schema) + of_units


def _place(reference: str) -> str:
    name = reference.rpartition("/")[2]
    return next(f"{path}-fields" for path, section in TABLES.items() if section.__name__ == name)


def _bounds(schema: dict[str, Any]) -> str:
    signs = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    if "maxLength" in schema:
        return f" of {schema['minLength']} to {schema['maxLength']} characters"
    parts = [f"{sign} {_number(schema[key])}" for key, sign in signs.items() if key in schema]
    return f" {' and '.join(parts)}" if parts else ""


def _number(value: float) -> str:
    return f"{int(value):,}" if value == int(value) else f"{value:g}"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("scenario-fields", ScenarioFields)
    return {"parallel_read_safe": True}
