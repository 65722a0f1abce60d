"""The tables of a journal, and the other files in its folder."""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple

from feasibee.model.outcomes import CURVES, OUTCOMES, TRACES, Outcome

NAME: Final = "journal.sqlite"
LOCK: Final = "journal.lock"
SEAL: Final = "journal.seal"
"""Holds the number of commits. It says whether a lost write-ahead log has taken some along."""
FORMAT: Final = 5
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
        wanted = {cls.RUNS: True, cls.CURVES: curves, cls.TRACES: dynamic}
        return tuple(kind for kind, is_wanted in wanted.items() if is_wanted)


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

    def said_by(self, study: Entry) -> Entry:
        """Return this point with what another study varies; a rule that chose the number of runs stays."""
        return self._replace(vary=study.vary, until=study.until or self.until)


class Chunk(NamedTuple):
    """Consecutive rows of a point that were written together."""

    first_run: int
    runs: int
    digest: bytes
