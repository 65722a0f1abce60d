"""The tables of a journal, the rows that encode runs in them, their digests, and the files in its folder.

Each change of a journal by anything else is found when it is read, since digests are compared.
"""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from enum import IntEnum
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import MODEL_VERSION
from feasibee.model.outcomes import CURVES, OUTCOMES, TRACES, Outcome
from feasibee.model.record import Record

NAME: Final = "journal.sqlite"
LOCK: Final = "journal.lock"
SEAL: Final = "journal.seal"
"""Holds the number of commits. It says whether a lost write-ahead log has taken some along."""
FORMAT: Final = 10
"""Number of the tables' format; raise it whenever `SCHEMA` changes."""


def _column(outcome: Outcome) -> str:
    """Return a column of the table ``runs`` in SQL, with a check of its values and the meaning of codes."""
    if outcome.codes:
        check = f"{outcome.name} IN ({', '.join(map(str, sorted(outcome.codes)))})"
        note = ", ".join(f"{code} {name}" for code, name in outcome.codes.items())
    else:
        check = f"{outcome.name} >= {outcome.fill}"
        note = f"{outcome.fill}: {outcome.missing}" if outcome.missing else ""
    return f"    {outcome.name} INTEGER NOT NULL CHECK ({check}),{note and f' -- {note}'}"


NAMES: Final = tuple(each.name for each in OUTCOMES)
CURVE_NAMES: Final = tuple(each.name.removesuffix("_count") for each in CURVES)
PLACES: Final = {name: place for place, name in enumerate(("run", *NAMES))}
"""Numbers of the columns in an array of runs, by name."""
RUN_COLUMNS: Final = "\n".join(map(_column, OUTCOMES))
TRACE_NAMES: Final = tuple(each.name for each in TRACES)
TRACE_COLUMNS: Final = "\n".join(
    f"    {each.name} BLOB NOT NULL, -- zlib of {each.dtype}, little-endian: at each step from 0"
    for each in TRACES
)
CURVE_COLUMNS: Final = "\n".join(f"    {name} BLOB NOT NULL," for name in CURVE_NAMES)
ENCODING: Final = "         -- zlib of int32, little-endian: robots with opinion 1 at each step from 0"
SCHEMA: Final = f"""
CREATE TABLE about (
    key TEXT PRIMARY KEY,           -- versions, how much there is, and the digest of all that
    value TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE sources (
    id INTEGER PRIMARY KEY,
    text TEXT NOT NULL UNIQUE       -- a strategy's file, as it was; part of its points' digests
);
CREATE TABLE points (
    id INTEGER PRIMARY KEY,
    hash TEXT NOT NULL,
    seed TEXT NOT NULL,             -- 64 bits without a sign, which SQLite's numbers don't hold
    truth INTEGER NOT NULL CHECK (truth IN (0, 1)), -- 1 feasible, 0 infeasible; before any change
    vary TEXT NOT NULL,             -- JSON: what the study varies, by dotted path
    scenario TEXT NOT NULL,         -- JSON: the complete form
    source INTEGER REFERENCES sources (id), -- NULL: the strategy is built in
    until TEXT,                     -- JSON: the rule that chose the number of runs. NULL: it was given
    digest BLOB NOT NULL,           -- of this row and its source
    UNIQUE (hash, seed)
);
CREATE TABLE chunks (
    point INTEGER NOT NULL REFERENCES points (id),
    kind INTEGER NOT NULL CHECK (kind IN (0, 1, 2)), -- rows of: 0 runs, 1 curves, 2 traces
    first_run INTEGER NOT NULL CHECK (first_run >= 0),
    runs INTEGER NOT NULL CHECK (runs > 0),
    digest BLOB NOT NULL,           -- of these rows
    PRIMARY KEY (point, kind, first_run)
) WITHOUT ROWID;
CREATE TABLE runs (
    point INTEGER NOT NULL REFERENCES points (id),
    run INTEGER NOT NULL CHECK (run >= 0),
{RUN_COLUMNS}
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
CREATE TABLE curves (
    point INTEGER NOT NULL REFERENCES points (id),
    run INTEGER NOT NULL CHECK (run >= 0),
{CURVE_COLUMNS.replace(",", f",{ENCODING}", 1)}
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
CREATE TABLE traces (
    point INTEGER NOT NULL REFERENCES points (id), -- of a world that changes
    run INTEGER NOT NULL CHECK (run >= 0),
{TRACE_COLUMNS}
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
"""
STATEMENTS: Final = tuple(statement.strip() for statement in SCHEMA.split(";\n") if statement.strip())


class Kind(IntEnum):
    """What the rows of a chunk are."""

    RUNS = 0
    CURVES = 1
    TRACES = 2

    @property
    def table(self) -> str:
        """Name of the table."""
        return self.name.lower()

    @property
    def columns(self) -> str:
        """Columns of a row after the point; the first is the run's number."""
        return ", ".join(("run", *COLUMNS[self]))

    @classmethod
    def of(cls, curves: bool, dynamic: bool) -> tuple[Kind, ...]:
        """Return the kinds of rows that runs have: with curves, and in a world that changes."""
        return (cls.RUNS, *[cls.CURVES] * curves, *[cls.TRACES] * dynamic)


COLUMNS: Final = {Kind.RUNS: NAMES, Kind.CURVES: CURVE_NAMES, Kind.TRACES: TRACE_NAMES}
"""Names of the columns of each kind of rows, after the run's number."""


class Entry(NamedTuple):
    """A point as its row and that of its source have it."""

    id: int
    hash: str
    seed: str
    truth: int
    vary: str
    scenario: str
    until: str | None
    source: int | None
    text: str | None
    """The file of its strategy, if it isn't built in."""


POINT: Final = ", ".join(Entry._fields[:-1])
"""Columns of the table of points, but for its digest."""


class Chunk(NamedTuple):
    """Consecutive rows of a point that were written together."""

    first_run: int
    runs: int
    digest: bytes


SIZE = 16
"""Bytes per digest: a random change goes unseen with probability 10**-38."""


def _digest(*parts: bytes) -> bytes:
    found = hashlib.blake2b(digest_size=SIZE)
    for part in parts:
        found.update(len(part).to_bytes(8, "little"))
        found.update(part)
    return found.digest()


def digest_of_entry(entry: Entry) -> bytes:
    """Return the digest of a point; it depends on the format and the model version."""
    return _digest(json.dumps([FORMAT, MODEL_VERSION, *entry]).encode())


def digest_of_rows(kind: Kind, point: int, rows: Any) -> bytes:
    """Return the digest of a chunk: an array of runs, or tuples of a run and what is kept by step."""
    place = json.dumps([kind, point]).encode()
    if kind is Kind.RUNS:
        return _digest(place, np.asarray(rows, "<i8").tobytes())
    return _digest(place, *(part for run, *blobs in rows for part in (str(run).encode(), *blobs)))


def digest_of_about(about: Mapping[str, str]) -> str:
    """Return the digest of the table ``about``, without its row for the digest."""
    rows = sorted((key, value) for key, value in about.items() if key != "digest")
    return _digest(json.dumps(rows).encode()).hex()


def write_seal(folder: Path, commits: int) -> None:
    """Write a journal's number of commits to the seal, a file in the same folder."""
    text = f"{commits:020d}"
    handle = os.open(folder / SEAL, os.O_WRONLY | os.O_CREAT, 0o666)  # truncating it takes 2 ms
    try:
        os.write(handle, f"{text} {_digest(text.encode()).hex()}\n".encode())
    finally:
        os.close(handle)


def read_seal(folder: Path) -> int:
    """Return a journal's least possible number of commits; 0 if unknown."""
    path = folder / SEAL
    if not path.is_file():
        return 0
    try:
        commits, digest = path.read_text("ascii").split()
    except (OSError, ValueError):
        return 0
    return int(commits) if digest == _digest(commits.encode()).hex() else 0


LEVEL, WINDOW_BITS, MEMORY_LEVEL = 1, 12, 5
"""Of zlib: 18 us per run of 1,000 steps, and 9 to read it. The usual 6, 15 and 8 take twice as long."""


class EncodedRuns(NamedTuple):
    """Consecutive runs of one point, as the rows of a journal's tables."""

    runs: list[tuple[int, ...]]
    """Number of each run, then its `OUTCOMES`."""
    curves: list[tuple[Any, ...]]
    """Number of each run, then its compressed `CURVES`; empty if no curves are kept."""
    traces: list[tuple[Any, ...]]
    """Number of each run, then its compressed `TRACES`; empty in a world that doesn't change."""


def encode(record: Record) -> EncodedRuns:
    """Encode runs, and their curves and traces if the record has any."""
    by_step = (list(_rows_by_step(record, outcomes)) for outcomes in (CURVES, TRACES))
    numbers = range(record.first_run, record.first_run + record.runs)
    rows = zip(numbers, *(getattr(record, each.name).tolist() for each in OUTCOMES), strict=True)
    return EncodedRuns(list(rows), *by_step)


def _rows_by_step(record: Record, outcomes: Sequence[Outcome]) -> Iterator[tuple[Any, ...]]:
    """Yield each run's number and its compressed outcomes by step; nothing if the record has none."""
    arrays = [getattr(record, each.name) for each in outcomes]
    for row in range(record.runs) if arrays[0].shape[1] else ():
        blobs = []
        for values in (each[row] for each in arrays):
            packer = zlib.compressobj(LEVEL, zlib.DEFLATED, WINDOW_BITS, MEMORY_LEVEL)
            little = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
            blobs.append(packer.compress(little.tobytes()) + packer.flush())
        yield record.first_run + row, *blobs


def curve_of(blob: bytes, dtype: str = "int32") -> NDArray[Any]:
    """Return an outcome at each step: shape (steps + 1,)."""
    return np.frombuffer(zlib.decompress(blob), np.dtype(dtype).newbyteorder("<")).astype(dtype)


def difference(
    kind: Kind, ours: tuple[Any, ...], theirs: tuple[Any, ...]
) -> tuple[str, object, object] | None:
    """Return the column in which two rows of a run differ, and both values; None if they agree."""
    if ours == theirs:
        return None
    if kind is Kind.RUNS:
        return next(each for each in zip(PLACES, ours, theirs, strict=True) if each[1] != each[2])
    types = [each.dtype for each in (CURVES if kind is Kind.CURVES else TRACES)]
    for name, dtype, mine, other in zip(COLUMNS[kind], types, ours[1:], theirs[1:], strict=True):
        here, there = curve_of(mine, dtype), curve_of(other, dtype)  # another zlib may give other bytes
        if here.size != there.size:
            return "its number of steps", here.size - 1, there.size - 1
        for step in np.flatnonzero(here != there)[:1]:
            what = f"the count of {name} opinions" if kind is Kind.CURVES else name
            return f"{what} at step {step}", int(here[step]), int(there[step])
    return None
