"""Lock a folder of output, so that one process at a time writes to it."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing, suppress
from pathlib import Path

from feasibee.errors import FeasibeeError
from feasibee.files import named


def lock(folder: Path, name: str) -> sqlite3.Connection:
    """Lock a folder until the connection is closed; the system unlocks it when the process ends.

    ``name`` is that of the file in the folder that carries the lock and the number of the process that has
    it. Raise a FeasibeeError if another process has locked the folder, or the file can't be written.
    """
    taken = sqlite3.connect(folder / name, timeout=0, isolation_level=None)
    try:
        taken.execute("BEGIN IMMEDIATE")
        taken.execute(f"PRAGMA user_version = {os.getpid()}")
        taken.execute("COMMIT")  # only now can others read the number
        taken.execute("BEGIN IMMEDIATE")
    except sqlite3.Error as error:
        taken.close()
        where = named(folder)
        if "locked" in str(error):
            raise FeasibeeError(
                f"{where}: {_holder(folder / name)} writes here; wait for it, or choose another folder"
            ) from None
        remedy = "choose a folder that you may write to, with some free space"
        raise FeasibeeError(f"{where}: can't be locked: {error}; {remedy}") from None
    return taken


def _holder(path: Path) -> str:
    """Return the process that has a lock, in words."""
    with suppress(sqlite3.Error), closing(sqlite3.connect(path, timeout=0)) as reader:
        ((number,),) = reader.execute("PRAGMA user_version")
        if number:
            return f"process {number}"
    return "another process"
