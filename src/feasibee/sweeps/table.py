"""A journal as tables: a row a point, to look at; a row a run, to take elsewhere."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from feasibee.errors import FeasibeeError, UnknownFieldError, how_to_install
from feasibee.files import atomic_write, check_output
from feasibee.model.codes import MODEL_VERSION
from feasibee.results.statistics import (
    DecisionTimes,
    Interval,
    bits_per_robot_and_step,
    confidence_sequence,
    decision_counts,
    decision_times,
    wilson,
)
from feasibee.sweeps.content import Array
from feasibee.sweeps.journal import Journal, Row, row_of
from feasibee.sweeps.schema import PLACES, Entry
from feasibee.sweeps.survey import Survey

if TYPE_CHECKING:
    import pandas as pd

SOURCE = "source"
KINDS: Mapping[str, str] = {"csv": ".csv", "parquet": ".parquet", "netcdf": ".nc"}
"""Formats of an export, and their suffixes."""


class Summary(NamedTuple):
    """What the runs of one point say."""

    row: Row
    runs: int
    right: int
    counts: dict[str, int]
    times: DecisionTimes
    bits: float
    """Sent a robot and step."""

    @property
    def accuracy(self) -> Interval | None:
        """Share of the runs whose first decision is as the truth."""
        return share([self], self.right) if self.runs else None


def share(points: Sequence[Summary], runs: int) -> Interval:
    """Return so many runs as a share of all runs of some points.

    Wilson's interval; a confidence sequence if one of the points was run until it was sure.
    """
    interval = confidence_sequence if any(point.row.until for point in points) else wilson
    return interval(runs, sum(point.runs for point in points))


def summaries(journal: Journal) -> list[Summary]:
    """Return a summary of each point."""
    return [_summary(row, journal.columns(row.id)) for row in journal.points]


def survey(journal: Journal) -> tuple[list[Summary], Survey]:
    """Return a summary of each point that is as it was written, and what is known of the others."""
    points = []

    def visit(entry: Entry, columns: Array) -> None:
        points.append(_summary(row_of(entry), columns))

    found = journal.survey(visit)
    return points, found


def _summary(row: Row, columns: Array) -> Summary:
    decision, step, bits = (columns[:, PLACES[name]] for name in ("decision", "decision_step", "bits_sent"))
    scenario = row.scenario
    return Summary(
        row,
        decision.size,
        int((decision == row.truth).sum()),
        decision_counts(decision),
        decision_times(step),
        bits_per_robot_and_step(
            bits, step, scenario.robots.count, scenario.run.steps, scenario.run.stop_at_decision
        ),
    )


def varied(points: Sequence[Row]) -> list[str]:
    """Return the fields that a study varies, in its order, and what else tells two of its points apart.

    A journal may hold several studies, which vary the same fields and differ in another; or in the text of a
    strategy's file, whose number is named ``source``.
    """
    fields = list(dict.fromkeys(path for row in points for path in row.values))
    groups: dict[str, list[Row]] = {}
    for row in points:
        key = json.dumps([row.seed, *(held(row, path) for path in fields)])
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
    """Return the fields in which some scenarios aren't all the same."""
    paths = dict.fromkeys(path for each in scenarios for path in each)
    first = scenarios[0]
    return [path for path in paths if any(each.get(path) != first.get(path) for each in scenarios)]


def alike(points: Sequence[Row], shown: Sequence[str], others: Sequence[str]) -> list[str]:
    """Return which other fields differ between points that are alike in those that a figure shows."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in points:
        key = json.dumps([held(row, path) for path in shown])
        groups.setdefault(key, []).append({path: held(row, path) for path in others})
    found = {path for group in groups.values() for path in _differing(group)}
    return [path for path in others if path in found]


def frame(journal: Journal) -> pd.DataFrame:
    """Return a row a run: the point, what it varies, the truth, and the outcome."""
    import pandas as pd

    points, parts = journal.points, []
    fields = {path: _column([held(row, path) for row in points]) for path in varied(points)}
    for number, row in enumerate(points):
        part = pd.DataFrame(journal.columns(row.id), columns=list(PLACES))
        part.insert(0, "point", row.id)
        for place, (path, values) in enumerate(fields.items(), start=1):
            part.insert(place, path, values[number])
        part.insert(1 + len(fields), "seed", np.uint64(row.seed))
        part.insert(2 + len(fields), "truth", int(row.truth))
        parts.append(part)
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def held(row: Row, path: str) -> Any:
    """Return what a point has in a field that the study varies, or another study in the same journal."""
    if path == SOURCE:
        return row.source
    try:
        value = row.values[path] if path in row.values else row.scenario.get(path)
    except UnknownFieldError:
        return None
    return value if isinstance(value, int | float | str) or value is None else json.dumps(value, default=str)


def _column(values: list[Any]) -> list[Any]:
    """Return values of one kind, as the formats want them: numbers, true and false, or else text."""
    kinds = {type(value) for value in values} - {type(None)}
    if kinds and kinds <= {int, float}:
        return [math.nan if value is None else value for value in values]
    if kinds == {bool} and None not in values:
        return values
    return [
        "" if value is None else value if isinstance(value, str) else json.dumps(value) for value in values
    ]


def export(journal: Journal, kind: str, path: Path) -> int:
    """Write a row a run to a file that is whole or not there; return how many rows.

    Parameters
    ----------
    journal : Journal
        What to write.
    kind : str
        ``"csv"``, ``"parquet"`` (needs the extra ``parquet``) or ``"netcdf"``.
    path : path
        The file.
    """
    check_output(path, [KINDS[kind]])
    rows = frame(journal)
    with atomic_write(path) as temporary:
        if kind == "csv":
            rows.to_csv(temporary, index=False)
        elif kind == "parquet":
            try:
                rows.to_parquet(temporary, index=False, engine="pyarrow")
            except ImportError:
                raise FeasibeeError(f"pyarrow: not installed; {how_to_install('parquet')}") from None
        else:
            _netcdf(journal, rows, temporary)
    return len(rows)


def _netcdf(journal: Journal, rows: pd.DataFrame, path: Path) -> None:
    """Write all rows, and the scenarios of the points as a recipe."""
    points = [
        {"point": row.id, "seed": row.seed, "hash": row.hash, "scenario": row.scenario.to_dict()}
        for row in journal.points
    ]
    dataset = rows.rename_axis("row").to_xarray()
    dataset.attrs = {
        "title": "feasibee sweep",
        "recipe": json.dumps({"model_version": MODEL_VERSION, "points": points}),
    }
    dataset.to_netcdf(path, engine="h5netcdf")
