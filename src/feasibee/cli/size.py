"""feasibee size: how many robots are enough, and for which numbers of tasks a swarm is blind."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import (
    JOURNAL,
    Given,
    Workforce,
    command,
    complete_strategy,
    count_type,
    keep_matplotlib_in_cache,
    named,
    option,
    outputs_option,
    print_json,
    wrapped,
)
from feasibee.files import FIGURES

if TYPE_CHECKING:
    from feasibee.studies.size import Sizing


@command()
def size(
    *,
    given: Given,
    right: float,
    steps: int | None,
    over: str = option(
        "Field to search, such as radio.range or run.steps.",
        default="robots.count",
        callback=named,
        metavar="FIELD[=LOW:HIGH]",
    ),
    strategy: str | None = option(
        "Short for --set decision.strategy=...", callback=named, shell_complete=complete_strategy
    ),
    runs: int = option("Largest number of runs at each value; the search begins with 100.", count_type, 2000),
    seed: int,
    workforce: Workforce,
    outputs: dict[str, Path] = outputs_option(
        f"Draw the shares, with the blind band shaded: .png, .pdf or .svg. A folder: {JOURNAL} Repeatable.",
        folder=True,
        figure=FIGURES,
    ),
    as_json: bool,
) -> None:
    """Find out how many robots are enough for a swarm to be right often enough.

    FILE is a scenario in TOML; without one, the paper's defaults. The answer is the least number of robots
    for these tasks, or the least value of another field. It also has the blind band: the numbers of tasks for
    which this swarm is not right often enough. The search tests few values, each by as many runs as it takes;
    the whole answer holds with a probability of 95 %. It assumes that the share of right swarms doesn't fall
    as the field grows. With a longer radio.range it may: the last value is tested, and a fall is reported.

    \b
    Examples:
      feasibee size mine.toml
      feasibee size mine.toml --strategy average --right 0.99 --steps 600 --out size.png
      feasibee size mine.toml --over radio.range=1:8
    """
    keep_matplotlib_in_cache()
    from feasibee.figures.sizing import draw_sizing
    from feasibee.figures.style import save_figure
    from feasibee.scenario.runs import Runs
    from feasibee.studies.size import Rule, panels_of
    from feasibee.studies.size import size as search

    scenario = given.read({"decision.strategy": strategy, "run.steps": steps})
    Runs(runs, seed)  # raises before the search
    with executing("Sizing", outputs.get("folder"), workforce) as execution:
        found = search(
            scenario, over, Rule(right, most=runs), seed, execution, lambda line: click.echo(line, err=True)
        )
    if plot := outputs.get("figure"):
        save_figure(draw_sizing(panels_of(found), found.rule.target), plot)
    if as_json:
        print_json(found.to_dict())
    else:
        _print(found, plot)


def _print(found: Sizing, plot: Path | None) -> None:
    from feasibee.studies.size import sentences

    for sentence in sentences(found):
        click.echo(wrapped(sentence))
    click.echo(wrapped(f"Whole answer: {100 * found.rule.confidence:g} % confidence, if {found.assumption}."))
    if plot is not None:
        click.echo(f"The figure is {plot}")
