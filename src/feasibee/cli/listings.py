"""feasibee strategies, feasibee presets: what there is to choose from, a line each."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.options import Given, command, console, print_json

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.strategies.contract import Manifest


@command()
def strategies(given: Given, as_json: bool) -> None:
    """List the strategies: what each needs, the length of its messages in bits, and its rule.

    Needs: names (robots recognise tasks), ids (robots' ids are never mistaken), n (robots know their number).
    A strategy that declares says when it is sure. Bits are those of a message in the scenario, by default the
    paper's: at first, and once its robot has seen and heard all; - if the scenario doesn't support it.

    \b
    Examples:
      feasibee strategies
      feasibee strategies mine.toml --json
    """
    from feasibee.studies.needs import all_strategies

    base = given.read()
    rows = [_strategy(base, name) for name in all_strategies(base)]
    if as_json:
        print_json(rows)
        return
    cells = [
        [
            row["strategy"],
            ", ".join(row["needs"]) or "-",
            "yes" if row["declares"] else "-",
            "-" if row["bits"] is None else _span(row["bits"]),
            row["rule"],
        ]
        for row in rows
    ]
    _print_lines([["strategy", "needs", "declares", "bits", "rule"], *cells])


@command()
def presets(as_json: bool) -> None:
    """List the presets: the length of a message in bits, the steps of a run, and whose controller it is.

    Bits are those of 20 robots with the strategy dmmd. The complete scenario with the values of a preset:
    feasibee scenario --set preset=NAME

    \b
    Examples:
      feasibee presets
      feasibee presets --json
    """
    from feasibee.scenario.messages import message_bits
    from feasibee.scenario.scenario import Scenario
    from feasibee.scenario.tables import ABOUT, PRESETS

    rows: list[dict[str, Any]] = []
    for name in PRESETS:
        scenario = Scenario(preset=name)
        bits = message_bits(scenario).full
        rows.append(
            {
                "preset": name,
                "needs": [],
                "bits": bits,
                "steps": scenario.run.steps,
                "about": ABOUT[name],
                "values": PRESETS[name],
            }
        )
    if as_json:
        print_json(rows)
        return
    cells = [[row["preset"], "-", str(row["bits"]), str(row["steps"]), row["about"]] for row in rows]
    _print_lines([["preset", "needs", "bits", "steps", "whose controller"], *cells])


def _strategy(scenario: Scenario, name: str) -> dict[str, Any]:
    """Return what a line says of a strategy; without bits if the scenario doesn't support it."""
    from feasibee.errors import ScenarioError
    from feasibee.scenario.messages import message_bits
    from feasibee.scenario.plugins import manifest_of
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
        "rule": _rule(manifest),
    }


def _rule(manifest: Manifest) -> str:
    """Return the first line of a strategy's file, without its name."""
    import ast
    from importlib import import_module

    if manifest.source:
        text = ast.get_docstring(ast.parse(manifest.source)) or ""
    else:
        text = import_module(f"feasibee.strategies.{manifest.name.replace('-', '_')}").__doc__ or ""
    line = text.partition("\n")[0]
    name, _, rule = line.partition(": ")
    return line if "," in name or not rule else rule


def _span(bits: Sequence[int]) -> str:
    first, full = bits
    return str(first) if first == full else f"{first} to {full}"


def _print_lines(rows: Sequence[Sequence[str]]) -> None:
    """Print rows in columns, a line each; on a terminal, leave out the last words that it has no room for."""
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]) - 1)]
    width = console().width
    for row in rows:
        start = "  ".join(f"{cell:{size}}" for cell, size in zip(row, widths, strict=False))
        text = row[-1]
        if sys.stdout.isatty():
            text = textwrap.shorten(text, max(8, width - len(start) - 2), placeholder=" …")
        click.echo(f"{start}  {text}".rstrip())
