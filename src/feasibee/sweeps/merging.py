"""Merge journals: copy all runs of several into one, or nothing if two of them disagree."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from feasibee.sweeps.journal import Journal
from feasibee.sweeps.schema import Kind


def merge(journal: Journal, folders: Sequence[Path]) -> int:
    """Copy all runs and curves of the journals in some folders; return the number of new runs.

    Raises
    ------
    FeasibeeError
        If a journal is damaged, or two journals differ in a run; then nothing is copied.
    """
    new = 0
    with journal.transaction():
        for folder in folders:
            with Journal(folder) as other:
                new += _take(journal, other)
    return new


def _take(journal: Journal, other: Journal) -> int:
    entries, origin, new = other.entries(), str(other.folder), 0
    numbers = journal.enter(entries, origin)
    for number, entry in zip(numbers, entries, strict=True):
        for kind in Kind:
            for rows in other.chunks(kind, entry.id):
                taken = journal.put(kind, number, rows, origin)
                new += taken if kind is Kind.RUNS else 0
    return new
