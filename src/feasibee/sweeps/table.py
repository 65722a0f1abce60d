"""A journal as a table of its points: what each varies, and statistics of its runs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError, UnknownFieldError
from feasibee.model.outcomes import TRACES
from feasibee.results.declarations import (
    Declarations,
    DeclareTimes,
    declare_times,
    declared_right,
    declared_wrong,
)
from feasibee.results.judging import decided_right, ended_right, mean_bits
from feasibee.results.replicates import Quartiles
from feasibee.results.statistics import (
    DecisionTimes,
    Interval,
    confidence_sequence,
    decision_counts,
    decision_times,
    wilson,
)
from feasibee.results.tracking import RunCounts, Tracking, counts_of, summarised
from feasibee.sweeps.journal import Journal
from feasibee.sweeps.schema import Entry
from feasibee.sweeps.stored import StoredPoint, stored_point
from feasibee.sweeps.survey import Survey

SOURCE = "source"
TRACKED = ("right_share", "detection_delay", "missed", "false_alarms")
"""Measures of worlds that change, by their names in `Tracking`."""


class Summary(NamedTuple):
    """Statistics of the runs of one point."""

    row: StoredPoint
    runs: int
    counts: dict[str, int]
    """Number of runs of each kind: ``accuracy`` (right decisions), ``right_at_end``, the three decisions, and
    ``declared_ok`` and ``declared_wrong`` if the robots can declare."""
    times: DecisionTimes
    declare_times: DeclareTimes | None
    """None if the robots can't declare."""
    bits: float
    """Bits per robot-step."""
    run_counts: RunCounts | None = None
    """What is counted of how swarms tracked the truth; None in a world that doesn't change."""

    def share(self, show: str) -> Interval | None:
        """Return the share of a kind of runs in ``counts``; None without runs or such a kind."""
        return share([self], self.counts[show]) if self.runs and show in self.counts else None

    @property
    def tracking(self) -> Tracking | None:
        """How swarms tracked the truth; None without runs, or in a world that doesn't change."""
        return summarised([self.run_counts]) if self.runs and self.run_counts else None

    @property
    def declared(self) -> Declarations | None:
        """Declarations in the runs; None without runs, or if the robots can't declare."""
        ok, wrong = self.share("declared_ok"), self.share("declared_wrong")
        if ok is None or wrong is None or self.declare_times is None:
            return None
        return Declarations(ok, wrong, self.declare_times)


def share(points: Sequence[Summary], runs: int) -> Interval:
    """Return a number of runs as a share of all runs of some points.

    The interval is Wilson's; a confidence sequence if a stopping rule chose the runs of one of the points.
    """
    interval = confidence_sequence if any(point.row.until for point in points) else wilson
    return interval(runs, sum(point.runs for point in points))


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
    results = results_in(row, results)
    scenario, decision, step = row.scenario, results.decision, results.decision_step
    right, right_at_end = rightness(row, results)
    chosen = {"accuracy": right, "right_at_end": right_at_end}
    if scenario.manifest.declares:
        chosen["declared_ok"] = declared_right(results, scenario, row.truth)
        chosen["declared_wrong"] = declared_wrong(results, scenario, row.truth)
    return Summary(
        row,
        decision.size,
        decision_counts(decision) | {name: int(runs.sum()) for name, runs in chosen.items()},
        decision_times(step),
        declare_times(results.declare_step) if scenario.manifest.declares else None,
        mean_bits(results, scenario),
        counts_of(results) if scenario.dynamic else None,
    )


def rightness(row: StoredPoint, results: SimpleNamespace) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return for each run of a point whether its decision was right, and whether it was right at the end."""
    return decided_right(results, row.scenario), ended_right(results, row.scenario)


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
    """Return a share of the runs by value of ``hue``, then by value of ``x``; see `share_of` for ``show``."""
    lines: dict[Any, dict[Any, list[Summary]]] = {}
    for each in points:
        line = _shown_value(each, hue) if hue else ""
        lines.setdefault(line, {}).setdefault(_shown_value(each, x), []).append(each)
    return {
        line: {value: share_of(group, show) for value, group in groups.items()}
        for line, groups in lines.items()
    }


def shares_by_cell(points: Sequence[Summary], x: str, y: str, show: str) -> dict[tuple[Any, Any], Interval]:
    """Return a share of the runs by value of ``x`` and value of ``y``; see `share_of` for ``show``."""
    cells: dict[tuple[Any, Any], list[Summary]] = {}
    for each in points:
        cells.setdefault((_shown_value(each, x), _shown_value(each, y)), []).append(each)
    return {cell: share_of(group, show) for cell, group in cells.items()}


def share_of(group: Sequence[Summary], show: str) -> Interval:
    """Return the share of a kind of runs in ``Summary.counts``, or a measure of tracking; NaN without runs.

    The interval of a delay of detection is from its lower to its upper quartile.
    """
    if show in TRACKED:
        return _tracked([each.run_counts for each in group if each.run_counts and each.runs], show)
    counted = [each for each in group if each.runs and show in each.counts]
    if not counted:
        return Interval(math.nan, math.nan, math.nan)
    return share(counted, sum(each.counts[show] for each in counted))


def _tracked(parts: Sequence[RunCounts], show: str) -> Interval:
    """Return a measure of the runs of some points together; NaN where it is unknown, or never."""
    found = getattr(summarised(parts), show) if parts else None
    if found is None:
        return Interval(math.nan, math.nan, math.nan)
    if isinstance(found, Quartiles):
        ends = (math.nan if step is None else float(step) for step in (found.median, found.q25, found.q75))
        return Interval(*ends)
    return Interval(*found)


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
