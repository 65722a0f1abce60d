"""feasibee recommend: which strategy meets the constraints of a deployment."""

from __future__ import annotations

from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import (
    JOURNAL,
    FiniteRange,
    Given,
    Workforce,
    command,
    count_type,
    folder_type,
    option,
    print_json,
    strategies_option,
)

if TYPE_CHECKING:
    from feasibee.studies.recommend import Recommendation

FEW = click.IntRange(0, 1_000_000)


@command()
def recommend(
    *,
    given: Given,
    right: float,
    bits: float | None = option("Most bits per robot-step, on average.", FiniteRange(0, 1e9, min_open=True)),
    message_bits: int | None = option("Most bits in a message.", click.IntRange(1, 2**31)),
    no_ids: bool = option("Ids of robots may be mistaken: robots draw them at random.", is_flag=True),
    no_names: bool = option("Tasks have no names: all look alike.", is_flag=True),
    liars: int = option("Number of Byzantine robots to bear.", FEW, 0, show_default=False),
    stopped: int = option("Number of robots that break down to bear.", FEW, 0, show_default=False),
    steps: int | None,
    strategies: tuple[str, ...] = strategies_option("the built-in ones and the scenario's own"),
    runs: int = option(
        "Largest number of runs of a strategy in a world; a test begins with 100.", count_type, 1000
    ),
    seed: int,
    workforce: Workforce,
    out: Path | None = option(f"Folder of {JOURNAL} By default in memory.", folder_type),
    as_json: bool,
) -> None:
    """Recommend strategies that meet the constraints of a deployment, and say why others don't.

    FILE is a scenario in TOML; without one, the paper's defaults. Each strategy is tested in this world, with
    the faulty robots that it must bear, and with the number of tasks at which the truth is the opposite. What
    it needs is declared in its file; what it bears is measured.

    \b
    Examples:
      feasibee recommend mine.toml
      feasibee recommend mine.toml --liars 1 --message-bits 64 --steps 500
      feasibee recommend mine.toml --no-names --strategies dmmd,average,mine.py
    """
    from feasibee.scenario.runs import Runs
    from feasibee.studies.recommend import Constraints
    from feasibee.studies.recommend import recommend as test_all

    scenario = given.read({"run.steps": steps})
    constraints = Constraints(right, bits, message_bits, not no_ids, not no_names, liars, stopped)
    Runs(runs, seed)  # raises before the tests
    with executing("Testing strategies", out, workforce) as execution:
        found = test_all(scenario, constraints, strategies, runs, seed, execution)
    if as_json:
        print_json(found.to_dict())
    else:
        _print(found)


def _print(found: Recommendation) -> None:
    from feasibee.studies.recommend import described

    if found.ranking:
        click.echo(f"Right in at least {100 * found.constraints.right:g} % of the swarms, the best first:")
    else:
        click.echo("No strategy is shown to meet all constraints.")
    for place, each in enumerate(found.ranking, start=1):
        best = found.best[each.strategy]
        title = f"{place}. {each.strategy}" + (f" ({', '.join(best)})" if best else "")
        click.echo(_entry(title, described(each)))
    for relaxed in found.relax:
        title = f"{relaxed.in_words}: {relaxed.candidate.strategy}"
        click.echo(_entry(title, described(relaxed.candidate)))
    if found.excluded:
        click.echo("Excluded:")
    for name, reason in found.excluded.items():
        click.echo(click.wrap_text(f"{name}: {reason}", _width(), "  ", "    "))


def _entry(title: str, text: str) -> str:
    return f"  {title}\n" + click.wrap_text(text, _width(), "     ", "     ")


def _width() -> int:
    return min(100, get_terminal_size().columns)
