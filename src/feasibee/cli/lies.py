"""feasibee lies: how often swarms are right under the worst lie that a search finds."""

from __future__ import annotations

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import Given, Workforce, command, option, print_json
from feasibee.scenario.runs import Runs


@command()
def lies(
    *,
    given: Given,
    liars: int = option("Number of Byzantine robots.", click.IntRange(1, 1000), 1),
    trials: int = option("Number of lies tried on each side.", click.IntRange(2, 10_000), 24),
    runs: int = option("Number of runs of each lie.", click.IntRange(2, 10_000), 20),
    seed: int,
    workforce: Workforce,
    as_json: bool,
) -> None:
    """Search for the worst lie against the strategy of a scenario, and judge it on fresh runs.

    Byzantine robots collude and know the truth. The search covers the scenario's ratio of robots to tasks and
    its reciprocal. Messages keep the strategy's own format. Needs the extra 'tune'.

    \b
    Examples:
      feasibee lies --set tasks.count=10
      feasibee lies mine.toml --liars 3 --trials 60 --json
    """
    from feasibee.studies.lies import worst_lie

    Runs(10 * runs, seed)  # raises before the work
    scenario = given.read()
    with executing("Lying", None, workforce) as execution:
        found = worst_lie(scenario, scenario.decision.strategy, liars, trials, runs, seed, execution)
    shares = {"no lie": found.none, "own lie": found.own, "worst lie": found.worst}
    if as_json:
        shown = {name.replace(" ", "_"): each._asdict() for name, each in shares.items()}
        print_json({"liars": liars, "values": found.values, **shown})
        return
    click.echo(f"Share right at the end, {20 * runs} fresh runs, 95 % interval:")
    for name, (middle, low, high) in shares.items():
        click.echo(f"  {name:9}  {middle:.3f} ({low:.3f} to {high:.3f})")
    values = (
        f"{path}={each:.4g}" if isinstance(each, float) else f"{path}={each}"
        for path, each in found.values.items()
    )
    click.echo(f"The worst lie: {', '.join(values)}")
