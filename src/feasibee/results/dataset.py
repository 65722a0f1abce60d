"""Convert records to labelled datasets with their recipe; save them to files and open them again."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError, quoted
from feasibee.base.files import RESULTS, atomic_write, check_output, write_csv
from feasibee.base.outcomes import CURVES, OUTCOMES, TRACES, Column
from feasibee.base.record import Record
from feasibee.results.measures import measures_of_runs
from feasibee.results.reading import reading
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario

LIBRARIES = ("numpy", "xarray", "matplotlib")
DIGEST = "digest"
"""Name of the attribute with the digest of a saved file."""
SAVED = "name a file that feasibee saved"


def to_dataset(record: Record, scenario: Scenario, seed: int) -> xr.Dataset:
    """Return a record as a dataset over run and step, with its recipe as JSON in ``attrs["recipe"]``."""
    numbers = np.arange(record.first_run, record.first_run + record.runs, dtype=np.int64)
    coordinates: dict[str, Any] = {"run": ("run", numbers, {"long_name": "number of the run"})}
    data: dict[str, Any] = {
        each.name: ("run", getattr(record, each.name), attributes_of(each))
        for each in OUTCOMES
        if each.needs is None or each.needs.is_met(scenario)
    }
    by_step = [each for each in (*CURVES, *TRACES) if getattr(record, each.name).shape[1]]
    data |= {
        each.name: (("run", "step"), getattr(record, each.name), attributes_of(each)) for each in by_step
    }
    if by_step:
        steps = np.arange(getattr(record, by_step[0].name).shape[1], dtype=np.int64)
        coordinates["step"] = ("step", steps, {"long_name": "time", "units": "step"})
    about = {"title": "feasibee results", "recipe": json.dumps(recipe(record, scenario, seed))}
    return xr.Dataset(data, coordinates, about)


def attributes_of(outcome: Column) -> dict[str, Any]:
    """Return the attributes of an outcome's variable, by the CF conventions."""
    if not outcome.codes:
        return {"long_name": outcome.meaning, "units": outcome.unit}
    codes = dict(sorted(outcome.codes.items()))
    values = np.array(list(codes), outcome.dtype)
    return {"long_name": outcome.words, "flag_values": values, "flag_meanings": " ".join(codes.values())}


def recipe(record: Record, scenario: Scenario, seed: int) -> dict[str, Any]:
    """Return all that is needed to compute a record again, with the versions that computed it."""
    return {
        "scenario": scenario.to_dict(),
        "scenario_hash": scenario.hash,
        "seed": seed,
        "first_run": record.first_run,
        "runs": record.runs,
        "truth": "feasible" if truth(scenario) else "infeasible",
        "model_version": MODEL_VERSION,
        "version": version("feasibee"),
        "python": platform.python_version(),
        **({"strategy_source": scenario.manifest.source} if scenario.manifest.source else {}),
        "libraries": {name: version(name) for name in LIBRARIES},
    }


def recipe_of(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the recipe that a dataset carries."""
    if not isinstance(dataset, xr.Dataset):
        raise FeasibeeError(
            f"results = {quoted(dataset)}: must be a Dataset; use one that feasibee.simulate returned"
        )
    try:
        found = json.loads(dataset.attrs["recipe"])
    except (KeyError, TypeError, ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or not isinstance(found.get("scenario"), dict):
        raise FeasibeeError("results without a recipe in their attributes; use those of feasibee.simulate")
    return found


def scenario_of(dataset: xr.Dataset, *, trust: bool = False) -> Scenario:
    """Return the scenario that a dataset was computed from, without running any of its code.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `feasibee.simulate` or `open_results`.
    trust : bool
        Whether simulating the scenario may run the text of a user's strategy that the dataset contains. If
        False, the text runs only if the file at its path has the same text.
    """
    recipe = recipe_of(dataset)
    return Scenario.from_tables(recipe["scenario"], source=recipe.get("strategy_source"), trusted=trust)


def save_results(dataset: xr.Dataset, path: str | Path) -> None:
    """Save results as NetCDF or CSV; a failed write leaves the previous file, if any.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `feasibee.simulate`.
    path : path
        Ends with ``.nc`` for NetCDF, which contains everything, or with ``.csv``. A CSV file has a row per
        run, and neither the opinions at each step nor the recipe.

    Raises
    ------
    FeasibeeError
        If the suffix is another, the dataset has no recipe, or the file can't be written.
    """
    kind = check_output(path, RESULTS)
    recipe_of(dataset)
    if kind == ".csv":
        _write_runs(dataset, Path(path))
        return
    curves = [str(name) for name, variable in dataset.data_vars.items() if variable.ndim == 2]
    packed = {name: {"zlib": True, "complevel": 4} for name in curves}
    sealed = dataset.assign_attrs({DIGEST: _digest(dataset)})
    write_netcdf(sealed, path, packed)


def write_netcdf(dataset: xr.Dataset, path: str | Path, encoding: Mapping[Any, Any]) -> None:
    """Write a dataset as NetCDF with `atomic_write`; ``encoding`` is that of its variables."""
    with atomic_write(path) as temporary:
        # In memory: HDF5 can't close a file on a full disk, and prints a traceback for each of its parts.
        temporary.write_bytes(dataset.to_netcdf(engine="h5netcdf", encoding=encoding))


def _write_runs(dataset: xr.Dataset, path: Path) -> None:
    """Write a row per run: its number, its outcomes, and its measures in a world that changes."""
    if "run" not in dataset.dims:
        raise FeasibeeError(
            "results without the dimension run can't be written as CSV; save the dataset of feasibee.simulate"
        )
    names = ["run", *(str(name) for name, values in dataset.data_vars.items() if values.dims == ("run",))]
    columns = {name: dataset[name].values for name in names}
    if "truth" in dataset:
        columns |= measures_of_runs(dataset)
    write_csv(path, list(columns), zip(*(each.tolist() for each in columns.values()), strict=True))


def open_results(path: str | Path) -> xr.Dataset:
    """Open saved results.

    Raises
    ------
    FeasibeeError
        If the file is missing, isn't NetCDF saved by feasibee, or was changed or damaged since.
    """
    if not os.path.isfile(Path(path)):  # noqa: PTH113 - Path.is_file raises for a long name
        why = "it isn't a plain file" if os.path.lexists(path) else "there is no such file"
        raise FeasibeeError(f"{path}: can't be read as NetCDF: {why}; {SAVED}")
    try:
        with reading(path) as parts:
            recipe_of(xr.Dataset(attrs=(attributes := next(parts))))
            variables = dict(parts)
    except FeasibeeError as error:
        raise FeasibeeError(f"{path}: {error}") from None
    except (OSError, ValueError) as error:
        raise FeasibeeError(f"{path}: can't be read as NetCDF: {error}; {SAVED}") from None
    try:
        dataset = xr.decode_cf(xr.Dataset(variables, attrs=attributes)).load()
        is_saved = dataset.attrs.pop(DIGEST, None) == _digest(dataset)
    except Exception:  # xarray raises many kinds of errors for names, dimensions and attributes of others
        is_saved = False
    if not is_saved:
        raise FeasibeeError(f"{path}: differs from what save_results wrote; {SAVED}")
    return dataset


def _digest(dataset: xr.Dataset) -> str:
    """Return the SHA-256 of all values and the recipe, independent of byte order and order of variables."""
    text = hashlib.sha256(str(dataset.attrs["recipe"]).encode())
    for name, variable in sorted(dataset.variables.items(), key=lambda each: str(each[0])):
        values = np.ascontiguousarray(variable.values)
        plain = values.astype(values.dtype.newbyteorder("<"))
        text.update(repr((name, variable.dims, plain.dtype.str, plain.shape)).encode())
        text.update(plain.tobytes())
    return text.hexdigest()
