"""What commands share: functions as commands, options, tables and progress bars."""

from __future__ import annotations

import json
import math
import os
import re
import sys
import textwrap
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache, wraps
from inspect import signature
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from feasibee.base.errors import FeasibeeError, one_line, quoted
from feasibee.base.files import check_output
from feasibee.scenario.paths import read_value

if TYPE_CHECKING:
    from rich.console import Console

    from feasibee.results.statistics import Interval
    from feasibee.scenario.scenario import Scenario
    from feasibee.simulation.executors import WorkerPool
    from feasibee.strategies.contract import Strategy


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


class Duration(click.ParamType):  # type: ignore[type-arg]
    """A time with its unit, such as 90s, 2min or 1h; in seconds."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the seconds, or raise a usage error."""
        found = re.fullmatch(r"(\d+(?:\.\d+)?) ?(s|min|h)", str(value))
        if found is None or not float(found[1]):
            self.fail(f"{quoted(value)}: must be a time such as 90s, 2min or 1h.", param, ctx)
        return float(found[1]) * {"s": 1, "min": 60, "h": 3600}[found[2]]


class MeasureChoice(click.Choice[str]):
    """The names of measures, which are loaded only when they are needed."""

    def __init__(self) -> None:
        self.case_sensitive = True

    @property
    def choices(self) -> Sequence[str]:  # type: ignore[override]
        """All measures."""
        from feasibee.results.measures import MEASURES

        return [*MEASURES]


file_type = NamedPath(dir_okay=False, path_type=Path)
folder_type = NamedPath(file_okay=False, path_type=Path)
path_type = NamedPath(path_type=Path)
count_type = click.IntRange(1)
RUNS = "all runs, with which the same command goes on."
ANIMATIONS = (".gif", ".webp", ".mp4")
"""File suffixes of animations."""


def complete_field(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Complete a field."""
    from feasibee.scenario.fields import fields

    return [field for field in fields() if field.startswith(incomplete)]


def complete_change(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Complete the field of FIELD=VALUE; commas belong to the value."""
    return [f"{field}=" for field in complete_field(context, parameter, incomplete)]


def complete_strategy(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Complete the last strategy of A,B,..."""
    from feasibee.scenario.plugins import registered
    from feasibee.strategies import STRATEGIES

    before, comma, last = incomplete.rpartition(",")
    return [before + comma + name for name in (*STRATEGIES, *registered()) if name.startswith(last)]


def _address(context: click.Context, parameter: click.Parameter, text: str | None) -> str | None:
    """Check a scheduler's address; with an impossible port, Dask would wait without end."""
    host = r"[\w.-]{1,253}|\[[\w:.%]{1,60}\]"
    found = re.fullmatch(rf"(?:[a-z]{{2,9}}://)?(?:{host}):([0-9]{{1,5}})", text or "", re.ASCII)
    if text is not None and not (found and 0 < int(found[1]) < 2**16):
        raise click.BadParameter("must be the address of a scheduler, such as tcp://10.0.0.1:8786.")
    return text


def _frames(context: click.Context, parameter: click.Parameter, text: str | None) -> Any:
    """Parse LAST, or FIRST:LAST."""
    if text is None:
        return None
    first, _, last = text.rpartition(":")
    try:
        return int(first or 0), int(last)
    except ValueError:
        raise click.BadParameter("must be a step, or two; such as 100 or 50:100.") from None


class GivenScenario(NamedTuple):
    """A scenario as a command asks for it."""

    file: Path | None
    changes: tuple[str, ...]

    def read(self, shorts: Mapping[str, Any] | None = None) -> Scenario:
        """Return the scenario of the file, or the default one, with the changes.

        ``shorts`` are fields that a command has options for, with their values; None changes nothing.
        """
        from feasibee.scenario.scenario import Scenario

        base = Scenario() if self.file is None else Scenario.read(self.file)
        given = {field: value for field, value in (shorts or {}).items() if value is not None}
        return base.replace({**dict(map(_parse_change, self.changes)), **given})


def with_flooding(scenario: Scenario) -> Scenario:
    """Return a scenario that knows how soon names flood its place, if its robots wait for it; show a bar."""
    if scenario.waits_for_names:
        from feasibee.simulation.flooding import flooded

        with progress("Flooding the place") as advance:
            flooded(scenario, advance)
    return scenario


def _parse_change(change: str) -> tuple[str, Any]:
    """Parse FIELD=VALUE; the value is TOML, or else plain text."""
    path, equals, text = change.partition("=")
    if not equals:
        raise FeasibeeError(f"--set {change}: must be FIELD=VALUE, such as --set tasks.count=50")
    return path.strip(), read_value(text)


class Workforce(NamedTuple):
    """Workers as a command asks for them."""

    workers: int | None
    dask: str | None

    def pool(self) -> WorkerPool:
        """Return the workers; connect to the Dask cluster, if one is named."""
        from feasibee.simulation import executors

        if self.dask is not None:
            if self.workers is not None:
                raise FeasibeeError("--dask: brings its own workers; leave out --workers")
            return executors.dask(self.dask)
        return executors.threads(self.workers)


class Film(NamedTuple):
    """What an animation shows, and how, as a command asks for it."""

    frames: tuple[int, int] | None
    every: int
    fps: int
    size: int
    dark: bool

    def draw(self, write: Callable[..., None], *what: Any) -> None:
        """Call a function that writes an animation, and show a bar."""
        with progress("Drawing") as advance:
            options = {name: value for name, value in self._asdict().items() if name != "frames"}
            write(*what, **options, steps=self.frames, progress=advance)


def option(text: str, kind: Any = None, default: Any = None, name: str = "", **settings: Any) -> Any:
    """Return the option that a parameter of a command stands for, by its help, type and default.

    It is named as the parameter, unless ``name`` is given with hyphens; ``click.Option`` has the settings. A
    parameter that is a bool is a flag, and one that is a tuple is repeatable, unless a callback makes it.
    """
    if default is not None:
        settings = {"default": default, "show_default": True, **settings}

    def made(parameter: str, annotation: str) -> click.Option:
        names = [parameter, name or f"--{parameter.replace('_', '-')}"]
        repeats = annotation.startswith("tuple[") and "callback" not in settings
        found = {"is_flag": True} if annotation == "bool" else {"multiple": True} if repeats else {}
        return click.Option(names, type=kind, help=text, **{**found, **settings})

    return made


def argument(kind: Any, **settings: Any) -> Any:
    """Return the argument that a parameter of a command stands for."""
    return lambda parameter, _: click.Argument([parameter], type=kind, **settings)


SHARED: dict[str, Any] = {
    "file": argument(file_type, required=False),
    "changes": option(
        "Change a field, such as tasks.count=50; repeatable.",
        name="--set",
        metavar="FIELD=VALUE",
        shell_complete=complete_change,
    ),
    "given": GivenScenario,
    "seed": option("Seed of the random numbers, 0 to 2**64 - 1; the same seed gives the same runs.", int, 0),
    "run": option("Number of the run, or of the first of several.", click.IntRange(0), 0),
    "steps": option('Steps, or time as "10 min": short for --set run.steps=...', read_value, metavar="STEPS"),
    "right": option(
        "Share of swarms that must be right.", FiniteRange(0, 1, min_open=True, max_open=True), 0.95
    ),
    "budget": option("Time such as 90s or 2min, after which the answer so far is printed.", Duration()),
    "workers": option("Number of workers; by default one per processor.", click.IntRange(1, 1024)),
    "dask": option("Use a Dask cluster, such as tcp://10.0.0.1:8786.", callback=_address, metavar="ADDRESS"),
    "workforce": Workforce,
    "frames": option(
        "Animation: steps to show; by default to 30 or more after the decision, or all if the world changes.",
        metavar="[FIRST:]LAST",
        callback=_frames,
    ),
    "every": option("Animation: steps per frame.", count_type, 1),
    "fps": option(
        "Animation: frames per second; for a GIF 1, 2, 4, 5, 10, 20, 25 or 50.", click.IntRange(1, 120), 20
    ),
    "size": option("Animation: width in pixels.", click.IntRange(240, 4096), 480),
    "dark": option("Animation: use a dark background."),
    "look": Film,
    "trust": option("Run a strategy from the text in the results; read it before."),
    "as_json": option("Print one JSON object.", name="--json"),
}
"""What parameters of these names stand for in all commands: an option, or the class of several."""


class Command(click.Command):
    """A command that errors about its options name, and so where its help is."""

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        """Parse the options."""
        try:
            return super().parse_args(context, args)
        except click.UsageError as error:
            error.ctx = error.ctx or context
            raise


def command(make: Callable[..., Any] = click.command) -> Callable[[Callable[..., None]], click.Command]:
    """Return a decorator that makes a command of a function, whose parameters are its options.

    A parameter's default is what `option` or a function below has returned; without one, it is `SHARED`.
    """

    def made(function: Callable[..., None]) -> click.Command:
        bundles: dict[str, Any] = {}
        options: list[click.Parameter] = []
        for each in signature(function).parameters.values():
            declared = SHARED[each.name] if each.default is each.empty else each.default
            if isinstance(declared, type):
                bundles[each.name] = declared
                fields = declared.__annotations__.items()
                options += [SHARED[field](field, of.__forward_arg__) for field, of in fields]
            else:
                options.append(declared(each.name, each.annotation))

        @wraps(function)
        def bundled(**values: Any) -> None:
            keep_matplotlib_in_cache()
            several = {name: of(*map(values.pop, of._fields)) for name, of in bundles.items()}
            function(**several, **values)

        new: click.Command = make(params=options, cls=Command)(bundled)
        return new

    return made


def outputs_option(text: str, *, folder: bool = False, hint: str = "", **kinds: Sequence[str]) -> Any:
    """Return --out for one file of each kind, by its suffixes, and for a folder if a command writes one.

    The command gets a dict of kinds and paths, of files that can be written. ``hint`` ends the error about
    another suffix.
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
                kind = suffixes[check_output(path, list(suffixes), "--out", hint)]
            earlier = next(
                (each for of, each in found.items() if of == kind or each.resolve() == path.resolve()), None
            )
            if earlier is not None:
                rule = "can't both be written; name one of them"
                raise FeasibeeError(f"--out {earlier} and --out {path}: {rule}")
            found[kind] = path
        return found

    return option(text, path_type, name="--out", multiple=True, metavar="FILE", callback=by_kind)


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


def only(chosen: str, why: str, *names: str) -> None:
    """Raise an error if a command is given more than the parameters that go with what is chosen."""
    others = (str(each.name) for each in click.get_current_context().command.params)
    exclude(chosen, why, *(each for each in others if each not in names))


def exclude(chosen: str, why: str, *names: str) -> None:
    """Raise an error if a command is given some parameters, which don't go with what is chosen."""
    context = click.get_current_context()
    given = [
        each.opts[0] if isinstance(each, click.Option) else re.sub(r"[^A-Z|]", "", each.human_readable_name)
        for each in context.command.params
        if each.name in names and context.get_parameter_source(each.name) is ParameterSource.COMMANDLINE
    ]
    if given:
        shown = " and ".join(given)
        raise FeasibeeError(f"{chosen} with {shown}: {why}; leave out {shown}")


def own_strategy(name: str) -> Strategy:
    """Load a user's strategy; an error names its file by the path that was given."""
    from feasibee.scenario.plugins import load

    try:
        return load(name)
    except FeasibeeError as error:
        told = str(error)
        raise FeasibeeError(
            told if told.startswith((f"{name}:", f"{name},")) else f"{one_line(name)}: {told}"
        ) from None


def folder_option(name: str, what: str) -> Any:
    """Return --out, a folder for some output and all runs."""
    return option(f"Folder for {what}, and {RUNS}", folder_type, Path(name))


def keep_matplotlib_in_cache() -> None:
    """Let matplotlib write its list of fonts to the cache folder, not to the user's home."""
    from feasibee.base.cache import cache_root, own_folder

    with suppress(FeasibeeError):  # then matplotlib uses a temporary folder
        own_folder(cache_root())
    os.environ.setdefault("MPLCONFIGDIR", str(cache_root() / "matplotlib"))


def print_json(answer: Any) -> None:
    """Print the answer of a command for programs."""
    click.echo(json.dumps(answer, indent=2))


def percents(share: Interval) -> tuple[str, str]:
    """Return the cells of a share in percent: itself, and its interval."""
    middle, low, high = (100 * each for each in share)
    return f"{middle:.1f}", f"{low:.1f} to {high:.1f}"


def in_brackets(share: Sequence[float], decimals: int = 1) -> str:
    """Return the cell of a share in percent, with its interval in brackets."""
    middle, low, high = (100 * each for each in share)
    return f"{middle:.{decimals}f} ({low:.0f} to {high:.0f})"


def console(*, highlight: bool = False) -> Console:
    """Return the console for tables, without Rich's markup, since a file's name may look like it."""
    from rich.console import Console

    return Console(markup=False, emoji=False, highlight=highlight)


def print_numbers(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    caption: str | None = None,
    *,
    narrow: bool = False,
    words: bool = False,
) -> None:
    """Print a table: a column of names, and columns of numbers, of which the last may have words.

    A narrow table breaks no cell.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, box=SIMPLE_HEAD, pad_edge=False, collapse_padding=narrow, caption=caption)
    table.caption_justify = "left"
    for place, head in enumerate(heads):
        left = not place or (words and place == len(heads) - 1)
        table.add_column(head, justify="left" if left else "right", no_wrap=narrow)
    for row in rows:
        table.add_row(*row)
    console().print(table)


@cache
def stderr_console() -> Console:
    """Return the console of standard error: one for all displays, since rich nests those of one console."""
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def progress(what: str, *, hidden: bool = False) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on standard error if it is a terminal; give the function that updates it."""
    from rich.progress import Progress

    with Progress(console=stderr_console(), transient=True, disable=hidden or not sys.stderr.isatty()) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def print_lines(lines: Iterable[str], indent: str = "", further: str = "") -> None:
    """Print lines, each wrapped for the terminal."""
    for line in lines:
        click.echo(wrapped(line, indent, further))


def wrapped(text: str, indent: str = "", further: str = "") -> str:
    """Wrap a text for the terminal, between words only; never between a number and its %."""
    lines = textwrap.fill(
        text.replace(" %", "\u00a0%"),
        min(100, get_terminal_size().columns),
        initial_indent=indent,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return lines.replace("\u00a0%", " %")
