"""What of a journal is good, what is damaged, and what can be done about it."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from feasibee.sweeps import checksums, content
from feasibee.sweeps.content import Array, Damage
from feasibee.sweeps.schema import NAME, Entry, Kind

NAMED = 20
"""So many damaged points are named in an error."""
AGAIN = "run the same feasibee sweep again: it computes what is damaged, and nothing else"


class Frame(NamedTuple):
    """The points of a journal, without their runs."""

    entries: list[Entry]
    """Those that are as they were written."""
    damaged: list[int]
    """Numbers of the others, as far as known."""
    flaws: list[str]
    """What else is wrong."""
    commits: int
    """How many transactions it has had, as far as known."""


class Survey(NamedTuple):
    """A journal, looked through from end to end."""

    folder: Path
    frame: Frame
    damaged: dict[int, str]
    """Points that aren't as they were written, and what is known of them, by number."""
    good: int
    """How many points are."""
    runs: int
    """How many runs these have."""

    @property
    def is_whole(self) -> bool:
        """Whether all is as it was written."""
        return not self.damaged and not self.frame.flaws

    @property
    def harm(self) -> str:
        """What is damaged, in words."""
        named = list(self.damaged.values())[:NAMED]
        more = len(self.damaged) - len(named)
        return ", ".join([*self.frame.flaws, *named, *([f"and {more} more points"] if more else [])])

    @property
    def line(self) -> str:
        """What is damaged, what isn't, and what to do."""
        return (
            f"{self.folder / NAME}: damaged: {self.harm or 'what was read just now'}; {self.runs} runs of "
            f"{self.good} other points are good; {AGAIN}"
        )


@contextmanager
def snapshot(database: sqlite3.Connection) -> Iterator[None]:
    """Read one state of a database, whatever is written meanwhile."""
    if database.in_transaction:
        yield
        return
    database.execute("BEGIN")
    try:
        yield
    finally:
        if database.in_transaction:
            database.execute("ROLLBACK")


def frame(database: sqlite3.Connection, folder: Path) -> Frame:
    """Return the points, and what is wrong with them or with the journal as a whole."""
    sealed = checksums.read_seal(folder)  # first: a writer commits before it seals
    flaws: list[str] = []
    with snapshot(database):
        commits = points = chunks = None
        with suppress(Damage), content.checked():
            about = content.about(database)
            if about.get("digest") == checksums.of_about(about):
                commits, points, chunks = (int(about[key]) for key in ("commits", "points", "chunks"))
        if commits is None:
            flaws.append("its table about")
        elif commits < sealed:
            flaws.append(f"commits missing at its end: {sealed - commits}")
        counts: dict[int, int] = {}
        try:
            counts = content.chunk_counts(database)
        except Damage:
            flaws.append("its table chunks")
            chunks = None
        good, bad = content.entries(database, points or max(counts, default=0))
    known = {*bad, *(entry.id for entry in good)}
    bad += [point for point in counts if point not in known]
    if points is not None and points > len(good) + len(bad):
        flaws.append(f"points missing: {points - len(good) - len(bad)}")
    if chunks is not None and chunks != sum(counts.values()):
        flaws.append(f"chunks missing: {chunks - sum(counts.values())}")
    return Frame(good, sorted(bad), flaws, max(commits or 0, sealed))


def survey(database: sqlite3.Connection, folder: Path, visit: Callable[[Entry, Array], object]) -> Survey:
    """Look through a journal.

    Parameters
    ----------
    database : sqlite3.Connection
        The journal's.
    folder : path
        Where it is.
    visit : callable
        Gets each point that is as it was written, and its runs; may raise `Damage` nevertheless.
    """
    runs = good = 0
    with snapshot(database):
        found = frame(database, folder)
        damaged = {number: f"point {number}" for number in found.damaged}
        for entry in found.entries:
            try:
                columns = content.runs_of(database, entry.id)
                for _ in content.chunks_of(database, Kind.CURVES, entry.id):
                    pass
                visit(entry, columns)
            except Damage:
                damaged[entry.id] = name_of(entry.id, entry.vary)
            else:
                good += 1
                runs += len(columns)
    return Survey(folder, found, dict(sorted(damaged.items())), good, runs)


def name_of(point: int, vary: str) -> str:
    """Name a point by its number and what its study varies."""
    told = ", ".join(f"{path} = {value}" for path, value in json.loads(vary).items())
    told = told if len(told) <= 100 else f"{told[:100]}..."
    return f"point {point} ({told})" if told else f"point {point}"
