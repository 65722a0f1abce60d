"""The tables of a scenario: texts, presets and defaults, files of points, the complete form and its hash."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any, Final

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import PROBLEMS_LIMIT, Problem, quoted
from feasibee.base.files import TABLE_LIMIT, UnreadableError, lines_of, read_text
from feasibee.scenario.cells import digest_of
from feasibee.scenario.fields import SECTIONS, Point, plain
from feasibee.scenario.maps import with_plans


class FilePoints(tuple[Point, ...]):
    """Points of a CSV file."""

    path: str
    """The file."""
    lines: Sequence[int]
    """The line of each point."""


def read_points(path: str, field: str) -> tuple[FilePoints, list[Problem]]:
    """Read a CSV file of points, which a scenario's field names; return the points and the problems."""
    try:
        text = read_text(path, "a CSV file of x and y", TABLE_LIMIT)
    except UnreadableError as error:
        return FilePoints(), [
            Problem(field, path, f"can't be read: {error.why}", "name a CSV file of x and y")
        ]
    points, lines, problems = list[Point](), array("L"), list[Problem]()
    reader = csv.reader(lines_of(text), strict=True)
    try:
        for row in reader:
            line, cells = reader.line_num, [cell.strip() for cell in row]
            if not any(cells) or (line == 1 and cells[:2] == ["x", "y"]):
                continue
            point = _point(cells)
            if point is not None:
                points.append(point)
                lines.append(line)
                continue
            rule = f"line {line} must be two numbers, x and y, not {quoted(','.join(row))}"
            problems.append(Problem(field, path, rule, "write two numbers, such as 1.5,2.0"))
            if len(problems) >= PROBLEMS_LIMIT:
                break
    except csv.Error as error:
        problems.append(Problem(field, path, f"isn't a CSV file: {error}", "name a CSV file of x and y"))
    found = FilePoints(points)
    found.path, found.lines = path, lines
    return found, problems


def _point(cells: list[str]) -> Point | None:
    """Return the cells as two finite numbers; None if they aren't."""
    try:
        x, y = (float(cell) for cell in cells)
    except ValueError:
        return None
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None


# Durations in steps: 10 s and 3 s at ten ticks a second.
_LONG: Final = {"exploration": 100.0, "gain": 100.0}
_WINDOW: Final = {"dissemination_floor": 30, "listen": {"last": 30}}


def _once_per(steps: int) -> dict[str, Any]:
    """Return the fields of a robot that broadcasts and decides once per so many steps on average."""
    return {"exploration": steps - 1.0, "gain": 0.001, "own_vote": False}


PRESETS: Final[Mapping[str, Mapping[str, Mapping[str, Any]]]] = {
    "valentini-2016": {"decision": {**_LONG, **_WINDOW, "inbox_size": 2}, "run": {"steps": 10_000}},
    "minimize-surprise": {"decision": {**_LONG, **_WINDOW, "inbox_size": 4}, "run": {"steps": 10_000}},
    "ros2swarm-majority": {
        "decision": {"strategy": "majority", **_once_per(50), "ties": "random-message"},
        "run": {"steps": 10_000},
    },
    "ros2swarm-voter": {"decision": {"strategy": "voter", **_once_per(20)}, "run": {"steps": 10_000}},
    "first-sight": {"decision": {"start": "first-sight"}},
}

ABOUT: Final[Mapping[str, str]] = {
    "valentini-2016": "Pold87/blockchain-swarm-robotics, on the collective perception of 2016",
    "minimize-surprise": "Minimize-Surprise/Collective-Perception",
    "ros2swarm-majority": "ROS2swarm/ROS2swarm, majority rule, a decision every 5 s",
    "ros2swarm-voter": "ROS2swarm/ROS2swarm, voter model, a decision every 2 s",
    "first-sight": "the paper's, but a robot begins with what its first exploration favours",
}
"""Whose controller each preset is."""


def given_tables(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a user gives as tables of plain values, with those of a preset where it sets none."""
    tables = {}
    for name, section in given.items():
        own = type(section) is SECTIONS.get(name)
        table: Any = section.model_dump(exclude_unset=True) if own else section
        tables[name] = plain(table) if isinstance(table, Mapping) else table
    preset = tables.get("preset")
    for section, values in PRESETS.get(preset, {}).items() if isinstance(preset, str) else ():
        table = tables.get(section, {})
        if isinstance(table, Mapping):  # validation reports anything else
            tables[section] = {**values, **table}
    return tables


ZONES: Final = "place.zones"
FILES: Final = {
    "robots.points": "",
    "tasks.points": "",
    "place.map": "",
    "place.keepout": "",
    ZONES: "",
    "decision.strategy": ".py",
}
"""Fields that may name a file, and how the name ends; other texts in them are no files."""


def with_names(path: str, value: Any, rename: Callable[[str], Any]) -> Any:
    """Return the value of a field with the name of each file in it replaced."""
    if path == ZONES and isinstance(value, Mapping):
        return {name: with_names(f"{ZONES}.{name}", zone, rename) for name, zone in value.items()}
    suffix = FILES.get(ZONES if path.startswith(f"{ZONES}.") else path)
    is_name = suffix is not None and isinstance(value, str) and value.endswith(suffix)
    return rename(value) if is_name else value


def with_files(given: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """Replace names of files by their contents, as in the complete form; return the problems, too."""
    tables, problems = dict(given), []
    for name in ("robots", "tasks"):
        table = tables.get(name)
        if isinstance(table, Mapping) and isinstance(table.get("points"), str):
            points, found = read_points(table["points"], f"{name}.points")
            problems += found
            tables[name] = {**table, "points": points}
    place = tables.get("place")
    if isinstance(place, Mapping):
        side, metres = (
            tables[section].get(key) if isinstance(tables.get(section), Mapping) else None
            for section, key in (("arena", "side"), ("units", "metres"))
        )
        tables["place"], found = with_plans(place, side, metres)
        problems += found
    return tables, problems


def without(tables: Mapping[str, Any], wrong: Iterable[tuple[Any, ...]]) -> dict[str, Any]:
    """Return tables without the fields, or whole sections and lists, at these places."""
    places = {place[:2] if place[0] in SECTIONS else place[:1] for place in wrong}
    kept = {name: table for name, table in tables.items() if (name,) not in places}
    for name in {place[0] for place in places} & SECTIONS.keys() & kept.keys():
        kept[name] = {key: value for key, value in kept[name].items() if (name, key) not in places}
    return kept


@cache
def default_tables() -> dict[str, dict[str, Any]]:
    """Return the default values of all sections; cached, since a sweep needs them for each of its points."""
    return {name: section().model_dump() for name, section in SECTIONS.items()}


def complete_form(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the complete form of a scenario's tables: all fields that have a value.

    Numbers of robots and tasks that follow from classes are left out: a file can't have both.
    """
    complete = {name: _with_values(table) for name, table in tables.items() if name != "events"}
    for name in ("robots", "tasks"):
        if "classes" in complete[name]:
            del complete[name]["count"]
    events = [_with_values(each) for each in tables["events"]]
    return {**complete, "events": events} if events else complete


def _with_values(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table without what has no value: None, an empty list, or a table of such."""
    inner = {
        key: _with_values(value) if isinstance(value, Mapping) else value for key, value in table.items()
    }
    return {key: value for key, value in inner.items() if value not in (None, {}, (), [])}


def hash_of(tables: Mapping[str, Any], source: str = "") -> str:
    """Return the hash of a complete form: that of what differs from the defaults, and of the model's version.

    So a new field whose default changes nothing keeps all hashes. ``source`` is the text of a user's
    strategy.
    """
    sparse = {name: _sparse(name, table) for name, table in tables.items() if name != "units"}  # no run's
    if source:
        sparse["decision"]["strategy"] = source
    kept = {name: table for name, table in sparse.items() if table}
    text = json.dumps([MODEL_VERSION, kept], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _sparse(name: str, table: Any) -> Any:
    """Return what differs from the defaults of a section; events have none."""
    if name not in default_tables():
        return table
    defaults = default_tables()[name]
    return {key: _cells(value) for key, value in table.items() if value != defaults[key]}


def _cells(value: Any) -> Any:
    """Return a map with a hash of its cells in place of their image, and without the origin of files."""
    if isinstance(value, Mapping) and isinstance(value.get("image"), str):
        return {"cell": value.get("cell"), "image": digest_of(value["image"])}
    return value
