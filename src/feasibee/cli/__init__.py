"""The command line: parse, call, print. Heavy libraries load inside the commands."""

from __future__ import annotations

import errno
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from importlib.metadata import version
from io import TextIOWrapper
from typing import Any, NoReturn

import click

from feasibee.cli import interrupts
from feasibee.cli.animate import animate
from feasibee.cli.assess import assess
from feasibee.cli.compile import compile_engines
from feasibee.cli.run import run
from feasibee.cli.scenarios import scenario, schema, truth
from feasibee.cli.search import sensitivity, tune
from feasibee.cli.studies import compare, paper
from feasibee.cli.sweeps import export, merge, plot, status, sweep
from feasibee.cli.watch import watch
from feasibee.errors import FeasibeeError, one_line
from feasibee.files import why_not


class Commands(click.Group):
    """The commands, with feasibee's errors as lines and exit status 2."""

    def list_commands(self, context: click.Context) -> list[str]:
        """Return the commands in the order in which they were added, not by their letters."""
        return list(self.commands)

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Run as a program, unless arguments say what to run; Ctrl-C ends it in a line at any moment."""
        if arguments:
            return super().__call__(*arguments, **options)
        interrupts.begin()
        try:
            return super().__call__(**options)
        finally:
            interrupts.end()

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Parse what comes before the command; without anything, click shows the help."""
        with _told(info_name or "feasibee") if args else nullcontext():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, context: click.Context) -> Any:
        """Run a command."""
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):  # a terminal may lack characters that a file's name has
                stream.reconfigure(errors="backslashreplace")
        with _told(context.command_path), interrupts.raising():
            return super().invoke(context)


@contextmanager
def _told(path: str) -> Iterator[None]:
    """Turn an error of the input or the surroundings into lines; ``path`` is that of the command."""
    try:
        yield
    except FeasibeeError as error:
        fail(str(error))
    except click.UsageError as error:
        message = one_line(error.format_message())
        stop = "" if message.endswith((".", "?")) else "."
        fail(f"{message}{stop} See '{error.ctx.command_path if error.ctx else path} --help'.")
    except MemoryError:
        fail("not enough memory; ask for fewer runs, steps or robots")
    except OSError as error:
        if error.errno == errno.EPIPE:  # whoever read the output has enough
            raise
        full = error.errno == errno.ENOSPC
        rule, remedy = ("can't be written", "free some room") if full else ("can't be used", "name another")
        fail(f"{one_line(str(error.filename or 'the output'))}: {rule}: {why_not(error)}; {remedy}")
    except KeyboardInterrupt as interrupt:
        interrupts.interrupted(str(interrupt))


def fail(message: str) -> NoReturn:
    """Print the lines of an error, and leave with the status of wrong input."""
    for line in message.split("\n"):
        click.echo(f"feasibee: {line}", err=True)
    sys.exit(2)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(version("feasibee"), message="%(prog)s %(version)s")
def main() -> None:
    """Can this swarm do these tasks? Simulate how the swarm itself finds out.

    \b
    Examples:
      feasibee paper                              the paper's figures and claims, in paper/
      feasibee run --set tasks.count=50           one scenario, 100 runs
      feasibee watch                              a swarm in the browser
      feasibee scenario > mine.toml               a file to edit
    """


for command in (
    run,
    watch,
    animate,
    assess,
    compare,
    sweep,
    status,
    plot,
    export,
    merge,
    tune,
    sensitivity,
    paper,
    compile_engines,
    truth,
    scenario,
    schema,
):
    command.short_help = re.split(r"[:,.]", command.help or "")[0]  # a line has no room for more
    main.add_command(command)
