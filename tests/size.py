"""Print the size of the house, and fail if a figure is above the last landed one: `make lint` runs it.

Who makes the house smaller lowers the figure in `LANDED`. Who must add says so in the commit that raises it.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

from feasibee.cli import main

LANDED = {
    "lines of Python in src": 38_328,
    "lines of C in src": 12_544,
    "lines of JavaScript, HTML and CSS": 5_609,
    "lines of tests": 34_242,
    "lines of claims and benchmarks": 4_208,
    "lines of research": 666,
    "words of docs": 59_579,
    "files of Python in src": 190,
    "packages": 14,
    "commands": 23,
}
"""Largest figure of each kind."""
OTHERS = ":(exclude)src/feasibee/live/static/uplot.js"
"""A library that isn't ours."""


def tracked(*patterns: str) -> list[Path]:
    """Return the files that git tracks and that match a pattern."""
    command = ["git", "ls-files", "-z", "--", *patterns]
    names = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\0")
    return [path for name in names if name and (path := Path(name)).exists()]


def lines(*patterns: str) -> int:
    """Return the number of lines in files."""
    return sum(path.read_bytes().count(b"\n") for path in tracked(*patterns))


def commands(group: Any = main) -> int:
    """Return the number of commands, each of a group's instead of the group."""
    parts: Iterable[Any] = group.commands.values()
    return sum(commands(each) if isinstance(each, click.Group) else 1 for each in parts)


def measured() -> dict[str, int]:
    """Return the figures of this checkout."""
    return {
        "lines of Python in src": lines("src/*.py"),
        "lines of C in src": lines("src/*.c", "src/*.h"),
        "lines of JavaScript, HTML and CSS": lines("src/*.js", "src/*.html", "src/*.css", OTHERS),
        "lines of tests": lines("tests/*.py"),
        "lines of claims and benchmarks": lines("claims/*.py", "benchmarks/*.py", "benchmarks/*.c"),
        "lines of research": lines("research/*.py"),
        "words of docs": sum(len(path.read_text("utf-8").split()) for path in tracked("docs/*.md")),
        "files of Python in src": len(tracked("src/*.py")),
        "packages": len(tracked("src/feasibee/*/__init__.py")),
        "commands": commands(),
    }


if __name__ == "__main__":
    found = measured()
    for name, figure in found.items():
        over = "" if figure <= LANDED[name] else f", {figure - LANDED[name]:,} above the last landed value"
        print(f"{figure:8,} {name}{over}")
    sys.exit(any(figure > LANDED[name] for name, figure in found.items()))
