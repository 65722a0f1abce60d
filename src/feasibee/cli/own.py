"""feasibee check: what a strategy of one's own needs and takes, and how good it is."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import (
    Workforce,
    argument,
    command,
    count_type,
    file_type,
    option,
    own_strategy,
    print_json,
    print_numbers,
    wrapped,
)
from feasibee.errors import FeasibeeError
from feasibee.strategies.overflow import LEAVES

if TYPE_CHECKING:
    from feasibee.results.statistics import Interval
    from feasibee.studies.check import Check
    from feasibee.studies.comparison import Outcome

IN_WORDS = {"names": "names of tasks", "ids": "ids that are never misread", "count": "the number of robots"}
"""What a strategy may need of robots."""
BOARDS = {"ATmega328P": (32_768, 2_048)}
"""Bytes of flash and RAM that a board has."""


@command()
def check(
    *,
    file: Path = argument(file_type, metavar="FILE"),
    runs: int = option("Number of runs of each strategy at each number of tasks.", count_type, 200),
    seed: int,
    workers: int | None,
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
        with executing("Checking", None, Workforce(workers, False, None)) as execution:
            found = check_strategy(str(file), runs, seed, execution)
    except FeasibeeError as error:
        if LEAVES not in str(error):
            raise
        click.echo(f"feasibee: {error}", err=True)
        sys.exit(1)
    if as_json:
        print_json(found.to_dict(seed))
    else:
        for title, text in _rows(found):
            click.echo(wrapped(f"{text}.", f"{title:10}", " " * 10))
        _print_accuracy(found, runs)
    if not found.agrees:
        sys.exit(1)


def _rows(found: Check) -> Iterator[tuple[str, str]]:
    """Yield titles and texts of the lines on a strategy."""
    yield "Needs", ", ".join(IN_WORDS[each] for each in found.needs) or "nothing that robots may lack"
    yield "Messages", f"{found.bits} bits"
    yield (
        "Memory",
        f"{found.words:,} words known, {found.message_words:,} in a message, {found.memory} floats",
    )
    yield "Engine", _equal(found.engine)
    if found.in_c:
        yield "C", found.in_c
        return
    yield "C", _equal(found.c)
    yield "", "needs FEASIBEE_DOUBLE" if found.needs_double else "needs no FEASIBEE_DOUBLE"
    for processor, size in found.sizes.items():
        if isinstance(size, str):
            yield "", f"{processor}: {size}"
            continue
        flash, ram = (f" of {each:,}" for each in BOARDS[processor]) if processor in BOARDS else ("", "")
        yield "", f"{processor}: {size[0]:,}{flash} bytes of flash, {size[1]:,}{ram} of RAM"


def _equal(agreement: str) -> str:
    from feasibee.studies.check import AGREE, WORLDS

    return (
        f"equal to Python in {WORLDS} random worlds" if agreement == AGREE else f"unlike Python: {agreement}"
    )


def _print_accuracy(found: Check, runs: int) -> None:
    """Print how often swarms with the strategy and with others are right."""
    by_tasks: dict[int, list[Outcome]] = {}
    for each in found.outcomes:
        by_tasks.setdefault(each.tasks, []).append(each)
    rows = [
        [f"{tasks} ({tasks / group[0].robots:.2f})", *(_share(each.accuracy) for each in group)]
        for tasks, group in by_tasks.items()
    ]
    heads = ["tasks (per robot)", *(each.contender for each in next(iter(by_tasks.values())))]
    print_numbers(f"Share of {runs} swarms that are right at the end (%)", heads, rows, narrow=True)


def _share(share: Interval) -> str:
    """Return a share with its 95 % interval, in percent."""
    middle, low, high = (100 * each for each in share)
    return f"{middle:.1f} ({low:.0f} to {high:.0f})"
