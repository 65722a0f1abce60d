"""The folder of compiled code, which only its owner may write to, since what lies in it is run."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Final

from feasibee.errors import LINE_LIMIT, FeasibeeError, one_line

SEAL: Final = hashlib.sha256().digest_size
"""Bytes of the checksum that a sealed file starts with."""


def cache_root() -> Path:
    """Return the folder for what may be computed again; ``FEASIBEE_CACHE`` moves it."""
    import platformdirs

    return Path(os.environ.get("FEASIBEE_CACHE") or platformdirs.user_cache_dir("feasibee", appauthor=False))


def own_folder(path: Path) -> Path:
    """Make a folder unless it is there, and return where it really is.

    Raises
    ------
    FeasibeeError
        If it can't be made, belongs to another user, or can be written by others.
    """
    folder = Path(os.path.realpath(path))  # the checks are of what a link leads to: it may change later
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        _check_owner(folder, folder.stat())
    except OSError as error:
        raise _cant_be_written(folder, error) from None
    return folder


@cache
def check_cache() -> None:
    """Raise an error if compiled code couldn't be kept, as in a home that isn't there; look once."""
    root = own_folder(cache_root())
    try:
        with tempfile.TemporaryFile(dir=root):
            pass
    except OSError as error:
        raise _cant_be_written(root, error) from None


def read_sealed(path: Path) -> bytes | None:
    """Return what `write_sealed` wrote; None if it is missing or damaged (said once for a folder).

    Raises
    ------
    FeasibeeError
        If others may have written it.
    """
    try:
        with path.open("rb") as file:
            _check_owner(path, os.fstat(file.fileno()))  # of the very file that is read
            seal, data = file.read(SEAL), file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise FeasibeeError(f"{_named(path)}: can't be read: {error.strerror}; remove it") from None
    if hashlib.sha256(data).digest() == seal:
        return data
    _say_damaged(path.parent)
    return None


def write_sealed(path: Path, data: bytes) -> None:
    """Write a file with its checksum; who reads meanwhile finds the old content or the new one, whole."""
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
        # Windows replaces no file that another process reads; that one has the same content, or is damaged
        # and will be found so again.


def _check_owner(path: Path, found: os.stat_result) -> None:
    """Raise an error if anyone but this user may have written a file or folder."""
    if not hasattr(os, "geteuid"):
        return  # Windows: access isn't told by these bits
    why, remedy = "", ""
    if found.st_uid != os.geteuid():
        why = f"belongs to user {found.st_uid}"
    elif found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        why = "can be written by others"
        remedy = "run chmod go-w on it, or "
    if why:
        raise FeasibeeError(
            f"FEASIBEE_CACHE = {_named(path)}: {why}, and compiled code in it would run; "
            f"{remedy}name a folder of your own, such as FEASIBEE_CACHE=~/feasibee-cache"
        )


def _cant_be_written(folder: Path, error: OSError) -> FeasibeeError:
    why = f"can't be written: {error.strerror}"
    return FeasibeeError(f"FEASIBEE_CACHE = {_named(folder)}: {why}; name a folder that you may write to")


def _named(path: Path) -> str:
    return one_line(str(path), LINE_LIMIT // 2)


@cache
def _say_damaged(folder: Path) -> None:
    text = f"feasibee: {folder}: compiled code is damaged; compiling it again, up to 30 s ..."
    print(text, file=sys.stderr, flush=True)
