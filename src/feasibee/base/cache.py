"""The folder of compiled code. Only this user or root may write to it, because feasibee runs it."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from contextlib import nullcontext, suppress
from functools import cache
from pathlib import Path
from typing import Final

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import named

ROOT: Final = 0
"""User number of root, whose files are trusted as the user's own: root may change those, too."""
SETTING: Final = "FEASIBEE_CACHE"


def cache_root() -> Path:
    """Return the folder of cached files; the environment variable ``FEASIBEE_CACHE`` overrides it."""
    import platformdirs

    return Path(os.environ.get(SETTING) or platformdirs.user_cache_dir("feasibee", appauthor=False))


def own_folder(path: Path) -> Path:
    """Create a private folder unless it exists; return its path with symbolic links resolved.

    Raise a FeasibeeError if it can't be created, belongs to another user than this one and root, or can be
    written by others.
    """
    folder = Path(os.path.realpath(path))  # the link's target, also if the link changes later
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        _check_owner(folder, folder.stat())
    except OSError as error:
        raise _cant_be_written(folder, error) from None
    return folder


def read_library(folder: Path, key: str) -> Path | None:
    """Return the library that `write_library` wrote; None if it is missing or damaged.

    The system loads it, so its checksum is in its name. Damage is reported on standard error, once per
    folder. Raise a FeasibeeError if another user may have written it.
    """
    for path in sorted(folder.glob(f"{key}.*")):
        try:
            with path.open("rb") as file:
                _check_owner(path, os.fstat(file.fileno()))  # of the open file, not of the path
                digest = hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise FeasibeeError(f"{named(path)}: can't be read: {error.strerror}; delete the file") from None
        if path.name.split(".")[1] == digest:
            return path
        _say_damaged(folder)
    return None


def write_library(folder: Path, key: str, made: Path) -> Path:
    """Copy a library that was made into the cache, under a key; return where it is.

    Concurrent readers get the complete old or the complete new content.
    """
    data = made.read_bytes()
    path = folder / f"{key}.{hashlib.sha256(data).hexdigest()}{made.suffix}"
    try:
        handle, temporary = tempfile.mkstemp(prefix=".", dir=folder)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            # Windows can't replace a file while another process reads it. That file has the same content, or
            # is damaged and will be detected again.
            with suppress(PermissionError) if os.name == "nt" else nullcontext():
                Path(temporary).replace(path)
        finally:
            Path(temporary).unlink(missing_ok=True)
    except OSError as error:
        raise _cant_be_written(folder, error) from None
    return path


def scratch_folder(folder: Path) -> tempfile.TemporaryDirectory[str]:
    """Return a folder for a while, within a folder of the cache."""
    try:
        return tempfile.TemporaryDirectory(prefix=".", dir=folder)
    except OSError as error:
        raise _cant_be_written(folder, error) from None


def _check_owner(path: Path, found: os.stat_result) -> None:
    """Raise an error if another user than this one and root may have written a file or folder."""
    if not hasattr(os, "geteuid"):
        return  # Windows: these bits don't describe access rights
    why = remedy = ""
    if found.st_uid not in (ROOT, os.geteuid()):
        why, remedy = f"belongs to user {found.st_uid}", "run chown -R root"
    elif found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        why, remedy = "can be written by others", "run chmod go-w"
    if why:
        raise FeasibeeError(
            f"{SETTING} = {named(path)}: {why}, and feasibee would run compiled code from it; "
            f"{remedy} on it, or name a folder of your own, such as {SETTING}=~/feasibee-cache"
        )


def _cant_be_written(folder: Path, error: OSError) -> FeasibeeError:
    why = f"can't be written: {error.strerror}"
    remedy = "name a folder that you may write to, or copy one that has this code from such a machine"
    return FeasibeeError(f"{SETTING} = {named(folder)}: {why}; {remedy}")


@cache
def _say_damaged(folder: Path) -> None:
    text = f"feasibee: {folder}: compiled code is damaged; compiling it again ..."
    print(text, file=sys.stderr, flush=True)
