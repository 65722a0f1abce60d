"""feasibee truth, scenario, schema: examine a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.options import Given, argument, command, console, file_type, option, print_json
from feasibee.errors import FeasibeeError

if TYPE_CHECKING:
    from feasibee.scenario.feasibility import Verdict
    from feasibee.scenario.scenario import Scenario


@command()
def truth(
    *,
    given: Given,
    seed: int,
    run: int,
    step: int = option("Step, if the world changes.", int, 0),
    as_json: bool,
) -> None:
    """Compute whether the tasks are feasible, with a proof.

    If feasible, print an assignment of robots to tasks; if not, the skills that too few robots have. A robot
    serves at most one place of a task. In a world that changes, the truth is that of a step of a run.

    \b
    Examples:
      feasibee truth mine.toml
      feasibee truth --set robots.count=20 --set tasks.count=21 --json
      feasibee truth examples/changing.toml --step 500 --seed 1
    """
    from feasibee.scenario.feasibility import explain
    from feasibee.scenario.runs import Runs

    scenario = given.read()
    Runs.single(seed, run)  # raises an error for wrong numbers, which a world that stays doesn't need
    verdict = explain(scenario)
    if scenario.dynamic or step:
        from feasibee.simulation.swarm import truth_at  # loads the engine

        verdict = truth_at(scenario, step, seed, run)
    if as_json:
        print_json(verdict.to_dict())
    else:
        _print_verdict(verdict, scenario)


@command()
def scenario(
    *,
    given: Given,
    form: str = option(
        "Form: a complete scenario, or an experiment of ARGoS3 for examples/argos.",
        click.Choice(["toml", "argos"]),
        "toml",
        name="--to",
    ),
) -> None:
    """Print a scenario with all its fields, as TOML; comments say what each means, and its unit.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks.

    \b
    Examples:
      feasibee scenario --set robots.count=40 > forty.toml
      feasibee scenario forty.toml --to argos > examples/argos/forty.argos
    """
    read = given.read()
    if form == "argos":
        from feasibee.scenario.argos import argos_text as text_of
    else:
        from feasibee.scenario.comments import commented_toml as text_of
    click.echo(text_of(read), nl=False)


@command()
def new(*, out: Path = argument(file_type, metavar="FILE"), changes: tuple[str, ...]) -> None:
    """Write a scenario to edit: a file with all fields; comments say what each means, and its unit.

    \b
    Examples:
      feasibee new mine.toml
      feasibee new hall.toml --set robots.count=35 --set "arena.side=[60.0, 25.0]"
    """
    from feasibee.files import atomic_write, check_output
    from feasibee.scenario.comments import commented_toml

    if out.exists():
        raise FeasibeeError(f"{out}: exists already; use another name, or remove it")
    check_output(out, (".toml",))
    with atomic_write(out) as path:
        path.write_text(commented_toml(Given(None, changes).read()), encoding="utf-8")
    click.echo(f"Wrote {out}. Edit it, then: feasibee run {out}")


@command()
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors and other tools.

    \b
    Example:
      feasibee schema > scenario.schema.json
    """
    from feasibee.scenario.scenario import Scenario

    print_json(Scenario.model_json_schema())


def _print_verdict(verdict: Verdict, scenario: Scenario) -> None:
    from rich.table import Table

    if verdict.violator is not None:
        skills, demand, robots = verdict.violator
        named = " or ".join(skills)
        asking, able = f"places that ask for {named}", f"robots that can {named}"
        if not scenario.tasks.classes:
            asking, able = "tasks, each for any one robot", "robots"
        click.echo(f"Infeasible: {asking}: {demand}; {able}: {robots}.")
        return
    free = scenario.robots.count - sum(verdict.assignment.values())
    left = "" if scenario.dynamic else f"; robots left over: {free}"
    click.echo(f"Feasible: each place has a robot of its own{left}.")
    table = Table("robots", "tasks", "skill")
    table.add_column("count", justify="right")
    for names, count in verdict.assignment.items():
        table.add_row(*names, str(count))
    if verdict.assignment:
        console(highlight=True).print(table)
