"""The command line: parse, call, print. Heavy libraries load inside the commands."""

from __future__ import annotations

import errno
import re
import sys
from importlib.metadata import version
from typing import Any, NoReturn

import click

from feasibee.cli import interrupts
from feasibee.cli.animate import animate
from feasibee.cli.assess import assess
from feasibee.cli.run import run
from feasibee.cli.scenarios import scenario, schema, truth
from feasibee.cli.search import sensitivity, tune
from feasibee.cli.studies import compare, paper
from feasibee.cli.sweeps import export, merge, plot, status, sweep
from feasibee.cli.watch import watch
from feasibee.errors import FeasibeeError


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

    def invoke(self, context: click.Context) -> Any:
        """Run a command."""
        try:
            with interrupts.raising():
                return super().invoke(context)
        except FeasibeeError as error:
            fail(str(error))
        except click.UsageError as error:
            path = error.ctx.command_path if error.ctx else context.command_path
            message = error.format_message()
            stop = "" if message.endswith((".", "?")) else "."
            fail(f"{message}{stop} See '{path} --help'.")
        except MemoryError:
            fail("not enough memory; ask for fewer runs, steps or robots")
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
            fail(f"{error.filename or 'the output'}: can't be written: {error.strerror}; free some room")
        except KeyboardInterrupt as interrupt:
            interrupts.interrupted(str(interrupt))


def fail(message: str) -> NoReturn:
    """Print an error, and leave with the status of wrong input."""
    for line in message.splitlines():
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
    truth,
    scenario,
    schema,
):
    command.short_help = re.split(r"[:,.]", command.help or "")[0]  # a line has no room for more
    main.add_command(command)
