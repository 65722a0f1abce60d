"""A journal in memory, for studies whose runs nobody wants to keep."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from feasibee.sweeps.journal import Journal


class MemoryJournal(Journal):
    """A journal that is gone when it is closed; it reads and writes as one in a folder does."""

    def __init__(self) -> None:
        self._begin(Path(":memory:"))
        self._database = sqlite3.connect(":memory:", isolation_level=None)
        self._make_tables()

    def _seal(self) -> None:
        """Do nothing: a seal finds what a file has lost."""
