"""feasibee benchmark: a strategy's card in all worlds of the suite, and the board."""

from __future__ import annotations

import secrets
import shlex
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import executing, leave_if_stopped
from feasibee.cli.options import (
    Workforce,
    argument,
    command,
    complete_strategy,
    folder_option,
    option,
    own_strategy,
    print_json,
    print_numbers,
    wrapped,
)
from feasibee.files import make_folder
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.studies.benchmark import Card
    from feasibee.studies.board import Standing


@command()
def benchmark(
    *,
    strategies: tuple[str, ...] = argument(
        str, nargs=-1, metavar="[STRATEGY]...", shell_complete=complete_strategy
    ),
    runs: int = option(
        "Number of runs of each side of a world; large swarms take fewer.", click.IntRange(1, 100_000), 200
    ),
    seed: int | None = option(
        "Seed of the random numbers, 0 to 2**64 - 1; by default drawn, so that no strategy is fitted to it.",
        int,
    ),
    budget: float | None,
    workforce: Workforce,
    out: Path = folder_option("benchmark", "the card, the page"),
    as_json: bool,
) -> None:
    """Compare strategies on a board: decisions, declarations, steps, bits and memory in 32 frozen worlds.

    STRATEGY is the path of a .py file, or a name; without any, all built-in ones. They rank among those whose
    robots are given the same. The card, benchmark.json, has their texts and the seed, for feasibee reproduce.

    \b
    Examples:
      feasibee benchmark mine.py --budget 5min
      feasibee benchmark mine.py theirs.py dmmd --runs 1000
      feasibee reproduce benchmark/benchmark.json --trust
    """
    from feasibee.results.statistics import plain
    from feasibee.studies.benchmark import benchmark as simulate_all
    from feasibee.studies.benchmark import board
    from feasibee.studies.board import standings, write_board
    from feasibee.sweeps.sweep import Rounds

    seed = secrets.randbits(64) if seed is None else seed
    Runs.of_point(0, runs, seed)  # raises before the folder is made
    for name in strategies:
        own_strategy(name)
    folder = make_folder(out)
    with (
        executing("Benchmarking", folder, workforce, budget=budget, answers=True) as execution,
        Rounds(execution, most=None) as rounds,
    ):
        card = simulate_all(strategies, runs, seed, rounds)
    card.write(folder / "benchmark.json")
    shown = card.joined(board()) if strategies else card
    names = tuple(card.contenders) if strategies else ()
    write_board(folder / "benchmark.html", shown, names, shlex.join(["feasibee", "benchmark", *strategies]))
    classes = standings(shown)
    if as_json:
        print_json(plain({given: tuple(group) for given, group in classes.items()}))
    else:
        _print_board(classes, card, names, folder)
    if card.runs < runs:
        short = f"{card.runs:,} instead of {runs:,} runs of each side; to go on, add --seed {seed}"
        click.echo(f"feasibee: {rounds.stopped}: {short}", err=True)
    leave_if_stopped(rounds.stopped)


def _print_board(
    classes: Mapping[str, Sequence[Standing]], card: Card, names: Collection[str], folder: Path
) -> None:
    """Print the classes of the contenders of a card, and how some of them rank."""
    from feasibee.studies.board import CAPTION, HEADS, IN_A_TERMINAL, in_words

    for given, group in classes.items():
        if any(each.contender in card.contenders for each in group):
            rows = [[each.contender, *each.cells[:IN_A_TERMINAL]] for each in group]
            print_numbers(f"Given {given}", ["", *HEADS[:IN_A_TERMINAL]], rows, narrow=True)
    for sentence in (f"{CAPTION}.", *in_words(classes, names)):
        click.echo(wrapped(sentence))
    click.echo(f"The page is {folder}/benchmark.html, the card {folder}/benchmark.json")
