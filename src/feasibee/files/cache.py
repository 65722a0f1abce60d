"""The folder of compiled code. Only its owner may write to it, because feasibee runs what it contains."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Final

from feasibee.errors import FeasibeeError
from feasibee.files.reading import named

SEAL: Final = hashlib.sha256().digest_size
"""Length in bytes of the SHA-256 checksum at the start of a sealed file."""


def cache_root() -> Path:
    """Return the folder of cached files; the environment variable ``FEASIBEE_CACHE`` overrides it."""
    import platformdirs

    return Path(os.environ.get("FEASIBEE_CACHE") or platformdirs.user_cache_dir("feasibee", appauthor=False))


def own_folder(path: Path) -> Path:
    """Create a private folder unless it exists; return its path with symbolic links resolved.

    Raises
    ------
    FeasibeeError
        If the folder can't be created, belongs to another user, or can be written by others.
    """
    folder = Path(
        os.path.realpath(path)
    )  # checked and used is the link's target, even if the link changes later
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        _check_owner(folder, folder.stat())
    except OSError as error:
        raise _cant_be_written(folder, error) from None
    return folder


@cache
def check_cache() -> None:
    """Raise an error if the cache can't be written, as with a missing home folder; check once per process."""
    root = own_folder(cache_root())
    try:
        with tempfile.TemporaryFile(dir=root):
            pass
    except OSError as error:
        raise _cant_be_written(root, error) from None


def read_sealed(path: Path) -> bytes | None:
    """Return the bytes that `write_sealed` wrote; None if the file is missing or damaged.

    Damage is reported on standard error, once per folder.

    Raises
    ------
    FeasibeeError
        If the file can't be read, or another user may have written it.
    """
    try:
        with path.open("rb") as file:
            _check_owner(path, os.fstat(file.fileno()))  # of the open file, not of the path
            seal, data = file.read(SEAL), file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise FeasibeeError(f"{named(path)}: can't be read: {error.strerror}; delete the file") from None
    if hashlib.sha256(data).digest() == seal:
        return data
    _say_damaged(path.parent)
    return None


def write_sealed(path: Path, data: bytes) -> None:
    """Write a file with its checksum; concurrent readers get the complete old or the complete new content."""
    try:
        handle, temporary = tempfile.mkstemp(prefix=".", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(data).digest() + data)
            _replace(temporary, path)
        finally:
            Path(temporary).unlink(missing_ok=True)
    except OSError as error:
        raise _cant_be_written(path.parent, error) from None


def _replace(temporary: str, path: Path) -> None:
    try:
        Path(temporary).replace(path)
    except PermissionError:
        if os.name != "nt":
            raise
        # Windows can't replace a file while another process reads it. That file has the same content, or is
        # damaged and will be detected again.


def _check_owner(path: Path, found: os.stat_result) -> None:
    """Raise an error if another user may have written a file or folder."""
    if not hasattr(os, "geteuid"):
        return  # Windows: these bits don't describe access rights
    why, remedy = "", ""
    if found.st_uid != os.geteuid():
        why = f"belongs to user {found.st_uid}"
    elif found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        why = "can be written by others"
        remedy = "run chmod go-w on it, or "
    if why:
        raise FeasibeeError(
            f"FEASIBEE_CACHE = {named(path)}: {why}, and feasibee would run compiled code from it; "
            f"{remedy}name a folder of your own, such as FEASIBEE_CACHE=~/feasibee-cache"
        )


def _cant_be_written(folder: Path, error: OSError) -> FeasibeeError:
    why = f"can't be written: {error.strerror}"
    return FeasibeeError(f"FEASIBEE_CACHE = {named(folder)}: {why}; name a folder that you may write to")


@cache
def _say_damaged(folder: Path) -> None:
    text = f"feasibee: {folder}: compiled code is damaged; compiling it again, up to 30 s ..."
    print(text, file=sys.stderr, flush=True)
