"""Studies: which points to run and how often, read from TOML.

A study file::

    runs = 1000
    seed = 1

    [scenario]
    decision.strategy = "dmvd"

    [sweep]
    "tasks.count" = {logspace = [2, 200, 19]}
    "radio.loss" = [0.0, 0.1, 0.3]
"""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from feasibee.base.codes import RUN_LIMIT
from feasibee.base.errors import (
    PROBLEMS_LIMIT,
    FeasibeeError,
    Problem,
    ScenarioError,
    UnknownFieldError,
    quoted,
)
from feasibee.base.files import TABLE_LIMIT, UnreadableError, lines_of, read_text
from feasibee.scenario.fields import Section
from feasibee.scenario.paths import toml_tables, toml_value
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.tables import with_names

POINTS_LIMIT = 1_000_000
VALUES_LIMIT = 2 * POINTS_LIMIT
"""Number of values of all fields of a sweep, before they are combined."""
MOST = 1e15
"""Largest number in a range; floats are exact for whole numbers up to here."""
KEYS = ("runs", "seed", "curves", "combine", "file", "design", "until", "scenario", "sweep")
RANGES: Final[Mapping[str, Callable[[float, float, int], Any]]] = {
    "linspace": np.linspace,
    "logspace": np.geomspace,
}


@dataclass(frozen=True)
class StoppingRule:
    """Rule that chooses the number of runs of each point.

    Parameters
    ----------
    width : float, optional
        Stop when the interval of the share of right decisions is at most this wide, from low to high.
    decided : float, optional
        Instead, stop when the interval lies wholly above or below this share.
    most : int
        Largest number of runs.
    """

    width: float | None
    decided: float | None
    most: int


@dataclass(frozen=True)
class DesignPoint:
    """One scenario of a study, and where its run numbers begin.

    Parameters
    ----------
    values : mapping of str to object
        What the study varies, by dotted path.
    scenario : Scenario
        The whole scenario.
    first_run : int
        Number of its first run.
    """

    values: Mapping[str, Any]
    scenario: Scenario
    first_run: int = 0


@dataclass(frozen=True)
class Study:
    """Points, and the runs of each.

    Parameters
    ----------
    points : sequence of DesignPoint
        Points; two with the same scenario and first run share their runs.
    runs : int
        Number of runs of each point. Points with the same run numbers can be compared in pairs.
    seed : int
        64 bits.
    curves : bool
        Whether to keep the numbers of opinions at each step.
    until : StoppingRule, optional
        Rule that runs each point ``runs`` times and then goes on until it is met.
    """

    points: Sequence[DesignPoint]
    runs: int
    seed: int
    curves: bool = False
    until: StoppingRule | None = None

    @classmethod
    def read(cls, path: str | Path) -> Study:
        """Read a study from a TOML file.

        Raises
        ------
        FeasibeeError
            If it can't be read or a key is invalid.
        ScenarioError
            If points are invalid.
        """
        tables = toml_tables(read_text(path, "a study in TOML"), str(path))
        try:
            return study_of(tables, Path(path).parent)
        except ScenarioError as error:
            raise ScenarioError(error.problems, error.source or str(path)) from None
        except FeasibeeError as error:
            raise FeasibeeError(f"{path}: {error}") from None


def study_of(tables: Mapping[str, Any], folder: Path) -> Study:
    """Return the study in the tables of a file; names of files in it are relative to ``folder``."""
    for key in tables:
        if key not in KEYS:
            raise FeasibeeError(f"{key}: unknown key; a study has {', '.join(KEYS)}")
    runs = Runs(tables.get("runs", 100), tables.get("seed", 0))
    curves = tables.get("curves", False)
    if not isinstance(curves, bool):
        raise FeasibeeError(f"curves = {curves!r}: must be true or false; leave it out for false")
    base = _base(tables, folder)
    return Study(
        points_of(base, tables, folder),
        runs.count,
        runs.seed,
        curves,
        _until(tables.get("until"), runs.count),
    )


def points_of(base: Scenario, tables: Mapping[str, Any], folder: Path) -> list[DesignPoint]:
    """Return the points that the keys ``sweep``, ``combine`` and ``design`` of a study make of a scenario."""
    return _points(base, (_located(values, folder) for values in _designs(tables, folder, base)))


def _base(tables: Mapping[str, Any], folder: Path) -> Scenario:
    """Return the scenario that all points start from."""
    own = tables.get("scenario", {})
    if not isinstance(own, Mapping):
        raise FeasibeeError(f"scenario = {own!r}: must be a table; write [scenario] and its fields below")
    if "file" not in tables:
        return Scenario.from_tables(own, folder)
    if not isinstance(tables["file"], str):
        raise FeasibeeError(f"file = {tables['file']!r}: must be a file name, such as 'swarm.toml'")
    base = Scenario.read(folder / tables["file"])
    return base.replace(_located(dict(_listed(own, base)), folder))


def _designs(tables: Mapping[str, Any], folder: Path, base: Scenario) -> Iterator[dict[str, Any]]:
    """Yield the values of each point."""
    sweep, design = tables.get("sweep", {}), tables.get("design")
    if design is not None:
        if sweep:
            raise FeasibeeError("design and sweep: exclude each other; leave out one of them")
        if not isinstance(design, str):
            raise FeasibeeError(f"design = {design!r}: must be a file name, such as 'points.csv'")
        yield from _table(folder / design, base)
        return
    if not isinstance(sweep, Mapping):
        raise FeasibeeError(f"sweep = {sweep!r}: must be a table; write [sweep] and fields below")
    combine = tables.get("combine", "grid")
    if combine not in ("grid", "zip"):
        raise FeasibeeError(f"combine = {quoted(combine)}: must be 'grid' or 'zip'; leave it out for a grid")
    values: dict[str, list[Any]] = {}
    many, total = 1, 0
    for path, given in _listed(sweep, base):
        values[path] = _values(path, given, base)
        many, total = many * len(values[path]), total + len(values[path])
        if total > VALUES_LIMIT:
            raise FeasibeeError(f"sweep: over {VALUES_LIMIT} values, at {path}; use fewer values or fields")
        if combine == "grid":
            _check_size(many)
    if combine == "zip" and len({len(each) for each in values.values()}) > 1:
        lengths = {path: len(each) for path, each in values.items()}
        raise FeasibeeError(f"sweep: lengths {lengths} differ; to zip, give as many values to each field")
    combined = (
        itertools.product(*values.values()) if combine == "grid" else zip(*values.values(), strict=True)
    )
    for each in combined:
        yield dict(zip(values, each, strict=True))


def _listed(sweep: Mapping[str, Any], base: Scenario, way: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the fields of [sweep] or [scenario], dotted or nested, with the given values.

    A field may have the name of a kind of range: ``radio = {range = 2.0}`` sets radio.range.
    """
    for key, given in sweep.items():
        now = _present(base, f"{way}{key}")
        if isinstance(given, Mapping) and (
            isinstance(now, Section)
            or (given and not isinstance(now, int | float | str) and not set(given) & {*RANGES, "range"})
        ):
            yield from _listed(given, base, f"{way}{key}.")
        else:
            yield f"{way}{key}", given


def _values(path: str, given: Any, base: Scenario) -> list[Any]:
    """Return the values of one field: a list, or a range."""
    if isinstance(given, list) and given:
        return given
    if isinstance(given, Mapping) and len(given) == 1:
        kind, numbers = next(iter(given.items()))
        known = kind in RANGES or kind == "range"
        if known and isinstance(numbers, list) and len(numbers) == 3 and all(map(_is_number, numbers)):
            return _range(path, kind, numbers, base)
    rule = "must be a list of values, or {linspace = [first, last, count]}, {logspace = ...} or {range = ...}"
    raise FeasibeeError(f"sweep.{path} = {given!r}: {rule}; such as [10, 20, 40]")


def _range(path: str, kind: str, numbers: Sequence[float], base: Scenario) -> list[Any]:
    first, last, third = numbers
    if kind == "range":
        if third == 0:
            raise FeasibeeError(
                f"sweep.{path}: the step of a range can't be 0; use a step such as 10: range = [10, 100, 10]"
            )
        steps = math.floor(min((last - first) / third + 1e-9, POINTS_LIMIT)) + 1
        _check_size(steps)
        made = [first + third * k for k in range(steps)]
    elif third == int(third) and 1 <= third <= POINTS_LIMIT:
        if kind == "logspace" and min(first, last) <= 0:
            raise FeasibeeError(f"sweep.{path}: logspace from {first} to {last}: must be > 0; use linspace")
        made = [float(each) for each in RANGES[kind](first, last, int(third))]
    else:
        rule = f"must have a whole number of values, from 1 to {POINTS_LIMIT}; such as [2, 200, 19]"
        raise FeasibeeError(f"sweep.{path}: {kind} = {list(numbers)}: {rule}")
    if _is_whole(base, path):
        made = list(dict.fromkeys(round(each) for each in made))
    if not made:
        raise FeasibeeError(f"sweep.{path}: range = {list(numbers)} is empty; use a step of the other sign")
    return made


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MOST


def _is_whole(base: Scenario, path: str) -> bool:
    """Whether a field holds whole numbers, judged by its present value."""
    value = _present(base, path)
    return isinstance(value, int) and not isinstance(value, bool)


def _present(base: Scenario, path: str) -> Any:
    """Return the present value of a field; None if there is no such field."""
    try:
        return base.get(path)
    except UnknownFieldError:
        return None


def _check_size(points: int) -> None:
    """Raise an error before points are made if they would not fit in memory."""
    if points > POINTS_LIMIT:
        raise FeasibeeError(f"sweep: {points} points: must be at most {POINTS_LIMIT}; use fewer values")


def _table(path: Path, base: Scenario) -> Iterator[dict[str, Any]]:
    """Yield the rows of a design table in CSV; its header has the paths of fields."""
    try:
        reader = csv.reader(lines_of(read_text(path, "a CSV file", TABLE_LIMIT)), strict=True)
        rows = [(reader.line_num, row) for row in reader if row]
    except (UnreadableError, csv.Error) as error:
        why = error.why if isinstance(error, UnreadableError) else f"not CSV: {error}"
        raise FeasibeeError(f"design = {quoted(str(path))}: can't be read: {why}; name a CSV file") from None
    if len(rows) < 2:
        raise FeasibeeError(f"design = {str(path)!r}: has no points; write fields in line 1 and points below")
    header = [name.strip() for name in rows[0][1]]
    if any(";" in name or "\t" in name for name in header):
        rule = f"line 1 is {','.join(header)!r}: values must be separated by commas"
        raise FeasibeeError(f"design = {str(path)!r}: {rule}; export it as comma-separated values")
    if len(set(header)) < len(header):
        raise FeasibeeError(f"design = {str(path)!r}: names a field twice in line 1; leave out one of them")
    whole = [_is_whole(base, name) for name in header]
    for number, row in rows[1:]:
        if len(row) != len(header):
            rule = f"line {number} has {len(row)} values, not {len(header)}"
            raise FeasibeeError(f"design = {str(path)!r}: {rule}; write one value per field")
        yield {name: _read(text, is_whole) for name, text, is_whole in zip(header, row, whole, strict=True)}


def _read(text: str, is_whole: bool) -> Any:
    """Parse a value as TOML, or as other tools write it: True, .5, 5., a bare word, or 5.0 for 5."""
    text = text.strip()
    value: Any = text
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for parse in (float, toml_value):
        with suppress(ValueError):
            value = parse(text)
    return round(value) if is_whole and isinstance(value, float) and _is_number(value) else value


def _located(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return values with the names of files relative to the study's folder."""
    return {path: with_names(path, value, lambda name: str(folder / name)) for path, value in values.items()}


def _points(base: Scenario, designs: Iterable[Mapping[str, Any]]) -> list[DesignPoint]:
    """Return the points, each scenario once; raise the problems of at most `PROBLEMS_LIMIT` points."""
    points: dict[str, DesignPoint] = {}
    problems: dict[str, Problem] = {}
    failed = 0
    for number, values in enumerate(designs, start=1):
        _check_size(number)
        try:
            scenario = base.replace(values)
        except ScenarioError as error:
            problems |= {str(problem): problem for problem in error.problems}
            failed += 1
            if failed == PROBLEMS_LIMIT:
                break
            continue
        texts = {path: scenario.get(path) for path, each in values.items() if isinstance(each, str)}
        numbers = {path: each for path, each in texts.items() if isinstance(each, int | float)}  # of "6 m"
        points.setdefault(scenario.hash, DesignPoint({**values, **numbers}, scenario))
    if problems:
        raise ScenarioError(problems.values())
    return list(points.values())


def _until(given: Any, runs: int) -> StoppingRule | None:
    if given is None:
        return None
    rule = "must be {width = 0.05} or {decided = 0.75}, perhaps with most = 10000"
    if not isinstance(given, Mapping) or not set(given) <= {"width", "decided", "most"}:
        raise FeasibeeError(f"until = {given!r}: {rule}; leave it out for a fixed number of runs")
    width, decided, most = given.get("width"), given.get("decided"), given.get("most", 100_000)
    shares = [each for each in (width, decided) if each is not None]
    if len(shares) != 1 or not _is_number(shares[0]) or not 0 < shares[0] < 1:
        raise FeasibeeError(f"until = {dict(given)!r}: {rule}, of a number between 0 and 1")
    if not isinstance(most, int) or isinstance(most, bool) or not 1 <= most <= RUN_LIMIT:
        raise FeasibeeError(
            f"until.most = {most!r}: must be a whole number from 1 to {RUN_LIMIT}; such as 10000"
        )
    return StoppingRule(width, decided, max(most, runs))
