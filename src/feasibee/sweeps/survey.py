"""Survey a journal: what is undamaged, what is damaged, and the remedy."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

from feasibee.sweeps import checksums, content
from feasibee.sweeps.content import Damage
from feasibee.sweeps.schema import NAME, Entry, Kind

Visit = Callable[[Entry, SimpleNamespace], object]
"""Called with a point and the outcomes of its runs by name."""
NAMED = 20
"""Number of damaged points that an error names."""
AGAIN = "run the command that wrote it again: it computes what is damaged, and nothing else"


class Inventory(NamedTuple):
    """The points of a journal, without their runs."""

    entries: list[Entry]
    """Undamaged points."""
    damaged: list[int]
    """Numbers of damaged points, as far as known."""
    flaws: list[str]
    """Other damage, in words."""
    commits: int
    """Number of transactions, as far as known."""


class Survey(NamedTuple):
    """Result of reading a journal from end to end."""

    folder: Path
    inventory: Inventory
    damaged: dict[int, str]
    """Names of damaged points, by number."""
    good: int
    """Number of undamaged points."""
    runs: int
    """Number of their runs."""

    @property
    def is_whole(self) -> bool:
        """Whether nothing is damaged."""
        return not self.damaged and not self.inventory.flaws

    @property
    def harm(self) -> str:
        """What is damaged, in words."""
        named = list(self.damaged.values())[:NAMED]
        more = len(self.damaged) - len(named)
        return ", ".join([*self.inventory.flaws, *named, *([f"and {more} more points"] if more else [])])

    @property
    def line(self) -> str:
        """What is damaged, what isn't, and the remedy, in one line."""
        return (
            f"{self.folder / NAME}: damaged: {self.harm or 'what was read just now'}; {self.runs} runs of "
            f"{self.good} other points are undamaged; {AGAIN}"
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


def inventory(database: sqlite3.Connection, folder: Path) -> Inventory:
    """Return the points, and the damage to them or to the journal as a whole."""
    sealed = checksums.read_seal(folder)  # before the tables: a writer commits before it seals
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
    return Inventory(good, sorted(bad), flaws, max(commits or 0, sealed))


def survey(database: sqlite3.Connection, folder: Path, visit: Visit) -> Survey:
    """Read a journal from end to end.

    Parameters
    ----------
    database : sqlite3.Connection
        Connection to the journal.
    folder : path
        Where it is.
    visit : callable
        Called with each undamaged point and the outcomes of its runs; may raise `Damage` itself.
    """
    runs = good = 0
    with snapshot(database):
        found = inventory(database, folder)
        damaged = {number: f"point {number}" for number in found.damaged}
        for entry in found.entries:
            try:
                results = content.results_of(database, entry.id)
                for _ in content.chunks_of(database, Kind.CURVES, entry.id):
                    pass
                visit(entry, results)
            except Damage:
                damaged[entry.id] = name_of(entry.id, entry.vary)
            else:
                good += 1
                runs += results.run.size
    return Survey(folder, found, dict(sorted(damaged.items())), good, runs)


def name_of(point: int, vary: str) -> str:
    """Return a point's name: its number and what its study varies."""
    named = ", ".join(f"{path} = {value}" for path, value in json.loads(vary).items())
    named = named if len(named) <= 100 else f"{named[:100]}..."
    return f"point {point} ({named})" if named else f"point {point}"
