"""The tables of a journal, and the files beside it."""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple

NAME: Final = "journal.sqlite"
LOCK: Final = "journal.lock"
SEAL: Final = "journal.seal"
"""Holds the number of commits. It says whether a lost write-ahead log has taken some along."""
FORMAT: Final = 3
SCHEMA: Final = """
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
    truth INTEGER NOT NULL CHECK (truth IN (0, 1)), -- 1 feasible, 0 infeasible
    vary TEXT NOT NULL,             -- JSON: what the study varies, by dotted path
    scenario TEXT NOT NULL,         -- JSON: the complete form
    source INTEGER REFERENCES sources (id), -- NULL: the strategy is built in
    until TEXT,                     -- JSON: the rule that chose the number of runs. NULL: it was given
    digest BLOB NOT NULL,           -- of this row and its source
    UNIQUE (hash, seed)
);
CREATE TABLE chunks (
    point INTEGER NOT NULL REFERENCES points (id),
    kind INTEGER NOT NULL CHECK (kind IN (0, 1)), -- rows of: 0 runs, 1 curves
    first_run INTEGER NOT NULL CHECK (first_run >= 0),
    runs INTEGER NOT NULL CHECK (runs > 0),
    digest BLOB NOT NULL,           -- of these rows
    PRIMARY KEY (point, kind, first_run)
) WITHOUT ROWID;
CREATE TABLE runs (
    point INTEGER NOT NULL REFERENCES points (id),
    run INTEGER NOT NULL CHECK (run >= 0),
    decision INTEGER NOT NULL CHECK (decision IN (-1, 0, 1)), -- 1 feasible, 0 infeasible, -1 undecided
    decision_step INTEGER NOT NULL CHECK (decision_step >= -1), -- -1: undecided
    bits_sent INTEGER NOT NULL CHECK (bits_sent >= 0),
    commit_step INTEGER NOT NULL CHECK (commit_step >= -1), -- -1: never
    committed_feasible INTEGER NOT NULL CHECK (committed_feasible >= 0),
    committed_infeasible INTEGER NOT NULL CHECK (committed_infeasible >= 0),
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
CREATE TABLE curves (
    point INTEGER NOT NULL REFERENCES points (id),
    run INTEGER NOT NULL CHECK (run >= 0),
    feasible BLOB NOT NULL,         -- zlib of int32, little-endian: robots with opinion 1 at each step from 0
    infeasible BLOB NOT NULL,
    PRIMARY KEY (point, run)
) WITHOUT ROWID;
"""
STATEMENTS: Final = tuple(statement.strip() for statement in SCHEMA.split(";\n") if statement.strip())
COLUMNS: Final = "decision, decision_step, bits_sent, commit_step, committed_feasible, committed_infeasible"


class Kind(IntEnum):
    """What the rows of a chunk are."""

    RUNS = 0
    CURVES = 1

    @property
    def table(self) -> str:
        """Name of the table."""
        return self.name.lower()

    @property
    def columns(self) -> str:
        """Columns of a row after the point; the first is the run's number."""
        return f"run, {COLUMNS}" if self is Kind.RUNS else "run, feasible, infeasible"


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
