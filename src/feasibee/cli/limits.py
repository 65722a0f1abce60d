"""feasibee limits, feasibee frontier: how soon any strategy could be sure, and how soon strategies are."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import Workforce, executing, folder_option, workforce_options
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
    strategies_option,
    tasks_option,
    threads_option,
)

if TYPE_CHECKING:
    from feasibee.studies.frontier import Spoken
    from feasibee.studies.limits import Limits

NOTE = (
    "By the median, half of the runs got there. Whatever their strategy, robots that are never wrong declare "
    "infeasible no sooner than flooding, and feasible no sooner than complete map."
)


@click.command()
@scenario_options
@click.option("--runs", type=click.IntRange(1), default=1000, show_default=True, help="Number of runs.")
@seed_option
@threads_option
@click.option(
    "--cells",
    type=click.IntRange(1, 64),
    default=4,
    show_default=True,
    help="Number of cells per range of sight; with more, the limits of the area are sharper.",
)
@click.option("--plot", type=file_type, metavar="FILE.png", help="Plot the share of runs at each step.")
@json_option
def limits(
    file: Path | None,
    changes: tuple[str, ...],
    runs: int,
    seed: int,
    threads: int | None,
    cells: int,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Compute how soon any strategy could be sure: when robots have seen enough, and can know enough.

    FILE is a scenario in TOML; without one, the paper's defaults. Its strategy and its phases don't matter.
    In every step, robots look, broadcast all that they know, and hear: no strategy lets them know more.

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
        found = compute(scenario, runs, seed, cells_per_range=cells, threads=threads, progress=advance)
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
    from feasibee.studies.needs import quiet_times_in_words

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
    for line in (NOTE, *quiet_times_in_words(found.scenario)):
        out.print(line, soft_wrap=True)


def _named(limit: str) -> str:
    return limit.replace("_", " ")


def _shown(step: int | None) -> str:
    return "never" if step is None else str(step)


@click.command()
@scenario_options
@strategies_option("those whose robots declare, tally and census")
@tasks_option("from one less than robots to two more")
@click.option(
    "--runs",
    type=click.IntRange(1),
    default=1000,
    show_default=True,
    help="Number of runs of each contender at each number of tasks.",
)
@seed_option
@workforce_options
@folder_option("frontier", "the figure and its data")
def frontier(
    file: Path | None,
    changes: tuple[str, ...],
    strategies: tuple[str, ...],
    tasks: tuple[int, ...],
    runs: int,
    seed: int,
    workforce: Workforce,
    out: Path,
) -> None:
    """Compare what robots say by their own word with the physical limits: accuracy, time, bits.

    FILE is a scenario in TOML; without one, the paper's defaults. Robots of strategies that don't declare
    commit to an opinion. A strategy may be the path of a .py file.

    \b
    Examples:
      feasibee frontier
      feasibee frontier --strategies quiet-census,map,mine.py --tasks 20,21 --runs 200
    """
    keep_matplotlib_in_cache()
    from feasibee.files import make_folder
    from feasibee.scenario.runs import Runs
    from feasibee.studies.frontier import (
        contenders_named,
        designs_of,
        limits_near,
        tasks_near,
        write_frontier,
    )
    from feasibee.studies.frontier import frontier as simulate_all

    scenario, contenders = read_scenario(file, changes), contenders_named(strategies)
    numbers = tasks_near(scenario, tasks)
    Runs.of_point(len(numbers) - 1, runs, seed)
    designs_of(scenario, contenders, numbers, runs, seed)  # raises before the folder is made
    folder = make_folder(out)
    with executing("Comparing", folder, workforce) as execution:
        found = simulate_all(scenario, contenders, numbers, runs, seed, execution)
    with progress("Computing the limits") as advance:
        bounds = limits_near(scenario, numbers, runs, seed, advance)
    write_frontier(folder, found, bounds)
    _print_frontier(found)
    click.echo(f"The figure (PNG, PDF) and its data, frontier.csv and limits.csv, are in {folder}/")


def _print_frontier(found: list[Spoken]) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    title = f"Right by their own word (%), of {found[0].runs} swarms; steps of half and 95 %"
    table = Table("", title=title, box=SIMPLE_HEAD, pad_edge=False)
    groups: dict[str, list[Spoken]] = {}
    for each in found:
        groups.setdefault(each.contender, []).append(each)
    for each in next(iter(groups.values())):
        table.add_column(f"m = {each.tasks}", justify="right")
    table.add_column("bits", justify="right")
    for name, group in groups.items():
        cells = [
            f"{100 * each.ok.estimate:.1f}\n{_shown(each.times.median)}/{_shown(each.times.p95)}"
            for each in group
        ]
        table.add_row(name, *cells, f"{sum(each.bits for each in group) / len(group):.3g}")
    console().print(table)
