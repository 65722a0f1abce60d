"""Runs that are kept from one question to the next: a folder of each scenario and seed, in the cache."""

from __future__ import annotations

import hashlib
import os
import shutil
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

from feasibee.base.cache import cache_root, own_folder
from feasibee.base.errors import FeasibeeError
from feasibee.scenario.scenario import Scenario

ROOM: Final = 2**30
"""Bytes of all folders together; the ones used longest ago are removed first."""
PACKAGE: Final = Path(__file__).parent.parent


def kept_folder(scenario: Scenario, seed: int) -> Path | None:
    """Return the folder of the runs kept of a scenario and its variants, by this very code.

    Parameters
    ----------
    scenario : Scenario
        What was asked about.
    seed : int
        Seed of the runs.

    Returns
    -------
    Path or None
        A folder that other users can't write to; None if it can't be made.
    """
    name = hashlib.sha256(f"{_code()} {scenario.hash} {seed}".encode()).hexdigest()[:24]
    try:
        every = own_folder(own_folder(cache_root()) / "runs")
        folder = own_folder(every / name)
        os.utime(folder)
    except (FeasibeeError, OSError):
        return None
    _make_room(every, folder)
    return folder


@cache
def _code() -> str:
    """Return a hash of the package's files: runs of other code may differ."""
    digest = hashlib.sha256()
    for file in sorted(PACKAGE.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _make_room(every: Path, used: Path) -> None:
    """Remove the folders that were used longest ago, until the others have room."""
    total = 0
    with suppress(OSError):  # another process may remove them, too
        for folder in sorted(every.iterdir(), key=lambda each: each.stat().st_mtime, reverse=True):
            total += sum(file.stat().st_size for file in folder.rglob("*"))
            if total > ROOM and folder != used:
                shutil.rmtree(folder, ignore_errors=True)
