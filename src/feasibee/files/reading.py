"""Read text files that a user names: plain files in UTF-8 of a limited size, with errors in one line."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from pathlib import Path

from feasibee.errors import LINE_LIMIT, FeasibeeError, one_line

TEXT_LIMIT = 2**20
"""Largest scenario, study or strategy file that is read, in bytes: about a thousand times a usual one."""
TABLE_LIMIT = 32 * 2**20
"""Largest table of points or design table that is read, in bytes."""


class UnreadableError(FeasibeeError):
    """A file that can't be read as text; ``why`` gives the reason in a few words."""

    why = ""


def read_text(path: str | Path, what: str, limit: int = TEXT_LIMIT) -> str:
    """Return the text of a plain UTF-8 file, with newlines as line endings.

    Pipes, devices and folders are never opened: reading a pipe could wait forever, and a device has no end.

    Parameters
    ----------
    path : path
        The file to read.
    what : str
        What the file should hold, for the error's remedy, such as ``"a scenario in TOML"``.
    limit : int
        Largest size that is read, in bytes.

    Raises
    ------
    UnreadableError
        If the file is missing, isn't a plain file, is larger than ``limit``, or isn't UTF-8 text.
    """
    text, why = _text_of(Path(path), limit)
    if why:
        error = UnreadableError(f"{named(path)}: can't be read: {why}; name {what}")
        error.why = why
        raise error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _text_of(path: Path, limit: int) -> tuple[str, str]:
    """Return a file's text and an empty string, or an empty text and the reason why it can't be read."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            return "", "it is a directory" if stat.S_ISDIR(found.st_mode) else "it isn't a plain file"
        with path.open("rb") as file:
            data = file.read(min(found.st_size, limit) + 1)  # memory for as many bytes is taken at once
    except (OSError, ValueError) as error:
        return "", why_not(error)
    if len(data) > limit:
        return "", f"it is larger than {limit // 2**20} MiB"
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return "", "it isn't UTF-8 text"
    return text, "it contains a NUL character, so it isn't text" if "\0" in text else ""


def lines_of(text: str) -> Iterator[str]:
    """Yield the lines of a text one by one; a list would take several times the text's memory."""
    start = 0
    while start < len(text):
        end = text.find("\n", start) + 1 or len(text)
        yield text[start:end]
        start = end


def why_not(error: OSError | ValueError) -> str:
    """Return why the system rejects a path; a ValueError is about a character in it, such as NUL."""
    return (error.strerror or str(error)) if isinstance(error, OSError) else "it can't be a file's name"


def is_file(path: str | Path) -> bool:
    """Return whether a path is a plain file; False for an invalid or overlong name."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def named(path: str | Path) -> str:
    """Return a path as one printable line, shortened if it is long, for an error."""
    return one_line(str(path), LINE_LIMIT // 2)
