"""The world's log: one JSON object a line, with all that a restarted world, a page and an animation need."""

from __future__ import annotations

import json
from pathlib import Path
from secrets import token_hex
from typing import TYPE_CHECKING, Any, Final

from feasibee.errors import FeasibeeError
from feasibee.field.linelog import LineLog
from feasibee.files.reading import named

if TYPE_CHECKING:
    from feasibee.field.plan import Plan

VERSION: Final = 4
"""Version of a world's log."""


class WorldLog(LineLog):
    """The log of one world.

    Parameters
    ----------
    path : Path
        The file.
    plan : Plan
        What the field does; the first line has it.
    appends : bool
        Whether the file is of the same field, whose world starts again.
    """

    def __init__(self, path: Path, plan: Plan, *, appends: bool) -> None:
        super().__init__(path, appends=appends)
        if not appends:
            recipe = {"scenario": plan.scenario.to_toml(), "source": plan.scenario.manifest.source}
            which = {"seed": plan.seed, "run": plan.run, "lockstep": plan.lockstep, "hz": plan.hz}
            session = token_hex(8)  # tells two fields in one folder apart
            self.write({"feasibee": "field", "version": VERSION, **recipe, **which, "session": session})


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Return the lines of a log; cut off an incomplete last line, of a world that was killed.

    Raises
    ------
    FeasibeeError
        If the file can't be read.
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
