"""Logs of a field: the lock of their folder, and files of one JSON object a line, each written at once."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from feasibee.base.errors import FeasibeeError, one_line
from feasibee.base.files import make_folder, named, read_text, why_not

VERSION: Final = 6
"""Version of a world's log."""
LOCK: Final = "field.lock"
LOG_LIMIT = 2**30
"""Largest log that is read, in bytes."""


@contextmanager
def locked(folder: Path | None) -> Iterator[None]:
    """Lock the folder of a field's logs, if it has one, against other fields.

    The system unlocks it when this process ends. Raise a FeasibeeError if the folder can't be made, or
    another process has locked it.
    """
    if folder is None:
        yield
        return
    import fcntl  # only where fields are: not on Windows

    path, where = make_folder(folder) / LOCK, named(folder)
    with ExitStack() as opened:
        try:
            file = opened.enter_context(path.open("a+b", buffering=0))
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            file.truncate(0)
            file.write(str(os.getpid()).encode())
        except BlockingIOError:
            number = path.read_bytes().decode(errors="replace")
            holder = f"process {number}" if number.isdecimal() else "another process"
            rule = "writes here; wait for it, or choose another folder"
            raise FeasibeeError(f"{where}: {holder} {rule}") from None
        except OSError as error:
            remedy = "choose a folder that you may write to, with some free space"
            raise FeasibeeError(f"{where}: can't be locked: {why_not(error)}; {remedy}") from None
        yield


def remove_older(folder: Path, robots: Collection[int]) -> None:
    """Remove the logs of robots that aren't of this field, or that came too late to begin."""
    for log in folder.glob("robot-*.jsonl"):
        number = log.stem.removeprefix("robot-")
        if number.isdecimal() and (int(number) not in robots or log.stat().st_size == 0):
            log.unlink(missing_ok=True)


class LineLog:
    """A log of one JSON object a line, each written at once: a killed process loses nothing.

    Raise a FeasibeeError if the file can't be written. All lines in it are complete then.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file = path.open("wb", buffering=0)
        except (OSError, ValueError) as error:
            raise self._unwritable(error, "name a file in a folder that you may write to") from None

    def write(self, line: Mapping[str, Any]) -> None:
        """Write a line."""
        left = json.dumps(line, separators=(",", ":")).encode() + b"\n"
        start = self._file.tell()
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(start)
            raise self._unwritable(error, "free some disk space, and run it again") from None

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _unwritable(self, error: OSError | ValueError, remedy: str) -> FeasibeeError:
        return FeasibeeError(f"{named(self._path)}: can't be written: {why_not(error)}; {remedy}")


def read_log(path: Path, what: str, first: Mapping[str, Any], wrong: str) -> tuple[list[str], str]:
    """Return the complete lines of a log, and the rest of its text, of a process that was killed.

    Raise a FeasibeeError if the file can't be read, which names ``what`` it should be, or its first line
    lacks what is in ``first``, which says what is ``wrong``.
    """
    *lines, rest = read_text(path, what, LOG_LIMIT).split("\n")
    with reading(path, 1):
        if not first.items() <= json.loads(lines[0]).items():
            raise FeasibeeError(f"{named(path)}: {wrong}")
    return lines, rest


@contextmanager
def reading(path: Path, at: int) -> Iterator[None]:
    """Raise any error of reading a log as a FeasibeeError with path and line."""
    try:
        yield
    except FeasibeeError:
        raise
    except Exception as error:
        why = one_line(f"{type(error).__name__}: {error}", 100)
        remedy = "the log is damaged: use an intact copy"
        raise FeasibeeError(f"{named(path)}: line {at}: can't be read ({why}); {remedy}") from error
