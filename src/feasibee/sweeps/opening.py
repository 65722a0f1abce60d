"""Open a journal's file, and say in a line what is wrong with it."""

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
from feasibee.sweeps.schema import FORMAT, LOCK, NAME, STATEMENTS
from feasibee.sweeps.survey import AGAIN

SETTINGS = (
    "writable_schema = ON",  # or SQLite reads nothing of a file that was cut short
    "busy_timeout = 60000",
    "synchronous = FULL",
    "cell_size_check = ON",
)
REMEDIES: Mapping[str, str] = {
    "SQLITE_IOERR_READ": f"it is damaged: {AGAIN}",
    "SQLITE_FULL": "free some room, and run the same command again: nothing that was kept is lost",
    "SQLITE_IOERR": "free some room, and run the same command again: nothing that was kept is lost",
    "SQLITE_READONLY": "choose a folder that you may write to",
    "SQLITE_CANTOPEN": "choose a folder that you may write to",
    "SQLITE_BUSY": "another process holds it: wait for that one",
    "": f"it is damaged: {AGAIN}",
}


@contextmanager
def told(path: Path) -> Iterator[None]:
    """Say in a line what SQLite finds wrong with a file."""
    try:
        yield
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorname", "") or ""
        remedy = next(text for start, text in REMEDIES.items() if code.startswith(start))
        raise FeasibeeError(f"{path}: {content.short(error)}; {remedy}") from None


def lock(folder: Path) -> sqlite3.Connection:
    """Take the lock, which the system gives back when the process ends, however it ends."""
    taken = sqlite3.connect(folder / LOCK, timeout=0, isolation_level=None)
    try:
        taken.execute("BEGIN EXCLUSIVE")
    except sqlite3.OperationalError as error:
        taken.close()
        if "locked" in str(error):
            raise FeasibeeError(
                f"{folder}: another sweep writes here; wait for it, or choose another folder"
            ) from None
        raise
    return taken


def connect(folder: Path, write: bool) -> sqlite3.Connection:
    """Open the file: to read it, without changing it; if nobody may write beside it, as one that stays."""
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
    """Tell whether a file has just been made, or its maker was killed before it had made the tables."""
    with _readable(path):
        ((tables,),) = database.execute("SELECT COUNT(*) FROM sqlite_master")
        ((pages,),) = database.execute("PRAGMA page_count")
        return bool(tables == 0 and pages <= 1)


def check(database: sqlite3.Connection, path: Path) -> None:
    """See that a file is a journal of this format and model, whose tables can be read.

    Raises
    ------
    FeasibeeError
        If it isn't, or nothing in it can be rescued.
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
        raise FeasibeeError(f"{path}: is no journal of feasibee; choose another folder")
    if schema != sorted(STATEMENTS):
        raise _hopeless(path, "its tables aren't as feasibee made them")


def _check_versions(about: Mapping[str, str], path: Path) -> None:
    try:
        found = int(about["format"]), int(about["model_version"])
    except (KeyError, ValueError):
        raise FeasibeeError(f"{path}: is no journal of feasibee; choose another folder") from None
    for name, number, ours in zip(("format", "model version"), found, (FORMAT, MODEL_VERSION), strict=True):
        if number != ours:
            newer = "install the newer feasibee" if number > ours else "choose another folder"
            raise FeasibeeError(f"{path}: is of {name} {number}, and this feasibee of {ours}; {newer}")


def move(fresh: Path, path: Path) -> None:
    """Put a journal in the place of another, whose log would be played into it."""
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
    """Tell whether SQLite finds the file's pages and indices as they should be, and may write to it."""
    with path.open("rb") as file:
        versions = file.read(20)[18:]  # to write and to read; SQLite writes to no file of a later one
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
        "same feasibee sweep again: it computes all of them"
    )
