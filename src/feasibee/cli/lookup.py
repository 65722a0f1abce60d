"""feasibee show and new: scenarios with all fields, their truth, strategies, presets, the schema."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.base.errors import FeasibeeError
from feasibee.cli.options import (
    GivenScenario,
    argument,
    command,
    console,
    exclude,
    file_type,
    option,
    print_json,
    with_flooding,
)
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.feasibility import Verdict
    from feasibee.scenario.scenario import Scenario


@click.group()
def show() -> None:
    """Look up a scenario's fields and truth, strategies, presets, or the schema of scenarios.

    \b
    Examples:
      feasibee show truth --set tasks.count=50
      feasibee show strategies
    """


@command(make=show.command)
def truth(
    *,
    given: GivenScenario,
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
      feasibee show truth mine.toml
      feasibee show truth --set robots.count=20 --set tasks.count=21 --json
      feasibee show truth examples/changing.toml --step 500 --seed 1
    """
    from feasibee.scenario.feasibility import explain

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


@command(make=show.command)
def scenario(*, given: GivenScenario) -> None:
    """Print a scenario with all its fields, as TOML; comments say what each means, and its unit.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks.

    \b
    Example:
      feasibee show scenario --set robots.count=40 > forty.toml
    """
    from feasibee.scenario.comments import commented_toml

    read, flooding = with_flooding(given.read()), []
    if read.waits_for_names:
        from feasibee.simulation.flooding import flooding_in_words  # loads the engine

        flooding = flooding_in_words(read)
    click.echo(commented_toml(read, *flooding), nl=False)


@command()
def new(
    *,
    file: Path = argument(file_type),
    knowledge: bool = option("For .py: robots pass on what they know, not only opinions."),
    changes: tuple[str, ...],
) -> None:
    """Write a file to edit: a scenario, .toml, or a strategy of your own, .py, that runs as it is.

    A scenario has all fields; comments say what each means, and its unit. A strategy has the functions that
    it needs; comments say what each does.

    \b
    Examples:
      feasibee new mine.toml
      feasibee new hall.toml --set robots.count=35 --set "arena.side=[60.0, 25.0]"
      feasibee new mine.py
      feasibee new mine.py --knowledge
    """
    from feasibee.base.files import check_output, write_text
    from feasibee.scenario.comments import commented_toml
    from feasibee.scenario.shown import render

    if file.exists():
        raise FeasibeeError(f"{file}: exists already; use another name, or remove it")
    if check_output(file, (".toml", ".py")) == ".py":
        exclude(str(file), "a strategy has no fields of a scenario", "changes")
        made, then = render("strategy.txt", file=file.name, knowledge=knowledge), "check"
    else:
        exclude(str(file), "only a strategy has it", "knowledge")
        made, then = commented_toml(GivenScenario(None, changes).read()), "run"
    write_text(file, made)
    click.echo(f"Wrote {file}. Edit it, then: feasibee {then} {file}")


@command(make=show.command)
def schema() -> None:
    """Print the JSON Schema of scenario files, for editors and other tools.

    \b
    Example:
      feasibee show schema > scenario.schema.json
    """
    from feasibee.scenario.scenario import Scenario

    print_json(Scenario.model_json_schema())


def _print_verdict(verdict: Verdict, scenario: Scenario) -> None:
    from rich.table import Table

    from feasibee.scenario.feasibility import who_counts

    if who := who_counts(scenario):
        click.echo(who)
    if verdict.violator is not None:
        skills, demand, robots = verdict.violator
        named = " or ".join(skills)
        asking, able = f"places that ask for {named}", f"robots that can {named}"
        if not scenario.tasks.classes:
            asking, able = "tasks, each for any one robot", "robots"
        where, of = (f" {verdict.where}", f" of {scenario.robots.count}") if verdict.where else ("", "")
        click.echo(f"Infeasible{where}: {asking}: {demand}; {able}: {robots}{of}.")
        return
    free = scenario.robots.count - sum(verdict.assignment.values())
    left = "" if scenario.dynamic else f"; robots left over: {free}"
    click.echo(f"Feasible: each task can have its own robots{left}.")
    rows = verdict.rows
    table = Table(*(key for key in (rows[0] if rows else ()) if key != "count"))
    table.add_column("count", justify="right")
    pieces = {each.number: each for each in verdict.pieces}
    for row in rows:
        if pieces:
            row["piece"] = pieces[row["piece"]]
        table.add_row(*map(str, row.values()))
    if rows:
        console(highlight=True).print(table)


@command(make=show.command)
def strategies(given: GivenScenario, as_json: bool) -> None:
    """List the strategies: what each needs, the length of its messages in bits, and its rule.

    Needs: names (robots recognise tasks), ids (robots' ids are never misread), n (robots know their number).
    A strategy that declares says when it is sure. Bits are those of a message in the scenario, by default the
    paper's: at first, and once its robot has seen and heard all; - if the scenario doesn't support it.

    \b
    Examples:
      feasibee show strategies
      feasibee show strategies mine.toml --json
    """
    from feasibee.studies.needs import all_strategies

    base = given.read()
    rows = [_strategy(base, name) for name in all_strategies(base)]
    _print_rows(rows, ("strategy", "needs", "declares", "bits", "rule"), as_json)
    if not as_json:
        click.echo("\nExamples of strategies of your own: examples/strategies/ of the repository.")


@command(make=show.command)
def presets(as_json: bool) -> None:
    """List the presets: the length of a message in bits, the steps of a run, and whose controller it is.

    Bits are those of 20 robots with the strategy dmmd. The complete scenario with the values of a preset:
    feasibee show scenario --set preset=NAME

    \b
    Examples:
      feasibee show presets
      feasibee show presets --json
    """
    from feasibee.scenario.messages import message_bits
    from feasibee.scenario.scenario import Scenario
    from feasibee.scenario.tables import ABOUT, PRESETS

    rows: list[dict[str, Any]] = [
        {
            "preset": name,
            "needs": [],
            "bits": message_bits(Scenario(preset=name)).full,
            "steps": Scenario(preset=name).run.steps,
            "about": ABOUT[name],
            "values": values,
        }
        for name, values in PRESETS.items()
    ]
    _print_rows(rows, ("preset", "needs", "bits", "steps", "about"), as_json)


def _strategy(scenario: Scenario, name: str) -> dict[str, Any]:
    """Return what a line says of a strategy; without bits if the scenario doesn't support it."""
    from feasibee.base.errors import ScenarioError
    from feasibee.scenario.messages import message_bits
    from feasibee.scenario.plugins import manifest_of, rule_of
    from feasibee.studies.needs import strategy_change

    manifest, own = manifest_of(name), scenario.decision.strategy
    changes = strategy_change(scenario, name)
    if manifest.declares:
        changes["decision.declare"] = None
    if manifest.needs_count:
        changes["robots.know_count"] = True
    try:
        bits: list[int] | None = list(message_bits(scenario.replace(changes)))
    except ScenarioError:
        bits = None
    needs = manifest.needs(scenario.decision.parameters if name == own else manifest.parameters)
    return {
        "strategy": name,
        "needs": ["n" if need == "count" else need for need in needs],
        "one_class": manifest.one_class,
        "declares": manifest.declares,
        "bits": bits,
        "rule": rule_of(manifest),
    }


def _print_rows(rows: Sequence[dict[str, Any]], columns: Sequence[str], as_json: bool) -> None:
    """Print rows as JSON, or some of their columns, a line each.

    On a terminal, leave out the last words that it has no room for.
    """
    if as_json:
        print_json(rows)
        return
    heads = ["whose controller" if name == "about" else name for name in columns]
    lines = [heads, *([_cell(row[name]) for name in columns] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)][:-1]
    width = console().width
    for line in lines:
        start = "  ".join(f"{cell:{size}}" for cell, size in zip(line, widths, strict=False))
        text = line[-1]
        if sys.stdout.isatty():
            text = textwrap.shorten(text, max(8, width - len(start) - 2), placeholder=" …")
        click.echo(f"{start}  {text}".rstrip())


def _cell(value: Any) -> str:
    """Return a value as text: names, two numbers or one, yes; a dash for none of these."""
    if isinstance(value, list) and value and isinstance(value[0], int):
        return " to ".join(map(str, dict.fromkeys(value)))
    return (
        ", ".join(value)
        if value and isinstance(value, list)
        else "yes"
        if value is True
        else str(value or "-")
    )
