"""Digests of a journal's contents: each change by anything else is found when it is read."""

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
"""Bytes per digest: a random change goes unseen with probability 10**-38."""


def _digest(*parts: bytes) -> bytes:
    found = hashlib.blake2b(digest_size=SIZE)
    for part in parts:
        found.update(len(part).to_bytes(8, "little"))
        found.update(part)
    return found.digest()


def of_entry(entry: Entry) -> bytes:
    """Return the digest of a point; it depends on the format and the model version."""
    return _digest(json.dumps([FORMAT, MODEL_VERSION, *entry]).encode())


def of_rows(kind: Kind, point: int, rows: Any) -> bytes:
    """Return the digest of a chunk: an array of runs, or tuples of a run and what is kept by step."""
    place = json.dumps([kind, point]).encode()
    if kind is Kind.RUNS:
        return _digest(place, np.asarray(rows, "<i8").tobytes())
    return _digest(place, *(part for run, *blobs in rows for part in (str(run).encode(), *blobs)))


def of_about(about: Mapping[str, str]) -> str:
    """Return the digest of the table ``about``, without its row for the digest."""
    rows = sorted((key, value) for key, value in about.items() if key != "digest")
    return _digest(json.dumps(rows).encode()).hex()


def write_seal(folder: Path, commits: int) -> None:
    """Write a journal's number of commits to the seal, a file in the same folder."""
    text = f"{commits:020d}"
    handle = os.open(folder / SEAL, os.O_WRONLY | os.O_CREAT, 0o666)  # truncating it takes 2 ms
    try:
        os.write(handle, f"{text} {_digest(text.encode()).hex()}\n".encode())
    finally:
        os.close(handle)


def read_seal(folder: Path) -> int:
    """Return a journal's least possible number of commits; 0 if unknown."""
    path = folder / SEAL
    if not path.is_file():
        return 0
    try:
        with path.open(encoding="ascii") as file:
            commits, digest = file.read(100).split()
    except (OSError, ValueError):
        return 0
    return int(commits) if digest == _digest(commits.encode()).hex() else 0
