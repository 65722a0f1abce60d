"""feasibee sweep, which resumes after an interruption, and feasibee results, which looks into its folder."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import FIGURES, RESULTS, check_output, make_folder, write_text
from feasibee.cli.execution import check_log, executing
from feasibee.cli.options import (
    MeasureChoice,
    Workforce,
    argument,
    command,
    complete_field,
    console,
    count_type,
    file_type,
    folder_type,
    named,
    option,
    percents,
    print_json,
    wrapped,
)
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from rich.table import Table

    from feasibee.simulation.table import Summary

_folder = argument(folder_type, default=Path("results"))
_field = partial(option, metavar="FIELD", shell_complete=complete_field, callback=named)


def _shard(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[int, int]:
    """Parse I/N, with parts counted from 1."""
    if text is None:
        return (0, 1)
    numbers = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
    part, parts = map(int, numbers.groups()) if numbers else (0, 0)
    if 1 <= part <= parts:
        return (part - 1, parts)
    raise click.BadParameter("must be I/N, such as 3/16 for the third of 16 parts")


@command()
def sweep(
    *,
    study: Path = argument(file_type),
    out: Path = option(
        "Folder of the runs; what is there isn't computed again.", folder_type, Path("results")
    ),
    runs: int | None = option("Number of runs of each point, instead of the study's.", count_type),
    workforce: Workforce,
    shard: tuple[int, int] = option("Run part I of N only, for job arrays.", callback=_shard, metavar="I/N"),
    log: Path | None = option("Append progress as JSON lines.", file_type),
) -> None:
    """Run a study, many scenarios with many runs each, into a folder.

    STUDY is a TOML file with [scenario], [sweep], runs and seed. If the sweep is interrupted or killed, or
    the disk is full, the same command goes on where it was.

    \b
    Examples:
      feasibee sweep ratio.toml --out results
      feasibee sweep ratio.toml --out results --runs 1000     adds runs to those there
      feasibee sweep ratio.toml --out results --shard 3/16    a part of a job array; all write there
    """
    from dataclasses import replace

    from feasibee.simulation.plan import Study
    from feasibee.simulation.sweep import complete

    plan = Study.read(study)
    if runs is not None:
        plan = replace(plan, runs=Runs(runs, plan.seed).count)
    make_folder(out)
    if log is not None:
        check_log(log)
    with executing("Sweeping", out, workforce, log) as execution:
        done = complete(plan, out, execution.pool, shard, execution.progress)
    click.echo(
        f"{done.runs_new} runs in {done.seconds:.1f} s; the {'study' if shard == (0, 1) else 'part'}'s "
        f"{done.runs_done} runs of {done.points} points are in {out}/. Look: feasibee results status {out}"
    )


@click.group()
def results() -> None:
    """Look into results of a sweep or study: tables, figures, files.

    FOLDER is --out of the command that made it; by default results.

    \b
    Examples:
      feasibee results status
      feasibee results plot --x tasks.count
    """


@command(make=results.command)
def status(
    *,
    folder: Path = _folder,
    as_json: bool = option("Print one JSON array.", name="--json"),
) -> None:
    """Show the progress of a sweep or study, and its results so far; also while it runs.

    \b
    Example:
      feasibee results status
    """
    from feasibee.simulation.store import Store
    from feasibee.simulation.table import summaries

    store = Store(folder)
    points = summaries(store)
    if as_json:
        print_json([_as_json(point) for point in points])
    else:
        _print_table(folder, points)
    store.check()


CAPTION = (
    "right (with 95 % interval) and undecided: % of the runs; half by: step by which half of the runs had "
    "decided"
)
CHANGING_CAPTION = (
    "; steps right: % of the steps at which the swarm held the truth; delay: steps until half of the changes "
    "of truth were followed; false alarms: per 1,000 steps"
)
UNTIL_CAPTION = "; the interval of a point with a stopping rule is valid at every look"
WIDE = 10_000
"""Width that no table needs, in columns."""


def _print_table(folder: Path, points: Sequence[Summary]) -> None:
    """Print a table, or two lines per point if the terminal is too narrow for it; break no word."""
    from rich.measure import Measurement

    from feasibee.simulation.table import value_of, varied

    fields = varied([point.row for point in points])
    seeds = len({point.row.seed for point in points}) > 1
    changing = any(point.row.scenario.dynamic for point in points)
    click.echo(f"{folder}: {sum(point.found.runs for point in points)} runs of {len(points)} points")
    rows = []
    for point in points:
        names = {path: _text(value_of(point.row, path)) for path in fields}
        names |= {"seed": str(point.row.seed)} if seeds else {}
        rows.append((names, _numbers(point) | (_tracked(point) if changing else {})))
    screen = console()
    for padding in (1, 0) if rows else ():
        table = _table(rows, padding)
        if Measurement.get(screen, screen.options.update(width=WIDE), table).maximum <= screen.width:
            screen.print(table)
            break
    else:
        for names, numbers in rows:
            click.echo(wrapped(", ".join(f"{name}={value}" for name, value in names.items()), further="  "))
            known = ", ".join(f"{name} {value}" for name, value in numbers.items() if value)
            click.echo(wrapped(known, "    ", "    "))
    until = any(point.row.until for point in points)
    click.echo(wrapped(CAPTION + CHANGING_CAPTION * changing + UNTIL_CAPTION * until, further="  "))


def _table(rows: Sequence[tuple[dict[str, str], dict[str, str]]], padding: int) -> Table:
    """Return the table of points; ``padding`` is the number of spaces at each side of a column."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Column, Table

    names, numbers = rows[0]
    table = Table(
        *(Column(name.replace(".", ".\n"), no_wrap=True) for name in names),  # the numbers need room
        *(Column(name.replace(" ", "\n"), justify="right", no_wrap=True) for name in numbers),
        box=SIMPLE_HEAD,
        pad_edge=False,
        show_edge=False,
        collapse_padding=True,
        padding=(0, padding),
    )
    for row in rows:
        table.add_row(*(value for cells in row for value in cells.values()))
    return table


def _numbers(point: Summary) -> dict[str, str]:
    """Return the cells that every point has; empty ones if they are unknown."""
    found, accuracy = point.found, point.found.share("accuracy")
    right, interval = percents(accuracy) if accuracy else ("", "")
    return {
        "truth": "changes" if point.row.scenario.dynamic else "feasible" if point.row.truth else "infeasible",
        "runs": str(found.runs),
        "right": right,
        "interval": interval,
        "undecided": f"{100 * found.counts['undecided'] / found.runs:.1f}" if accuracy else "",
        "half by": _text(found.times.median),
    }


def _tracked(point: Summary) -> dict[str, str]:
    """Return the further cells if the world of some point changes; empty ones if they are unknown."""
    found = point.found.tracking
    if found is None:
        return dict.fromkeys(("steps right", "delay", "false alarms"), "")
    median = found.detection_delay.median
    return {
        "steps right": f"{100 * found.right_share.estimate:.1f}",
        "delay": "" if not found.changes else "never" if median is None else str(median),
        "false alarms": f"{found.false_alarms.estimate:.2g}",
    }


def _text(value: Any) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def _as_json(point: Summary) -> dict[str, Any]:
    from feasibee.base.codes import DECISIONS
    from feasibee.results.measures import TRACKED

    found = point.found
    shares = {name: found.share(name) for name in ("accuracy", "right_at_end")}
    return {
        "values": point.row.values,
        "hash": point.row.hash,
        "seed": point.row.seed,
        "truth": "feasible" if point.row.truth else "infeasible",
        "runs": found.runs,
        "until": point.row.until,
        **{name: found.counts[name] for name in DECISIONS.values()},
        **{name: share._asdict() if share else None for name, share in shares.items()},
        "decision_step": found.times._asdict(),
        "bits_per_robot_and_step": found.bits,
        **dict.fromkeys(TRACKED),
        **found.to_dict(),
    }


@command(make=results.command)
def export(
    *,
    folder: Path = _folder,
    out: Path | None = option("File to write, .csv or .nc; by default FOLDER/runs.csv.", file_type),
) -> None:
    """Write all runs of a sweep or study as one table, and whether each was right.

    CSV has a row per run. NetCDF has a dimension per field that varies, and one of the runs.

    \b
    Examples:
      feasibee results export
      feasibee results export --out ratio.nc
    """
    from feasibee.simulation.store import Store
    from feasibee.simulation.table import export as write

    target, store = out or folder / "runs.csv", Store(folder)
    check_output(target, RESULTS, "--out")
    rows = write(store, target)
    click.echo(f"{rows} runs are in {target}")


TEXT_LIMIT = 200
"""Most characters of a text in a figure."""
INCHES = {"mm": 1 / 25.4, "cm": 1 / 2.54, "in": 1.0}
"""Units of a journal's column, in inches."""
COLUMN = 84 * INCHES["mm"]
"""Width of a usual column of a journal, in inches."""


def _inches(context: click.Context, parameter: click.Parameter, text: str | None) -> float | None:
    """Parse a length with its unit."""
    if text is None:
        return None
    from feasibee.figures.sweep import WIDTHS

    found = re.fullmatch(r"([0-9]{1,4}(?:\.[0-9]{1,4})?) *(mm|cm|in)", text)
    inches = float(found[1]) * INCHES[found[2]] if found else 0.0
    if not WIDTHS[0] <= inches <= WIDTHS[1]:
        low, high = (f"{width:g}in" for width in WIDTHS)
        raise click.BadParameter(f"must be a length from {low} to {high}, with its unit, such as 84mm.")
    return inches


def _printable(context: click.Context, parameter: click.Parameter, text: str) -> str:
    if len(text) > TEXT_LIMIT or not text.isprintable():
        raise click.BadParameter(f"must be a line of at most {TEXT_LIMIT} printable characters.")
    return text


_length = partial(option, metavar="LENGTH", callback=_inches)
_words = partial(option, default="", show_default=False, callback=_printable)


@command(make=results.command)
def plot(
    *,
    folder: Path = _folder,
    x: str = _field("Field along the horizontal axis.", required=True),
    hue: str | None = _field("Field with one line per value."),
    y: str | None = _field("Field along the vertical axis of a heat map."),
    show: str = option(
        "Which share of the runs to draw, or measure of a world that changes or of robots that act.",
        MeasureChoice(),
        "accuracy",
    ),
    out: Path | None = option("File to write; by default FOLDER/plot.png.", file_type),
    style: str = option(
        "journal: type, symbols and sharpness for a paper; caption and methods are written next to it, .txt.",
        click.Choice(["default", "journal"]),
        "default",
    ),
    facet: str | None = _field("Field with one panel per value."),
    width: float | None = _length("Width: 84mm, 8.4cm or 3.3in; with --style journal by default 84mm."),
    height: float | None = _length("Height, such as 60mm."),
    title: str = _words("Title above the figure."),
    xlabel: str = _words("Label of the horizontal axis, instead of the field's name."),
    ylabel: str = _words("Label of the vertical axis."),
) -> None:
    """Draw a sweep or study: lines with 95 % bands, or a heat map over two fields.

    \b
    Examples:
      feasibee results plot --x tasks.count --hue decision.strategy
      feasibee results plot --x tasks.count --y radio.loss --out map.pdf
      feasibee results plot --x tasks.count --facet radio.loss --width 7in --height 3in --title "Lossy radio"
      feasibee results plot --x tasks.count --style journal --width 84mm --out column.pdf
    """
    from feasibee.figures.sweep import Shown, text_of
    from feasibee.simulation.store import Store
    from feasibee.simulation.table import summaries, varied

    target, journal = out or folder / "plot.png", style == "journal"
    if hue and y:
        raise FeasibeeError("--hue and --y: exclude each other; leave out one of them")
    store = Store(folder)
    found = summaries(store)
    store.check()
    width = width or (COLUMN if journal else None)
    view = Shown(x, show, hue, y, facet, journal, width, height, title, xlabel, ylabel)
    if facet and facet in (x, hue, y):
        raise FeasibeeError(
            f"--facet {facet}: is already an axis; choose another field that the sweep varies"
        )
    varying = varied([each.row for each in found])
    points = view.drawable(found, folder)
    check_output(target, FIGURES, "--out")
    over = view.over(points, varying)
    if journal:
        text = target.with_suffix(".txt")
        write_text(text, text_of(view, points, varying, store.version))
        click.echo(f"Its caption and methods are {text}")
    view.save(points, over, target)
    click.echo(f"The figure is {target}" + (f", averaged over {', '.join(over)}" if over else ""))
