"""feasibee reproduce: simulate saved results again, and compare every byte."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.options import (
    NamedPath,
    argument,
    command,
    option,
    path_type,
    print_json,
    progress,
    wrapped,
)

if TYPE_CHECKING:
    from feasibee.studies.reproduce import Reproduction

NAMED = 10
"""Number of runs that a line names."""


@command()
def reproduce(
    *,
    path: Path = argument(path_type, metavar="FILE|FOLDER"),
    figure: tuple[Path, ...] = option(
        "Figure that was written with FILE, repeatable; by default those named as FILE, such as mine.png.",
        NamedPath(exists=True, dir_okay=False, path_type=Path),
        multiple=True,
        metavar="FILE",
    ),
    trust: bool = option("Run a strategy from the text in the results; read it before.", is_flag=True),
    workers: int | None,
    as_json: bool,
) -> None:
    """Simulate saved results again, and compare every byte of all runs and figures with what was saved.

    FILE is one that feasibee run --out has written, .nc. FOLDER is that of a journal, as of feasibee sweep.
    The exit status is 0 if all bytes are the same, 1 if some differ, and 2 after an error.

    \b
    Examples:
      feasibee reproduce mine.nc
      feasibee reproduce mine.nc --figure paper/mine.pdf
      feasibee reproduce results
    """
    from feasibee.studies.reproduce import reproduce as simulate_again

    with progress("Simulating again") as advance:
        found = simulate_again(path, figure, trust=trust, workers=workers, progress=advance)
    if as_json:
        print_json({"same": found.same, **found._asdict()})
    else:
        _print(path, found)
    if not found.same:
        sys.exit(1)


def _print(path: Path, found: Reproduction) -> None:
    """Print versions, then a line per column that differs, then a line per figure."""
    changed = [f"{name} {now} (was {then})" for name, (then, now) in found.versions.items() if now != then]
    written = found.versions.get("feasibee", ("an unknown version",))[0]
    click.echo(
        wrapped(
            f"{path}: {found.runs:,} runs, written by feasibee {written}; now: "
            f"{', '.join(changed) or 'the same versions'}."
        )
    )
    if not found.differing:
        click.echo("All results are the same, byte for byte.")
    for column, runs in found.differing.items():
        named = ", ".join(map(str, runs[:NAMED])) + (", ..." if len(runs) > NAMED else "")
        click.echo(wrapped(f"Different: {column} in {len(runs):,} runs: {named}.", further="  "))
    for figure, same in found.figures.items():
        click.echo(f"{figure}: {'the same, byte for byte' if same else 'differs'}.")
