"""feasibee recommend: which strategy meets the constraints of a deployment."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import Workforce, executing, journal_option, workforce_options
from feasibee.cli.options import (
    console,
    json_option,
    read_scenario,
    scenario_options,
    seed_option,
    strategies_option,
)
from feasibee.cli.size import by_option, right_option

if TYPE_CHECKING:
    from rich.table import Table

    from feasibee.studies.recommendation import Recommendation

CAPTION = (
    "right: the lesser of the shares with these tasks and at the opposite truth (%), with an interval; step: from "
    "where on enough swarms are right; bits: per robot-step, and in the longest message"
)


@click.command()
@scenario_options
@right_option
@click.option("--bits", type=click.FloatRange(0, min_open=True), help="Most bits per robot-step, on average.")
@click.option("--message-bits", type=click.IntRange(1), help="Most bits in a message.")
@click.option("--no-ids", is_flag=True, help="Ids of robots may be mistaken: robots draw them at random.")
@click.option("--no-names", is_flag=True, help="Robots can't tell one task from another.")
@click.option("--liars", type=click.IntRange(0), default=0, help="Number of Byzantine robots to bear.")
@click.option(
    "--stopped", type=click.IntRange(0), default=0, help="Number of robots that break down to bear."
)
@by_option
@strategies_option("the built-in ones and the scenario's own")
@click.option(
    "--runs",
    type=click.IntRange(1),
    default=1000,
    show_default=True,
    help="Largest number of runs of a strategy in a world; a test begins with 100.",
)
@seed_option
@workforce_options
@journal_option
@json_option
def recommend(
    file: Path | None,
    changes: tuple[str, ...],
    right: float,
    bits: float | None,
    message_bits: int | None,
    no_ids: bool,
    no_names: bool,
    liars: int,
    stopped: int,
    by: int | None,
    strategies: tuple[str, ...],
    runs: int,
    seed: int,
    workforce: Workforce,
    out: Path | None,
    as_json: bool,
) -> None:
    """Recommend strategies that meet the constraints of a deployment, and say why others don't.

    FILE is a scenario in TOML; without one, the paper's defaults. Each strategy is tested in this world, with
    the faulty robots that it must bear, and with the number of tasks at which the truth is the opposite. What
    it needs is declared in its file; what it bears is measured.

    \b
    Examples:
      feasibee recommend mine.toml
      feasibee recommend mine.toml --liars 1 --message-bits 64 --by 500
      feasibee recommend mine.toml --no-names --strategies dmmd,average,mine.py
    """
    from feasibee.scenario.runs import Runs
    from feasibee.studies.recommend import recommend as test_all
    from feasibee.studies.recommendation import Constraints

    more = () if by is None else (f"run.steps={by}",)
    scenario = read_scenario(file, (*changes, *more))
    constraints = Constraints(right, bits, message_bits, not no_ids, not no_names, liars, stopped)
    Runs(runs, seed)  # raises before the tests
    with executing("Testing strategies", out, workforce) as execution:
        found = test_all(scenario, constraints, strategies, runs, seed, execution)
    if as_json:
        click.echo(json.dumps(found.to_dict(), indent=2))
    else:
        _print(found)


def _print(found: Recommendation) -> None:
    from feasibee.studies.recommendation import described

    if found.ranking:
        console().print(_table(found))
    else:
        click.echo("No strategy is shown to meet all constraints.")
        for each in found.relax:
            click.echo(f"  Without {each.constraint}: {each.candidate.strategy}, {described(each.candidate)}")
    if found.excluded:
        click.echo("Excluded:")
    for name, reason in found.excluded.items():
        click.echo(f"  {name}: {reason}")


def _table(found: Recommendation) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    title = f"Strategies that are right in {100 * found.constraints.right:g} % of the swarms or more"
    table = Table(title=title, caption=CAPTION, box=SIMPLE_HEAD, pad_edge=False)
    for name in ("strategy", "right", "step", "bits", "message"):
        table.add_column(name, no_wrap=True, justify="left" if name == "strategy" else "right")
    table.add_column("needs")
    table.add_column("best")
    for each in found.ranking:
        share = each.worst.right
        table.add_row(
            each.strategy,
            f"{100 * share.estimate:.1f} ({100 * share.low:.1f} to {100 * share.high:.1f})",
            "" if each.step is None else str(each.step),
            f"{each.bits:.3g}",
            str(each.message_bits),
            ", ".join(each.needs),
            ", ".join(found.best[each.strategy]),
        )
    return table
