"""The command line: parse, call, print. Importing it loads nothing: ``main`` is loaded when asked for."""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    """Return the group of commands, whose import takes a while."""
    if name != "main":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from feasibee.cli.commands import main

    return main
