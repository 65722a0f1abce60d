"""feasibee limits: how soon any strategy could be sure."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.options import (
    check_figure,
    console,
    file_type,
    json_option,
    keep_matplotlib_in_cache,
    progress,
    read_scenario,
    scenario_options,
    seed_option,
    threads_option,
)

if TYPE_CHECKING:
    from feasibee.studies.limits import Limits

NOTE = (
    "By the median, half of the runs got there. No strategy with the same phases can soundly declare "
    "infeasible before flooding, or feasible with a proof before complete map."
)


@click.command()
@scenario_options
@click.option("--runs", type=click.IntRange(1), default=1000, show_default=True, help="Number of runs.")
@seed_option
@threads_option
@click.option("--plot", type=file_type, metavar="FILE.png", help="Plot the share of runs at each step.")
@json_option
def limits(
    file: Path | None,
    changes: tuple[str, ...],
    runs: int,
    seed: int,
    threads: int | None,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Compute how soon any strategy could be sure: when enough was seen, and told to enough robots.

    FILE is a scenario in TOML; without one, the paper's defaults. Its strategy doesn't matter. Robots look
    only while exploring, and tell all they know while disseminating, for the scenario's gain on average.

    \b
    Examples:
      feasibee limits
      feasibee limits mine.toml --set tasks.count=21 --plot limits.png
      feasibee limits --set robots.count=50 --set arena.side=31.6 --json
    """
    from feasibee.studies.limits import limits as compute

    check_figure("--plot", plot)
    scenario = read_scenario(file, changes)
    with progress("Simulating") as advance:
        found = compute(scenario, runs, seed, threads=threads, progress=advance)
    if plot is not None:
        keep_matplotlib_in_cache()
        from feasibee.figures.limits import draw_limits
        from feasibee.figures.style import save_figure

        save_figure(draw_limits(found.steps, scenario.run.steps), plot)
    if as_json:
        click.echo(json.dumps(found.to_dict(), indent=2))
    else:
        _print_limits(found)


def _print_limits(found: Limits) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from feasibee.studies.limits import LIMITS

    robots, tasks = found.scenario.robots.count, found.scenario.tasks.count
    title = f"{robots} robots, {tasks} tasks, {found.runs} runs"
    table = Table("limit", title=title, box=SIMPLE_HEAD, pad_edge=False)
    for column in ("median", "interval", "95 %", "interval"):
        table.add_column(column, justify="right")
    for name, times in found.times.items():
        steps = ((times.median, times.median_interval), (times.p95, times.p95_interval))
        cells = [text for step, ends in steps for text in (_shown(step), " to ".join(map(_shown, ends)))]
        table.add_row(_named(name), *cells)
    out = console()
    out.print(table)
    for name, words in LIMITS.items():
        out.print(f"{_named(name)}: {words}.", soft_wrap=True)
    out.print(NOTE, soft_wrap=True)


def _named(limit: str) -> str:
    return limit.replace("_", " ")


def _shown(step: int | None) -> str:
    return "never" if step is None else str(step)
