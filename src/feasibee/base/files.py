"""Files that a user names: read with a limit, written whole or not at all, with errors in one line."""

from __future__ import annotations

import csv
import os
import re
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path

from feasibee.base.errors import LINE_LIMIT, FeasibeeError, one_line

TEXT_LIMIT = 2**20
"""Largest scenario, study or strategy file that is read, in bytes: about a thousand times a usual one."""
TABLE_LIMIT = 32 * 2**20
"""Largest table of points or design table that is read, in bytes."""

FIGURES = (".png", ".pdf", ".svg")
"""File suffixes of figures."""
RESULTS = (".nc", ".csv")
"""File suffixes of saved results."""
FORMULAS = tuple("=+-@\t\n\uff1d\uff0b\uff0d\uff20")
"""First characters of cells that spreadsheets compute, by OWASP; the last four are full-width."""


class UnreadableError(FeasibeeError):
    """A file that can't be read as text; ``why`` gives the reason in a few words."""

    why = ""


def read_text(path: str | Path, what: str, limit: int = TEXT_LIMIT, smaller: str = "") -> str:
    """Return the text of a plain UTF-8 file, with newlines as line endings.

    Pipes, devices and folders are never opened: reading a pipe could wait forever, and a device has no end.
    Raise an `UnreadableError` if it isn't such a file, or is larger than ``limit`` bytes. The remedy names
    ``what`` the file should hold or, if it is too large, the ``smaller`` one to use.
    """
    data = read_bytes(path, what, limit, smaller)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise _unreadable(path, what, "it isn't UTF-8 text") from None
    if "\0" in text:
        raise _unreadable(path, what, "it contains a NUL character, so it isn't text")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_bytes(path: str | Path, what: str, limit: int, smaller: str = "") -> bytes:
    """Return the contents of a plain file; parameters and errors are those of `read_text`."""
    try:
        found = Path(path).stat()
        if not stat.S_ISREG(found.st_mode):
            why = "it is a directory" if stat.S_ISDIR(found.st_mode) else "it isn't a plain file"
            raise _unreadable(path, what, why)
        with Path(path).open("rb") as file:
            data = file.read(min(found.st_size, limit) + 1)  # memory for as many bytes is taken at once
    except (OSError, ValueError) as error:
        raise _unreadable(path, what, why_not(error)) from None
    if len(data) > limit:
        raise _unreadable(path, smaller or what, f"it is larger than {limit // 2**20} MiB")
    return data


def _unreadable(path: str | Path, what: str, why: str) -> UnreadableError:
    error = UnreadableError(f"{named(path)}: can't be read: {why}; name {what}")
    error.why = why
    return error


def lines_of(text: str) -> Iterator[str]:
    """Yield the lines of a text one by one; a list would take several times the text's memory."""
    return (line[0] for line in re.finditer(r"[^\n]*\n|[^\n]+", text))


def why_not(error: OSError | ValueError) -> str:
    """Return why the system rejects a path; a ValueError is about a character in it, such as NUL."""
    return (error.strerror or str(error)) if isinstance(error, OSError) else "it can't be a file's name"


def named(path: str | Path) -> str:
    """Return a path as one printable line, shortened if it is long, for an error."""
    return one_line(str(path), LINE_LIMIT // 2)


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path in the folder of ``path``, and rename it to ``path`` at the end.

    After an error or an interruption, the previous file is unchanged. If ``path`` is a symbolic link, the
    file that it points to is replaced. Raise a FeasibeeError if ``path`` is a folder or device, or its folder
    is missing or can't be written to.
    """
    target, temporary = _beside(path)
    try:
        yield temporary
        os.umask(umask := os.umask(0))  # mkstemp's own permissions are fewer than those of new files
        temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~umask)
        temporary.replace(target)
    except OSError as error:
        raise FeasibeeError(f"{named(target)}: can't be written: {why_not(error)}; free disk space") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text to a file; after an error, the previous file is unchanged."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table as CSV with `atomic_write`; see `as_cell`."""
    with (
        atomic_write(path) as temporary,
        temporary.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        for row in chain([header], rows):
            writer.writerow([as_cell(each) if isinstance(each, str) else each for each in row])


def as_cell(text: str) -> str:
    """Return a text for a CSV file, with an apostrophe before one that a spreadsheet would compute."""
    text = text.replace("\r", r"\r")  # Python 3.11's csv doesn't quote it: a new row
    if not text.startswith(FORMULAS):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text


def write_table(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows, which have the same columns, as CSV; None is an empty cell."""
    write_csv(path, list(rows[0]), [list(row.values()) for row in rows])


def check_output(path: str | Path, suffixes: Sequence[str], option: str = "", hint: str = "") -> str:
    """Validate an output path before a long computation; return its suffix in lower case.

    Raise a FeasibeeError if the suffix isn't one of ``suffixes``, or the file can't be written. It names the
    command-line ``option``, and ends with a ``hint`` about another suffix.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        known = f"{', '.join(suffixes[:-1])} or {suffixes[-1]}" if len(suffixes) > 1 else suffixes[0]
        raise FeasibeeError(
            f"{option} {named(path)}: unknown file format; end the name with {known}{hint}".lstrip()
        )
    _beside(path)[1].unlink()
    return suffix


def _beside(path: str | Path) -> tuple[Path, Path]:
    """Return the file that a path points to, and an empty temporary file in the same folder."""
    # The suffix is that of the link, if any: writers choose the format by the name that the user gave.
    target, suffix = Path(path), Path(path).suffix[-20:]
    try:
        is_plain = True
        with suppress(FileNotFoundError):
            is_plain = stat.S_ISREG(target.stat().st_mode)
        if not is_plain:
            raise FeasibeeError(f"{named(target)}: isn't a plain file; name a new or a plain file")
        target = target.resolve() if target.is_symlink() else target
        handle, name = tempfile.mkstemp(suffix, f".{target.stem[:20]}-", target.parent)
    except (OSError, ValueError) as error:
        remedy = "name a file in a folder that you may write to"
        raise FeasibeeError(f"{named(target)}: can't be written: {why_not(error)}; {remedy}") from None
    os.close(handle)
    return target, Path(name)


def make_folder(path: str | Path) -> Path:
    """Create a folder for output, with its parents, unless it exists."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FeasibeeError(
            f"{named(folder)}: can't be created: {why_not(error)}; name a folder in one that you may write to"
        ) from None
    return folder
