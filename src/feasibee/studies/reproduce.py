"""Simulate saved results again, and compare each value and figure with what was saved."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from feasibee.errors import FeasibeeError
from feasibee.files import FIGURES
from feasibee.model.codes import MODEL_VERSION
from feasibee.model.outcomes import CURVES
from feasibee.model.record import Record
from feasibee.results.dataset import open_results, recipe_of, scenario_of, to_dataset
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.sweeps.content import name_of
from feasibee.sweeps.journal import Journal, StoredPoint
from feasibee.sweeps.schema import Kind

Advance = Callable[[float], None]


class Reproduction(NamedTuple):
    """How a second simulation of saved results compares with the first."""

    runs: int
    """Number of runs that were simulated again."""
    versions: dict[str, tuple[str, str]]
    """Versions that wrote the results and that simulated them again, by name."""
    differing: dict[str, list[int]]
    """Numbers of the runs that differ, by column; none if all bytes are equal."""
    figures: dict[str, bool]
    """Whether each figure has the same bytes, by its path."""

    @property
    def same(self) -> bool:
        """Whether every byte is the same."""
        return not self.differing and all(self.figures.values())


def reproduce(
    path: Path,
    figures: Sequence[Path] = (),
    *,
    trust: bool = False,
    workers: int | None = None,
    progress: Advance = lambda share: None,
) -> Reproduction:
    """Simulate saved results again from their recipe, and compare every byte.

    Parameters
    ----------
    path : Path
        Results of ``feasibee run --out``, .nc; or the folder of a journal.
    figures : sequence of Path
        Figures of the same results; by default those of the same name in the same folder.
    trust : bool
        Whether the text of a user's strategy in the results may run.
    workers : int, optional
        Number of threads, by default one per processor.
    progress : callable, optional
        Called with the share of the work that is done.
    """
    if not path.is_dir():
        return _of_file(path, figures, trust, workers, progress)
    if figures:
        raise FeasibeeError(f"{figures[0]}: is compared with results of a file only; leave out --figure")
    return _of_journal(path, trust, workers, progress)


def _of_file(
    path: Path, figures: Sequence[Path], trust: bool, workers: int | None, progress: Advance
) -> Reproduction:
    saved = open_results(path)
    recipe, scenario = recipe_of(saved), scenario_of(saved, trust=trust)
    runs = Runs(*(recipe.get(key) for key in ("runs", "seed", "first_run")))  # type: ignore[arg-type]
    curves = "feasible_count" in saved
    record = simulate_record(scenario, runs, curves=curves, threads=workers, progress=progress)
    again = to_dataset(record, scenario, runs.seed)
    differing = _unlike_columns(saved, again, path)
    same_name = (path.with_suffix(suffix) for suffix in FIGURES)
    paths = figures or [each for each in same_name if each.is_file()]
    drawn = {str(each): _drawn_alike(again, each) for each in paths}
    versions = _versions(recipe, recipe_of(again))
    return Reproduction(saved["run"].size, versions, differing, drawn)


def _versions(saved: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return the versions in two recipes, as far as both have them."""
    one, two = (
        {"feasibee": each.get("version"), "model": each.get("model_version"), "Python": each.get("python")}
        | each.get("libraries", {})
        for each in (saved, now)
    )
    return {name: (str(one[name]), str(two[name])) for name in one if one[name] and two.get(name)}


def _of_journal(folder: Path, trust: bool, workers: int | None, progress: Advance) -> Reproduction:
    differing: dict[str, list[int]] = {}
    with Journal(folder) as journal:
        parts = [(point, runs) for point in journal.points for runs in _stretches(journal, point)]
        total, done = sum(runs.count for _, runs in parts), 0
        now = {"version": version("feasibee"), "model_version": MODEL_VERSION}
        for point, runs in parts:
            scenario = point.scenario.with_trust() if trust else point.scenario
            curves = any(journal.chunks(Kind.CURVES, point.id))
            again = simulate_record(scenario, runs, curves=curves, threads=workers)
            saved = _saved(journal, point.id, again)
            one, two = (to_dataset(each, scenario, point.seed) for each in (saved, again))
            name = name_of(point.id, json.dumps(point.values))
            found = _unlike_columns(one, two, folder)
            differing |= {f"{column} of {name}": numbers for column, numbers in found.items()}
            done += runs.count
            progress(done / total)
        return Reproduction(total, _versions(journal.about, now), differing, {})


def _stretches(journal: Journal, point: StoredPoint) -> Iterator[Runs]:
    """Yield the consecutive runs of a point."""
    numbers = np.sort(journal.results(point.id).run)
    for part in np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1):
        if part.size:
            yield Runs(part.size, point.seed, int(part[0]))


def _saved(journal: Journal, point: int, again: Record) -> Record:
    """Return the runs of a record as a journal has them."""
    lengths = again.feasible_count.shape[1], again.truth.shape[1]
    saved = journal.record(point, Record.empty(again.first_run, again.runs, *lengths))
    if lengths[0]:
        unkept = saved.feasible_count[:, 0] < 0  # runs that were simulated before curves were kept
        for each in CURVES:
            getattr(saved, each.name)[unkept] = getattr(again, each.name)[unkept]
    return saved


def _unlike_columns(saved: xr.Dataset, again: xr.Dataset, path: Path) -> dict[str, list[int]]:
    """Return the numbers of the runs in which each column differs; results may have been saved in part."""
    found = {}
    try:
        numbers = saved["run"].values
        part = again.sel({name: saved[name] for name in saved.dims})
        for name in map(str, saved.data_vars):
            one, two = saved[name].values, part[name].values
            rows = np.ones(numbers.size, bool)
            if (one.dtype, one.shape) == (two.dtype, two.shape):
                rows = (one != two).reshape(numbers.size, -1).any(axis=1)
            if rows.any():
                found[name] = numbers[rows].tolist()
    except KeyError as error:
        lack = f"has {error.args[0]}, or lacks it, unlike results of feasibee.simulate"
        raise FeasibeeError(f"{path}: {lack}; use a file of feasibee run --out") from None
    return found


def _drawn_alike(dataset: xr.Dataset, path: Path) -> bool:
    """Return whether the figure of results has the bytes of a file."""
    from feasibee.figures.decisions import draw_runs
    from feasibee.figures.style import save_figure

    if path.suffix.lower() not in FIGURES:
        return False
    with TemporaryDirectory() as folder:
        drawn = Path(folder, path.name)
        save_figure(draw_runs(dataset), drawn)
        return drawn.read_bytes() == path.read_bytes()
