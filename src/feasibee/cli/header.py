"""feasibee header: the controller in C."""

from __future__ import annotations

import click

from feasibee.cli.options import command, option


@command()
def header(
    *,
    strategies: tuple[str, ...] = option(
        "Include this strategy, repeatable; by default all that exist in C.",
        name="--strategy",
        multiple=True,
        metavar="NAME",
    ),
    inbox: int | None = option("Number of senders whose message a robot keeps; by default 64.", int),
) -> None:
    """Print the controller of one robot in C99, as one header file.

    The comments in the file say how to use it.

    \b
    Examples:
      feasibee header > feasibee.h
      feasibee header --strategy dmmd --inbox 32 > feasibee.h
      feasibee header --strategy dmmd --strategy average > feasibee.h
    """
    from feasibee.robot.firmware import header

    click.echo(header(strategies or None, inbox), nl=False)
