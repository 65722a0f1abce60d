"""Open a journal's file; raise errors of one line with a remedy."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from feasibee.errors import FeasibeeError
from feasibee.model.codes import MODEL_VERSION
from feasibee.sweeps import checksums, content
from feasibee.sweeps.content import Damage, checked
from feasibee.sweeps.schema import FORMAT, NAME, STATEMENTS
from feasibee.sweeps.survey import AGAIN

SETTINGS = (
    "writable_schema = ON",  # without it, SQLite reads nothing of a truncated file
    "busy_timeout = 60000",
    "synchronous = FULL",
    "cell_size_check = ON",
)
REMEDIES: Mapping[str, str] = {
    "SQLITE_IOERR_READ": f"it is damaged: {AGAIN}",
    "SQLITE_FULL": "free some room, and run the same command again: the runs in the journal are kept",
    "SQLITE_IOERR": "free some room, and run the same command again: the runs in the journal are kept",
    "SQLITE_READONLY": "choose a folder that you may write to",
    "SQLITE_CANTOPEN": "choose a folder that you may write to",
    "SQLITE_BUSY": "another process has locked it: wait for that process",
    "": f"it is damaged: {AGAIN}",
}


@contextmanager
def translating_errors(path: Path) -> Iterator[None]:
    """Raise SQLite's errors as errors of feasibee, with a remedy."""
    try:
        yield
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorname", "") or ""
        remedy = next(text for start, text in REMEDIES.items() if code.startswith(start))
        raise FeasibeeError(f"{path}: {content.short(error)}; {remedy}") from None


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


def check(database: sqlite3.Connection, path: Path) -> None:
    """Check that a file is a journal of this format and model version, with readable tables.

    Raises
    ------
    FeasibeeError
        If it isn't, or nothing of it can be rescued.
    """
    with _readable(path):
        query = "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL"
        schema = sorted(sql for (sql,) in database.execute(query))
    about: dict[str, str] = {}
    with suppress(Damage):
        about = content.about(database)
    if "format" in about and about.get("digest") in (None, checksums.of_about(about)):  # format 2 had none
        _check_versions(about, path)
    if not any(sql in STATEMENTS for sql in schema) and not checksums.read_seal(path.parent):
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
