"""Make a damaged journal anew, from all in it that is as it was written."""

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
    """Copy what is good into a new file beside a damaged journal, whose lock the caller has.

    Points keep their numbers. What is lost is for a sweep to compute again.

    Returns
    -------
    Path
        The new file, alone in a folder.
    str
        What was damaged, and how many runs were kept.
    """
    folder = found.folder / FOLDER
    shutil.rmtree(folder, ignore_errors=True)  # of an attempt that was killed
    kept = 0
    with Journal(make_folder(folder), write=True) as fresh:
        for entry in found.frame.entries:
            with fresh.transaction():
                fresh.store(entry)
                for kind in Kind:
                    for rows in content.good_chunks(database, kind, entry.id):
                        fresh.put(kind, entry.id, rows, "itself")
                        kept += len(rows) if kind is Kind.RUNS else 0
        fresh.outdo(found.frame.commits)
    for name in (LOCK, SEAL):
        (folder / name).unlink(missing_ok=True)
    return folder / NAME, f"{found.folder / NAME}: damaged: {found.harm}; {kept} runs are good and stay"
