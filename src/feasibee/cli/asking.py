"""What feasibee new does on a terminal: ask for a scenario, and say how long commands take with it here."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final

import click

from feasibee.cli.options import Given
from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.scenario.paths import read_value
from feasibee.scenario.types import LENGTHS, TIMES
from feasibee.scenario.units import duration

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario


QUESTIONS: Final[Mapping[str, tuple[str, ...]]] = {
    "Metres per unit of length, and seconds per step, for tables and figures.": (
        "units.metres",
        "units.seconds",
    ),
    "Width and height of the arena, in units; one number for a square.": ("arena.side",),
    "Type walls, or torus: who leaves at an edge enters at the opposite one.": ("arena.boundary",),
    "How many robots there are, and how many tasks, each for one robot.": ("robots.count", "tasks.count"),
    "How far robots see, in units, and the share in range that they miss in a step.": (
        "sensing.range",
        "sensing.miss",
    ),
    "How far a message reaches, in units, and the share of messages lost.": ("radio.range", "radio.loss"),
    "How many robots are broken, and how many send false opinions; below 1, a share.": (
        "faults.stopped",
        "faults.byzantine",
    ),
    "Number of steps after which the swarm must have decided.": ("run.steps",),
}
"""What feasibee new asks, and the fields that an answer gives, with spaces between their values."""
EFFORT: Final = {"recommend": 17_000, "assess": 22_000, "size": 40_000, "compare": 58_000}
"""Commands that try all strategies, and how many runs with `USUAL` take as long: measured in two worlds."""
USUAL: Final = "census"
"""A strategy that takes as long as strategies do on average."""
RUNS: Final = 100
"""Runs of feasibee run, unless it says another number."""
ENOUGH: Final = 0.3
"""Seconds of a measurement that is precise enough."""


def on_terminal() -> bool:
    """Return whether a user can be asked."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def ask(changes: tuple[str, ...]) -> Scenario:
    """Ask for a scenario; ``changes`` are answers that were given before, as ``--set`` has them."""
    given = Given(None, changes)
    scenario, answers = given.read(), dict[str, Any]()
    known = {change.partition("=")[0].strip() for change in changes}
    questions = [(about, fields) for about, fields in QUESTIONS.items() if not known & set(fields)]
    click.echo("Enter keeps what is in brackets; Ctrl-C ends without a file.")
    for number, (about, fields) in enumerate(questions, start=1):
        later = {field for _, others in questions[number:] for field in others}
        click.echo(f"\n{number} of {len(questions)}. {about}")
        kept = " ".join(_kept(scenario, field) for field in fields)
        while True:
            try:
                answer = click.prompt(f"{' '.join(fields)} [{kept}]", default="", show_default=False)
                tried = {**answers, **_values(fields, answer)}
                scenario = given.read(tried)
            except click.Abort:
                raise FeasibeeError("the answers end too early; answer all questions, or use --yes") from None
            except ScenarioError as error:
                problems = [each for each in error.problems if each.path not in later]
                if problems:
                    click.echo(str(ScenarioError(problems)))
                    continue
            answers = tried
            break
    return scenario


def _kept(scenario: Scenario, field: str) -> str:
    """Return the value of a field as a user would type it."""
    section, _, key = field.partition(".")
    value = getattr(getattr(scenario, section), key)
    if isinstance(value, Mapping):
        return str(value["count"])
    if isinstance(value, tuple):
        return " ".join(f"{each:g}" for each in value)
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _values(fields: Sequence[str], answer: str) -> dict[str, Any]:
    """Return the fields that an answer gives, from the first on, with their values."""
    words = re.findall(rf"[^\s,\[\]]+(?: (?:{'|'.join(LENGTHS | TIMES)})\b)?", answer)
    values = [None if word == "none" else read_value(word) for word in words]
    if len(fields) == 1 < len(values):
        return {fields[0]: values}
    if len(values) > len(fields):
        raise ScenarioError(
            [Problem(fields[0], answer, f"must be at most {len(fields)} values", "type fewer")]
        )
    found = dict(zip(fields, values, strict=False))
    whole = {field for field in found if field.startswith("faults.") and type(found[field]) is int}
    return {field: {"count": value} if field in whole and value else value for field, value in found.items()}


def durations(scenario: Scenario) -> str:
    """Return how long commands take with a scenario on this machine, in words."""
    usual = own = _seconds_per_run(scenario)
    with suppress(ScenarioError):  # not every world has names of tasks
        usual = _seconds_per_run(scenario.replace({"decision.strategy": USUAL}))
    seconds = {"run": RUNS * own, **{name: runs * usual for name, runs in EFFORT.items()}}
    named = (f"{name} {duration(float(f'{max(1.0, each):.2g}'))}" for name, each in seconds.items())
    return f"On this machine, commands take about: {', '.join(named)}."


def _seconds_per_run(scenario: Scenario) -> float:
    """Measure for about a second: ever more steps, then ever more runs, until the time is long enough."""
    from feasibee.scenario.runs import Runs
    from feasibee.simulation.ensemble import processors, simulate_record

    simulate_record(scenario.replace({"run.steps": 1, "events": ()}), Runs(1))  # loads the engine
    steps, runs = 16, 2 * processors()
    while True:
        steps = min(steps, scenario.run.steps)
        part, start = scenario.replace({"run.steps": steps, "events": ()}), perf_counter()
        simulate_record(part, Runs(runs))
        taken = perf_counter() - start
        if taken > ENOUGH:
            return taken / runs * scenario.run.steps / steps
        steps, runs = (4 * steps, runs) if steps < scenario.run.steps else (steps, 4 * runs)
