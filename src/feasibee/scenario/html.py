"""The HTML that a notebook shows for a scenario: tables for light and dark pages, without scripts."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from typing import Any

from feasibee.model.codes import DECISIONS
from feasibee.scenario.feasibility import truth
from feasibee.scenario.fields import SECTIONS
from feasibee.scenario.picture import as_html, outlines_of, paint_plan
from feasibee.scenario.sections import Sections

LONGEST = 80
"""Number of characters of a value that are shown."""

STYLE = """<style>
.feasibee { font-size: .9em; line-height: 1.45; max-width: 60em; text-align: left; }
.feasibee.feasibee p { margin: .3em 0; }
.feasibee.feasibee details table { border-collapse: collapse; margin: .2em 0 .6em 1.1em; font-size: 1em; }
.feasibee.feasibee table tr td, .feasibee.feasibee table tr th { text-align: left; vertical-align: top;
  padding: .05em 1.2em .05em 0; border: 0; color: inherit; white-space: normal; }
.feasibee.feasibee .note { opacity: .75; }
.feasibee.feasibee summary { cursor: pointer; }
.feasibee.feasibee code { background: none; color: inherit; padding: 0; font-weight: inherit; }
.feasibee > img { display: block; width: 24em; max-width: 100%; height: auto; }
</style>"""
"""The class is written twice to have priority over the tables' style of notebooks."""


def framed(body: str) -> str:
    """Return HTML with the style of feasibee's output in notebooks."""
    return f'<div class="feasibee">{STYLE}{body}</div>'


def folded(title: str, body: str, unfold: bool = False) -> str:
    """Return HTML that is collapsed to its title until somebody clicks; ``title`` is HTML, too."""
    return f"<details{' open' if unfold else ''}><summary>{title}</summary>{body}</details>"


def show_scenario(
    scenario: Sections, tables: Mapping[str, Any], usual: Mapping[str, Mapping[str, Any]], digest: str
) -> str:
    """Return a scenario as HTML: a collapsed table per section, with differences from the paper emphasised.

    Parameters
    ----------
    scenario : Sections
        The scenario.
    tables, usual : mapping of str to mapping
        The complete forms of the scenario and of the paper's scenario; a list of tables becomes a section.
    digest : str
        The scenario's hash.
    """
    tables = {name: _as_table(table) for name, table in tables.items()}
    changed = {
        name: [key for key, value in table.items() if usual.get(name, {}).get(key) != value]
        for name, table in tables.items()
    }
    count = sum(map(len, changed.values()))
    differing = f"{count} field{'s' if count > 1 else ''} not as in the paper" if count else "as in the paper"
    when = " at the start" if scenario.dynamic else ""
    head = (
        f"<p><strong>Scenario</strong>: {scenario.robots.count} robots, {scenario.tasks.count} tasks, "
        f"{html.escape(scenario.decision.strategy)}; truth{when}: "
        f"<strong>{DECISIONS[int(truth(scenario))]}</strong>; "
        f"{differing}; <code>{html.escape(digest[:12])}</code></p>"
    )
    sections = [
        folded(_title(name, table, changed[name]), _rows(name, table, changed[name]))
        for name, table in tables.items()
    ]
    return framed(head + _drawn(scenario) + "".join(sections))


def _drawn(scenario: Sections) -> str:
    """Return the plan of a scenario as an image on white; empty without a place."""
    if scenario.plan is None:
        return ""
    from PIL import Image, ImageFont, ImageOps

    width, height = (round(1440 * side / max(scenario.arena.size)) for side in scenario.arena.size)
    ground = Image.new("RGB", (width, height), "#FFFFFF")
    paint_plan(ground, scenario, ImageFont.load_default(45))
    zones = [f"zone {each.name}" for each in outlines_of(scenario)]
    return as_html(ImageOps.expand(ground, 8, "#1F2328").reduce(2), ", ".join(["Floor plan", *zones]))


def _as_table(table: Any) -> Mapping[str, Any]:
    """Return a table; of a list, its entries by number."""
    return table if isinstance(table, Mapping) else {str(k): each for k, each in enumerate(table)}


def _title(name: str, table: Mapping[str, Any], changed: list[str]) -> str:
    """Return a section's name, followed by the fields that differ from the paper."""
    listed = ", ".join(f"<strong>{_code(f'{key} = {_shown(table[key])}')}</strong>" for key in changed)
    return f"{html.escape(name)}{f': {listed}' if listed else ''}"


def _rows(name: str, table: Mapping[str, Any], changed: list[str]) -> str:
    rows, fields = [], SECTIONS[name].model_fields if name in SECTIONS else {}
    for key, value in table.items():
        field = _code(f"{key} = {_shown(value)}")
        field = f"<strong>{field}</strong>" if key in changed else field
        note = (fields[key].description or "") if key in fields else ""
        rows.append(f"<tr><td>{field}</td><td class='note'>{html.escape(note)}</td></tr>")
    return f"<table>{''.join(rows)}</table>"


def _code(text: str) -> str:
    return f"<code>{html.escape(text)}</code>"


def _shown(value: Any) -> str:
    """Return a value as JSON, shortened if it is long."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
