"""feasibee compile: compile the engines ahead of other commands."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.options import argument, command, file_type, folder_type, option, print_json

if TYPE_CHECKING:
    from feasibee.simulation.loading import Prepared


@command("compile")
def compile_engines(
    *,
    files: tuple[Path, ...] = argument(file_type, nargs=-1, metavar="[FILE]..."),
    out: Path | None = option(
        "Write the compiled code to this folder, too. FEASIBEE_CACHE=FOLDER uses it, or a copy of it.",
        folder_type,
        metavar="FOLDER",
    ),
    as_json: bool,
) -> None:
    """Compile the simulation engines and keep them on disk, so that later commands start at once.

    FILE is a scenario, or a strategy if it ends in .py: only what these need is compiled. Without it, both
    engines and all built-in strategies are: the fast path, for worlds like the paper's, and the general
    engine, for all others. Each compiles by itself when a scenario first needs it, once on a machine.

    The code runs on processors of the kind that it was compiled on. For a container image or a cluster, write
    it to a folder; see the documentation's page on installing.

    \b
    Examples:
      feasibee compile
      feasibee compile mine.toml my_strategy.py
      feasibee compile --out /opt/feasibee
      FEASIBEE_CACHE=/opt/feasibee feasibee run
    """
    from feasibee.engine.compile import READABLE_FOLDER, cache_folder, export, processor
    from feasibee.files.cache import own_folder
    from feasibee.simulation.loading import prepare_engines

    if out:
        own_folder(out, READABLE_FOLDER, setting="--out")  # before anything is compiled
    parts = []
    for part in prepare_engines(files):
        parts.append(part)
        if not as_json:
            click.echo(_line(part))
    folder = export(out) if out else cache_folder()
    if as_json:
        answer = {"cache": str(cache_folder()), "out": out and str(folder), "processor": processor()}
        print_json({**answer, "parts": [part._asdict() for part in parts]})
        return
    click.echo(f"The compiled code is in {folder}")
    if out:
        click.echo(f"It runs on processors of the kind {processor()}. To use it: FEASIBEE_CACHE={out}")
    elif all(part.cached for part in parts):
        click.echo("There was nothing to compile.")


def _line(part: Prepared) -> str:
    state = "loaded from disk" if part.cached else "compiled"
    return f"{part.name}: {state} in {part.seconds:.1f} s"
