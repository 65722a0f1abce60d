"""The group of all commands. Heavy libraries are imported inside the commands."""

from __future__ import annotations

import errno
import itertools
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any, NoReturn

import click
from click.exceptions import NoArgsIsHelpError

from feasibee.base.errors import FeasibeeError, one_line
from feasibee.base.files import why_not
from feasibee.cli import interrupts, streams
from feasibee.cli.lookup import new, show
from feasibee.cli.own import benchmark, check
from feasibee.cli.predict import predict
from feasibee.cli.questions import assess, compare, paper, size
from feasibee.cli.robots import robot
from feasibee.cli.run import run
from feasibee.cli.sweeps import results, sweep
from feasibee.cli.watch import watch

_KINDS = {"integer": "a whole number", "float": "a number"}
_LIMITS = {">": "above", ">=": "at least", "<": "below", "<=": "at most"}


class Commands(click.Group):
    """The group of commands; an error of the input becomes one line per problem and exit status 2."""

    def list_commands(self, context: click.Context) -> list[str]:
        """Return the commands in the order in which they were added; click would sort them."""
        return list(self.commands)

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands, a section for each group."""
        for title, commands in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(f"{each.name:10}", each.short_help or "") for each in commands])

    def resolve_command(self, context: click.Context, args: list[str]) -> Any:
        """Find a command; name the new one if an earlier version called it otherwise."""
        if args and (name := RENAMED.get(args[0])):
            fail(f"{args[0]}: is now feasibee {name}")
        return super().resolve_command(context, args)

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Run as a program, unless called with arguments; signals print one line at any moment."""
        if arguments:
            return super().__call__(*arguments, **options)
        interrupts.begin()
        try:
            return super().__call__(**options)
        finally:
            interrupts.end()

    def main(self, *arguments: Any, **options: Any) -> Any:
        """Run a command, as a program or not."""
        streams.prepare()
        return super().main(*arguments, **options)

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Parse the options before the command."""
        with _errors_as_lines(info_name or "feasibee"):
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, context: click.Context) -> Any:
        """Run the command."""
        with _errors_as_lines(context.command_path), interrupts.raising():
            return super().invoke(context)


@contextmanager
def _errors_as_lines(path: str) -> Iterator[None]:
    """Print errors of the input or the system as lines, and exit; ``path`` is the command's name."""
    try:
        yield
    except FeasibeeError as error:
        fail(str(error))
    except NoArgsIsHelpError:
        raise  # click prints the help
    except click.UsageError as error:
        message = _plainly(one_line(error.format_message()))
        stop = "" if message.endswith((".", "?")) else "."
        fail(f"{message}{stop} See '{error.ctx.command_path if error.ctx else path} --help'.")
    except MemoryError:
        fail("not enough memory; use fewer runs, steps or robots")
    except OSError as error:
        if error.errno == errno.EPIPE:  # the reader of the output has closed it
            raise
        full = error.errno == errno.ENOSPC
        rule, remedy = (
            ("can't be written", "free some disk space") if full else ("can't be used", "use another")
        )
        fail(f"{one_line(str(error.filename or 'the output'))}: {rule}: {why_not(error)}; {remedy}")


def _plainly(message: str) -> str:
    """Return a message of click with the rule for a number in words: click writes ``x>=1``."""
    kind = re.sub(
        r" is not a valid (integer|float)( range)?\.$", lambda m: f" must be {_KINDS[m[1]]}.", message
    )
    rule = re.search(r" is not in the range (?:(\S+?)(<=?))?x(?:([<>]=?)(\S+))?\.$", kind)
    if rule is None:
        return kind
    low, below, beyond, last = rule.groups()
    if (below, beyond) == ("<=", "<="):
        words = f"from {low} to {last}"
    else:
        ends = (
            f"{_LIMITS[below.replace('<', '>')]} {low}" if below else "",
            f"{_LIMITS[beyond]} {last}" if beyond else "",
        )
        words = " and ".join(filter(None, ends))
    return f"{kind[: rule.start()]} must be {words}."


def fail(message: str) -> NoReturn:
    """Print the lines of an error, and exit with status 2."""
    for line in message.split("\n"):
        click.echo(f"feasibee: {line}", err=True)
    sys.exit(2)


GROUPS: dict[str, tuple[click.Command, ...]] = {
    "Start": (run, watch, paper, new),
    "Decide": (assess, size, compare, predict, check, benchmark),
    "Study": (sweep, results),
    "Robots": (robot,),
    "Look up": (show,),
}
"""All commands, by what they are for."""
RENAMED = {
    "animate": "run --out run.gif",
    "page": "run --out run.html",
    "lesson": "watch --lesson",
    "reproduce": "run --again mine.nc",
    "field": "robot launch",
    "recommend": "compare --right 0.95",
    **{name: f"robot {name}" for name in ("launch", "replay", "header")},
    **{name: f"results {name}" for name in ("status", "plot", "export")},
    **{name: f"show {name}" for name in ("scenario", "truth", "strategies", "presets", "schema")},
}
"""Commands of earlier versions, and what they are called now."""


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(version("feasibee"), message="%(prog)s %(version)s")
def main() -> None:
    """Simulate robot swarms that decide together whether a set of tasks is feasible.

    \b
    Examples, to start with:
      feasibee run --set tasks.count=50           simulate 100 swarms of 20 robots with 50 tasks
      feasibee watch                              watch a swarm in the browser
      feasibee paper                              reproduce the paper's figures and claims, in paper/
      feasibee new mine.toml                      write a scenario to edit; then: feasibee run mine.toml
      feasibee assess mine.toml                   is this swarm right, how soon, and what would help?

    Every command has --help, with examples.
    """


for command in itertools.chain(*GROUPS.values()):
    main.add_command(command)
for command in itertools.chain(*(each.commands.values() for each in (main, results, robot, show))):
    command.short_help = re.split(r"[:,.]", command.help or "")[0]  # a line per command
