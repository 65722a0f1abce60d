"""Convert the results of a sweep or study of feasibee before the folder of chunks: journal.sqlite to runs/.

    python convert_journal.py results

The journal stays as it is; runs that are in the folder already are compared when they are read. A journal of
another model version can't be converted: its runs aren't those of this version.
"""

from __future__ import annotations

import json
import sqlite3
import sys
import zlib
from contextlib import closing
from pathlib import Path

import numpy as np

from feasibee import FeasibeeError, Scenario
from feasibee.base.codes import MODEL_VERSION
from feasibee.base.outcomes import ACCOUNT, CURVES, OUTCOMES, TRACES
from feasibee.base.record import Record
from feasibee.simulation.plan import DesignPoint, StoppingRule
from feasibee.simulation.store import Store

FORMAT = "10"
BY_STEP = (
    ("curves", {each.name.removesuffix("_count"): each for each in CURVES}),
    ("traces", {each.name: each for each in TRACES}),
)


def convert(folder: Path) -> int:
    """Write the runs of a journal into a folder's store; return their number."""
    path = folder / "journal.sqlite"
    if not path.is_file():
        raise FeasibeeError(f"{folder}: has no journal.sqlite; name the folder of a sweep or study")
    runs, store = 0, Store(folder, write=True)
    with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
        about = dict(database.execute("SELECT key, value FROM about"))
        if (about["format"], about["model_version"]) != (FORMAT, str(MODEL_VERSION)):
            raise FeasibeeError(f"{path}: is of another format or model version; sweep again")
        texts = dict(database.execute("SELECT id, text FROM sources"))
        query = "SELECT id, seed, vary, scenario, source, until FROM points ORDER BY id"
        for point, seed, vary, tables, source, until in database.execute(query).fetchall():
            scenario = Scenario.from_tables(json.loads(tables), source=texts.get(source), trusted=False)
            rule = StoppingRule(**json.loads(until)) if until else None
            (key,) = store.add([DesignPoint(json.loads(vary), scenario)], int(seed), rule)
            for record in records_of(database, point, scenario):
                store.put(key, record)
                runs += record.runs
    return runs


def records_of(database: sqlite3.Connection, point: int, scenario: Scenario) -> list[Record]:
    """Return the stretches of consecutive runs of a point, those with curves apart."""
    columns = ", ".join(each.name for each in OUTCOMES)
    query = f"SELECT run, {columns} FROM runs WHERE point = ? ORDER BY run"
    rows = np.array(database.execute(query, (point,)).fetchall(), np.int64).reshape(-1, 1 + len(OUTCOMES))
    by_step = {
        name: {run: blobs for run, *blobs in database.execute(
            f"SELECT run, {', '.join(outcomes)} FROM {name} WHERE point = ?", (point,)
        )}
        for name, outcomes in BY_STEP
    }  # fmt: skip
    has_curves = np.array([run in by_step["curves"] for run in rows[:, 0]], bool)
    breaks = np.flatnonzero((np.diff(rows[:, 0]) != 1) | (np.diff(has_curves) != 0)) + 1
    return [record_of(part, by_step, scenario) for part in np.split(rows, breaks) if len(part)]


def record_of(rows: np.ndarray, by_step: dict[str, dict[int, list[bytes]]], scenario: Scenario) -> Record:
    """Return consecutive runs as a record."""
    first, length = int(rows[0, 0]), scenario.run.steps + 1
    curves = first in by_step["curves"]
    record = Record.empty(first, len(rows), length * curves, length * scenario.dynamic)
    values = dict(zip((each.name for each in OUTCOMES), rows[:, 1:].T, strict=True))
    record.decision[:], record.decision_step[:] = values["decision"], values["decision_step"]
    record.account[:] = np.stack([values[each.name] for each in ACCOUNT], axis=1)
    for name, outcomes in BY_STEP:
        for row in range(len(rows)):
            for each, blob in zip(outcomes.values(), by_step[name].get(first + row, ()), strict=False):
                little = np.dtype(each.dtype).newbyteorder("<")
                getattr(record, each.name)[row] = np.frombuffer(zlib.decompress(blob), little)
    return record


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(f"{name}: {convert(Path(name))} runs are in {name}/runs")
