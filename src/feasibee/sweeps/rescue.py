"""Rescue a damaged journal: copy its undamaged part into a new file."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

from feasibee.files import make_folder
from feasibee.sweeps import content
from feasibee.sweeps.journal import Journal
from feasibee.sweeps.schema import LOCK, NAME, SEAL, Kind
from feasibee.sweeps.survey import Survey

FOLDER = ".rescue"


def rescue(database: sqlite3.Connection, found: Survey) -> tuple[Path, str]:
    """Copy the undamaged part of a journal into a new file; the caller holds the journal's lock.

    Points keep their numbers. A sweep computes again what is lost.

    Returns
    -------
    Path
        The new file, alone in a folder.
    str
        What was damaged, and the number of runs that are kept.
    """
    folder = found.folder / FOLDER
    shutil.rmtree(folder, ignore_errors=True)  # left by an attempt that was killed
    kept = 0
    with Journal(make_folder(folder), write=True) as fresh:
        for entry in found.inventory.entries:
            with fresh.transaction():
                fresh.store(entry)
                for kind in Kind:
                    for rows in content.good_chunks(database, kind, entry.id):
                        fresh.put(kind, entry.id, rows, "itself")
                        kept += len(rows) if kind is Kind.RUNS else 0
        fresh.outdo(found.inventory.commits)
    for name in (LOCK, SEAL):
        (folder / name).unlink(missing_ok=True)
    return folder / NAME, f"{found.folder / NAME}: damaged: {found.harm}; {kept} undamaged runs are kept"
