"""Files that are whole or not there."""

from __future__ import annotations

import csv
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from feasibee.errors import LINE_LIMIT, FeasibeeError, one_line

TEXT_LIMIT = 2**20
"""Bytes of a scenario, a study or a strategy: a thousand times what people write."""
TABLE_LIMIT = 32 * 2**20
"""Bytes of a table of points or of a design."""
FIGURES = (".png", ".pdf", ".svg")
"""Suffixes of figures."""
RESULTS = (".nc", ".csv")
"""Suffixes of saved results."""


class UnreadableError(FeasibeeError):
    """A file that can't be read as text; ``why`` says what is wrong with it, in a few words."""

    why = ""


def read_text(path: str | Path, what: str, limit: int = TEXT_LIMIT) -> str:
    """Return the text of a plain file in UTF-8, its lines ending in newlines.

    Whatever isn't a plain file is never opened: a pipe would wait, and a device has no end.

    Parameters
    ----------
    path : path
        The file.
    what : str
        What to name instead, such as ``"a scenario in TOML"``.
    limit : int
        Bytes that it may have.

    Raises
    ------
    UnreadableError
        If it isn't there or isn't a plain file, is larger, or isn't UTF-8.
    """
    text, why = _text_of(Path(path), limit)
    if why:
        error = UnreadableError(f"{_named(path)}: can't be read: {why}; name {what}")
        error.why = why
        raise error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _text_of(path: Path, limit: int) -> tuple[str, str]:
    """Return the text of a file, or why it can't be had."""
    try:
        mode = path.stat().st_mode
        if not stat.S_ISREG(mode):
            return "", "it is a directory" if stat.S_ISDIR(mode) else "it isn't a plain file"
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as error:
        return "", why_not(error)
    if len(data) > limit:
        return "", f"it has more than {limit // 2**20} MiB"
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return "", "not UTF-8 text"
    return text, "it holds a NUL, as no text does" if "\0" in text else ""


def lines_of(text: str) -> Iterator[str]:
    """Yield the lines of a text, one at a time: a list of them takes several times its room."""
    start = 0
    while start < len(text):
        end = text.find("\n", start) + 1 or len(text)
        yield text[start:end]
        start = end


def why_not(error: OSError | ValueError) -> str:
    """Return in words why the system refuses a path; a ValueError is about a character in it, such as NUL."""
    return (error.strerror or str(error)) if isinstance(error, OSError) else "it can't be a file's name"


def is_file(path: str | Path) -> bool:
    """Return whether a path is a plain file; an invalid or overlong name is none."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside ``path`` to write to, and rename it at the end.

    An error or an interruption leaves what was there before. A link stays one: its file is replaced.

    Raises
    ------
    FeasibeeError
        If it isn't a plain file, or the folder doesn't exist or can't be written to.
    """
    target, temporary = _beside(path)
    try:
        yield temporary
        temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else _usual_permissions())
        temporary.replace(target)
    except OSError as error:
        raise FeasibeeError(f"{_named(target)}: can't be written: {why_not(error)}; free some room") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; the file is whole or not there."""
    with whole_file(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def check_output(path: str | Path, suffixes: Sequence[str], option: str = "") -> str:
    """Raise an error now, before the work, if its outcome couldn't be written; return the path's suffix.

    Parameters
    ----------
    path : str or Path
        The file; its suffix says in which format it is to be.
    suffixes : sequence of str
        Those that are known, such as ``".csv"``.
    option : str
        Which option named it, for the error.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        known = f"{', '.join(suffixes[:-1])} or {suffixes[-1]}" if len(suffixes) > 1 else suffixes[0]
        raise FeasibeeError(f"{option} {_named(path)}: unknown kind of file; end it with {known}".lstrip())
    _beside(path)[1].unlink()
    return suffix


def _named(path: str | Path) -> str:
    return one_line(str(path), LINE_LIMIT // 2)


def _beside(path: str | Path) -> tuple[Path, Path]:
    """Return the file that a path names, and an empty temporary one in its folder."""
    target, suffix = Path(path), Path(path).suffix[-20:]  # writers go by the name given, not by a link's end
    try:
        if _is_something_else(target):
            raise FeasibeeError(f"{_named(target)}: isn't a plain file; name another")
        target = target.resolve() if target.is_symlink() else target
        handle, name = tempfile.mkstemp(suffix, f".{target.stem[:20]}-", target.parent)
    except (OSError, ValueError) as error:
        remedy = "name a file in a folder that you may write to"
        raise FeasibeeError(f"{_named(target)}: can't be written: {why_not(error)}; {remedy}") from None
    os.close(handle)
    return target, Path(name)


def _is_something_else(target: Path) -> bool:
    """Return whether a path exists and isn't a plain file; an invalid name raises the system's error."""
    try:
        return not stat.S_ISREG(target.stat().st_mode)
    except FileNotFoundError:
        return False


def make_folder(path: str | Path) -> Path:
    """Make a folder for output, unless it is there."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FeasibeeError(
            f"{_named(folder)}: can't be made: {why_not(error)}; name another folder"
        ) from None
    return folder


def _usual_permissions() -> int:
    """Return what a new file gets: mkstemp's are private, and the user's umask may allow more."""
    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask
