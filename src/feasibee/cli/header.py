"""feasibee header: the controller in C."""

from __future__ import annotations

import click


@click.command()
@click.option(
    "--strategy",
    "strategies",
    multiple=True,
    metavar="NAME",
    help="Include this strategy, repeatable; by default all that exist in C.",
)
@click.option("--inbox", type=int, help="Number of senders whose message a robot keeps; by default 64.")
def header(strategies: tuple[str, ...], inbox: int | None) -> None:
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
