"""Runs of many scenarios as tables: the public `feasibee.sweep`, summaries of points, and exports."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from feasibee.base.codes import DECISIONS, FEASIBLE, INFEASIBLE, MODEL_VERSION
from feasibee.base.errors import FeasibeeError, UnknownFieldError, quoted
from feasibee.base.files import RESULTS, as_cell, atomic_write, check_output
from feasibee.base.outcomes import OUTCOMES
from feasibee.results.dataset import attributes_of, write_netcdf
from feasibee.results.measures import (
    MEASURES,
    OF_RUNS,
    Measured,
    measured,
    measures_of_runs,
    rightness,
    together,
)
from feasibee.results.statistics import Interval
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import check_progress, check_scenario
from feasibee.simulation.plan import Study, points_of
from feasibee.simulation.store import Store, StoredPoint, key_of
from feasibee.simulation.sweep import Execution, Progress, Rounds

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


SOURCE = "source"
NUMBER: Final = "number of the run"
SEED: Final = "seed"
UNSCALED: Final[Mapping[str, float]] = MappingProxyType({})
POINT: Final = "point"
"""The dimension of points that don't form a grid."""


class Summary(NamedTuple):
    """A point, and what came of its runs."""

    row: StoredPoint
    found: Measured


def summaries(store: Store) -> list[Summary]:
    """Return a summary of each point, of its undamaged runs."""
    return [
        Summary(row, measured(store.results(row.key), row.scenario, bool(row.until))) for row in store.points
    ]


def varied(points: Sequence[StoredPoint]) -> list[str]:
    """Return the fields that a study varies, in its order, and further fields in which its points differ.

    A folder may hold several studies that vary the same fields and differ in another one, or in the text of
    a strategy's file. The number of that text is named ``source``.
    """
    fields = list(dict.fromkeys(path for row in points for path in row.values))
    groups: dict[str, list[StoredPoint]] = {}
    for row in points:
        key = json.dumps([row.seed, *(value_of(row, path) for path in fields)])
        groups.setdefault(key, []).append(row)
    more = [
        _differing([{**dict(leaves(row.scenario.to_dict())), SOURCE: row.source} for row in group])
        for group in groups.values()
        if len(group) > 1
    ]
    return list(dict.fromkeys([*fields, *(path for paths in more for path in paths)]))


def leaves(tables: Mapping[str, Any], way: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all fields of a scenario by dotted path."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{way}{key}.")
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
    points: Sequence[Summary], x: str, hue: str | None, show: str, sizes: Mapping[str, float] = UNSCALED
) -> dict[Any, dict[Any, Interval]]:
    """Return a measure by value of ``hue``, then by value of ``x``; fields in ``sizes`` are multiplied."""
    return {
        line: {
            value: together([each.found for each in part], show)
            for value, part in by_value(group, x, sizes).items()
        }
        for line, group in by_value(points, hue, sizes).items()
    }


def by_value(
    points: Sequence[Summary], path: str | None, sizes: Mapping[str, float] = UNSCALED
) -> dict[Any, list[Summary]]:
    """Return the points by their value of a field; all of them as one group without a field."""
    groups: dict[Any, list[Summary]] = {}
    for each in points:
        groups.setdefault(_shown_value(each, path, sizes) if path else "", []).append(each)
    return groups


def _shown_value(point: Summary, path: str, sizes: Mapping[str, float]) -> Any:
    """Return a point's value of a field, whether the study varies it or not."""
    if path == SOURCE:
        return point.row.source or "built in"
    try:
        value = point.row.scenario.get(path)
    except UnknownFieldError:
        raise FeasibeeError(f"{path}: isn't a field of the scenarios; such as tasks.count") from None
    if sizes.get(path, 1) != 1 and isinstance(value, int | float):
        return sizes[path] * value
    return value if isinstance(value, int | float | str) else str(value)


def value_of(row: StoredPoint, path: str) -> Any:
    """Return a point's value of a field that this or another study in the folder varies; None if missing."""
    if path == SOURCE:
        return row.source
    try:
        value = row.values[path] if path in row.values else row.scenario.get(path)
    except UnknownFieldError:
        return None
    return value if isinstance(value, int | float | str) or value is None else json.dumps(value, default=str)


def sweep(
    scenario: Scenario,
    vary: Mapping[str, Sequence[Any]],
    runs: int = 100,
    seed: int = 0,
    *,
    combine: Literal["grid", "zip"] = "grid",
    out: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Simulate a scenario with all combinations of some fields' values; run r of all points can be paired.

    Parameters
    ----------
    scenario : Scenario
        What all points have in common.
    vary : mapping of str to sequence
        Values of each field, by its dotted path, such as ``{"tasks.count": [10, 20, 40]}``.
    runs, seed : int
        Number of runs of each point, and their seed.
    combine : {"grid", "zip"}
        Each value with each, or element by element.
    out : path, optional
        Folder for the runs. What is there isn't computed again: after an interruption, the same call goes on.
    progress : callable, optional
        Called about each second with the share of the work that is done, from 0 to 1.

    Returns
    -------
    xarray.Dataset
        Over each field and ``run``: ``right`` (whether the first collective decision equals the truth),
        ``right_at_end``, and the outcomes of `simulate`; per point ``truth`` and ``seed``. Over ``point`` and
        ``run`` if the values don't form a grid. Scenarios and seed are in ``attrs["recipe"]``.

    Examples
    --------
    >>> import feasibee
    >>> vary = {"tasks.count": [10, 40], "sensing.range": [1.0, 2.0]}
    >>> table = feasibee.sweep(feasibee.Scenario(run={"steps": 300}), vary, runs=50, seed=1)
    >>> table.right.mean("run").round(2).values.tolist()
    [[0.26, 0.64], [0.28, 0.78]]
    """
    with Rounds(Execution(out, progress=_share(progress))) as rounds:
        study = _study(scenario, vary, combine, Runs(runs, seed))
        rounds.complete(study)
        keys = {key_of(point.scenario.hash, study.seed) for point in study.points}
        return to_dataset(rounds.store, keys, study.runs)


def _share(progress: Callable[[float], None] | None) -> Callable[[Progress], None] | None:
    """Return a function that reports the share of the work that is done."""
    check_progress(progress)
    return None if progress is None else lambda told: progress(told.work_done / max(1, told.work))


def _study(scenario: Scenario, vary: Any, combine: str, runs: Runs) -> Study:
    if not isinstance(vary, Mapping):
        rule = 'must be fields with their values; such as {"tasks.count": [10, 20]}'
        raise FeasibeeError(f"vary = {quoted(vary)}: {rule}")
    tables = {"sweep": {path: _listed(path, values) for path, values in vary.items()}, "combine": combine}
    return Study(points_of(check_scenario(scenario), tables, Path()), runs.count, runs.seed)


def _listed(path: str, values: Any) -> list[Any]:
    """Return values as a study's file would have them."""
    if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray) or not len(values):
        rule = "must be a list of values; such as [10, 20, 40]"
        raise FeasibeeError(f"vary[{path!r}] = {quoted(values)}: {rule}")
    return [each.item() if isinstance(each, np.generic) else each for each in values]


def open_results(path: str | Path) -> xr.Dataset:
    """Open saved results: a file of `save_results` or of ``feasibee run``, or the folder of a sweep or study.

    Parameters
    ----------
    path : path
        The file, NetCDF, or the folder.

    Returns
    -------
    xarray.Dataset
        Of a file, what was saved; of a folder, all its runs as `sweep` returns them.

    Raises
    ------
    FeasibeeError
        If it is missing, wasn't written by feasibee, or was changed or damaged since.
    """
    from feasibee.results import dataset

    is_folder = isinstance(path, str | Path) and os.path.isdir(path)  # noqa: PTH112 - else raises for long names
    return to_dataset(Store(path)) if is_folder else dataset.open_results(path)


def export(store: Store, path: Path) -> int:
    """Write all runs to a file, which is complete or missing; return their number.

    Parameters
    ----------
    store : Store
        The runs.
    path : path
        The file: ``.csv`` has a row per run, ``.nc`` a dimension per field that the study varies.
    """
    if check_output(path, RESULTS) == ".nc":
        write_netcdf(to_dataset(store), path, {})
        return sum(store.count(row.key) for row in store.points)
    rows = to_dataframe(store)
    for name in (each for each in rows if rows[each].dtype.kind == "O"):
        rows[name] = [as_cell(each) if isinstance(each, str) else each for each in rows[name]]
    with atomic_write(path) as temporary:
        rows.to_csv(temporary, index=False, errors="backslashreplace")
    return len(rows)


def to_dataframe(store: Store, keys: Collection[str] | None = None, most: int | None = None) -> pd.DataFrame:
    """Return one row per run: the point, what the study varies, the truth, whether it was right, outcomes.

    ``keys`` are those of the points, by default all; ``most`` is the number of the run before which to end.
    Runs of a world that changes also have `feasibee.results.measures.OF_RUNS`. There, the column ``truth`` is
    that before any change.
    """
    points = _chosen(store, keys)
    return _runs_of(store, points, _fields(points), most)


def _runs_of(
    store: Store, points: Sequence[StoredPoint], fields: Mapping[str, list[Any]], most: int | None
) -> pd.DataFrame:
    """Return the rows of some points, whose values of the fields that vary are given."""
    import pandas as pd

    parts = [pd.DataFrame(columns=[*OF_POINTS, "run", *_of_runs(())])]
    for number, row in enumerate(points):
        results = store.results(row.key)
        some = slice(None) if most is None else results.run < most
        results = SimpleNamespace(**{name: values[some] for name, values in vars(results).items()})
        columns = {POINT: row.id, **{path: values[number] for path, values in fields.items()}}
        columns |= {SEED: np.uint64(row.seed), "truth": int(row.truth), **rightness(results, row.scenario)}
        columns |= {name: getattr(results, name) for name in ("run", *(each.name for each in OUTCOMES))}
        columns |= measures_of_runs(results) if row.scenario.dynamic else {}
        parts.append(pd.DataFrame(columns, index=range(results.run.size)))
    store.check()
    return pd.concat(parts[bool(points) :], ignore_index=True)


def _chosen(store: Store, keys: Collection[str] | None) -> list[StoredPoint]:
    return [row for row in store.points if keys is None or row.key in keys]


def to_dataset(store: Store, keys: Collection[str] | None = None, most: int | None = None) -> xr.Dataset:
    """Return all runs as a dataset with a dimension per field that the study varies, and one of the runs.

    If the points don't form a grid, because a study combines values otherwise or several studies share the
    folder, the dataset has the dimension ``point`` instead, and the fields are its coordinates. The
    coordinate ``run`` is the number of the run. If the points have different numbers of runs, missing values
    are NaN. If they have runs of different numbers, ``run`` counts from 0, and the variable ``run_number``
    has the numbers.
    """
    import pandas as pd
    import xarray as xr

    points = _chosen(store, keys)
    fields = _fields(points)
    runs = _runs_of(store, points, fields, most)
    shared = runs["run"].nunique() == max(runs[POINT].value_counts(), default=0)
    if not shared:
        runs["run_number"], runs["run"] = runs["run"], runs.groupby(POINT).cumcount()
    about = pd.DataFrame(fields)
    for name, (dtype, _) in OF_POINTS.items():
        about[name] = np.array([getattr(row, "id" if name == POINT else name) for row in points], dtype)
    axes = _axes_of(points, fields)
    along: dict[str, Any] = {**axes, "run": np.unique(runs["run"].to_numpy(np.int64))}
    data = _variables(about, axes, {name: of for name, of in OF_POINTS.items() if name not in axes})
    data |= _variables(runs, along, _of_runs(runs.columns))
    coordinates: dict[str, Any] = {name: (name, values) for name, values in along.items()}
    coordinates["run"] += ({"long_name": NUMBER if shared else "place of the run"},)
    if POINT in axes:
        coordinates |= {path: (POINT, values) for path, values in fields.items()}
    recipes = [
        {"point": row.id, "seed": row.seed, "hash": row.hash, "scenario": row.scenario.to_dict()}
        for row in points
    ]
    recipe = json.dumps({"model_version": MODEL_VERSION, "points": recipes})
    return xr.Dataset(data, coordinates, {"title": "feasibee sweep", "recipe": recipe})


OF_POINTS: Final[Mapping[str, tuple[str, dict[str, Any]]]] = {
    POINT: ("int64", {"long_name": "number of the point in the recipe"}),
    SEED: ("uint64", {"long_name": "seed of the runs"}),
    "truth": (
        "int8",
        {
            "long_name": "ground truth before any change",
            "flag_values": np.array([INFEASIBLE, FEASIBLE], np.int8),
            "flag_meanings": f"{DECISIONS[INFEASIBLE]} {DECISIONS[FEASIBLE]}",
        },
    ),
}
"""Type and attributes of the variables with a value per point."""


def _of_runs(columns: Collection[str]) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return type and attributes of the variables with a value per run, in a table with these columns."""
    right = {each.column: ("bool", {"long_name": each.of_run}) for each in MEASURES.values() if each.column}
    outcomes = {each.name: (each.dtype, attributes_of(each)) for each in OUTCOMES}
    more = {"run_number": NUMBER, **OF_RUNS}
    some = {name: ("int64", {"long_name": words}) for name, words in more.items() if name in columns}
    return {**right, **outcomes, **some}


def _variables(
    table: pd.DataFrame,
    axes: Mapping[str, Sequence[Any]],
    kinds: Mapping[str, tuple[str, dict[str, Any]]],
) -> dict[str, tuple[Any, ...]]:
    """Return columns of a table as variables; NaN, in a file a fill value, where a point lacks a run.

    ``kinds`` has the type and the attributes of each.
    """
    import pandas as pd

    shape = tuple(map(len, axes.values()))
    whole = len(table) == math.prod(shape)
    places = tuple(pd.Index(values).get_indexer(table[path]) for path, values in axes.items())
    found: dict[str, tuple[Any, ...]] = {}
    for name, (dtype, attributes) in kinds.items():
        array = np.full(shape, 0 if whole else np.nan, dtype if whole else "float64")
        values = table[name].fillna(-1).to_numpy()  # -1: a measure of worlds that change, of one that doesn't
        array[places] = values if axes else values[0]
        encoding: dict[str, Any] = {"zlib": True, "complevel": 4} if "run" in axes else {}
        if not whole:
            stored = "int8" if dtype == "bool" else dtype
            encoding |= {"dtype": stored, "_FillValue": np.iinfo(stored).min}
        found[name] = (tuple(axes), array, attributes, encoding)
    return found


def _axes_of(points: Sequence[StoredPoint], fields: Mapping[str, list[Any]]) -> dict[str, list[Any]]:
    """Return the values of each field if the points form a grid; otherwise the numbers of the points."""
    if len({row.seed for row in points}) > 1:
        fields = {**fields, SEED: [row.seed for row in points]}
    axes = {path: list(dict.fromkeys(values)) for path, values in fields.items()}
    distinct = len(set(zip(*fields.values(), strict=True))) if fields else 1
    missing = any(isinstance(value, float) and math.isnan(value) for one in axes.values() for value in one)
    if missing or not distinct == len(points) == math.prod(map(len, axes.values())):
        return {POINT: [row.id for row in points]}
    return {path: values if isinstance(values[0], str) else sorted(values) for path, values in axes.items()}


def _fields(points: Sequence[StoredPoint]) -> dict[str, list[Any]]:
    """Return the value of each point of each field that varies."""
    return {path: _column([value_of(row, path) for row in points]) for path in varied(points)}


def _column(values: list[Any]) -> list[Any]:
    """Return values of one type, as the formats need them: numbers, Booleans, or else text."""
    kinds = {type(value) for value in values} - {type(None)}
    if kinds and kinds <= {int, float}:
        return [math.nan if value is None else value for value in values]
    if kinds == {bool} and None not in values:
        return values
    return [
        "" if value is None else value if isinstance(value, str) else json.dumps(value) for value in values
    ]
