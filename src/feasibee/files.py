"""Files that are whole or not there."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from feasibee.errors import FeasibeeError


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside ``path`` to write to, and rename it at the end.

    An error or an interruption leaves what was there before.

    Raises
    ------
    FeasibeeError
        If the folder doesn't exist or can't be written to.
    """
    target = Path(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent)
        os.close(handle)
    except OSError as error:
        raise FeasibeeError(
            f"{target}: can't be written: {error.strerror}; name a folder that you may write to"
        ) from None
    temporary = Path(name)
    try:
        yield temporary
        _give_usual_permissions(temporary)
        temporary.replace(target)
    except OSError as error:
        raise FeasibeeError(f"{target}: can't be written: {error.strerror or error}") from None
    finally:
        temporary.unlink(missing_ok=True)


def make_folder(path: str | Path) -> Path:
    """Make a folder for output, unless it is there."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FeasibeeError(f"{folder}: can't be made: {error.strerror}; name another folder") from None
    return folder


def _give_usual_permissions(path: Path) -> None:
    """Undo mkstemp's privacy: what a user saves, others may read as far as the user's umask says."""
    umask = os.umask(0)
    os.umask(umask)
    path.chmod(0o666 & ~umask)
