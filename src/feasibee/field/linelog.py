"""A log of one JSON object a line, each written at once."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from feasibee.errors import FeasibeeError
from feasibee.files.reading import named, why_not


class LineLog:
    """A log of one JSON object a line, each written at once: a killed process loses nothing.

    Parameters
    ----------
    path : Path
        The file.
    appends : bool
        Whether to go on at the end of the file.

    Raises
    ------
    FeasibeeError
        If the file can't be written. All lines in it are complete then.
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
