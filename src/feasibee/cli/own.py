"""feasibee check, benchmark: what strategies of one's own need and take, and how good they are."""

from __future__ import annotations

import secrets
import shlex
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import make_folder
from feasibee.cli.execution import executing, leave_if_stopped
from feasibee.cli.options import (
    Workforce,
    argument,
    command,
    complete_strategy,
    count_type,
    file_type,
    folder_option,
    in_brackets,
    option,
    own_strategy,
    print_json,
    print_lines,
    print_numbers,
    wrapped,
)
from feasibee.scenario.runs import Runs
from feasibee.strategies.overflow import LEAVES

if TYPE_CHECKING:
    from feasibee.studies.benchmark import Card, Standing
    from feasibee.studies.check import Check
    from feasibee.studies.comparison import Outcome

BOARDS = {"ATmega328P": (32_768, 2_048)}
"""Bytes of flash and RAM that a board has."""


@command()
def check(
    *,
    file: Path = argument(file_type, metavar="FILE"),
    runs: int = option("Number of runs of each strategy at each number of tasks.", count_type, 200),
    seed: int,
    workers: int | None,
    details: bool = option("Also print messages, memory, and bytes in flash and RAM."),
    as_json: bool,
) -> None:
    """Check a strategy of your own: what it needs, whether C agrees with Python, how often it is right.

    FILE is a strategy, .py. Its needs, messages and sizes are those in the paper's world of 20 robots and 20
    tasks. The compiled engine, the reference in Python and the translation to C are compared in random
    worlds, in each step. It is compared with dmmd and census at six numbers of tasks. The exit status is 1 if
    they differ, or if a whole number leaves 64 bits.

    \b
    Examples:
      feasibee check mine.py
      feasibee check mine.py --runs 1000 --seed 1
    """
    from feasibee.studies.check import check as check_strategy

    try:
        if own_strategy(str(file)).source == "":
            raise FeasibeeError(f"{file}: is built in; name a file of your own, such as mine.py")
        with executing("Checking", None, Workforce(workers, None)) as execution:
            found = check_strategy(str(file), runs, seed, execution)
    except FeasibeeError as error:
        if LEAVES not in str(error):
            raise
        click.echo(f"feasibee: {error}", err=True)
        sys.exit(1)
    if as_json:
        print_json(found.to_dict(seed))
    else:
        print_lines(_answer(found))
        _print_accuracy(found, runs)
        for title, text in _rows(found) if details else ():
            click.echo(wrapped(f"{text}.", f"{title:10}", " " * 10))
    if not found.agrees:
        sys.exit(1)


def _answer(found: Check) -> Iterator[str]:
    """Yield whether all backends agree, how often swarms are right, and what the strategy needs."""
    from feasibee.results.statistics import OF_THE_RUNS, in_percent
    from feasibee.studies.check import AGREE, WORLDS
    from feasibee.studies.comparison import by_contender, overall
    from feasibee.studies.needs import IN_WORDS

    parts = {"the engine": found.engine, "C": found.in_c or found.c}
    unlike = [f"{name}: {problem}" for name, problem in parts.items() if problem != AGREE]
    agree = f"The engine, Python and C agree, in {WORLDS} random worlds."
    yield agree if not unlike else f"Not all of the engine, Python and C agree. {'; '.join(unlike)}."
    own, *others = by_contender(found.outcomes).items()
    rest = " and ".join(f"{name} in {in_percent(overall(group))}" for name, group in others)
    yield f"{own[0]} is right in {in_percent(overall(own[1]), OF_THE_RUNS)}, {rest}."
    needs = ", ".join(IN_WORDS[each] for each in found.needs) or "nothing that robots may lack"
    yield f"It needs {needs}; a message has {found.bits} bits."


def _rows(found: Check) -> Iterator[tuple[str, str]]:
    """Yield titles and texts of the lines on a strategy."""
    words = f"{found.words:,} words known, {found.message_words:,} in a message"
    yield "Memory", f"{words}, {found.memory} floats"
    yield "Engine", _equal(found.engine)
    if found.in_c:
        yield "C", found.in_c
        return
    yield "C", _equal(found.c)
    yield "", "needs FEASIBEE_DOUBLE" if found.needs_double else "needs no FEASIBEE_DOUBLE"
    for processor, size in found.sizes.items():
        flash, ram = (f" of {each:,}" for each in BOARDS[processor]) if processor in BOARDS else ("", "")
        why = size if isinstance(size, str) else ""
        yield "", f"{processor}: {why or f'{size[0]:,}{flash} bytes of flash, {size[1]:,}{ram} of RAM'}"


def _equal(agreement: str) -> str:
    from feasibee.studies.check import AGREE, WORLDS

    same = f"equal to Python in {WORLDS} random worlds"
    return same if agreement == AGREE else f"unlike Python: {agreement}"


def _print_accuracy(found: Check, runs: int) -> None:
    """Print how often swarms with the strategy and with others are right."""
    by_tasks: dict[int, list[Outcome]] = {}
    for each in found.outcomes:
        by_tasks.setdefault(each.tasks, []).append(each)
    rows = [
        [f"{tasks} ({tasks / group[0].robots:.2f})", *(in_brackets(each.accuracy) for each in group)]
        for tasks, group in by_tasks.items()
    ]
    heads = ["tasks (per robot)", *(each.contender for each in next(iter(by_tasks.values())))]
    print_numbers(f"Share of {runs} swarms that are right at the end (%)", heads, rows, narrow=True)


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
    details: bool = option("Also print where it is behind, and what the columns are."),
    as_json: bool,
) -> None:
    """Compare strategies on a board: decisions, declarations, steps, bits and memory in 32 frozen worlds.

    STRATEGY is the path of a .py file, or a name; without any, all built-in ones. They rank among those whose
    robots are given the same. The card, benchmark.json, has their texts and the seed: feasibee run --again.

    \b
    Examples:
      feasibee benchmark mine.py --budget 5min
      feasibee benchmark mine.py theirs.py dmmd --runs 1000
      feasibee run --again benchmark/benchmark.json --trust
    """
    from feasibee.results.statistics import plain
    from feasibee.simulation.sweep import Rounds
    from feasibee.studies.benchmark import benchmark as simulate_all
    from feasibee.studies.benchmark import board, standings, write_board

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
        _print_board(classes, card, names, details, folder)
    if card.runs < runs:
        short = f"{card.runs:,} instead of {runs:,} runs of each side; to go on, add --seed {seed}"
        click.echo(f"feasibee: {rounds.stopped}: {short}", err=True)
    leave_if_stopped(rounds.stopped)


def _print_board(
    classes: Mapping[str, Sequence[Standing]],
    card: Card,
    names: Collection[str],
    details: bool,
    folder: Path,
) -> None:
    """Print how contenders of a card rank, and a table of their classes."""
    from feasibee.studies.benchmark import CAPTION, HEADS, IN_A_TERMINAL, behind, in_words

    print_lines(in_words(classes, names))
    rows: list[list[str]] = []
    for group in classes.values():
        given = next(
            (card.contenders[each.contender].given for each in group if each.contender in card.contenders),
            None,
        )
        if given is not None:
            rows.append([f"given {', '.join(given) or 'nothing'}:", *[""] * IN_A_TERMINAL])
            rows += [[f" {each.contender}", *each.cells[:IN_A_TERMINAL]] for each in group]
    print_numbers("", ["", *HEADS[:IN_A_TERMINAL]], rows, narrow=True)
    print_lines([*behind(classes, names), f"{CAPTION}."] if details else [])
    click.echo(f"The page is {folder}/benchmark.html, the card {folder}/benchmark.json")
