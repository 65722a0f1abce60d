"""feasibee sweep, status, export, plot, merge: studies that survive anything."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.completion import complete_field
from feasibee.cli.interrupts import leaving
from feasibee.cli.options import (
    check_figure,
    console,
    file_type,
    folder_type,
    keep_matplotlib_in_cache,
    named,
)
from feasibee.cli.sweep_progress import check_log, told
from feasibee.errors import FeasibeeError

if TYPE_CHECKING:
    from feasibee.sweeps.executors import Crew
    from feasibee.sweeps.sweep import Progress
    from feasibee.sweeps.table import Summary

_folder = click.argument("folder", type=folder_type)
_field = partial(click.option, metavar="FIELD", shell_complete=complete_field, callback=named)


def _shard(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[int, int]:
    """Read I/N, parts counted from 1."""
    if text is None:
        return (0, 1)
    numbers = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
    part, parts = map(int, numbers.groups()) if numbers else (0, 0)
    if 1 <= part <= parts:
        return (part - 1, parts)
    raise click.BadParameter("must be I/N, such as 3/16 for the third of 16 parts")


def _address(context: click.Context, parameter: click.Parameter, text: str | None) -> str | None:
    """Check a scheduler's address; with a port that can't be, Dask would wait without end."""
    host = r"[\w.-]{1,253}|\[[\w:.%]{1,60}\]"
    found = re.fullmatch(rf"(?:[a-z]{{2,9}}://)?(?:{host}):([0-9]{{1,5}})", text or "", re.ASCII)
    if text is not None and not (found and 0 < int(found[1]) < 2**16):
        raise click.BadParameter("must be the address of a scheduler, such as tcp://10.0.0.1:8786.")
    return text


@click.command()
@click.argument("study", type=file_type)
@click.option(
    "--out",
    type=folder_type,
    default=Path("results"),
    show_default=True,
    help="Folder of the journal; what is there already isn't run again.",
)
@click.option("--runs", type=click.IntRange(1), help="Runs of each point, instead of the study's.")
@click.option("--workers", type=click.IntRange(1, 1024), help="By default one for each processor.")
@click.option(
    "--processes", is_flag=True, help="Use processes instead of threads; one that dies is replaced."
)
@click.option(
    "--dask", callback=_address, metavar="ADDRESS", help="Use a Dask cluster, such as tcp://10.0.0.1:8786."
)
@click.option("--shard", callback=_shard, metavar="I/N", help="Do part I of N only, for job arrays.")
@click.option("--log", type=file_type, help="Append progress as JSON lines.")
def sweep(
    study: Path,
    out: Path,
    runs: int | None,
    workers: int | None,
    processes: bool,
    dask: str | None,
    shard: tuple[int, int],
    log: Path | None,
) -> None:
    """Run a study: many scenarios, many runs of each, into a journal.

    STUDY is a TOML file with [scenario], [sweep], runs and seed. Interrupt it, kill it, let the disk fill up:
    the same command goes on where it was.

    \b
    Examples:
      feasibee sweep ratio.toml --out results
      feasibee sweep ratio.toml --out results --runs 1000     grows what is there
      feasibee sweep ratio.toml --out part3 --shard 3/16      then: feasibee merge results part*
    """
    with leaving("what was kept stays; the same command goes on"):
        done = _sweep(study, out, runs, (workers, processes, dask), shard, log)
    click.echo(
        f"{done.runs_new} runs in {done.seconds:.1f} s; the {'study' if shard == (0, 1) else 'part'}'s "
        f"{done.runs_done} runs of {done.points} points are in {out}/. Look: feasibee status {out}"
    )


def _sweep(
    study: Path,
    out: Path,
    runs: int | None,
    crew: tuple[int | None, bool, str | None],
    shard: tuple[int, int],
    log: Path | None,
) -> Progress:
    from dataclasses import replace

    from feasibee.files import make_folder
    from feasibee.scenario.runs import Runs
    from feasibee.sweeps.plan import Study
    from feasibee.sweeps.sweep import sweep as run_sweep

    plan = Study.read(study)
    if runs is not None:
        plan = replace(plan, runs=Runs(runs, plan.seed).count)
    make_folder(out)
    if log is not None:
        check_log(log)
    workers = _crew(*crew)
    _prepare(plan, crew[-1])
    with told(log) as progress:
        return run_sweep(plan, out, workers, shard, progress)


def _crew(workers: int | None, use_processes: bool, address: str | None) -> Crew:
    from feasibee.sweeps import executors

    if address is not None:
        if use_processes or workers is not None:
            raise FeasibeeError("--dask: brings its own workers; leave --workers and --processes out")
        return executors.dask(address)
    return executors.processes(workers) if use_processes else executors.threads(workers)


def _prepare(plan: Any, address: str | None) -> None:
    """Compile here, once, what workers on this machine will need."""
    from feasibee.simulation.loading import load_engine

    if address is None:
        for point in plan.points:
            load_engine(point.scenario)


@click.command()
@_folder
@click.option("--json", "as_json", is_flag=True, help="Print one JSON array.")
def status(folder: Path, as_json: bool) -> None:
    """Say how far a sweep is, and what its points say so far; also while it runs.

    \b
    Example:
      feasibee status results
    """
    from feasibee.sweeps.journal import Journal
    from feasibee.sweeps.table import survey

    with Journal(folder) as journal:
        points, found = survey(journal)
    if as_json:
        click.echo(json.dumps([_as_json(point) for point in points], indent=2))
    else:
        _print_table(folder, points)
    if not found.is_whole:
        raise FeasibeeError(found.line)


def _print_table(folder: Path, points: Sequence[Summary]) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.table import Column, Table

    from feasibee.sweeps.table import held, varied

    fields = varied([point.row for point in points])
    total = sum(point.runs for point in points)
    seeds = len({point.row.seed for point in points}) > 1
    names = [*fields, "seed"] if seeds else fields
    table = Table(
        *(Column(name.replace(".", ".\n"), overflow="fold") for name in names),  # the numbers need room
        box=SIMPLE_HEAD,
        pad_edge=False,
        collapse_padding=True,
        title=f"{folder}: {total} runs of {len(points)} points",
        caption="right (with 95 % interval) and undecided: % of the runs; half by: the step by which half of "
        "the runs had decided" + _sequential(points),
    )
    for column in ("truth", "runs", "right", "interval", "undecided", "half by"):
        table.add_column(column, justify="right", no_wrap=True)
    for point in points:
        values = [_text(held(point.row, path)) for path in fields]
        values += [str(point.row.seed)] if seeds else []
        accuracy = point.accuracy
        middle = "" if point.times.median is None else str(point.times.median)
        told = ["", "", "", middle]
        if accuracy is not None:
            told = [
                f"{100 * accuracy.estimate:.1f}",
                f"{100 * accuracy.low:.1f} to {100 * accuracy.high:.1f}",
                f"{100 * point.counts['undecided'] / point.runs:.1f}",
                middle,
            ]
        table.add_row(*values, "feasible" if point.row.truth else "infeasible", str(point.runs), *told)
    console().print(table)


def _text(value: Any) -> str:
    return "" if value is None else str(value)


def _sequential(points: Sequence[Summary]) -> str:
    told = "; the interval of a point that runs until sure holds however often one looks"
    return told if any(point.row.until for point in points) else ""


def _as_json(point: Summary) -> dict[str, Any]:
    return {
        "values": point.row.values,
        "hash": point.row.hash,
        "seed": point.row.seed,
        "truth": "feasible" if point.row.truth else "infeasible",
        "runs": point.runs,
        "until": point.row.until,
        **point.counts,
        "accuracy": point.accuracy._asdict() if point.accuracy else None,
        "decision_step": point.times._asdict(),
        "bits_per_robot_and_step": point.bits,
    }


@click.command()
@_folder
@click.option(
    "--to",
    "kind",
    type=click.Choice(["csv", "parquet", "netcdf"]),
    help="By default as --out ends: .csv, .parquet or .nc; without --out, csv.",
)
@click.option("--out", type=file_type, help="By default FOLDER/runs.csv, ...")
def export(folder: Path, kind: str | None, out: Path | None) -> None:
    """Write all runs of a sweep as one table, a row a run.

    \b
    Examples:
      feasibee export results
      feasibee export results --out ratio.parquet
    """
    from feasibee.files import check_output
    from feasibee.sweeps.journal import Journal
    from feasibee.sweeps.table import KINDS
    from feasibee.sweeps.table import export as write

    target = out or folder / f"runs{KINDS[kind or 'csv']}"
    kinds = {suffix: name for name, suffix in KINDS.items() if kind in (None, name)}
    with Journal(folder) as journal:
        rows = write(journal, kinds[check_output(target, list(kinds), "--out")], target)
    click.echo(f"{rows} runs are in {target}")


@click.command()
@_folder
@_field("--x", required=True, help="Field along the horizontal axis.")
@_field("--hue", help="A line for each value of this field.")
@_field("--y", help="Instead, a heat map over --x and this field.")
@click.option(
    "--show",
    type=click.Choice(["accuracy", "feasible", "infeasible", "undecided"]),
    default="accuracy",
    show_default=True,
    help="The share of the runs to draw.",
)
@click.option("--out", type=file_type, help="By default FOLDER/plot.png.")
def plot(folder: Path, x: str, hue: str | None, y: str | None, show: str, out: Path | None) -> None:
    """Draw a sweep: lines with 95 % bands, or a heat map over two fields.

    \b
    Examples:
      feasibee plot results --x tasks.count --hue decision.strategy
      feasibee plot results --x tasks.count --y radio.loss --out map.pdf
    """
    keep_matplotlib_in_cache()
    from feasibee.figures.style import save_figure
    from feasibee.sweeps.figures import draw_lines, draw_map
    from feasibee.sweeps.journal import Journal
    from feasibee.sweeps.table import alike, summaries, varied

    target = out or folder / "plot.png"
    if hue and y:
        raise FeasibeeError("--hue and --y: can't stand together; leave one of them out")
    with Journal(folder) as journal:
        found = summaries(journal)
    points = [each for each in found if each.runs]
    if not points:
        raise FeasibeeError(f"{folder}: has no runs yet; run feasibee sweep first")
    check_figure("--out", target)
    drawn = draw_map(points, x, y, show) if y else draw_lines(points, x, hue, show)
    save_figure(drawn, target)
    click.echo(f"The figure is {target}")
    others = [field for field in varied([each.row for each in found]) if field not in (x, hue, y)]
    over = alike([each.row for each in points], [field for field in (x, hue, y) if field], others)
    if over:
        click.echo(f"feasibee: it takes runs together that differ in {', '.join(over)}", err=True)


@click.command()
@_folder
@click.argument("parts", nargs=-1, required=True, type=folder_type)
def merge(folder: Path, parts: tuple[Path, ...]) -> None:
    """Merge journals: bring the runs of several, such as those of a job array, into one.

    \b
    Example:
      feasibee merge results part1 part2 part3
    """
    from feasibee.files import make_folder
    from feasibee.sweeps.journal import Journal
    from feasibee.sweeps.merging import merge as merge_all

    for part in parts:
        Journal(part).close()  # refused before anything is written
    with Journal(make_folder(folder), write=True) as journal:
        merge_all(journal, parts)
        total = sum(runs for runs, _ in journal.counts().values())
    click.echo(f"{folder}/ has {total} runs of {len(parts)} parts and of what was there")
