"""A scenario as pages are given it: for the arena and its words, for the engine, and for the form."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from feasibee.base.errors import ScenarioError
from feasibee.engine.own import failures
from feasibee.live.form import EVENTS, shown
from feasibee.live.packet import MOST, check_scenario, packets_of, reached_of
from feasibee.robot.firmware import constant
from feasibee.scenario.feasibility import in_brief
from feasibee.scenario.fields import dimension_of, fields
from feasibee.scenario.picture import extent_of, outlines_of, picture_of
from feasibee.scenario.plugins import docstring_of, rule_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import in_brackets
from feasibee.simulation.flooding import flooded
from feasibee.simulation.lowering import unit_of
from feasibee.strategies import STRATEGIES

FARTHEST: Final = 1e6
"""Longest range where the arena doesn't limit it, in units."""
LONGEST: Final = 2000
"""Most characters of a field that isn't a number or a word, in the form of settings."""


def opened_of(scenario: Scenario, runs: Runs) -> dict[str, Any]:
    """Return what a page gets when it opens a scenario, but for the engine.

    Raise a ScenarioError if a page can't simulate the scenario, with all reasons.
    """
    return simulated_of(scenario, runs, variants_of(scenario)) | settings_of(scenario)


def simulated_of(scenario: Scenario, runs: Runs, variants: Iterable[Scenario]) -> dict[str, Any]:
    """Return what a page needs to simulate a scenario and its variants by strategy.

    Raise a ScenarioError if a page can't simulate the scenario, with all reasons.
    """
    check_scenario(scenario)
    variants = list(map(flooded, variants))
    return {
        **scene_of(scenario, runs, variants),
        "packets": packets_of(variants),
        "reached": reached_of(scenario),
        "patches": patches(scenario),
        "failures": failures() if scenario.strategy.source else {},
    }


def scene_of(scenario: Scenario, runs: Runs, variants: list[Scenario]) -> dict[str, Any]:
    """Return what a page shows of a scenario, of which it has these variants by strategy."""
    sides, walls, sensing = scenario.arena.size, scenario.arena.boundary == "walls", scenario.sensing
    half, most = min(sides) / 2, {"robots": MOST["robots.count"], "tasks": MOST["tasks.count"]}
    reach = FARTHEST if walls else half  # on a torus, farther things would be seen twice
    return {
        "toml": scenario.to_toml(),
        "strategies": list(map(_strategy_of, variants)),
        "threshold": scenario.decision.threshold,
        "most": most | {"sight": reach, "radio": reach, "speed": half},
        "counted": why_counted(scenario),
        "legend": _legend_of(scenario),
        "settings": {
            "robots": scenario.robots.count,
            "tasks": scenario.tasks.count,
            "strategy": variants.index(scenario),
            "seed": str(runs.seed),
            "run": runs.first,
            "events": [each.model_dump(exclude_defaults=True) for each in scenario.events],
            "sight": sensing.range,
            "radio": scenario.radio.range,
            "speed": scenario.robots.speed,
        },
        "lengths": {
            "size": list(sides),
            "walls": walls,
            "plan": _plan_of(scenario),
            "diameter": scenario.robots.diameter,
            "sight": sensing.range,
            "view": sensing.view,
            "radio": scenario.radio.range,
            "changes": scenario.replace({"events": ()}).dynamic,  # without them, which may be taken out
            "acts": scenario.acts,
            "robotClasses": [each.name for each in scenario.robots.classes],
            "taskClasses": [each.name for each in scenario.tasks.classes],
        },
        "unit": [str(part) for part in unit_of(scenario).as_integer_ratio()],
        "run": {"steps": scenario.run.steps, "stops": scenario.run.stop_at_decision},
    }


def settings_of(scenario: Scenario) -> dict[str, Any]:
    """Return what the form shows of a scenario: values and units of fields, walls, and the truth's proof.

    ``changed`` are the paths of fields that differ from a scenario without any. Values too long to edit are
    missing in ``fields``.
    """
    values, usual, place = _values(scenario), _values(Scenario()), scenario.place
    units = {path: each for path in fields() if (each := dimension_of(path)).unit}
    return {
        "fields": {path: each for path, each in values.items() if len(str(each)) <= LONGEST},
        "changed": [path for path, each in values.items() if each != usual.get(path)],
        "units": {p: each.unit + in_brackets(scenario, each, scenario.get(p)) for p, each in units.items()},
        "drawn": place.walls,
        "cell": place.map.cell if place.map else place.cell,
        "proof": in_brief(scenario),
        "seconds": scenario.units.seconds or 0,
    }


def _values(scenario: Scenario) -> dict[str, Any]:
    """Return the values of all fields by dotted path, as the form shows them."""
    tables: dict[str, Any] = scenario.to_dict()
    events = tables.pop(EVENTS, "")
    found = {f"{section}.{key}": value for section, table in tables.items() for key, value in table.items()}
    found |= {"robots.count": scenario.robots.count, "tasks.count": scenario.tasks.count, EVENTS: events}
    return {path: shown(value) for path, value in found.items()}


def variants_of(scenario: Scenario) -> Iterator[Scenario]:
    """Yield a scenario with each strategy with which a page can simulate it, and its robots' number known.

    The scenario's own replaces a built-in one of the same name in C.
    """
    for each in {constant(each): each for each in (*STRATEGIES.values(), scenario.strategy)}.values():
        if each == scenario.strategy:
            yield scenario
            continue
        known = scenario.robots.know_count or each.needs_count
        changes = {"decision.strategy": each.name, "decision.parameters": {}, "robots.know_count": known}
        try:
            changed = scenario.replace(changes)
            check_scenario(changed)
        except ScenarioError:
            continue
        yield changed


def why_counted(scenario: Scenario) -> str:
    """Return why a page can't change the numbers at the start; empty if it can."""
    robots, tasks = scenario.robots, scenario.tasks
    reasons = {
        "robots or tasks have classes": robots.classes or tasks.classes,
        "some robots are faulty": any(scenario.faulty),
        "their places are given": "points" in (robots.placement, tasks.placement),
        "robots need room": robots.avoid_collisions,
        "robots act": scenario.acts,
    }
    found = next((reason for reason, holds in reasons.items() if holds), "")
    return found and f"The numbers at the start are those of the scenario, since {found}"


def patches(scenario: Scenario) -> bool:
    """Return whether a page can change ranges and speed by itself.

    What else follows from them needs Python: ways behind walls and between bodies, when robots begin to act,
    what a narrow view sweeps, and which tasks get one name.
    """
    sensing = scenario.sensing
    narrow = sensing.view < 360 or sensing.position_error > 0
    return not (scenario.place.exists or scenario.robots.avoid_collisions or scenario.acts or narrow)


def why_fixed(scenario: Scenario) -> str:
    """Return why events can't change a world; empty if they can."""
    try:
        scenario.replace({EVENTS: [{"step": 1, "tasks": 1}]})
    except ScenarioError as error:
        return str(error.problems[0])
    return ""


def _strategy_of(variant: Scenario) -> dict[str, Any]:
    """Return what a page says of the strategy of a variant."""
    manifest = variant.manifest
    return {
        "name": manifest.name,
        "rule": rule_of(manifest),
        "declares": variant.declares,
        "fixed": why_fixed(variant),
        "knows": variant.robots.know_count,
        "judges": manifest.judges,
        "knowledge": manifest.knowledge,
        "byName": manifest.by_name,
        "forgets": manifest.forgets,
        **{name: docstring_of(manifest, name) for name in ("quality", "decide")},
    }


def _legend_of(scenario: Scenario) -> Mapping[str, bool]:
    """Return which entries of the legend a scenario needs, of those that not all need."""
    stopped, byzantine, _ = scenario.faulty
    acts = dict.fromkeys(("free", "taken"), scenario.acts) | {"task": not scenario.acts}
    return {**acts, "done": bool(scenario.tasks.work), "stopped": stopped > 0, "liar": byzantine > 0}


def _plan_of(scenario: Scenario) -> dict[str, Any] | None:
    """Return the plan of a scenario, if it has one: an image in base64, its size, and zones."""
    if scenario.plan is None:
        return None
    image = base64.b64encode(picture_of(scenario.plan)).decode()
    zones = [each._asdict() for each in outlines_of(scenario)]
    return {"image": image, "size": extent_of(scenario.plan), "zones": zones}
