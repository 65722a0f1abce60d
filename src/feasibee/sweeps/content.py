"""Open a journal's file, read its tables, compare each digest with what was read, and survey the damage."""

from __future__ import annotations

import json
import operator
import os
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.model.codes import MODEL_VERSION
from feasibee.model.outcomes import TRACES
from feasibee.scenario.tables import hash_of
from feasibee.sweeps.schema import (
    FORMAT,
    NAME,
    PLACES,
    POINT,
    STATEMENTS,
    Chunk,
    Entry,
    Kind,
    curve_of,
    digest_of_about,
    digest_of_entry,
    digest_of_rows,
    read_seal,
)

Rows = list[tuple[Any, ...]]
Array = NDArray[np.int64]

UNREADABLE: Final = (ArithmeticError, LookupError, TypeError, ValueError, RecursionError)
"""Errors that the values of a damaged row may raise: text in place of numbers, invalid JSON."""


Visit = Callable[[Entry, SimpleNamespace], object]
"""Called with a point and the outcomes of its runs by name."""
NAMED = 20
"""Number of damaged points that an error names."""
AGAIN = "run the command that wrote it again: it computes what is damaged, and nothing else"
SETTINGS = (
    "writable_schema = ON",  # without it, SQLite reads nothing of a truncated file
    "busy_timeout = 60000",
    "synchronous = FULL",
    "cell_size_check = ON",
)
DAMAGED = f"it is damaged: {AGAIN}"
ROOM = "free some room, and run the same command again: the runs in the journal are kept"
FOLDER = "choose a folder that you may write to"
LOCKED = "another process has locked it: wait for that process"
REMEDIES: Mapping[str, str] = {
    "SQLITE_IOERR_READ": DAMAGED,  # a bad sector
    **dict.fromkeys(("SQLITE_FULL", "SQLITE_IOERR"), ROOM),
    **dict.fromkeys(("SQLITE_READONLY", "SQLITE_CANTOPEN", "SQLITE_PERM", "SQLITE_AUTH"), FOLDER),
    **dict.fromkeys(("SQLITE_BUSY", "SQLITE_LOCKED", "SQLITE_INTERRUPT"), LOCKED),
    "": DAMAGED,
}
"""What to do about errors of SQLite, by how their names begin."""


class Damage(Exception):  # noqa: N818
    """Part of a journal differs from what was written."""


def remedy_of(error: sqlite3.Error) -> str:
    """Return what to do about an error of SQLite."""
    code = getattr(error, "sqlite_errorname", "") or ""
    return next(remedy for start, remedy in REMEDIES.items() if code.startswith(start))


@contextmanager
def checked() -> Iterator[None]:
    """Raise `Damage` in place of each error that a damaged row or page may cause."""
    try:
        yield
    except (sqlite3.Error, *UNREADABLE) as error:
        if isinstance(error, sqlite3.Error) and remedy_of(error) != DAMAGED:
            raise
        raise Damage(short(error)) from None


def short(error: Exception) -> str:
    """Return the message of an error as one line of at most 100 characters: SQLite may quote a statement."""
    text = " ".join(str(error).split())
    return text if len(text) <= 100 else f"{text[:100]}..."


@contextmanager
def translating_errors(path: Path) -> Iterator[None]:
    """Raise SQLite's errors as errors of feasibee, with a remedy."""
    try:
        yield
    except sqlite3.Error as error:
        raise FeasibeeError(f"{path}: {short(error)}; {remedy_of(error)}") from None


def connect(folder: Path, write: bool) -> sqlite3.Connection:
    """Open the file; to read, don't change it, and if nobody can write to the folder, as immutable."""
    path = folder / NAME
    if write:
        name = str(path)
    else:
        fixed = not path.with_name(f"{NAME}-wal").exists() and not os.access(folder, os.W_OK)
        name = f"{path.resolve().as_uri()}?mode=ro{'&immutable=1' if fixed else ''}"
    database = sqlite3.connect(name, timeout=60, isolation_level=None, uri=not write)
    with _readable(path):
        for setting in SETTINGS:
            database.execute(f"PRAGMA {setting}")
    return database


def is_empty(database: sqlite3.Connection, path: Path) -> bool:
    """Whether a file has no tables yet: it is new, or its maker was killed before it made them."""
    with _readable(path):
        ((tables,),) = database.execute("SELECT COUNT(*) FROM sqlite_master")
        ((pages,),) = database.execute("PRAGMA page_count")
        return bool(tables == 0 and pages <= 1)


def check_schema(database: sqlite3.Connection, path: Path) -> None:
    """Raise an error unless a file is a journal of this format and model version with readable tables."""
    with _readable(path):
        query = "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL"
        schema = sorted(sql for (sql,) in database.execute(query))
    about: dict[str, str] = {}
    with suppress(Damage):
        about = about_of(database)
    if "format" in about and about.get("digest") in (None, digest_of_about(about)):  # format 2 had none
        _check_versions(about, path)
    if not any(sql in STATEMENTS for sql in schema) and not read_seal(path.parent):
        raise FeasibeeError(f"{path}: isn't a journal of feasibee; choose another folder")
    if schema != sorted(STATEMENTS):
        raise _hopeless(path, "its tables aren't as feasibee made them")


def _check_versions(about: Mapping[str, str], path: Path) -> None:
    try:
        found = int(about["format"]), int(about["model_version"])
    except (KeyError, ValueError):
        raise FeasibeeError(f"{path}: isn't a journal of feasibee; choose another folder") from None
    for name, number, ours in zip(("format", "model version"), found, (FORMAT, MODEL_VERSION), strict=True):
        if number != ours:
            newer = "install the newer feasibee" if number > ours else "choose another folder"
            raise FeasibeeError(f"{path}: has {name} {number}, this feasibee has {ours}; {newer}")


def move(fresh: Path, path: Path) -> None:
    """Replace a journal by another file; delete its log, which SQLite would apply to the new file."""
    try:
        for suffix in ("-wal", "-shm"):
            path.with_name(path.name + suffix).unlink(missing_ok=True)
        fresh.replace(path)
        fresh.parent.rmdir()
    except OSError as error:
        raise FeasibeeError(
            f"{path}: can't be replaced: {error.strerror}; end what reads it, and run the same command again"
        ) from None


def is_sound(database: sqlite3.Connection, path: Path) -> bool:
    """Whether SQLite finds the pages and indices of a file intact, and can write to it."""
    with path.open("rb") as file:
        versions = file.read(20)[18:]  # formats for writing and reading; SQLite doesn't write later ones
    with suppress(Damage), checked():
        found = database.execute("PRAGMA integrity_check(1)").fetchall()
        return found == [("ok",)] and versions in (b"\1\1", b"\2\2")
    return False


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        with checked():
            yield
    except Damage as error:
        raise _hopeless(path, str(error)) from None


def _hopeless(path: Path, why: str) -> FeasibeeError:
    return FeasibeeError(
        f"{path}: damaged as a whole ({why}): none of its runs can be rescued; move it away, and run the "
        "command that wrote it again: it computes all of them"
    )


def about_of(database: sqlite3.Connection) -> dict[str, str]:
    """Return the rows of the table ``about``."""
    with checked():
        found = dict(database.execute("SELECT key, value FROM about").fetchall())
        if not all(isinstance(text, str) for pair in found.items() for text in pair):
            raise Damage("not text")
        return found


def entries(database: sqlite3.Connection, most: int) -> tuple[list[Entry], list[int]]:
    """Return the undamaged points, and the numbers of the damaged ones.

    If the table can't be read from end to end, look up each number from 1 to ``most``.
    """
    texts = {row[0]: row[-1] for row in _each(database, "SELECT id, text FROM sources", most)}
    query = f"SELECT {POINT}, digest FROM points"
    good: list[Entry] = []
    bad: list[int] = []
    for number, *row in _each(database, query, most):
        *values, digest = row or (None,) * 8
        entry = Entry._make((number, *values, texts.get(values[-1])))
        if _is_whole(entry, digest):
            good.append(entry)
        else:
            bad.append(number)
    return good, bad


def _each(database: sqlite3.Connection, query: str, most: int) -> Iterator[tuple[Any, ...]]:
    """Yield the rows of a query, each with its number first; of an unreadable row, the number alone."""
    last = 0
    try:
        with checked():
            for row in database.execute(f"{query} ORDER BY id"):
                yield row
                last = row[0]
    except Damage:
        for number in range(last + 1, most + 1):
            try:
                with checked():
                    yield from database.execute(f"{query} WHERE id = ?", (number,))
            except Damage:
                yield (number,)


def _is_whole(entry: Entry, digest: Any) -> bool:
    """Whether a point matches its digest, and its scenario the hash that identifies its runs."""
    with suppress(*UNREADABLE):
        return bool(
            digest == digest_of_entry(entry)
            and entry.hash == hash_of(json.loads(entry.scenario), entry.text or "")
        )
    return False


def chunks(database: sqlite3.Connection, kind: Kind, point: int) -> list[Chunk]:
    """Return the chunks of a point, in order."""
    query = "SELECT first_run, runs, digest FROM chunks WHERE point = ? AND kind = ? ORDER BY first_run"
    with checked():
        return [Chunk(*row) for row in database.execute(query, (point, kind))]


def gaps(
    database: sqlite3.Connection, kind: Kind, point: int, first: int, last: int
) -> list[tuple[int, int]]:
    """Return the stretches from one run to before another that no chunk covers."""
    found = database.execute(
        "SELECT first_run, runs FROM chunks WHERE point = :point AND kind = :kind AND first_run < :last"
        " AND first_run >= COALESCE((SELECT MAX(first_run) FROM chunks"
        " WHERE point = :point AND kind = :kind AND first_run <= :first), 0) ORDER BY first_run",
        {"point": point, "kind": kind, "first": first, "last": last},
    )
    stretches = []
    for start, runs in found:
        if start > first:
            stretches.append((first, start))
        first = max(first, start + runs)
    return [*stretches, (first, last)] if first < last else stretches


def missing(
    database: sqlite3.Connection, kinds: Sequence[Kind], point: int, first: int, last: int
) -> list[tuple[int, int]]:
    """Return the stretches from one run to before another of which some kind of rows is missing."""
    stretches: list[tuple[int, int]] = []
    for low, high in sorted(gap for kind in kinds for gap in gaps(database, kind, point, first, last)):
        if stretches and low <= stretches[-1][1]:
            stretches[-1] = (stretches[-1][0], max(high, stretches[-1][1]))
        else:
            stretches.append((low, high))
    return stretches


def runs_of(database: sqlite3.Connection, point: int) -> Array:
    """Return all runs of a point: int64, shape (runs, columns of `PLACES`).

    Raise `Damage` if no chunk covers some run, or a chunk differs from what was written.
    """
    with checked():
        rows = _array(select(database, Kind.RUNS, point))
        end = 0
        for chunk in chunks(database, Kind.RUNS, point):
            start, end = end, end + chunk.runs
            _check(Kind.RUNS, point, chunk, rows[start:end])
        if end != len(rows):
            raise Damage("runs that no chunk covers")
    return rows


def results_of(database: sqlite3.Connection, point: int) -> SimpleNamespace:
    """Return the outcomes of a point's runs by name, and the numbers of the runs as ``run``.

    In a world that changes, its `TRACES` are among them, of shape (runs, steps + 1). Runs that lack them,
    because these were damaged, are left out. Raise as `runs_of`.
    """
    columns = runs_of(database, point)
    rows = [row for chunk in chunks_of(database, Kind.TRACES, point) for row in chunk]
    traces: dict[str, NDArray[Any]] = {}
    if rows and columns.size:
        numbers = columns[:, 0], np.array([row[0] for row in rows])
        columns = columns[np.isin(*numbers)]
        rows = [rows[place] for place in np.flatnonzero(np.isin(*reversed(numbers)))]
        for place, outcome in enumerate(TRACES, start=1):
            blobs = [row[place] for row in rows]
            traces[outcome.name] = np.stack([curve_of(blob, outcome.dtype) for blob in blobs])
    return SimpleNamespace(**{name: columns[:, place] for name, place in PLACES.items()}, **traces)


def chunks_of(database: sqlite3.Connection, kind: Kind, point: int) -> Iterator[Rows]:
    """Yield the stored rows of each chunk of a point; raise as `runs_of`."""
    there = 0
    for chunk in chunks(database, kind, point):
        yield _rows(database, kind, point, chunk)
        there += chunk.runs
    with checked():
        query = f"SELECT COUNT(run) FROM {kind.table} WHERE point = ?"
        if database.execute(query, (point,)).fetchone() != (there,):
            raise Damage("rows that no chunk covers")


def good_chunks(database: sqlite3.Connection, kind: Kind, point: int) -> Iterator[Rows]:
    """Yield the rows of each undamaged chunk; skip damaged ones."""
    found: list[Chunk] = []
    with suppress(Damage):
        found = chunks(database, kind, point)
    for chunk in found:
        with suppress(Damage):
            yield _rows(database, kind, point, chunk)


def _rows(database: sqlite3.Connection, kind: Kind, point: int, chunk: Chunk) -> Rows:
    with checked():
        last = chunk.first_run + chunk.runs
        rows = select(database, kind, point, chunk.first_run, last).fetchall()
        _check(kind, point, chunk, _array(rows) if kind is Kind.RUNS else rows)
        return rows


def select(
    database: sqlite3.Connection, kind: Kind, point: int, first: int = 0, last: int = 2**63 - 1
) -> sqlite3.Cursor:
    """Select the rows of a point, from one run to before another."""
    return database.execute(
        f"SELECT {kind.columns} FROM {kind.table} WHERE point = ? AND run >= ? AND run < ? ORDER BY run",
        (point, first, last),
    )


def _array(rows: Any) -> Array:
    return np.fromiter(chain.from_iterable(rows), np.int64).reshape(-1, len(PLACES))


def _check(kind: Kind, point: int, chunk: Chunk, rows: Any) -> None:
    """Raise `Damage` unless the rows match the chunk's numbers and digest."""
    if (
        len(rows) != chunk.runs
        or rows[0][0] != chunk.first_run
        or digest_of_rows(kind, point, rows) != chunk.digest
    ):
        raise Damage(f"runs {chunk.first_run} to {chunk.first_run + chunk.runs - 1}")


class Survey(NamedTuple):
    """What is known of a journal: its points, and the damage."""

    folder: Path
    entries: list[Entry]
    """Points whose rows are undamaged; their runs may be damaged."""
    damaged: dict[int, str]
    """Names of damaged points, by number."""
    flaws: list[str]
    """Other damage, in words."""
    commits: int
    """Number of transactions, as far as known."""
    runs: int = 0
    """Number of runs of undamaged points, if the journal was read from end to end."""

    @property
    def is_whole(self) -> bool:
        """Whether nothing is damaged."""
        return not self.damaged and not self.flaws

    @property
    def harm(self) -> str:
        """What is damaged, in words."""
        named = list(self.damaged.values())[:NAMED]
        more = len(self.damaged) - len(named)
        return ", ".join([*self.flaws, *named, *([f"and {more} more points"] if more else [])])

    @property
    def line(self) -> str:
        """What is damaged, what isn't, and the remedy, in one line."""
        return (
            f"{self.folder / NAME}: damaged: {self.harm or 'what was read just now'}; {self.runs} runs of "
            f"{sum(each.id not in self.damaged for each in self.entries)} other points are undamaged; {AGAIN}"
        )


@contextmanager
def snapshot(database: sqlite3.Connection) -> Iterator[None]:
    """Read one state of a database, whatever other processes write meanwhile."""
    if database.in_transaction:
        yield
        return
    database.execute("BEGIN")
    try:
        yield
    finally:
        if database.in_transaction:
            database.execute("ROLLBACK")


def inventory(database: sqlite3.Connection, folder: Path) -> Survey:
    """Return the points, and the damage to them or to the journal as a whole; read no runs."""
    sealed = read_seal(folder)  # before the tables: a writer commits before it seals
    flaws: list[str] = []
    with snapshot(database):
        commits = points = chunks = None
        with suppress(Damage), checked():
            about = about_of(database)
            if about.get("digest") == digest_of_about(about):
                commits, points, chunks = (int(about[key]) for key in ("commits", "points", "chunks"))
        if commits is None:
            flaws.append("its table about")
        elif commits < sealed:
            flaws.append(f"commits missing at its end: {sealed - commits}")
        counts: dict[int, int] = {}
        try:
            with checked():
                query = "SELECT point, COUNT(*) FROM chunks GROUP BY point"
                counts = {operator.index(point): number for point, number in database.execute(query)}
        except Damage:
            flaws.append("its table chunks")
            chunks = None
        good, bad = entries(database, points or max(counts, default=0))
    bad = sorted({*bad, *counts} - {entry.id for entry in good})
    if points is not None and points > len(good) + len(bad):
        flaws.append(f"points missing: {points - len(good) - len(bad)}")
    if chunks is not None and chunks != sum(counts.values()):
        flaws.append(f"chunks missing: {chunks - sum(counts.values())}")
    damaged = {point: f"point {point}" for point in bad}
    return Survey(folder, good, damaged, flaws, max(commits or 0, sealed))


def survey(database: sqlite3.Connection, folder: Path, visit: Visit) -> Survey:
    """Read a journal from end to end.

    Call ``visit`` with each undamaged point and the outcomes of its runs; it may raise `Damage` itself.
    """
    runs, damaged = 0, {}
    with snapshot(database):
        found = inventory(database, folder)
        for entry in found.entries:
            try:
                results = results_of(database, entry.id)
                for _ in chunks_of(database, Kind.CURVES, entry.id):
                    pass
                visit(entry, results)
            except Damage:
                damaged[entry.id] = name_of(entry.id, entry.vary)
            else:
                runs += results.run.size
    return found._replace(damaged=dict(sorted({**found.damaged, **damaged}.items())), runs=runs)


def name_of(point: int, vary: str) -> str:
    """Return a point's name: its number and what its study varies."""
    named = ", ".join(f"{path} = {value}" for path, value in json.loads(vary).items())
    named = named if len(named) <= 100 else f"{named[:100]}..."
    return f"point {point} ({named})" if named else f"point {point}"
