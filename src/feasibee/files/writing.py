"""Write files that a user names: a failed write leaves the file that was there before, if any."""

from __future__ import annotations

import csv
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from feasibee.errors import FeasibeeError
from feasibee.files.reading import named, why_not

FIGURES = (".png", ".pdf", ".svg")
"""File suffixes of figures."""
RESULTS = (".nc", ".csv")
"""File suffixes of saved results."""


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path in the folder of ``path``, and rename it to ``path`` at the end.

    After an error or an interruption, the previous file is unchanged. If ``path`` is a symbolic link, the
    file that it points to is replaced.

    Raises
    ------
    FeasibeeError
        If ``path`` is a folder or device, or its folder is missing or can't be written to.
    """
    target, temporary = _beside(path)
    try:
        yield temporary
        temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else _usual_permissions())
        temporary.replace(target)
    except OSError as error:
        raise FeasibeeError(f"{named(target)}: can't be written: {why_not(error)}; free disk space") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table as CSV with `atomic_write`."""
    with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def write_table(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows, which have the same columns, as CSV; None is an empty cell."""
    write_csv(path, list(rows[0]), [list(row.values()) for row in rows])


def check_output(path: str | Path, suffixes: Sequence[str], option: str = "") -> str:
    """Validate an output path before a long computation; return its suffix in lower case.

    Parameters
    ----------
    path : str or Path
        The output file, whose suffix chooses the format.
    suffixes : sequence of str
        The supported suffixes, such as ``".csv"``.
    option : str
        The command-line option that named the file, for the error.

    Raises
    ------
    FeasibeeError
        If the suffix isn't supported, or the file can't be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        known = f"{', '.join(suffixes[:-1])} or {suffixes[-1]}" if len(suffixes) > 1 else suffixes[0]
        raise FeasibeeError(
            f"{option} {named(path)}: unknown file format; end the name with {known}".lstrip()
        )
    _beside(path)[1].unlink()
    return suffix


def _beside(path: str | Path) -> tuple[Path, Path]:
    """Return the file that a path points to, and an empty temporary file in the same folder."""
    # The suffix is that of the link, if any: writers choose the format by the name that the user gave.
    target, suffix = Path(path), Path(path).suffix[-20:]
    try:
        if _is_something_else(target):
            raise FeasibeeError(f"{named(target)}: isn't a plain file; name a new or a plain file")
        target = target.resolve() if target.is_symlink() else target
        handle, name = tempfile.mkstemp(suffix, f".{target.stem[:20]}-", target.parent)
    except (OSError, ValueError) as error:
        remedy = "name a file in a folder that you may write to"
        raise FeasibeeError(f"{named(target)}: can't be written: {why_not(error)}; {remedy}") from None
    os.close(handle)
    return target, Path(name)


def _is_something_else(target: Path) -> bool:
    """Return whether a path exists and isn't a plain file; raise an OSError for an invalid name."""
    try:
        return not stat.S_ISREG(target.stat().st_mode)
    except FileNotFoundError:
        return False


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


def _usual_permissions() -> int:
    """Return the permissions of a new file under the user's umask; mkstemp's own are more restrictive."""
    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask
