"""A page that simulates: markup, style, modules, the compiled world and a scenario in one HTML file."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from string import Template
from typing import Any, Final
from urllib.parse import quote

from feasibee.files import write_text
from feasibee.live.lane import why_fixed
from feasibee.live.packet import (
    MOST,
    check_scenario,
    packets_of,
    reached_of,
    variants_of,
    wasm_of,
    why_counted,
)
from feasibee.live.prediction import prediction_of
from feasibee.live.scene import scene_of
from feasibee.scenario.plugins import rule_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.flooding import flooded
from feasibee.simulation.lowering import unit_of

STATIC: Final = Path(__file__).parent / "static"
IMPORTED: Final = re.compile(r'(?m)^import [^;]+ from "\./(\w+)\.js";\n')
MARKUP: Final = Path(__file__).parent
"""Folder of the templates, which don't stand among the files that the live server gives."""


def page_of(scenario: Scenario, seed: int = 0, run: int = 0, name: str = "") -> str:
    """Return the page that begins with a scenario, a seed and a run, as HTML.

    Sliders change the scenario's numbers of robots and tasks and its strategy. ``name`` says what to call it,
    such as its file's name. Raise a ScenarioError if a page can't simulate the scenario, with all reasons,
    and a FeasibeeError if seed or run is out of range.
    """
    runs = Runs(1, seed, run)
    given = given_of(scenario, runs, variants_of(scenario))
    own = {"name": name, "prediction": prediction_of(scenario), "wasm": wasm_of(scenario)}
    return filled("page", "feasibee", "simulator", {**given, **own})


def filled(name: str, title: str, script: str, given: dict[str, Any]) -> str:
    """Return a page: markup and style of a name, a module and its imports, and what is given to it."""
    shell, body = (Template((MARKUP / f"{each}.html").read_text("utf-8")) for each in ("shell", name))
    parts = {each: _part(each) for each in ("transport", "legend", "terms", "theory")}
    icon = "data:image/svg+xml," + quote(_text("icon.svg"))
    return shell.substitute(
        title=title,
        icon=icon,
        body=body.substitute(parts, icon=icon),
        style=_text("base.css") + _text(f"{name}.css"),
        given=json.dumps(given, separators=(",", ":")).replace("<", "\\u003c"),
        script=joined(script),
    )


def _text(name: str) -> str:
    """Return the text of a file of the live page."""
    return (STATIC / name).read_text("utf-8")


def _part(name: str) -> str:
    """Return an element of the live page, by its id: it ends where the indentation is that of its start."""
    (found,) = re.finditer(rf'(?ms)^( *)<(\w+) id="{name}".*?^\1</\2>', _text("index.html"))
    return found[0]


def write_page(scenario: Scenario, out: Path, seed: int = 0, run: int = 0, name: str = "") -> None:
    """Write the page of `page_of` to a file; after an error, the previous file is unchanged."""
    write_text(out, page_of(scenario, seed, run, name))


def given_of(scenario: Scenario, runs: Runs, variants: Iterable[Scenario]) -> dict[str, Any]:
    """Return what world.js calls Given of a scenario and its variants by strategy, without the world.

    Raise a ScenarioError if a page can't simulate the scenario, with all reasons.
    """
    check_scenario(scenario)
    variants = [flooded(each) for each in variants]
    return {
        "version": version("feasibee"),
        "toml": scenario.to_toml(),
        "packets": packets_of(variants),
        "reached": reached_of(scenario),
        "strategies": list(map(_strategy_of, variants)),
        "threshold": scenario.decision.threshold,
        "most": {"robots": MOST["robots.count"], "tasks": MOST["tasks.count"]},
        "counted": why_counted(scenario),
        "legend": _legend_of(scenario),
        "settings": {
            "robots": scenario.robots.count,
            "tasks": scenario.tasks.count,
            "strategy": variants.index(scenario),
            "seed": str(runs.seed),
            "run": runs.first,
            "events": [each.model_dump(exclude_defaults=True) for each in scenario.events],
        },
        "lengths": {
            **scene_of(scenario),
            "changes": scenario.replace({"events": ()}).dynamic,  # without them, which may be taken out
            "robotClasses": [each.name for each in scenario.robots.classes],
        },
        "unit": [str(part) for part in unit_of(scenario).as_integer_ratio()],
        "run": {"steps": scenario.run.steps, "stops": scenario.run.stop_at_decision},
    }


def _strategy_of(variant: Scenario) -> dict[str, Any]:
    """Return what a page says of the strategy of a variant."""
    return {
        "name": variant.decision.strategy,
        "rule": rule_of(variant.manifest),
        "declares": variant.declares,
        "fixed": why_fixed(variant),
        "knows": variant.robots.know_count,
    }


def _legend_of(scenario: Scenario) -> dict[str, bool]:
    """Return which entries of the legend a scenario needs, of those that not all need."""
    stopped, byzantine, _ = scenario.faulty
    acts = dict.fromkeys(("free", "taken"), scenario.acts) | {"task": not scenario.acts}
    return {**acts, "done": bool(scenario.tasks.work), "stopped": stopped > 0, "liar": byzantine > 0}


def joined(name: str, seen: set[str] | None = None) -> str:
    """Return a module and all that it imports as one text, for what can't import; keep its default export."""
    seen = set() if seen is None else seen  # names of the modules before it
    seen.add(name)
    text = _text(f"{name}.js")
    before = [joined(each, seen) for each in IMPORTED.findall(text) if each not in seen]
    return "\n".join([*before, re.sub(r"(?m)^export (?!default)", "", IMPORTED.sub("", text))])
