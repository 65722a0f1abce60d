"""A journal as a table of its points: what each varies, and statistics of its runs."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from feasibee.errors import FeasibeeError, UnknownFieldError
from feasibee.model.outcomes import TRACES
from feasibee.results.measures import Measured, measured, together
from feasibee.results.statistics import Interval
from feasibee.sweeps.journal import Journal
from feasibee.sweeps.schema import Entry
from feasibee.sweeps.stored import StoredPoint, stored_point
from feasibee.sweeps.survey import Survey

SOURCE = "source"


class Summary(NamedTuple):
    """A point, and what came of its runs."""

    row: StoredPoint
    found: Measured


def summaries(journal: Journal) -> list[Summary]:
    """Return a summary of each point."""
    return [_summary(row, journal.results(row.id)) for row in journal.points]


def survey(journal: Journal) -> tuple[list[Summary], Survey]:
    """Return a summary of each undamaged point, and what is known of the damaged ones."""
    points = []

    def visit(entry: Entry, results: SimpleNamespace) -> None:
        points.append(_summary(stored_point(entry), results))

    found = journal.survey(visit)
    return points, found


def _summary(row: StoredPoint, results: SimpleNamespace) -> Summary:
    return Summary(row, measured(results_in(row, results), row.scenario, bool(row.until)))


def results_in(row: StoredPoint, results: SimpleNamespace) -> SimpleNamespace:
    """Return the outcomes of a point's runs; of none if the truth of their steps isn't there."""
    if not row.scenario.dynamic or hasattr(results, "truth"):
        return results
    empty = {name: values[:0] for name, values in vars(results).items()}
    return SimpleNamespace(**empty, **{each.name: np.empty((0, 1), each.dtype) for each in TRACES})


def varied(points: Sequence[StoredPoint]) -> list[str]:
    """Return the fields that a study varies, in its order, and further fields in which its points differ.

    A journal may hold several studies that vary the same fields and differ in another one, or in the text of
    a strategy's file. The number of that text is named ``source``.
    """
    fields = list(dict.fromkeys(path for row in points for path in row.values))
    groups: dict[str, list[StoredPoint]] = {}
    for row in points:
        key = json.dumps([row.seed, *(value_of(row, path) for path in fields)])
        groups.setdefault(key, []).append(row)
    more = [
        _differing([{**dict(_leaves(row.scenario.to_dict())), SOURCE: row.source} for row in group])
        for group in groups.values()
        if len(group) > 1
    ]
    return list(dict.fromkeys([*fields, *(path for paths in more for path in paths)]))


def _leaves(tables: Mapping[str, Any], way: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all fields of a scenario by dotted path."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{way}{key}.")
        else:
            yield f"{way}{key}", value


def _differing(scenarios: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the fields in which some scenarios differ."""
    paths = dict.fromkeys(path for each in scenarios for path in each)
    first = scenarios[0]
    return [path for path in paths if any(each.get(path) != first.get(path) for each in scenarios)]


def pooled_fields(points: Sequence[StoredPoint], shown: Sequence[str], others: Sequence[str]) -> list[str]:
    """Return the other fields in which points differ that a figure shows as one."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in points:
        key = json.dumps([value_of(row, path) for path in shown])
        groups.setdefault(key, []).append({path: value_of(row, path) for path in others})
    found = {path for group in groups.values() for path in _differing(group)}
    return [path for path in others if path in found]


def shares_by_line(
    points: Sequence[Summary], x: str, hue: str | None, show: str
) -> dict[Any, dict[Any, Interval]]:
    """Return a measure by value of ``hue``, then by value of ``x``."""
    lines: dict[Any, dict[Any, list[Summary]]] = {}
    for each in points:
        line = _shown_value(each, hue) if hue else ""
        lines.setdefault(line, {}).setdefault(_shown_value(each, x), []).append(each)
    return {
        line: {value: together([each.found for each in group], show) for value, group in groups.items()}
        for line, groups in lines.items()
    }


def shares_by_cell(points: Sequence[Summary], x: str, y: str, show: str) -> dict[tuple[Any, Any], Interval]:
    """Return a measure by value of ``x`` and value of ``y``."""
    cells: dict[tuple[Any, Any], list[Summary]] = {}
    for each in points:
        cells.setdefault((_shown_value(each, x), _shown_value(each, y)), []).append(each)
    return {cell: together([each.found for each in group], show) for cell, group in cells.items()}


def _shown_value(point: Summary, path: str) -> Any:
    """Return a point's value of a field, whether the study varies it or not."""
    if path == SOURCE:
        return point.row.source or "built in"
    try:
        value = point.row.scenario.get(path)
    except UnknownFieldError:
        raise FeasibeeError(f"{path}: isn't a field of the scenarios; such as tasks.count") from None
    return value if isinstance(value, int | float | str) else str(value)


def value_of(row: StoredPoint, path: str) -> Any:
    """Return a point's value of a field that this or another study in the journal varies; None if missing."""
    if path == SOURCE:
        return row.source
    try:
        value = row.values[path] if path in row.values else row.scenario.get(path)
    except UnknownFieldError:
        return None
    return value if isinstance(value, int | float | str) or value is None else json.dumps(value, default=str)
