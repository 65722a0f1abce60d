"""The journal of a study: one SQLite file, with a transaction for each chunk of runs.

What is in it stays, whatever happens to the process or the machine; what isn't is computed again. A run is
known by the hash of its scenario, the seed, and its number.
"""

from __future__ import annotations

import json
import os
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.feasibility import truth
from feasibee.record import Record
from feasibee.scenario import Scenario
from feasibee.study.plan import Point, Until
from feasibee.vocabulary import MODEL_VERSION

NAME = "journal.sqlite"
LOCK = "journal.lock"
FORMAT = 2
SCHEMA = """
CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE sources (
    id INTEGER PRIMARY KEY,
    text TEXT NOT NULL UNIQUE       -- a strategy's file, as it was
);
CREATE TABLE points (
    id INTEGER PRIMARY KEY,
    hash TEXT NOT NULL,
    seed TEXT NOT NULL,             -- 64 bits without a sign, which SQLite's numbers don't hold
    truth INTEGER NOT NULL,         -- 1 feasible, 0 infeasible
    vary TEXT NOT NULL,             -- JSON: what the study varies, by dotted path
    scenario TEXT NOT NULL,         -- JSON: the complete form
    source INTEGER REFERENCES sources (id), -- NULL: the strategy is built in
    until TEXT,                     -- JSON: the rule that chose the number of runs. NULL: it was given
    UNIQUE (hash, seed)
);
CREATE TABLE runs (
    point INTEGER NOT NULL REFERENCES points (id),
    run INTEGER NOT NULL,
    decision INTEGER NOT NULL,      -- 1 feasible, 0 infeasible, -1 undecided
    decision_step INTEGER NOT NULL, -- -1: undecided
    bits_sent INTEGER NOT NULL,
    commit_step INTEGER NOT NULL,   -- -1: never
    committed_feasible INTEGER NOT NULL,
    committed_infeasible INTEGER NOT NULL,
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
CREATE TABLE curves (
    point INTEGER NOT NULL REFERENCES points (id),
    run INTEGER NOT NULL,
    feasible BLOB NOT NULL,         -- zlib of int32, little-endian: robots with opinion 1 at each step from 0
    infeasible BLOB NOT NULL,
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
"""
COLUMNS = "decision, decision_step, bits_sent, commit_step, committed_feasible, committed_infeasible"


class Row(NamedTuple):
    """A point in the journal."""

    id: int
    hash: str
    seed: int
    truth: bool
    values: dict[str, Any]
    scenario: Scenario
    """With the text of the strategy's file that the journal keeps, which isn't run unasked."""
    until: dict[str, float] | None
    """The rule by which the number of runs was chosen, if they say it."""
    source: int | None
    """Number of the text of its strategy's file, if it has one."""


class Journal:
    """A journal in a folder.

    Parameters
    ----------
    folder : path
        Where it is.
    write : bool
        Whether to write; then it is made if need be, and locked against others that write.

    Raises
    ------
    FeasibeeError
        If there is none, it is damaged, of another model version, or another process writes to it.
    """

    def __init__(self, folder: str | Path, write: bool = False) -> None:
        self.folder = Path(folder)
        self.path = self.folder / NAME
        self._lock: sqlite3.Connection | None = None
        if not write and not self.path.is_file():
            raise FeasibeeError(f"{self.folder}: has no {NAME}; name the folder of a sweep")
        with self._told():
            if write:
                self._lock = self._locked()
            try:
                self._database = self._connected(write)
                self._open(write)
            except BaseException:
                self.close()
                raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave it to others."""
        if hasattr(self, "_database"):
            self._database.close()
        if self._lock is not None:
            self._lock.close()

    @property
    def points(self) -> list[Row]:
        """All points, in the order in which they were added."""
        with self._told():
            rows = self._database.execute(
                "SELECT points.id, hash, seed, truth, vary, scenario, until, source, text"
                " FROM points LEFT JOIN sources ON sources.id = source ORDER BY points.id"
            ).fetchall()
        return [
            Row(
                id_,
                hash_,
                int(seed),
                bool(true),
                json.loads(vary),
                Scenario.from_tables(json.loads(scenario), source=text, trusted=False),
                json.loads(until or "null"),
                source,
            )
            for id_, hash_, seed, true, vary, scenario, until, source, text in rows
        ]

    def add(self, points: Sequence[Point], seed: int, until: Until | None = None) -> list[int]:
        """Enter points, unless they are there; return their numbers in the journal."""
        rule = None if until is None else json.dumps(vars(until))
        rows = [
            (
                point.scenario.hash,
                str(seed),
                int(truth(point.scenario)),
                json.dumps(dict(point.values)),
                json.dumps(point.scenario.to_dict()),
                rule,
                point.scenario.manifest.source or None,
            )
            for point in points
        ]
        found = self._enter(rows)
        return [found[row[0], row[1]] for row in rows]

    def _enter(self, rows: Sequence[tuple[Any, ...]]) -> dict[tuple[str, str], int]:
        """Enter points; return the numbers of all by hash and seed."""
        with self._transaction() as database:
            database.executemany(
                "INSERT OR IGNORE INTO sources (text) VALUES (?)", {row[-1:] for row in rows if row[-1]}
            )
            database.executemany(
                "INSERT INTO points (hash, seed, truth, vary, scenario, until, source)"
                " VALUES (?, ?, ?, ?, ?, ?, (SELECT id FROM sources WHERE text = ?))"
                " ON CONFLICT (hash, seed) DO UPDATE SET"
                " vary = excluded.vary, until = COALESCE(excluded.until, until)",
                rows,
            )
            found = database.execute("SELECT hash, seed, id FROM points")
            return {(hash_, seed): id_ for hash_, seed, id_ in found}

    def write(self, parts: Iterable[tuple[int, Record]]) -> None:
        """Enter the runs of a chunk: all of them or, if that fails, none."""
        with self._transaction() as database:
            for point, record in parts:
                database.executemany(
                    f"INSERT OR IGNORE INTO runs (point, run, {COLUMNS}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                    _rows(point, record),
                )
                if record.feasible_count.shape[1]:
                    database.executemany(
                        "INSERT OR IGNORE INTO curves VALUES (?, ?, ?, ?)", _curves(point, record)
                    )

    def missing(self, point: int, runs: int, curves: bool) -> list[tuple[int, int]]:
        """Return which runs below a number aren't there: stretches, each first and one past the last."""
        table = "curves" if curves else "runs"
        with self._told():
            there = self._database.execute(
                f"SELECT run FROM {table} WHERE point = ? AND run < ? ORDER BY run", (point, runs)
            )
            stretches, first = [], 0
            for (run,) in there:
                if run > first:
                    stretches.append((first, run))
                first = run + 1
        return [*stretches, (first, runs)] if first < runs else stretches

    def counts(self) -> dict[int, tuple[int, int]]:
        """Return how many runs each point has, and how many of them decided as the truth."""
        with self._told():
            rows = self._database.execute(
                "SELECT point, COUNT(*), SUM(decision = truth)"
                " FROM runs JOIN points ON id = point GROUP BY point"
            )
            return {point: (runs, right) for point, runs, right in rows}

    def right(self, point: int, runs: int) -> int:
        """Return how many of the first runs of a point decided as the truth."""
        with self._told():
            (number,) = self._database.execute(
                "SELECT COUNT(*) FROM runs JOIN points ON id = point"
                " WHERE point = ? AND run < ? AND decision = truth",
                (point, runs),
            ).fetchone()
        return int(number)

    def columns(self, point: int) -> NDArray[np.int64]:
        """Return the runs of a point: int64, shape (runs, 7), the run's number and then `COLUMNS`."""
        with self._told():
            rows = self._database.execute(
                f"SELECT run, {COLUMNS} FROM runs WHERE point = ? ORDER BY run", (point,)
            ).fetchall()
        return np.array(rows, np.int64).reshape(-1, 7)

    def curves(self, point: int) -> Iterator[tuple[int, NDArray[np.int32], NDArray[np.int32]]]:
        """Yield run, feasible count and infeasible count of a point's runs whose curves were kept."""
        with self._told():
            yield from (
                (run, *(np.frombuffer(zlib.decompress(blob), "<i4").astype(np.int32) for blob in blobs))
                for run, *blobs in self._database.execute(
                    "SELECT run, feasible, infeasible FROM curves WHERE point = ? ORDER BY run", (point,)
                )
            )

    def take(self, other: Journal) -> int:
        """Take over all runs of another journal; return how many were new."""
        with other._told():
            rows = other._database.execute(
                "SELECT hash, seed, truth, vary, scenario, until, text, points.id"
                " FROM points LEFT JOIN sources ON sources.id = source ORDER BY points.id"
            ).fetchall()
        numbers = self._enter([row[:-1] for row in rows])  # as they are: a strategy's file may be another now
        before = self._database.total_changes
        for hash_, seed, *_, theirs in rows:
            mine = numbers[hash_, seed]
            with self._transaction() as database:
                database.executemany(
                    f"INSERT OR IGNORE INTO runs (point, run, {COLUMNS}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                    ((mine, *values) for values in other.columns(theirs).tolist()),
                )
        new = self._database.total_changes - before
        for hash_, seed, *_, theirs in rows:
            mine = numbers[hash_, seed]
            with self._transaction() as database, other._told():
                database.executemany(
                    "INSERT OR IGNORE INTO curves VALUES (?, ?, ?, ?)",
                    (
                        (mine, *values)
                        for values in other._database.execute(
                            "SELECT run, feasible, infeasible FROM curves WHERE point = ?", (theirs,)
                        )
                    ),
                )
        return new

    def _locked(self) -> sqlite3.Connection:
        """Take the lock, which the system gives back when the process ends, however it ends."""
        lock = sqlite3.connect(self.folder / LOCK, timeout=0, isolation_level=None)
        try:
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            lock.close()
            if "locked" in str(error):
                raise FeasibeeError(
                    f"{self.folder}: another sweep writes here; wait for it, or choose another folder"
                ) from None
            raise
        return lock

    def _connected(self, write: bool) -> sqlite3.Connection:
        """Open the file; one that nobody may write to or beside, as a file that doesn't change."""
        name, fixed = str(self.path), False
        if not write and not self.path.with_name(f"{NAME}-wal").exists():
            fixed = not os.access(self.folder, os.W_OK)
            name = f"{self.path.resolve().as_uri()}?immutable=1" if fixed else name
        return sqlite3.connect(name, timeout=60, isolation_level=None, uri=fixed)

    def _open(self, write: bool) -> None:
        self._database.execute("PRAGMA busy_timeout = 60000")
        self._database.execute("PRAGMA synchronous = FULL")
        self._check(write)
        if write:
            self._database.execute("PRAGMA journal_mode = WAL")

    def _check(self, write: bool) -> None:
        """Make the tables of a new journal, or see that they are of this format and model."""
        tables = {name for (name,) in self._database.execute("SELECT name FROM sqlite_master")}
        if not tables and write:
            new = {"format": FORMAT, "model_version": MODEL_VERSION, "version": version("feasibee")}
            with self._transaction() as database:
                for statement in SCHEMA.split(";\n")[:-1]:
                    database.execute(statement)
                database.executemany("INSERT INTO about VALUES (?, ?)", new.items())
        try:
            about = dict(self._database.execute("SELECT key, value FROM about"))
            found = int(about["format"]), int(about["model_version"])
        except (sqlite3.OperationalError, KeyError, ValueError):
            raise FeasibeeError(f"{self.path}: is no journal of feasibee; choose another folder") from None
        for name, number, ours in zip(
            ("format", "model version"), found, (FORMAT, MODEL_VERSION), strict=True
        ):
            if number != ours:
                newer = "install the newer feasibee" if number > ours else "choose another folder"
                raise FeasibeeError(
                    f"{self.path}: is of {name} {number}, and this feasibee of {ours}; {newer}"
                )

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        with self._told():
            self._database.execute("BEGIN IMMEDIATE")
            try:
                yield self._database
            except BaseException:
                if self._database.in_transaction:  # a full disk has ended it already
                    self._database.execute("ROLLBACK")
                raise
            self._database.execute("COMMIT")

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Say in a line what is wrong with the file."""
        try:
            yield
        except sqlite3.Error as error:
            code = getattr(error, "sqlite_errorname", "") or ""
            remedy = next((text for start, text in REMEDIES.items() if code.startswith(start)), "look at it")
            raise FeasibeeError(f"{self.path}: {error}; {remedy}") from None


REMEDIES: Mapping[str, str] = {
    "SQLITE_FULL": "free some room, and run the same command again: nothing that was kept is lost",
    "SQLITE_IOERR": "free some room, and run the same command again: nothing that was kept is lost",
    "SQLITE_READONLY": "choose a folder that you may write to",
    "SQLITE_CANTOPEN": "choose a folder that you may write to",
    "SQLITE_CORRUPT": "it is damaged: move it away, and run the same command again",
    "SQLITE_NOTADB": "it is damaged: move it away, and run the same command again",
    "SQLITE_BUSY": "another process holds it: wait for that one",
}


def _rows(point: int, record: Record) -> Iterator[tuple[int, ...]]:
    columns = (
        range(record.first_run, record.first_run + record.runs),
        record.decision.tolist(),
        record.decision_step.tolist(),
        record.bits_sent.tolist(),
        record.commit_step.tolist(),
        record.committed_feasible.tolist(),
        record.committed_infeasible.tolist(),
    )
    return ((point, *values) for values in zip(*columns, strict=True))


def _curves(point: int, record: Record) -> Iterator[tuple[int, int, bytes, bytes]]:
    for row in range(record.runs):
        feasible, infeasible = (
            zlib.compress(np.ascontiguousarray(counts[row], "<i4").tobytes())
            for counts in (record.feasible_count, record.infeasible_count)
        )
        yield point, record.first_run + row, feasible, infeasible
