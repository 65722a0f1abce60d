"""Simulate saved results again, and compare each value and figure with what was saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError
from feasibee.base.files import FIGURES
from feasibee.figures.sweep import Shown, view_in
from feasibee.results.dataset import open_results, recipe_of, scenario_of, to_dataset
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.executors import threads
from feasibee.simulation.store import Store, differences
from feasibee.simulation.sweep import Execution
from feasibee.simulation.table import Summary, summaries, varied
from feasibee.studies.benchmark import Card, again

NAMED = 10
"""Largest number of runs that a line names."""


NOW = {"version": version("feasibee"), "model_version": MODEL_VERSION}
"""Versions that simulate results again."""


class Reproduction(NamedTuple):
    """How a second simulation of saved results compares with the first."""

    runs: int
    """Number of runs that were simulated again."""
    versions: dict[str, tuple[str, str]]
    """Versions that wrote the results and that simulated them again, by name."""
    differences: list[str]
    """Which columns of which runs differ; none if all bytes are equal."""
    figures: dict[str, bool]
    """Whether each figure has the same bytes, by its path."""


Advance = Callable[[float], None]


def reproduce_file(
    path: Path, figures: Sequence[Path], trust: bool, workers: int | None, progress: Advance
) -> Reproduction:
    """Simulate the runs of a file, .nc, again; by default draw the figures that are named as the file."""
    saved = open_results(path)
    recipe, scenario = recipe_of(saved), scenario_of(saved, trust=trust)
    runs = Runs(*(recipe.get(key) for key in ("runs", "seed", "first_run")))  # type: ignore[arg-type]
    curves = "feasible_count" in saved
    record = simulate_record(scenario, runs, curves=curves, threads=workers, progress=progress)
    again = to_dataset(record, scenario, runs.seed)
    try:
        part = again.sel({name: saved[name] for name in saved.dims})  # results may be saved in part
        differences = list(_differences(saved, part, saved["run"].values))
    except KeyError as error:
        lack = f"has {error.args[0]}, or lacks it, unlike results of feasibee.simulate"
        raise FeasibeeError(f"{path}: {lack}; use a file of feasibee run --out") from None
    same_name = (path.with_suffix(suffix) for suffix in FIGURES)
    drawn = figures or [each for each in same_name if each.is_file()]
    alike = {str(each): _drawn_alike(again, each) for each in drawn}
    return Reproduction(saved["run"].size, _versions(recipe, recipe_of(again)), differences, alike)


def _versions(saved: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return the versions in two recipes, as far as both have them."""
    names = {"version": "feasibee", "model_version": "model", "python": "Python"}
    one, two = ({**each, **each.get("libraries", {})} for each in (saved, now))
    wanted = [*names, *saved.get("libraries", {})]
    return {
        names.get(key, key): (str(one[key]), str(two[key])) for key in wanted if key in one and key in two
    }


def _differences(saved: xr.Dataset, again: xr.Dataset, numbers: Any) -> Iterator[str]:
    """Yield each column that differs, and in which runs."""
    for name in map(str, saved.data_vars):
        one, two = saved[name].values, again[name].values
        rows = np.ones(numbers.size, bool)
        if (one.dtype, one.shape) == (two.dtype, two.shape):
            rows = (one != two).reshape(numbers.size, -1).any(axis=1)
        if rows.any():
            named = ", ".join(map(str, numbers[rows][:NAMED])) + (", ..." if rows.sum() > NAMED else "")
            yield f"{name} in {rows.sum():,} of {numbers.size:,} runs: {named}"


def _drawn_alike(dataset: xr.Dataset, path: Path) -> bool:
    """Return whether the figure of results has the bytes of a file."""
    from feasibee.figures.decisions import draw_runs
    from feasibee.figures.style import save_figure

    if path.suffix.lower() not in FIGURES:
        return False
    return _same_bytes(path, partial(save_figure, draw_runs(dataset)))


def _same_bytes(path: Path, save: Callable[[Path], None]) -> bool:
    """Return whether a figure that is saved again has the bytes of a file."""
    with TemporaryDirectory() as folder:
        save(drawn := Path(folder, path.name))
        return drawn.read_bytes() == path.read_bytes()


def reproduce_card(
    path: Path, figures: Sequence[Path], trust: bool, workers: int | None, progress: Advance
) -> Reproduction:
    """Simulate all runs of a card of the benchmark again; it has no figures."""
    if figures:
        raise FeasibeeError(f"--again {figures[0]}: a card has no figures; leave it out")
    card = Card.read(path)
    execution = Execution(pool=threads(workers), progress=lambda each: progress(each.work_done / each.most))
    differences = again(card, trust, execution)
    versions = _versions({"version": card.version, "model_version": card.model_version}, NOW)
    return Reproduction(sum(row.runs for row in card.rows), versions, differences, {})


def reproduce_folder(
    folder: Path, figures: Sequence[Path], trust: bool, workers: int | None, progress: Advance
) -> Reproduction:
    """Simulate all runs of a folder again, and draw its figures again; by default those in it."""
    views, store, differ, done = _views_in(folder, figures), Store(folder), [], 0
    points = store.points
    for number, point in enumerate(points, start=1):
        scenario = point.scenario.with_trust() if trust else point.scenario
        for saved in store.records(point.key):
            runs, curves = Runs(saved.runs, point.seed, saved.first_run), saved.feasible_count.shape[1] > 0
            again = simulate_record(scenario, runs, curves=curves, threads=workers)
            differ += [
                f"{point.name}, run {run}: {what} was {old}, is {new}"
                for run, what, old, new in differences(saved, again)
            ]
        done += store.count(point.key)
        progress(number / len(points))
    store.check()
    alike = _redrawn_alike(summaries(store), folder, views) if views else {}
    return Reproduction(done, _versions({**NOW, "version": store.version}, NOW), differ, alike)


def _views_in(folder: Path, figures: Sequence[Path]) -> dict[Path, Shown]:
    """Return what the figures show, or those in the folder; a given one that isn't a sweep's is an error."""
    there = sorted(each for each in folder.iterdir() if each.suffix.lower() in FIGURES)
    views = {each: view_in(each) for each in figures or there}
    for path, view in views.items():
        if figures and view is None:
            remedy = "leave it out, or draw it again"
            raise FeasibeeError(f"{path}: isn't a figure of feasibee results plot; {remedy}")
    return {path: view for path, view in views.items() if view is not None}


def _redrawn_alike(found: Sequence[Summary], folder: Path, views: Mapping[Path, Shown]) -> dict[str, bool]:
    """Return whether each figure of a sweep has the bytes of its file, which says what it shows."""
    alike, varying = {}, varied([each.row for each in found])
    for path, view in views.items():
        points = view.drawable(found, folder)
        alike[str(path)] = _same_bytes(path, partial(view.save, points, view.over(points, varying)))
    return alike
