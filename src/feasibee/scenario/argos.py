"""A scenario as an experiment of ARGoS3, for the controller and loop functions of `examples/argos`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np

from feasibee.errors import Problem, ScenarioError
from feasibee.model.codes import exact
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import ARGOS, unsupported

FOOTBOT_DIAMETER: Final = 0.170073516
"""Diameter of ARGoS's foot-bot, in metres."""
LIBRARY: Final = "build/libfeasibee_argos"
"""Where `examples/argos` builds controller and loop functions, from its folder."""
BODY_TICKS: Final = 10
"""Ticks per step of robots with bodies: proximity is sensed ten times a second."""
POINT_TICKS: Final = 2
"""Ticks per step of points: one to drive, one to turn."""
WALL: Final = 0.1
"""Thickness of a wall, in metres."""
MOST_HEARD: Final = 1024
"""Length of the inbox in `examples/argos/mind.c`."""
LARGEST: Final = 65_535
"""Largest whole number of 16 bits, as which the C header keeps numbers of steps and messages."""


def argos_text(scenario: Scenario) -> str:
    """Return a scenario as an .argos file for `examples/argos`.

    One unit is the foot-bot's diameter divided by ``robots.diameter``; one step is one second.

    Parameters
    ----------
    scenario : Scenario
        A torus or walls with robots that are points, or walls and robots with bodies
        (``robots.avoid_collisions``). Bodies touch as ARGoS's physics has it.

    Raises
    ------
    ScenarioError
        If the example can't express the scenario, with all the reasons.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> print(argos_text(Scenario(tasks={"count": 10})).splitlines()[0])
    <argos-configuration>
    """
    problems = list(_problems(scenario))
    if problems:
        raise ScenarioError(problems)
    root = ElementTree.Element("argos-configuration")
    unit = FOOTBOT_DIAMETER / scenario.robots.diameter
    scale = (
        f" Made by `feasibee scenario`. 1 unit = {_short(unit)} m, 1 step = 1 s. Run it in examples/argos. "
    )
    root.append(ElementTree.Comment(scale))  # "to argos" is missing: a comment can't hold two hyphens
    for name, content in _experiment(scenario, unit).items():
        _add(root, name, content)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _problems(scenario: Scenario) -> Iterator[Problem]:
    """Yield what the example can't express."""
    yield from unsupported(scenario, ARGOS, "can't be exported to ARGoS: the example has only the default")
    if scenario.robots.avoid_collisions and scenario.arena.boundary == "torus":
        rule = "bodies need walls: ARGoS has no torus"
        remedy = 'set arena.boundary = "walls", or robots.avoid_collisions = false'
        yield Problem("arena.boundary", "torus", rule, remedy)
    if scenario.plan and not scenario.robots.avoid_collisions:
        rule = "must be true in a place: ARGoS's points have no boxes"
        yield Problem("robots.avoid_collisions", False, rule, "set robots.avoid_collisions = true")
    if scenario.robots.count > MOST_HEARD:
        rule = f"must be ≤ {MOST_HEARD:,}, the length of an inbox in examples/argos"
        yield Problem("robots.count", scenario.robots.count, rule, f"use 1 to {MOST_HEARD}")
    yield from _decision_problems(scenario)


def _decision_problems(scenario: Scenario) -> Iterator[Problem]:
    """Yield what the C header, or its use in the example, can't express of [decision]."""
    decision, manifest = scenario.decision, scenario.manifest
    if manifest.knowledge or manifest.source:
        rule = "can't be exported to ARGoS: the example has built-in strategies that pass on opinions"
        yield Problem("decision.strategy", decision.strategy, rule, 'such as decision.strategy = "dmmd"')
    for key in ("dissemination_floor", "quality_floor"):
        yield from _too_large(f"decision.{key}", getattr(decision, key), 0)
    if _listens_for(scenario) > LARGEST:
        rule = f"last must be ≤ {LARGEST} in ARGoS"
        yield Problem("decision.listen", decision.listen, rule, 'use "dissemination"')
    if decision.declare is None:
        return
    for key in ("rounds", "heard"):
        yield from _too_large(f"decision.declare.{key}", getattr(decision.declare, key), 1)
    if 10_000 % exact(decision.declare.quorum).denominator:
        rule = "must have at most 4 decimals in ARGoS"
        nearest = f"use {round(decision.declare.quorum, 4)}"
        yield Problem("decision.declare.quorum", decision.declare.quorum, rule, nearest)


def _too_large(path: str, value: int, least: int) -> Iterator[Problem]:
    if value > LARGEST:
        yield Problem(path, value, f"must be ≤ {LARGEST} in ARGoS", f"use {least} to {LARGEST}")


def _experiment(scenario: Scenario, unit: float) -> dict[str, Any]:
    """Return the elements of the experiment by name: attributes are values, further elements tables."""
    bodies = scenario.robots.avoid_collisions
    ticks = BODY_TICKS if bodies else POINT_TICKS
    # with more than one iteration, a foot-bot as a point goes one of them per tick
    engine = {"dynamics2d": {}} if bodies else {"pointmass3d": {"iterations": 1}}
    cells = (min(200, max(1, math.floor(side / scenario.radio.range))) for side in scenario.arena.size)
    grid = ",".join(map(str, (*cells, 1)))  # its cells are about as large as the radio's range
    return {
        "framework": {
            "system": {"threads": 0},
            "experiment": {"length": 0, "ticks_per_second": ticks, "random_seed": 1},
        },
        "controllers": {"feasibee_controller": _controller(scenario, unit, ticks)},
        "loop_functions": _loop_functions(scenario, unit),
        "arena": _arena(scenario, unit),
        "physics_engines": {name: {"id": "physics", **options} for name, options in engine.items()},
        "media": {
            "range_and_bearing": {"id": "rab", "check_occlusions": bodies, "index": "grid", "grid_size": grid}
        },
        "visualization": {},
    }


def _controller(scenario: Scenario, unit: float, ticks: int) -> dict[str, Any]:
    """Return the robots' devices, walk and decision."""
    sensors: dict[str, Any] = {"range_and_bearing": {"implementation": "medium", "medium": "rab"}}
    if scenario.robots.avoid_collisions:
        sensors["footbot_proximity"] = {"implementation": "default"}
    walk = {
        "ticks_per_step": ticks,
        "metres_per_step": _metres(scenario.robots.speed * unit),
        "mean_run": scenario.walk.mean_run,
    }
    actuators = {
        name: {"implementation": "default"} for name in ("differential_steering", "range_and_bearing")
    }
    params = {"walk": walk, "radio": {"loss": scenario.radio.loss}, "decision": _decision(scenario)}
    devices = {"actuators": actuators, "sensors": sensors, "params": params}
    return {"id": "feasibee", "library": LIBRARY, **devices}


def _decision(scenario: Scenario) -> dict[str, Any]:
    """Return [decision] as attributes; mind.h says what they mean."""
    decision, declare = scenario.decision, scenario.decision.declare
    return {
        "strategy": decision.strategy,
        "exploration": decision.exploration,
        "gain": decision.gain,
        "id_bits": scenario.setting.id_bits,
        "dissemination_floor": decision.dissemination_floor,
        "quality_floor": decision.quality_floor,
        "listens_for": _listens_for(scenario),
        "inbox_size": min(decision.inbox_size or MOST_HEARD, MOST_HEARD),
        "every_message": decision.inbox == "every-message",
        "own_vote": decision.own_vote,
        "random_ties": decision.ties == "random-message",
        "first_sight": decision.start == "first-sight",
        "switching": decision.switching or 0.0,
        **(
            {f"declare_{key}": getattr(declare, key) for key in ("rounds", "heard", "quorum")}
            if declare
            else {}
        ),
        **{name: _parameter(name, value) for name, value in decision.parameters.items()},
    }


def _parameter(name: str, value: float) -> float:
    """Return a strategy's parameter as the type of mind.h, with the meaning that it has in feasibee."""
    if name == "k":
        return min(LARGEST, max(1, math.ceil(value)))
    return value > 0 if name == "positive_feedback" else max(0.0, value)


def _listens_for(scenario: Scenario) -> int:
    """Return for how many of its last steps of dissemination a robot hears: 0 all, -1 always."""
    listen = scenario.decision.listen
    return {"always": -1, "dissemination": 0}[listen] if isinstance(listen, str) else listen["last"]


def _loop_functions(scenario: Scenario, unit: float) -> dict[str, Any]:
    """Return the world that the loop functions place, watch and record."""
    return {
        "library": LIBRARY,
        "label": "feasibee_world",
        "world": {
            "size": _metres(*_size(scenario, unit)),
            "boundary": scenario.arena.boundary,
            "bodies": scenario.robots.avoid_collisions,
            "robots": scenario.robots.count,
            "tasks": scenario.tasks.count,
        },
        "sensing": {
            "range": _metres(scenario.sensing.range * unit),
            "miss": scenario.sensing.miss,
            "count_self": scenario.sensing.count_self,
        },
        "radio": {"range": _metres(scenario.radio.range * unit)},
        "run": {
            "steps": scenario.run.steps,
            "threshold": scenario.decision.threshold,
            "stop_at_decision": scenario.run.stop_at_decision,
            "steps_file": "steps.csv",
            "runs_file": "runs.csv",
        },
    }


def _arena(scenario: Scenario, unit: float) -> dict[str, Any]:
    """Return the space of ARGoS, with walls as boxes if robots have bodies.

    Points may be outside by a step before the loop functions hold them, so the space is larger.
    """
    width, height = _size(scenario, unit)
    bodies = scenario.robots.avoid_collisions
    margin = 2 * WALL if bodies else 1.01 * unit * scenario.robots.speed + WALL
    size = _metres(width + 2 * margin, height + 2 * margin, 1.0)
    x, y = (width + WALL) / 2, (height + WALL) / 2
    long, high = _metres(width + 2 * WALL, WALL, 0.3), _metres(WALL, height, 0.3)
    walls = (("north", long, 0, y), ("south", long, 0, -y), ("east", high, x, 0), ("west", high, -x, 0))
    boxes = [_box(f"wall_{name}", sides, *at) for name, sides, *at in walls]
    for number, (left, low, right, top) in enumerate(_walls(scenario)):
        sides = _metres((right - left) * unit, (top - low) * unit, 0.3)
        middle = ((left + right) * unit - width) / 2, ((low + top) * unit - height) / 2
        boxes.append(_box(f"place_{number}", sides, *middle))
    return {"size": size, "center": "0,0,0.5", "box": boxes if bodies else []}


def _box(name: str, sides: str, x: float, y: float) -> dict[str, Any]:
    """Return a box that stands on the ground, from its sides and middle."""
    body = {"position": _metres(x, y, 0), "orientation": "0,0,0"}
    return {"id": name, "size": sides, "movable": False, "body": body}


def _walls(scenario: Scenario) -> Iterator[tuple[float, float, float, float]]:
    """Yield rectangles in units, of which the walls of a scenario's place consist: left, low, right, top.

    Rows' runs of wall cells are one rectangle with equal runs in the next rows.
    """
    if scenario.plan is None:
        return
    cell, begun = float(scenario.plan.cell), dict[tuple[int, int], int]()
    for row, cells in enumerate(np.pad(scenario.plan.walls, ((0, 1), (1, 1)))):
        runs = np.flatnonzero(np.diff(cells)).reshape(-1, 2).tolist()
        ended = [run for run in begun if list(run) not in runs]
        for left, right in ended:
            yield left * cell, begun.pop((left, right)) * cell, right * cell, row * cell
        for left, right in runs:
            begun.setdefault((left, right), row)


def _size(scenario: Scenario, unit: float) -> tuple[float, float]:
    width, height = scenario.arena.size
    return width * unit, height * unit


def _add(parent: ElementTree.Element, name: str, content: Mapping[str, Any]) -> None:
    """Append an element: values become attributes, tables become elements, lists elements of one name."""
    inner = {key: value for key, value in content.items() if isinstance(value, dict | list)}
    texts = {key: _text(value) for key, value in content.items() if key not in inner}
    element = ElementTree.SubElement(parent, name, texts)
    for key, value in inner.items():
        for each in value if isinstance(value, list) else [value]:
            _add(element, key, each)


def _text(value: str | float) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value).removesuffix(".0")


def _metres(*lengths: float) -> str:
    """Write lengths in metres with nanometres, which ARGoS parses at commas."""
    return ",".join(_short(length) for length in lengths)


def _short(length: float) -> str:
    return f"{length:.9f}".rstrip("0").rstrip(".")
