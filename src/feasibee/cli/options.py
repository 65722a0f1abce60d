"""Options, scenarios and progress bars that several commands share."""

from __future__ import annotations

import math
import os
import sys
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.completion import complete_change, complete_strategy
from feasibee.errors import FeasibeeError, quoted
from feasibee.files import check_output
from feasibee.scenario.paths import read_value

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from feasibee.scenario.scenario import Scenario


class NamedPath(click.Path):
    """A path on the command line; invalid if no file or folder can have such a name."""

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> Any:
        """Return the path, or raise a usage error."""
        name = os.fspath(value)
        if not name:
            self.fail("must be a name, not empty.", param, ctx)
        if any(unicodedata.category(each) == "Cc" for each in name):
            self.fail(f"{quoted(name)} has control characters; use another name.", param, ctx)
        try:
            return super().convert(value, param, ctx)
        except ValueError:  # half a character
            self.fail(f"{quoted(name)} can't be the name of a file or folder.", param, ctx)


class FiniteRange(click.FloatRange):
    """A range of floats; infinities and NaN, which no comparison excludes, are invalid."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or raise a usage error."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{number} is not a finite number.", param, ctx)
        return number


class MeasureChoice(click.Choice[str]):
    """The names of measures, which are loaded only when they are needed."""

    def __init__(self, improvable: bool) -> None:
        self.improvable, self.case_sensitive = improvable, True

    @property
    def choices(self) -> Sequence[str]:  # type: ignore[override]
        """All measures, or those that a search may improve."""
        from feasibee.results.measures import MEASURES

        return [name for name, each in MEASURES.items() if each.values or not self.improvable]


file_type = NamedPath(dir_okay=False, path_type=Path)
folder_type = NamedPath(file_okay=False, path_type=Path)
path_type = NamedPath(path_type=Path)


def scenario_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the argument FILE and the option --set to a command."""
    file = click.argument("file", required=False, type=file_type)
    return file(changes_option(command))


changes_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="FIELD=VALUE",
    shell_complete=complete_change,
    help="Change a field, such as tasks.count=50; repeatable.",
)
seed_option = click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    help="Seed of the random numbers, 0 to 2**64 - 1; the same seed gives the same runs.",
)
run_option = click.option(
    "--run",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    help="Number of the run, or of the first of several.",
)
steps_option = click.option("--steps", type=int, help="Steps per run: short for --set run.steps=...")
workers_option = click.option(
    "--workers", type=click.IntRange(1, 1024), help="Number of workers; by default one per processor."
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")


def runs_option(default: int, text: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return the option of how many runs to simulate."""
    return click.option("--runs", type=click.IntRange(1), default=default, show_default=True, help=text)


def outputs_option(
    text: str, *, folder: bool = False, **kinds: Sequence[str]
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return --out for one file of each kind, by its suffixes, and for a folder if a command writes one.

    The command gets a dict of kinds and paths, of files that can be written.
    """
    suffixes = {suffix: kind for kind, group in kinds.items() for suffix in group}

    def by_kind(
        context: click.Context, parameter: click.Parameter, paths: tuple[Path, ...]
    ) -> dict[str, Path]:
        found: dict[str, Path] = {}
        for path in paths:
            if folder and path.suffix.lower() not in suffixes and (path.is_dir() or not path.suffix):
                kind = "folder"
            else:
                kind = suffixes[check_output(path, list(suffixes), "--out")]
            earlier = next((each for of, each in found.items() if of == kind or _same(each, path)), None)
            if earlier is not None:
                rule = "can't both be written; name one of them"
                raise FeasibeeError(f"--out {earlier} and --out {path}: {rule}")
            found[kind] = path
        return found

    return click.option(
        "--out", "outputs", multiple=True, type=path_type, metavar="FILE", callback=by_kind, help=text
    )


def _same(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve()


def named(context: click.Context, parameter: click.Parameter, text: str | None) -> str | None:
    """Return the text of an option, or raise a usage error if it is empty."""
    if text is not None and not text.strip():
        raise click.BadParameter("must not be empty.")
    return text


def listed(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[str, ...]:
    """Split A,B,... at the commas."""
    parts = tuple(part.strip() for part in text.split(",") if part.strip()) if text is not None else ()
    if text is not None and not parts:
        named(context, parameter, "")
    return parts


def numbered(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[int, ...]:
    """Split M,N,... at the commas into whole numbers."""
    try:
        return tuple(int(part) for part in listed(context, parameter, text))
    except ValueError:
        raise click.BadParameter("must be whole numbers, such as 10,20,40") from None


def strategies_option(default: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return the option that lists strategies to compare; ``default`` says which these are without it."""
    return click.option(
        "--strategies",
        callback=listed,
        metavar="A,B,...",
        shell_complete=complete_strategy,
        help=f"Strategies to compare; by default {default}.",
    )


def tasks_option(default: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return the option that lists numbers of tasks; ``default`` says which these are without it."""
    return click.option(
        "--tasks", callback=numbered, metavar="M,N,...", help=f"Numbers of tasks; by default {default}."
    )


def read_scenario(
    file: Path | None, changes: tuple[str, ...], shorts: Mapping[str, Any] | None = None
) -> Scenario:
    """Return the scenario of a file, or the default one, with changes.

    ``shorts`` are fields that a command has options for, with their values; None changes nothing.
    """
    from feasibee.scenario.scenario import Scenario

    base = Scenario() if file is None else Scenario.read(file)
    given = {field: value for field, value in (shorts or {}).items() if value is not None}
    return base.replace({**dict(_parse_change(change) for change in changes), **given})


def _parse_change(change: str) -> tuple[str, Any]:
    """Parse FIELD=VALUE; the value is TOML, or else plain text."""
    path, equals, text = change.partition("=")
    if not equals:
        raise FeasibeeError(f"--set {change}: must be FIELD=VALUE, such as --set tasks.count=50")
    return path.strip(), read_value(text)


def keep_matplotlib_in_cache() -> None:
    """Let matplotlib write its list of fonts to the cache folder, not to the user's home."""
    from feasibee.files.cache import cache_root, own_folder

    with suppress(FeasibeeError):  # then matplotlib uses a temporary folder
        own_folder(cache_root())
    os.environ.setdefault("MPLCONFIGDIR", str(cache_root() / "matplotlib"))


def console(*, highlight: bool = False) -> Console:
    """Return the console for tables, without Rich's markup, since a file's name may look like it."""
    from rich.console import Console

    return Console(markup=False, emoji=False, highlight=highlight)


def numbers_table(title: str, first: str, columns: Sequence[str], caption: str | None = None) -> Table:
    """Return an empty table: a column of names, and columns of numbers."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(first, title=title, box=SIMPLE_HEAD, pad_edge=False, caption=caption)
    for column in columns:
        table.add_column(column, justify="right")
    return table


@contextmanager
def progress(what: str) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on standard error if it is a terminal; give the function that updates it."""
    from rich.progress import Progress

    from feasibee.simulation.loading import stderr_console

    with Progress(console=stderr_console(), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def wrapped(line: str, indent: str = "") -> str:
    """Wrap a line for the terminal; never break between a number and its %."""
    width = min(88, get_terminal_size().columns)
    further = f"{indent}  " if indent else ""
    text = click.wrap_text(line.replace(" %", "\u00a0%"), width, indent, further)
    return text.replace("\u00a0%", " %")
