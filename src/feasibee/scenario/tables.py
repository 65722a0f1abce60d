"""Raw tables of a scenario, before validation: files of points are read, defaults filled in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from feasibee.errors import Problem
from feasibee.scenario.coordinates import read_points
from feasibee.scenario.event import Event
from feasibee.scenario.fields import SECTIONS, Robots, Tasks
from feasibee.scenario.section import Section


def with_points(
    given: Mapping[str, Any],
) -> tuple[dict[str, Any], dict[str, tuple[str, Sequence[int]]], list[Problem]]:
    """Replace names of files of points by the points, so that the complete form contains them.

    Returns
    -------
    dict
        The tables with points.
    dict
        For each section whose points are from a file: the file, and the line of each point.
    list of Problem
        The problems of these files.
    """
    tables, places, problems = dict(given), {}, []
    for name, section in (("robots", Robots), ("tasks", Tasks)):
        table = tables.get(name)
        if isinstance(table, section):
            table = table.model_dump(exclude_unset=True)
        if isinstance(table, Mapping) and isinstance(table.get("points"), str):
            points, lines, found = read_points(table["points"], f"{name}.points")
            places[name] = (table["points"], lines)
            problems += found
            table = {**table, "points": points}
        if table is not None:
            tables[name] = table
    return tables, places, problems


@cache
def default_tables() -> dict[str, dict[str, Any]]:
    """Return the default values of all sections; cached, since a sweep needs them for each of its points."""
    return {name: section().model_dump() for name, section in SECTIONS.items()}


def with_defaults(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the raw values of all sections with defaults filled in, for the rules about several fields."""
    explicit: dict[str, Any] = {"events": _events(given.get("events", ()))}
    for name in SECTIONS:
        table = given.get(name, {})
        if isinstance(table, Section):
            table = table.model_dump(exclude_unset=True)
        explicit[name] = {**default_tables()[name], **(table if isinstance(table, Mapping) else {})}
    if explicit["radio"]["range"] is None:
        explicit["radio"]["range"] = explicit["sensing"]["range"]
    for name in ("robots", "tasks"):
        given_table = given.get(name)
        counted = isinstance(given_table, Mapping) and "count" in given_table
        points = explicit[name]["points"]
        if explicit[name]["placement"] == "points" and not counted and not explicit[name]["classes"]:
            explicit[name]["count"] = len(points) if isinstance(points, list | tuple) else 0
    return explicit


def _events(given: Any) -> list[dict[str, Any]]:
    """Return the raw values of the events with defaults filled in; of invalid ones, they aren't used."""
    return [_event(each) for each in given] if isinstance(given, list | tuple) else []


def _event(given: Any) -> dict[str, Any]:
    table = given.model_dump(exclude_unset=True) if isinstance(given, Section) else given
    event = Event(step=0).model_dump()
    for key, value in (table if isinstance(table, Mapping) else {}).items():
        inner = value.model_dump(exclude_unset=True) if isinstance(value, Section) else value
        event[key] = (
            {**event[key], **inner}
            if isinstance(event.get(key), dict) and isinstance(inner, Mapping)
            else inner
        )
    return event
