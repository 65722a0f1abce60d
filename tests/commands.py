"""Commands as a user types them, and the tables that they write, for tests."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys

from click.testing import CliRunner

from feasibee.cli import main


def invoke(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def output_of(*arguments):
    """Return the standard output of a command that must succeed."""
    result = invoke(*arguments)
    assert result.exit_code == 0, result.output
    return result.stdout


def json_of(*arguments):
    """Return what a command prints for programs."""
    return json.loads(output_of(*arguments, "--json"))


WITHOUT_BYTECODE = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
"""For processes whose files may not grow: Python would keep compiled modules cut off, for all that follow."""


def python(*words, **options):
    """Run Python in a process of its own; return what it said."""
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=900, **options)


def refused(*arguments):
    """Return the lines on standard error of a command that must be refused."""
    result = invoke(*arguments)
    assert result.exit_code == 2, (result.exit_code, result.output, result.exception)
    assert result.stdout == ""
    return result.stderr.splitlines()


def refused_in_a_line(*arguments):
    """Return the only line on standard error of a command that must be refused."""
    (line,) = refused(*arguments)
    return line


def rows_of(path):
    """Return the rows of a table in CSV."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
