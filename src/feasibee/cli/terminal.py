"""The terminal that progress is shown on."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


@cache
def stderr_console() -> Console:
    """Return the console of standard error: one for all displays, since rich nests those of one console."""
    from rich.console import Console

    return Console(stderr=True)
