"""Write a scenario as an experiment of ARGoS3, for the controller and loop functions of this folder.

python3 export.py mine.toml > mine.argos
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np

from feasibee import FeasibeeError, Scenario

FOOTBOT_DIAMETER: Final = 0.170073516
"""Diameter of ARGoS's foot-bot, in metres."""
LIBRARY: Final = "build/libfeasibee_argos"
"""Where CMake builds controller and loop functions, from this folder."""
BODY_TICKS: Final = 10
"""Ticks per step of robots with bodies: proximity is sensed ten times a second."""
POINT_TICKS: Final = 2
"""Ticks per step of points: one to drive, one to turn."""
WALL: Final = 0.1
"""Thickness of a wall, in metres."""
MOST_HEARD: Final = 1024
"""Length of the inbox in `mind.c`."""
LARGEST: Final = 65_535
"""Largest whole number of 16 bits, as which the C header keeps numbers of steps and messages."""
EXPORTED: Final = {
    "arena": {"side", "boundary"},
    "robots": {"count", "speed", "diameter", "avoid_collisions"},
    "tasks": {"count"},
    "walk": {"mean_run"},
    "sensing": {"range", "count_self", "miss"},
    "radio": {"range", "loss"},
    "decision": {
        *("strategy", "parameters", "exploration", "gain", "dissemination_floor", "quality_floor", "listen"),
        *("inbox", "inbox_size", "own_vote", "ties", "start", "declare", "threshold"),
    },
    "run": {"steps", "stop_at_decision"},
    "place": {"map", "walls", "cell"},
}
"""Fields that an experiment expresses, by section. Any other field must have its default."""


def main() -> None:
    """Print the experiment of a scenario's file, or what it can't express."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", type=Path, help="a scenario in TOML")
    try:
        sys.stdout.write(argos_text(Scenario.read(parser.parse_args().file)))
    except (FeasibeeError, ValueError) as error:
        raise SystemExit(f"export.py: {error}") from None


def argos_text(scenario: Scenario) -> str:
    """Return a scenario as the text of an .argos file.

    One unit is the foot-bot's diameter divided by ``robots.diameter``; one step is one second.

    Parameters
    ----------
    scenario : Scenario
        A torus or walls with robots that are points, or walls and robots with bodies
        (``robots.avoid_collisions``). Bodies touch as ARGoS's physics has it.

    Raises
    ------
    ValueError
        If the experiment can't express the scenario, with a line per reason.
    """
    if problems := [*_not_exported(scenario), *_beyond_argos(scenario)]:
        raise ValueError("\n".join(problems))
    root = ElementTree.Element("argos-configuration")
    unit = FOOTBOT_DIAMETER / scenario.robots.diameter
    scale = f" Made by export.py. 1 unit = {_short(unit)} m, 1 step = 1 s. Run it in examples/argos. "
    root.append(ElementTree.Comment(scale))
    for name, content in _experiment(scenario, unit).items():
        _add(root, name, content)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _not_exported(scenario: Scenario) -> Iterator[str]:
    """Yield a line for each field that an experiment doesn't have and that isn't at its default."""
    default = Scenario().to_dict()
    for section, values in scenario.to_dict().items():
        for key, value in values.items() if isinstance(values, dict) else [("", values)]:
            usual = default[section].get(key) if key else default.get(section)
            if value != usual and key not in EXPORTED.get(section, ()):
                path = f"{section}.{key}".rstrip(".")
                remedy = f"leave out {path}" if usual is None else f"set it to {usual!r}"
                yield f"{path} = {value!r}: can't be exported to ARGoS; {remedy}"


def _beyond_argos(scenario: Scenario) -> Iterator[str]:
    """Yield a line for each value that ARGoS or the C header of the example can't express."""
    decision, bodies = scenario.decision, scenario.robots.avoid_collisions
    torus = scenario.arena.boundary == "torus"
    declare = decision.declare
    sizes = {
        "robots.count": (scenario.robots.count, MOST_HEARD),
        "decision.dissemination_floor": (decision.dissemination_floor, LARGEST),
        "decision.quality_floor": (decision.quality_floor, LARGEST),
        "decision.listen": (_listens_for(scenario), LARGEST),
        **(
            {f"decision.declare.{key}": (getattr(declare, key), LARGEST) for key in ("rounds", "heard")}
            if declare
            else {}
        ),
    }
    for path, (value, most) in sizes.items():
        if value > most:
            yield f"{path} = {value}: must be at most {most:,} in this example; use {most} or less"
    if bodies and torus:
        yield 'arena.boundary = "torus": ARGoS has no torus for bodies; set arena.boundary = "walls"'
    if scenario.plan and not bodies:
        yield "robots.avoid_collisions = false: points meet no walls; set robots.avoid_collisions = true"
    if scenario.manifest.knowledge or scenario.manifest.source:
        rule = "the example has built-in strategies that pass on opinions"
        yield f'decision.strategy = "{decision.strategy}": {rule}; such as decision.strategy = "dmmd"'
    if declare and 10_000 % Fraction(str(declare.quorum)).denominator:
        nearest = round(declare.quorum, 4)
        yield f"decision.declare.quorum = {declare.quorum}: must have at most 4 decimals; use {nearest}"


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


if __name__ == "__main__":
    main()
