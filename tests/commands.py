"""Commands as a user types them, and the tables that they write, for tests."""

from __future__ import annotations

import csv

from click.testing import CliRunner

from feasibee.cli import main


def invoke(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


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
