"""The folder of a field's logs: locked, and temporary if the user names none."""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Final

from feasibee.files.locking import lock
from feasibee.files.writing import make_folder

LOCK: Final = "field.lock"


@contextmanager
def log_folder(named: Path | None) -> Iterator[Path]:
    """Give the folder of a field's logs: a named one, locked against other fields, or a temporary one.

    Raises
    ------
    FeasibeeError
        If the folder can't be made, or another process has locked it.
    """
    if named is None:
        with tempfile.TemporaryDirectory(prefix="feasibee-field-", ignore_cleanup_errors=True) as name:
            yield Path(name)
        return
    with closing(lock(make_folder(named), LOCK)):
        yield named


def remove_older(folder: Path, robots: Collection[int]) -> None:
    """Remove the logs of robots that aren't of this field: an earlier one left them in the folder."""
    for log in folder.glob("robot-*.jsonl"):
        number = log.stem.removeprefix("robot-")
        if number.isdecimal() and int(number) not in robots:
            log.unlink(missing_ok=True)
