"""feasibee pays: whether robots should ask first, or start."""

from __future__ import annotations

from pathlib import Path

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import (
    FiniteRange,
    Given,
    Workforce,
    command,
    option,
    outputs_option,
    print_json,
    wrapped,
)
from feasibee.files import FIGURES
from feasibee.scenario.runs import Runs

COST = FiniteRange(0, 1e9)


@command()
def pays(
    *,
    given: Given,
    step: float = option("Cost of a step.", COST, 1.0),
    vain: float = option("Cost of each robot that takes a task though robots are missing.", COST, 10.0),
    call: float = option("Cost of each call for help.", COST, 0.0),
    patience: int = option(
        "Steps after which an operator who heard nothing calls the missing robots.",
        click.IntRange(1, 100_000),
        500,
    ),
    runs: int = option("Runs of each policy with each number of tasks.", click.IntRange(2, 100_000), 40),
    seed: int,
    workforce: Workforce,
    outputs: dict[str, Path] = outputs_option(
        "Draw the cheapest policy over robots per task and the cost of a start in vain: .png, .pdf or .svg.",
        figure=FIGURES,
    ),
    as_json: bool,
) -> None:
    """Find out whether robots should ask first if they are enough, search first, or start at once.

    FILE is a scenario in TOML; without one, the paper's defaults. Robots go to tasks and stand there. Robots
    that are missing are called and come, in the simulation, too: [response] says when. Numbers of tasks are
    Poisson, with a mean for each ratio of robots to tasks. The answer is for the ratio of the scenario.

    \b
    Examples:
      feasibee pays
      feasibee pays mine.toml --vain 100 --call 50 --out pays.png
      feasibee pays mine.toml --patience 1000 --json
    """
    from feasibee.figures.style import save_figure
    from feasibee.studies.pays import Costs, diagram, sentences
    from feasibee.studies.pays import pays as simulate_all

    Runs(runs, seed)  # raises before the work
    scenario = given.read()
    with executing("Simulating missions", None, workforce) as execution:
        found = simulate_all(
            scenario,
            Costs(step, vain, call),
            runs=runs,
            patience=patience,
            seed=seed,
            execution=execution,
        )
    if plot := outputs.get("figure"):
        save_figure(diagram(found), plot)
    if as_json:
        print_json(found.to_dict())
        return
    for sentence in (*sentences(found), *([f"The figure is {plot}"] if plot else ())):
        click.echo(wrapped(sentence))
