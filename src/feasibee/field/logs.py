"""Logs of a field: their folder, and files of one JSON object a line, each written at once."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from feasibee.errors import FeasibeeError
from feasibee.field.checks import Form
from feasibee.files import make_folder, named, read_text, why_not
from feasibee.files.locking import lock

VERSION: Final = 5
"""Version of a world's log."""
LOCK: Final = "field.lock"
LOG_LIMIT = 2**30
"""Largest log that is read, in bytes."""


@contextmanager
def log_folder(folder: Path | None) -> Iterator[Path]:
    """Give the folder of a field's logs: a named one, locked against other fields, or a temporary one.

    Raise a FeasibeeError if the folder can't be made, or another process has locked it.
    """
    if folder is None:
        with tempfile.TemporaryDirectory(prefix="feasibee-field-", ignore_cleanup_errors=True) as name:
            yield Path(name)
        return
    with closing(lock(make_folder(folder), LOCK)):
        yield folder


def remove_older(folder: Path, robots: Collection[int]) -> None:
    """Remove the logs of robots that aren't of this field: an earlier one left them in the folder."""
    for log in folder.glob("robot-*.jsonl"):
        number = log.stem.removeprefix("robot-")
        if number.isdecimal() and int(number) not in robots:
            log.unlink(missing_ok=True)


class LineLog:
    """A log of one JSON object a line, each written at once: a killed process loses nothing.

    Raise a FeasibeeError if the file can't be written. All lines in it are complete then.
    """

    def __init__(self, path: Path, *, appends: bool = False) -> None:
        self._path = path
        try:
            self._file = path.open("ab" if appends else "wb", buffering=0)
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


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Return the lines of a log; cut off an incomplete last line, of a world that was killed.

    Raise a FeasibeeError if the file can't be read.
    """
    try:
        data = path.read_bytes()
        end = data.rfind(b"\n") + 1
        if end < len(data):
            with path.open("r+b") as file:
                file.truncate(end)
        return [json.loads(line) for line in data[:end].splitlines()]
    except (OSError, ValueError) as error:
        raise FeasibeeError(f"{named(path)}: can't be resumed: {error}; start the field again") from None


def read_log(path: Path, what: str, first: Mapping[str, Any], wrong: str) -> tuple[list[str], str]:
    """Return the complete lines of a log, and the rest of its text, of a process that was killed.

    Raise a FeasibeeError if the file can't be read, which names ``what`` it should be, or its first line
    lacks what is in ``first``, which says what is ``wrong``.
    """
    *lines, rest = read_text(path, what, LOG_LIMIT).split("\n")
    if not lines:
        raise damaged(path, 1, "is incomplete")
    if not first.items() <= parsed(path, 1, lines[0]).items():
        raise FeasibeeError(f"{named(path)}: {wrong}")
    return lines, rest


def parsed(path: str | Path, at: int, text: str, forms: Mapping[str, Form] | None = None) -> dict[str, Any]:
    """Return a line of a log, which must be a JSON object whose values have these forms."""
    try:
        line = json.loads(text)
    except (ValueError, RecursionError):
        raise damaged(path, at, "isn't JSON") from None
    if not isinstance(line, dict):
        raise damaged(path, at, "isn't a JSON object")
    check_line(path, at, line, forms or {})
    return line


def check_line(path: str | Path, at: int, line: Mapping[str, Any], forms: Mapping[str, Form]) -> None:
    """Raise the error of the first value of a line that lacks its form."""
    for name, form in forms.items():
        if not form(line.get(name)):
            raise damaged(path, at, f"has no valid {name}")


def damaged(path: str | Path, at: int, what: str) -> FeasibeeError:
    """Return the error of a damaged line of a log."""
    return FeasibeeError(f"{named(path)}: line {at}: {what}; the log is damaged: use an intact copy")
