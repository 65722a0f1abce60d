"""The journal of a study: one SQLite file, with a transaction for each chunk of runs.

A transaction that is done survives the end of the process or of the machine; the runs of others are
computed again. A run is identified by its scenario's hash, the seed, and its number. Each point and chunk has
a digest: every method that reads raises an error if what it reads is damaged.
"""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from itertools import count, product
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.files import make_folder
from feasibee.files.locking import lock
from feasibee.model.codes import MODEL_VERSION
from feasibee.model.outcomes import CURVES, OUTCOMES, TRACES
from feasibee.model.record import Record
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.sweeps import content
from feasibee.sweeps.content import Damage, Rows, Survey, Visit, inventory, name_of, snapshot, survey
from feasibee.sweeps.plan import DesignPoint, StoppingRule
from feasibee.sweeps.schema import (
    FORMAT,
    LOCK,
    NAME,
    POINT,
    SEAL,
    STATEMENTS,
    EncodedRuns,
    Entry,
    Kind,
    curve_of,
    difference,
    digest_of_about,
    digest_of_entry,
    digest_of_rows,
    write_seal,
)

RESCUE = ".rescue"
"""Folder within a damaged journal's, in which the undamaged part is copied."""


class Journal:
    """A journal in a folder.

    Parameters
    ----------
    folder : path, optional
        Folder of the journal; by default it is in memory, and gone when it is closed.
    write : bool
        Whether to write. Then it is made if need be, and locked against other writers.
    rescue : bool
        Whether to keep the undamaged part of a damaged journal, and write to that.

    Attributes
    ----------
    rescued : str
        What was rescued, in one line; empty if nothing was damaged.

    Raises
    ------
    FeasibeeError
        If it is missing, damaged or of another model version, or another process writes to it.
    """

    def __init__(self, folder: str | Path | None = None, write: bool = False, rescue: bool = False) -> None:
        self.folder = Path(folder or ":memory:")
        self.path = self.folder / NAME
        self.rescued = ""
        self._lock: sqlite3.Connection | None = None
        self._writing = False
        self._totals = {"commits": 0, "points": 0, "chunks": 0}
        self._versions = {
            "format": str(FORMAT),
            "model_version": str(MODEL_VERSION),
            "version": version("feasibee"),
        }
        if folder is None:
            self._database = sqlite3.connect(":memory:", isolation_level=None)
            self._make_tables()
            return
        if not write and not self.path.is_file():
            rule = f"has no {NAME}" if self.folder.is_dir() else "isn't a folder"
            raise FeasibeeError(f"{self.folder}: {rule}; name the folder of a sweep or study")
        try:
            with content.translating_errors(self.path):
                if write:
                    self._lock = lock(self.folder, LOCK)
                self._database = content.connect(self.folder, write)
                self._open(write, rescue)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the journal, and release its lock."""
        if hasattr(self, "_database"):
            self._database.close()
        if self._lock is not None:
            self._lock.close()

    # --- Reading ---

    @property
    def about(self) -> dict[str, str]:
        """Versions of the format, the model and the package that wrote it, and totals."""
        with self._strict():
            return content.about_of(self._database)

    @property
    def points(self) -> list[StoredPoint]:
        """All points, in the order in which they were added."""
        entries = self.entries()
        with self._strict():
            return [stored_point(entry) for entry in entries]

    def entries(self) -> list[Entry]:
        """Return the rows of all points."""
        with self._strict():
            found = inventory(self._database, self.folder)
            if not found.is_whole:
                raise Damage
        return found.entries

    def survey(self, visit: Visit) -> Survey:
        """Read the journal from end to end; call ``visit`` with each undamaged point and its runs."""
        with content.translating_errors(self.path):
            return survey(self._database, self.folder, visit)

    def missing(
        self, point: int, first: int, last: int, curves: bool, dynamic: bool = False
    ) -> list[tuple[int, int]]:
        """Return the missing runs from ``first`` to before ``last``, as pairs of the same kind."""
        kinds = Kind.of(curves, dynamic)
        with content.translating_errors(self.path):
            return content.missing(self._database, kinds, point, first, last)

    def counts(self) -> dict[int, int]:
        """Return the number of undamaged runs of each point."""
        return {entry.id: self.results(entry.id).run.size for entry in self.entries()}

    def record(self, point: int, record: Record) -> Record:
        """Return an empty record filled with its runs of a point, and what it has room for by step."""
        results, first = self.results(point), record.first_run
        wanted = (first <= results.run) & (results.run < first + record.runs)
        for outcome in (*OUTCOMES, *TRACES):
            values = getattr(record, outcome.name)
            if values.shape[1:] != (0,):
                values[results.run[wanted] - first] = getattr(results, outcome.name)[wanted]
        if record.feasible_count.shape[1]:
            for run, *counts in self.curves(point):
                if 0 <= run - first < record.runs:
                    for outcome, values in zip(CURVES, counts, strict=True):
                        getattr(record, outcome.name)[run - first] = values
        return record

    def results(self, point: int) -> SimpleNamespace:
        """Return the outcomes of a point's runs by name, as ``content.results_of`` does."""
        with self._strict():
            return content.results_of(self._database, point)

    def curves(self, point: int) -> Iterator[tuple[int, NDArray[np.int32], NDArray[np.int32]]]:
        """Yield number, feasible counts and infeasible counts of each run whose curves were kept."""
        for rows in self.chunks(Kind.CURVES, point):
            for run, feasible, infeasible in rows:
                yield run, curve_of(feasible), curve_of(infeasible)

    def chunks(self, kind: Kind, point: int) -> Iterator[Rows]:
        """Yield the stored rows of each chunk of a point."""
        with self._strict():
            yield from content.chunks_of(self._database, kind, point)

    # --- Writing ---

    def add(self, points: Sequence[DesignPoint], seed: int, until: StoppingRule | None = None) -> list[int]:
        """Write points that are new; return the numbers of all of them in the journal."""
        rule = None if until is None else json.dumps(vars(until))
        entries = [
            Entry(
                0,
                point.scenario.hash,
                str(seed),
                int(truth(point.scenario)),
                json.dumps(dict(point.values)),
                json.dumps(point.scenario.to_dict()),
                rule,
                None,
                point.scenario.manifest.source or None,
            )
            for point in points
        ]
        return self.enter(entries, "this study")

    def enter(self, entries: Iterable[Entry], origin: str) -> list[int]:
        """Write points that ``origin`` may number differently; return their numbers in this journal."""
        numbers = []
        with self.transaction() as database:
            taken = {number for (number,) in database.execute("SELECT id FROM points")}
            free = (number for number in count(1) if number not in taken)
            for entry in entries:
                query = f"SELECT {POINT} FROM points WHERE hash = ? AND seed = ?"
                known = database.execute(query, (entry.hash, entry.seed)).fetchone()
                if known is None:
                    there = entry._replace(id=next(free), source=self._source(entry.text))
                else:
                    there = Entry._make((*known, entry.text))
                    there = there._replace(vary=entry.vary, until=entry.until or there.until)
                    self._agree(there, "its truth", (there.truth, entry.truth), origin)
                self.store(there)
                numbers.append(there.id)
        return numbers

    def _source(self, text: str | None) -> int | None:
        """Return the number of a strategy's text; if it is new, the first free number."""
        if not text:
            return None
        found = self._database.execute("SELECT id FROM sources WHERE text = ?", (text,)).fetchone()
        if found:
            return int(found[0])
        taken = {number for (number,) in self._database.execute("SELECT id FROM sources")}
        return next(number for number in count(1) if number not in taken)

    def store(self, entry: Entry) -> None:
        """Write a point with its own number, or update what its study varies and its stopping rule."""
        with self.transaction() as database:
            if entry.text:
                database.execute("INSERT OR IGNORE INTO sources VALUES (?, ?)", (entry.source, entry.text))
            (before,) = database.execute("SELECT COUNT(*) FROM points WHERE id = ?", (entry.id,)).fetchone()
            database.execute(
                f"INSERT INTO points ({POINT}, digest) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"
                " ON CONFLICT (id) DO UPDATE"
                " SET vary = excluded.vary, until = excluded.until, digest = excluded.digest",
                (*entry[:-1], digest_of_entry(entry)),
            )
            self._totals["points"] += 1 - before

    def enter_runs(self, parts: Iterable[tuple[int, EncodedRuns]]) -> None:
        """Write encoded runs of some points: all of them or, after an error, none."""
        with self.transaction():
            for point, encoded in parts:
                for kind, rows in zip(Kind, encoded, strict=True):
                    if rows:
                        self.put(kind, point, rows, "this sweep")

    def put(self, kind: Kind, point: int, rows: Rows, origin: str) -> int:
        """Write consecutive runs of a point, or their curves; return the number of new ones.

        Raise an error if the journal has one of them already, and it differs; ``origin`` names their source.
        """
        first, last = rows[0][0], rows[-1][0] + 1
        with self.transaction() as database:
            gaps = content.gaps(database, kind, point, first, last)
            if gaps != [(first, last)]:
                self._compare(kind, point, rows, origin)
            for low, high in gaps:
                new = rows[low - first : high - first]
                marks = ", ".join("?" * (1 + len(new[0])))
                database.executemany(
                    f"INSERT INTO {kind.table} VALUES ({marks})", ((point, *row) for row in new)
                )
                digest = digest_of_rows(kind, point, new)
                database.execute(
                    "INSERT INTO chunks VALUES (?, ?, ?, ?, ?)", (point, kind, low, high - low, digest)
                )
                self._totals["chunks"] += 1
        return sum(high - low for low, high in gaps)

    def _compare(self, kind: Kind, point: int, rows: Rows, origin: str) -> None:
        """Raise an error if a stored run differs from the same run in some rows."""
        first = rows[0][0]
        for ours in content.select(self._database, kind, point, first, rows[-1][0] + 1).fetchall():
            found = difference(kind, ours, rows[ours[0] - first])
            if found is None:
                continue
            column, *values = found
            query = f"SELECT {POINT}, NULL FROM points WHERE id = ?"
            entry = Entry._make(self._database.execute(query, (point,)).fetchone())
            self._agree(entry, f"run {ours[0]}: {column}", values, origin)

    def _agree(self, entry: Entry, what: str, values: Sequence[object], origin: str) -> None:
        """Raise an error if two journals have different values for a point."""
        here, there = values
        if here != there:
            raise FeasibeeError(
                f"{name_of(entry.id, entry.vary)}, seed {entry.seed}, {what} is {here} in {self.folder} and "
                f"{there} in {origin}, and only one can be right; sweep into an empty folder to see which, "
                "and leave out the other"
            )

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Write everything within it, or nothing; a nested transaction is part of the outer one."""
        if self._writing:
            yield self._database
            return
        before = dict(self._totals)
        with content.translating_errors(self.path):
            self._database.execute("BEGIN IMMEDIATE")
            self._writing = True
            try:
                yield self._database
                self._totals["commits"] += 1
                about = {**self._versions, **{key: str(number) for key, number in self._totals.items()}}
                about["digest"] = digest_of_about(about)
                self._database.executemany("REPLACE INTO about VALUES (?, ?)", about.items())
                self._database.execute("COMMIT")
            except BaseException:
                self._totals = before
                if self._database.in_transaction:  # unless a full disk has ended it
                    self._database.execute("ROLLBACK")
                raise
            finally:
                self._writing = False
        with suppress(OSError):  # without a seal, less damage is found
            if self._lock is not None:
                write_seal(self.folder, self._totals["commits"])

    # --- Opening ---

    def _open(self, write: bool, rescue: bool) -> None:
        if content.is_empty(self._database, self.path) and write:
            self._make_tables()
        content.check_schema(self._database, self.path)
        if write:
            self._mend(rescue)
            about = content.about_of(self._database)
            self._totals = {key: int(about[key]) for key in self._totals}
            self._versions = {key: about[key] for key in self._versions}
            for setting in ("journal_mode = WAL", "writable_schema = OFF"):
                self._database.execute(f"PRAGMA {setting}")

    def _make_tables(self) -> None:
        with self.transaction() as database:
            for statement in STATEMENTS:
                database.execute(statement)

    def _mend(self, rescue: bool) -> None:
        """Check that nothing is damaged, or rescue the undamaged part."""
        found = self.survey(lambda entry, results: None)
        if not content.is_sound(self._database, self.path):
            found.flaws.append("its pages or indices")
        if found.is_whole:
            return
        if not rescue:
            raise FeasibeeError(found.line)
        fresh = self._rescue(found)
        self._database.close()
        content.move(fresh, self.path)
        self._database = content.connect(self.folder, write=True)

    def _rescue(self, found: Survey) -> Path:
        """Copy the undamaged part into a new file, alone in a folder; a sweep computes again what is lost."""
        folder = self.folder / RESCUE
        shutil.rmtree(folder, ignore_errors=True)  # left by an attempt that was killed
        kept = 0
        with Journal(make_folder(folder), write=True) as fresh:
            for entry in found.entries:
                with fresh.transaction():
                    fresh.store(entry)
                    for kind in Kind:
                        for rows in content.good_chunks(self._database, kind, entry.id):
                            fresh.put(kind, entry.id, rows, "itself")
                            kept += len(rows) if kind is Kind.RUNS else 0
            with fresh.transaction():  # continues the count of commits of the journal that it replaces
                fresh._totals["commits"] = max(found.commits, fresh._totals["commits"])
        for name in (LOCK, SEAL):
            (folder / name).unlink(missing_ok=True)
        self.rescued = f"{self.path}: damaged: {found.harm}; {kept} undamaged runs are kept"
        return folder / NAME

    @contextmanager
    def _strict(self) -> Iterator[None]:
        """Read one state, whatever others write meanwhile; raise an error if it is damaged."""
        try:
            with content.translating_errors(self.path), snapshot(self._database):
                yield
        except Damage:
            raise FeasibeeError(self.survey(_visit).line) from None


def _visit(entry: Entry, results: SimpleNamespace) -> None:
    with suppress(FeasibeeError):  # a strategy that isn't installed here isn't damage
        stored_point(entry)


class StoredPoint(NamedTuple):
    """A point in the journal."""

    id: int
    hash: str
    seed: int
    truth: bool
    values: dict[str, Any]
    scenario: Scenario
    """With the text of the strategy's file from the journal, which isn't run without the user's consent."""
    until: dict[str, float] | None
    """Stopping rule that chose the number of runs, if any."""
    source: int | None
    """Number of the text of its strategy's file, if any."""


def stored_point(entry: Entry) -> StoredPoint:
    """Return a point from its row; compute its truth again, and raise `Damage` if it differs."""
    scenario = Scenario.from_tables(json.loads(entry.scenario), source=entry.text, trusted=False)
    if truth(scenario) != entry.truth:
        raise Damage("its truth")
    return StoredPoint(
        entry.id,
        entry.hash,
        int(entry.seed),
        bool(entry.truth),
        json.loads(entry.vary),
        scenario,
        json.loads(entry.until or "null"),
        entry.source,
    )


def merge(journal: Journal, folders: Sequence[Path]) -> int:
    """Copy all runs and curves of the journals in some folders; return the number of new runs.

    Raises
    ------
    FeasibeeError
        If a journal is damaged, or two journals differ in a run; then nothing is copied.
    """
    new = 0
    with journal.transaction():
        for folder in folders:
            with Journal(folder) as other:
                entries = other.entries()
                numbers = journal.enter(entries, str(folder))
                for (number, entry), kind in product(zip(numbers, entries, strict=True), Kind):
                    for rows in other.chunks(kind, entry.id):
                        taken = journal.put(kind, number, rows, str(folder))
                        new += taken if kind is Kind.RUNS else 0
    return new
