"""Words and HTML by ``templates/``; a scenario as HTML in notebooks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from feasibee.base.codes import DECISIONS
from feasibee.scenario.feasibility import truth
from feasibee.scenario.fields import SECTIONS
from feasibee.scenario.picture import encoded, outlines_of, paint_plan
from feasibee.scenario.sections import Sections

if TYPE_CHECKING:
    from jinja2 import Environment
    from pydantic.fields import FieldInfo

LONGEST = 80
"""Number of characters of a value that are shown."""


def render(template: str, **values: Any) -> str:
    """Return a file of ``templates/`` with values filled in; in HTML, texts are escaped."""
    return _environment().get_template(template).render(values)


@cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

    return Environment(
        loader=PackageLoader("feasibee"),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def show_scenario(scenario: Any) -> str:
    """Return a `Scenario` as HTML: a collapsed table per section, with differences from the paper emphasised.

    A list of tables is a section, too.
    """
    usual = type(scenario)().to_dict()
    sections = {name: _rows(name, table, usual.get(name, {})) for name, table in scenario.to_dict().items()}
    return render(
        "scenario.html",
        scenario=scenario,
        sections=sections,
        count=sum(row["changed"] for rows in sections.values() for row in rows),
        truth=DECISIONS[int(truth(scenario))],
        plan=_drawn(scenario),
    )


def _drawn(scenario: Sections) -> dict[str, str] | None:
    """Return the plan of a scenario as an image on white, and what it shows; None without a place."""
    if scenario.plan is None:
        return None
    from PIL import Image, ImageFont, ImageOps

    width, height = (round(1440 * side / max(scenario.arena.size)) for side in scenario.arena.size)
    ground = Image.new("RGB", (width, height), "#FFFFFF")
    paint_plan(ground, scenario, ImageFont.load_default(45))
    zones = [f"zone {each.name}" for each in outlines_of(scenario)]
    picture = ImageOps.expand(ground, 8, "#1F2328").reduce(2)
    return {"text": ", ".join(["Floor plan", *zones]), "data": encoded(picture)}


def _rows(name: str, table: Any, usual: Mapping[Any, Any]) -> list[dict[str, Any]]:
    """Return the fields of a section, or the entries of a list by number, as they are shown."""
    fields: Mapping[Any, FieldInfo] = SECTIONS[name].model_fields if name in SECTIONS else {}
    return [
        {
            "text": f"{key} = {_shown(value)}",
            "changed": usual.get(key) != value,
            "note": (fields[key].description or "") if key in fields else "",
        }
        for key, value in (table.items() if isinstance(table, Mapping) else enumerate(table))
    ]


def _shown(value: Any) -> str:
    """Return a value as JSON, shortened if it is long."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
