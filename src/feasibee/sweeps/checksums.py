"""Digests of what a journal holds: whatever changes it afterwards is found when it is read."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from feasibee.model.codes import MODEL_VERSION
from feasibee.sweeps.schema import FORMAT, SEAL, Entry, Kind

SIZE = 16
"""Bytes of a digest: by chance, one damage in 10**38 goes unseen."""


def _digest(*parts: bytes) -> bytes:
    found = hashlib.blake2b(digest_size=SIZE)
    for part in parts:
        found.update(len(part).to_bytes(8, "little"))
        found.update(part)
    return found.digest()


def of_entry(entry: Entry) -> bytes:
    """Return the digest of a point; journals of other models have others."""
    return _digest(json.dumps([FORMAT, MODEL_VERSION, *entry]).encode())


def of_rows(kind: Kind, point: int, rows: Any) -> bytes:
    """Return the digest of a chunk: an array of runs, or tuples of run, feasible and infeasible."""
    place = json.dumps([kind, point]).encode()
    if kind is Kind.RUNS:
        return _digest(place, np.asarray(rows, "<i8").tobytes())
    return _digest(place, *(part for run, *blobs in rows for part in (str(run).encode(), *blobs)))


def of_about(about: Mapping[str, str]) -> str:
    """Return the digest of the table ``about``, whose row for the digest doesn't count."""
    rows = sorted((key, value) for key, value in about.items() if key != "digest")
    return _digest(json.dumps(rows).encode()).hex()


def write_seal(folder: Path, commits: int) -> None:
    """Write the number of a journal's commits to the seal, a file beside it."""
    text = f"{commits:020d}"
    handle = os.open(folder / SEAL, os.O_WRONLY | os.O_CREAT, 0o666)  # truncating it takes 2 ms
    try:
        os.write(handle, f"{text} {_digest(text.encode()).hex()}\n".encode())
    finally:
        os.close(handle)


def read_seal(folder: Path) -> int:
    """Return how many commits a journal has had at least; 0 if that isn't known."""
    path = folder / SEAL
    if not path.is_file():
        return 0
    try:
        with path.open(encoding="ascii") as file:
            commits, digest = file.read(100).split()
    except (OSError, ValueError):
        return 0
    return int(commits) if digest == _digest(commits.encode()).hex() else 0
