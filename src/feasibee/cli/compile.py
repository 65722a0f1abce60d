"""feasibee compile: compile both engines ahead of other commands."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import click

from feasibee.cli.options import json_option

if TYPE_CHECKING:
    from feasibee.simulation.loading import Prepared


@click.command("compile")
@json_option
def compile_engines(as_json: bool) -> None:
    """Compile the simulation engines and keep them on disk, so that later commands start at once.

    There are two engines: the fast path, for worlds like the paper's, and the general engine, for all others.
    Without this command each compiles when a scenario first needs it, once on a machine.

    \b
    Examples:
      feasibee compile
      FEASIBEE_CACHE=/scratch/feasibee feasibee compile
    """
    from feasibee.engine.compile import cache_folder
    from feasibee.simulation.loading import prepare_engines

    parts = []
    for part in prepare_engines():
        parts.append(part)
        if not as_json:
            click.echo(_line(part))
    if as_json:
        click.echo(
            json.dumps({"cache": str(cache_folder()), "parts": [part._asdict() for part in parts]}, indent=2)
        )
        return
    click.echo(f"The compiled code is in {cache_folder()}")
    if all(part.cached for part in parts):
        click.echo("There was nothing to compile.")


def _line(part: Prepared) -> str:
    state = "loaded from disk" if part.cached else "compiled"
    return f"{part.name}: {state} in {part.seconds:.1f} s"
