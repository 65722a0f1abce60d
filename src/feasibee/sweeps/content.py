"""Read a journal's tables, and compare each digest with what was read."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import chain
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.model.outcomes import TRACES
from feasibee.scenario.complete import hash_of
from feasibee.sweeps import checksums
from feasibee.sweeps.encoding import curve_of
from feasibee.sweeps.schema import PLACES, Chunk, Entry, Kind

Rows = list[tuple[Any, ...]]
Array = NDArray[np.int64]

SURROUNDINGS: Final = ("FULL", "IOERR", "READONLY", "CANTOPEN", "BUSY", "LOCKED", "INTERRUPT", "PERM", "AUTH")
"""Errors of SQLite that aren't caused by the file's contents, except IOERR_READ: a bad sector."""
UNREADABLE: Final = (ArithmeticError, LookupError, TypeError, ValueError, RecursionError)
"""Errors that the values of a damaged row may raise: text in place of numbers, invalid JSON."""


class Damage(Exception):  # noqa: N818
    """Part of a journal differs from what was written."""


def is_damage(error: sqlite3.Error) -> bool:
    """Whether an error of SQLite means that the file is damaged."""
    code = (getattr(error, "sqlite_errorname", "") or "").removeprefix("SQLITE_")
    return code == "IOERR_READ" or not code.startswith(SURROUNDINGS)


@contextmanager
def checked() -> Iterator[None]:
    """Raise `Damage` in place of each error that a damaged row or page may cause."""
    try:
        yield
    except sqlite3.Error as error:
        if not is_damage(error):
            raise
        raise Damage(short(error)) from None
    except UNREADABLE as error:
        raise Damage(short(error)) from None


def short(error: Exception) -> str:
    """Return the message of an error as one line of at most 100 characters: SQLite may quote a statement."""
    text = " ".join(str(error).split())
    return text if len(text) <= 100 else f"{text[:100]}..."


def about(database: sqlite3.Connection) -> dict[str, str]:
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
    query = "SELECT id, hash, seed, truth, vary, scenario, until, source, digest FROM points"
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
            digest == checksums.of_entry(entry)
            and entry.hash == hash_of(json.loads(entry.scenario), entry.text or "")
        )
    return False


def chunk_counts(database: sqlite3.Connection) -> dict[int, int]:
    """Return each point's number of chunks."""
    with checked():
        found = dict(database.execute("SELECT point, COUNT(*) FROM chunks GROUP BY point").fetchall())
        if not all(isinstance(point, int) for point in found):
            raise Damage("chunks of no point")
        return found


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

    Raises
    ------
    Damage
        If no chunk covers some run, or a chunk differs from what was written.
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
    because these were damaged, are left out.

    Raises
    ------
    Damage
        As `runs_of`.
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
        or checksums.of_rows(kind, point, rows) != chunk.digest
    ):
        raise Damage(f"runs {chunk.first_run} to {chunk.first_run + chunk.runs - 1}")
