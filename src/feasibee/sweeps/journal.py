"""The journal of a study: one SQLite file, with a transaction for each chunk of runs.

What is in it stays, whatever happens to the process or the machine; what isn't is computed again. A run is
known by the hash of its scenario, the seed, and its number. Each point and chunk has a digest: what isn't as
it was written is refused by every method that reads.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.model.codes import MODEL_VERSION
from feasibee.model.record import Record
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.sweeps import checksums, content, opening
from feasibee.sweeps.agreement import difference
from feasibee.sweeps.content import Array, Damage, Rows
from feasibee.sweeps.encoding import curve_of, rows_of_curves, rows_of_runs
from feasibee.sweeps.plan import Point, Until
from feasibee.sweeps.schema import FORMAT, NAME, PLACES, STATEMENTS, Entry, Kind
from feasibee.sweeps.survey import Survey, frame, name_of, snapshot, survey

Visit = Callable[[Entry, Array], object]
Rescue = Callable[[sqlite3.Connection, Survey], tuple[Path, str]]


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
    rescue : callable, optional
        Makes a damaged journal anew before it is written to; see ``feasibee.sweeps.rescue``.

    Attributes
    ----------
    rescued : str
        What was rescued, in a line; empty if nothing was damaged.

    Raises
    ------
    FeasibeeError
        If there is none, it is damaged, of another model version, or another process writes to it.
    """

    def __init__(self, folder: str | Path, write: bool = False, rescue: Rescue | None = None) -> None:
        self.folder = Path(folder)
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
        if not write and not self.path.is_file():
            raise FeasibeeError(f"{self.folder}: has no {NAME}; name the folder of a sweep")
        try:
            with opening.told(self.path):
                if write:
                    self._lock = opening.lock(self.folder)
                self._database = opening.connect(self.folder, write)
                self._open(write, rescue)
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

    # --- Reading ---

    @property
    def points(self) -> list[Row]:
        """All points, in the order in which they were added."""
        entries = self.entries()
        with self._strict():
            return [row_of(entry) for entry in entries]

    def entries(self) -> list[Entry]:
        """Return all points as they are stored."""
        with self._strict():
            found = frame(self._database, self.folder)
            if found.damaged or found.flaws:
                raise Damage
        return found.entries

    def survey(self, visit: Visit) -> Survey:
        """Look through all that is there; show each point that is as it was written, with its runs."""
        with opening.told(self.path):
            return survey(self._database, self.folder, visit)

    def missing(self, point: int, runs: int, curves: bool) -> list[tuple[int, int]]:
        """Return which runs below a number aren't there: stretches, each first and one past the last."""
        kinds = (Kind.RUNS, Kind.CURVES) if curves else (Kind.RUNS,)
        with opening.told(self.path):
            return content.missing(self._database, kinds, point, runs)

    def counts(self) -> dict[int, tuple[int, int]]:
        """Return how many runs each point that has any has, and how many of them decided as the truth."""
        found = {}
        for entry in self.entries():
            decisions = self.columns(entry.id)[:, PLACES["decision"]]
            if decisions.size:
                found[entry.id] = decisions.size, int((decisions == entry.truth).sum())
        return found

    def right(self, point: int, runs: int) -> int:
        """Return how many of the first runs of a point decided as the truth."""
        columns = self.columns(point)
        with opening.told(self.path):
            ((true,),) = self._database.execute("SELECT truth FROM points WHERE id = ?", (point,))
        return int((columns[columns[:, 0] < runs, PLACES["decision"]] == true).sum())

    def columns(self, point: int) -> NDArray[np.int64]:
        """Return the runs of a point: int64, shape (runs, columns of `PLACES`)."""
        with self._strict():
            return content.runs_of(self._database, point)

    def curves(self, point: int) -> Iterator[tuple[int, NDArray[np.int32], NDArray[np.int32]]]:
        """Yield run, feasible count and infeasible count of a point's runs whose curves were kept."""
        for rows in self.chunks(Kind.CURVES, point):
            for run, feasible, infeasible in rows:
                yield run, curve_of(feasible), curve_of(infeasible)

    def chunks(self, kind: Kind, point: int) -> Iterator[Rows]:
        """Yield the rows of each chunk of a point, as they are stored."""
        with self._strict():
            yield from content.chunks_of(self._database, kind, point)

    # --- Writing ---

    def add(self, points: Sequence[Point], seed: int, until: Until | None = None) -> list[int]:
        """Enter points, unless they are there; return their numbers in the journal."""
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
        """Enter points that ``origin`` may number otherwise; return their numbers in this journal."""
        numbers = []
        with self.transaction() as database:
            taken = {number for (number,) in database.execute("SELECT id FROM points")}
            free = (number for number in count(1) if number not in taken)
            for entry in entries:
                known = database.execute(
                    "SELECT id, hash, seed, truth, vary, scenario, until, source FROM points"
                    " WHERE hash = ? AND seed = ?",
                    (entry.hash, entry.seed),
                ).fetchone()
                if known is None:
                    there = entry._replace(id=next(free), source=self._source(entry.text))
                else:
                    there = Entry._make((*known, entry.text)).said_by(entry)
                    self._agree(there, "its truth", (there.truth, entry.truth), origin)
                self.store(there)
                numbers.append(there.id)
        return numbers

    def _source(self, text: str | None) -> int | None:
        """Return the number of a strategy's text, or the first free one."""
        if not text:
            return None
        found = self._database.execute("SELECT id FROM sources WHERE text = ?", (text,)).fetchone()
        if found:
            return int(found[0])
        taken = {number for (number,) in self._database.execute("SELECT id FROM sources")}
        return next(number for number in count(1) if number not in taken)

    def store(self, entry: Entry) -> None:
        """Enter a point with the numbers that it has, or what its study says of it now."""
        with self.transaction() as database:
            if entry.text:
                database.execute("INSERT OR IGNORE INTO sources VALUES (?, ?)", (entry.source, entry.text))
            (before,) = database.execute("SELECT COUNT(*) FROM points WHERE id = ?", (entry.id,)).fetchone()
            database.execute(
                "INSERT INTO points (id, hash, seed, truth, vary, scenario, until, source, digest)"
                " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (id) DO UPDATE"
                " SET vary = excluded.vary, until = excluded.until, digest = excluded.digest",
                (*entry[:-1], checksums.of_entry(entry)),
            )
            self._totals["points"] += 1 - before

    def write(self, parts: Iterable[tuple[int, Record]]) -> None:
        """Enter the runs of a chunk: all of them or, if that fails, none."""
        with self.transaction():
            for point, record in parts:
                self.put(Kind.RUNS, point, list(rows_of_runs(record)), "this sweep")
                if record.feasible_count.shape[1]:
                    self.put(Kind.CURVES, point, list(rows_of_curves(record)), "this sweep")

    def put(self, kind: Kind, point: int, rows: Rows, origin: str) -> int:
        """Enter consecutive runs of a point, or their curves; return how many were new.

        Raises
        ------
        FeasibeeError
            If one is there already, and differs; ``origin`` says where the rows come from.
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
                digest = checksums.of_rows(kind, point, new)
                database.execute(
                    "INSERT INTO chunks VALUES (?, ?, ?, ?, ?)", (point, kind, low, high - low, digest)
                )
                self._totals["chunks"] += 1
        return sum(high - low for low, high in gaps)

    def _compare(self, kind: Kind, point: int, rows: Rows, origin: str) -> None:
        """Raise an error if a run that is there differs from that in some rows."""
        first = rows[0][0]
        for ours in content.select(self._database, kind, point, first, rows[-1][0] + 1).fetchall():
            found = difference(kind, ours, rows[ours[0] - first])
            if found is None:
                continue
            column, *values = found
            query = (
                "SELECT id, hash, seed, truth, vary, scenario, until, source, NULL FROM points WHERE id = ?"
            )
            entry = Entry._make(self._database.execute(query, (point,)).fetchone())
            self._agree(entry, f"run {ours[0]}: {column}", values, origin)

    def _agree(self, entry: Entry, what: str, values: Sequence[object], origin: str) -> None:
        """Raise an error if two journals say different things of a point."""
        here, there = values
        if here != there:
            raise FeasibeeError(
                f"{name_of(entry.id, entry.vary)}, seed {entry.seed}, {what} is {here} in {self.folder} and "
                f"{there} in {origin}, and only one can be right; sweep into an empty folder to see which, "
                "and leave the other out"
            )

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Write all that is written in it, or nothing; one within another is part of that."""
        if self._writing:
            yield self._database
            return
        before = dict(self._totals)
        with opening.told(self.path):
            self._database.execute("BEGIN IMMEDIATE")
            self._writing = True
            try:
                yield self._database
                self._sum_up()
                self._database.execute("COMMIT")
            except BaseException:
                self._totals = before
                if self._database.in_transaction:  # a full disk has ended it already
                    self._database.execute("ROLLBACK")
                raise
            finally:
                self._writing = False
        with suppress(OSError):  # it only adds to what is found
            checksums.write_seal(self.folder, self._totals["commits"])

    def outdo(self, commits: int) -> None:
        """Count on from so many commits, of a journal whose place this one takes."""
        with self.transaction():
            self._totals["commits"] = max(commits, self._totals["commits"])

    def _sum_up(self) -> None:
        """Write down how much there is, of which versions, and the digest of that."""
        self._totals["commits"] += 1
        about = {**self._versions, **{key: str(number) for key, number in self._totals.items()}}
        about["digest"] = checksums.of_about(about)
        self._database.executemany("REPLACE INTO about VALUES (?, ?)", about.items())

    # --- Opening ---

    def _open(self, write: bool, rescue: Rescue | None) -> None:
        if opening.is_empty(self._database, self.path) and write:
            with self.transaction() as database:
                for statement in STATEMENTS:
                    database.execute(statement)
        opening.check(self._database, self.path)
        if write:
            self._mend(rescue)
            about = content.about(self._database)
            self._totals = {key: int(about[key]) for key in self._totals}
            self._versions = {key: about[key] for key in self._versions}
            for setting in ("journal_mode = WAL", "writable_schema = OFF"):
                self._database.execute(f"PRAGMA {setting}")

    def _mend(self, rescue: Rescue | None) -> None:
        """See that all is as it was written, or make the journal anew from what is."""
        found = self.survey(lambda entry, columns: None)
        if not opening.is_sound(self._database, self.path):
            found.frame.flaws.append("its pages or indices")
        if found.is_whole:
            return
        if rescue is None:
            raise FeasibeeError(found.line)
        fresh, self.rescued = rescue(self._database, found)
        self._database.close()
        opening.move(fresh, self.path)
        self._database = opening.connect(self.folder, write=True)

    @contextmanager
    def _strict(self) -> Iterator[None]:
        """Read one state, whatever is written meanwhile; refuse it if it isn't as it was written."""
        try:
            with opening.told(self.path), snapshot(self._database):
                yield
        except Damage:
            raise FeasibeeError(self.survey(_visit).line) from None


def row_of(entry: Entry) -> Row:
    """Return a point as it is stored; its truth is found again."""
    scenario = Scenario.from_tables(json.loads(entry.scenario), source=entry.text, trusted=False)
    if truth(scenario) != entry.truth:
        raise Damage("its truth")
    return Row(
        entry.id,
        entry.hash,
        int(entry.seed),
        bool(entry.truth),
        json.loads(entry.vary),
        scenario,
        json.loads(entry.until or "null"),
        entry.source,
    )


def _visit(entry: Entry, columns: Array) -> None:
    with suppress(FeasibeeError):  # a strategy that isn't installed here is no damage
        row_of(entry)
