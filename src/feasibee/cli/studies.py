"""feasibee paper, feasibee compare: studies with figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.completion import complete_strategy
from feasibee.cli.options import (
    console,
    folder_type,
    keep_matplotlib_in_cache,
    listed,
    progress,
    read_scenario,
    scenario_options,
    seed_option,
    threads_option,
)

if TYPE_CHECKING:
    from feasibee.studies.claims import Claim
    from feasibee.studies.comparison import Outcome


def _numbers(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in listed(context, parameter, text))
    except ValueError:
        raise click.BadParameter("must be whole numbers, such as 10,20,40") from None


@click.command()
@scenario_options
@click.option(
    "--strategies",
    callback=listed,
    metavar="A,B,...",
    shell_complete=complete_strategy,
    help="By default all built-in ones.",
)
@click.option("--presets", callback=listed, metavar="A,B,...", help="Instead; 'default' is the paper.")
@click.option(
    "--tasks", callback=_numbers, metavar="M,N,...", help="By default nine numbers, most near ratio one."
)
@click.option("--runs", type=click.IntRange(1), default=200, show_default=True, help="Swarms of each kind.")
@seed_option
@threads_option
@click.option(
    "--out",
    type=folder_type,
    default=Path("compare"),
    show_default=True,
    help="Folder for figures and data.",
)
def compare(
    file: Path | None,
    changes: tuple[str, ...],
    strategies: tuple[str, ...],
    presets: tuple[str, ...],
    tasks: tuple[int, ...],
    runs: int,
    seed: int,
    threads: int | None,
    out: Path,
) -> None:
    """Let strategies decide on the same worlds: how often right, how soon, at how many bits.

    FILE is a scenario in TOML; without one, the paper's defaults. A strategy may be the path of a .py file.

    \b
    Examples:
      feasibee compare
      feasibee compare --strategies dmmd,dmvd,census --tasks 10,20,21,40 --runs 1000
      feasibee compare mine.toml --strategies dmmd,my_strategy.py
      feasibee compare --presets default,valentini-2016 --runs 100
    """
    keep_matplotlib_in_cache()
    from feasibee.files import make_folder
    from feasibee.scenario.runs import Runs
    from feasibee.studies.comparison import TASKS, contenders_of, write_comparison
    from feasibee.studies.comparison import compare as simulate_all

    scenario = read_scenario(file, changes)
    Runs.of_point(0, runs, seed)  # raises before the folder is made
    numbers = tasks or (() if scenario.tasks.classes or scenario.tasks.points else TASKS)
    contenders = contenders_of(scenario, strategies, presets)
    for number in tasks:
        scenario.replace({"tasks.count": number})
    folder = make_folder(out)
    with progress("Comparing") as advance:
        outcomes = simulate_all(contenders, numbers, runs, seed, threads, advance)
    write_comparison(folder, outcomes)
    _print_comparison(outcomes)
    click.echo(f"Figures (PNG, PDF) and their data, compare.csv, are in {folder}/")


@click.command()
@click.option(
    "--out",
    type=folder_type,
    default=Path("paper"),
    show_default=True,
    help="Folder for figures, data and claims.",
)
@click.option(
    "--runs",
    type=click.IntRange(4),
    default=2000,
    show_default=True,
    help="Swarms at each ratio; the paper has 100, which leave some claims open.",
)
@seed_option
@threads_option
@click.option("--beyond", is_flag=True, help="Instead, draw Fig. 3 again in seven worlds unlike the paper's.")
def paper(out: Path, runs: int, seed: int, threads: int | None, beyond: bool) -> None:
    """Reproduce the paper: its three figures, the data behind them, its claims checked.

    \b
    Examples:
      feasibee paper
      feasibee paper --runs 100 --out paper-100
      feasibee paper --beyond --runs 400
    """
    keep_matplotlib_in_cache()
    if beyond:
        from feasibee.studies.robustness import reproduce_beyond, summary

        with progress("Simulating beyond the paper") as advance:
            rows = reproduce_beyond(out, runs, seed, threads, advance)
        _print_beyond(summary(rows), runs)
        click.echo(f"beyond.png, beyond.pdf and their data, beyond.csv, are in {out}/")
        return
    from feasibee.studies.paper import reproduce

    with progress("Simulating the paper's study") as advance:
        claims = reproduce(out, runs, seed, threads, advance)
    _print_claims(claims, runs)
    click.echo(f"Figures (PNG, PDF), their data (CSV) and claims.json are in {out}/")


def _print_claims(claims: list[Claim], runs: int) -> None:
    from rich.console import Console
    from rich.table import Table

    colours = {"holds": "green", "fails": "red", "can't tell": "yellow"}
    table = Table(title=f"The paper's claims, from {runs} runs at each ratio", show_lines=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("claim, and what the runs say")
    for claim in claims:
        measured = f"{claim.estimate:.3g} ({claim.low:.3g} to {claim.high:.3g}); must be {claim.bar}"
        verdict = f"[{colours[claim.verdict]}]{claim.verdict}[/]"
        table.add_row(verdict, f"{claim.claim}\n[dim]{claim.statistic}:[/]\n{measured}")
    Console(highlight=False).print(table)


def _print_beyond(lines: list[list[str]], runs: int) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(*lines[0], title=f"Share of right decisions, by ratio, from {runs} runs each")
    for line in lines[1:]:
        table.add_row(*line)
    Console(highlight=False).print(table)


def _print_comparison(outcomes: list[Outcome]) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from feasibee.studies.comparison import by_contender, overall

    groups = by_contender(outcomes)
    ranked = sorted(groups, key=lambda name: -overall(groups[name]).estimate)
    runs = outcomes[0].runs
    shares = Table(
        "tasks m",
        title=f"Swarms that are right at the end (%), of {runs} each",
        box=SIMPLE_HEAD,
        pad_edge=False,
    )
    for each in next(iter(groups.values())):
        shares.add_column(str(each.tasks), justify="right")
    for name in ranked:
        shares.add_row(name, *(f"{100 * each.accuracy.estimate:.0f}" for each in groups[name]))
    commits = any((each.committed > 0).any() for each in outcomes)
    more = ["committed", "wrongly"] if commits else []
    sums = Table(
        "over all m",
        title="All together",
        box=SIMPLE_HEAD,
        pad_edge=False,
        caption="right: at the end (%), and where that lies with 95 % confidence; difference: from "
        f"{next(iter(groups))}, in points, in the same runs; first: the first collective decision is right "
        "(%); by: the step by which half of the runs had decided; bits: sent a robot and step",
    )
    for column in ("right", "interval", "difference", "first", "by", "bits", *more):
        sums.add_column(column, justify="right")
    for name in ranked:
        sums.add_row(name, *_sums(groups[name], next(iter(groups.values())), commits))
    out = console()
    out.print(shares)
    out.print(sums)


def _sums(group: list[Outcome], baseline: list[Outcome], commits: bool) -> list[str]:
    """Return what to print of a contender over all numbers of tasks."""
    from feasibee.studies.comparison import mean_bits, overall, overall_difference

    share, difference = overall(group), overall_difference(group, baseline)
    first = sum(each.first.estimate for each in group) / len(group)
    steps = sorted(each.times.median or float("inf") for each in group)
    row = [
        f"{100 * share.estimate:.1f}",
        f"{100 * share.low:.1f} to {100 * share.high:.1f}",
        f"{100 * difference.low:+.1f} to {100 * difference.high:+.1f}" if group is not baseline else "",
        f"{100 * first:.0f}",
        f"{steps[len(steps) // 2]:g}",
        f"{mean_bits(group):.3g}",
    ]
    if commits:
        row += [f"{100 * sum(each.committed.mean() for each in group) / len(group):.0f}"]
        row += [f"{100 * sum(each.committed_wrong.mean() for each in group) / len(group):.1f}"]
    return row
