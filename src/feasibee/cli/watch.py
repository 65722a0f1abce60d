"""feasibee watch: show swarms live in the browser."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.options import Given, argument, command, option, path_type, with_flooding
from feasibee.errors import FeasibeeError
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.live.catalogue import Catalogue
    from feasibee.live.fieldsession import FieldCatalogue

PICKS = ("wrong", "right", "undecided", "feasible", "infeasible", "all")


@command()
def watch(
    *,
    source: Path | None = argument(path_type, metavar="[FILE|FOLDER]", required=False),
    changes: tuple[str, ...],
    seed: int | None = option("Seed, 0 to 2**64 - 1; by default 0, or that of the sweep.", int),
    run: int | None = option("Number of the run; by default 0, or the first that --pick selects.", int),
    pick: str = option("Runs of a sweep to list, by their decision.", click.Choice(PICKS), "wrong"),
    trust: bool = option(
        "Run strategies from the text in the sweep's journal; read it before.", is_flag=True
    ),
    host: str = option(
        "Address or name to listen on; 0.0.0.0 is reachable from other machines.", default="127.0.0.1"
    ),
    port: int | None = option("Port; by default the first free one from 8765.", click.IntRange(0, 65535)),
    no_open: bool = option("Print the address without opening a browser.", is_flag=True),
) -> None:
    """Watch a swarm in the browser, step by step, and change it on the page.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks. FOLDER is the output
    of feasibee sweep: the page lists the runs that --pick selects, and replays them. FOLDER may also be the
    output of feasibee launch: the page shows its processes, while they run and later.

    \b
    Examples:
      feasibee watch
      feasibee watch mine.toml --set robots.count=30 --seed 7 --run 417
      feasibee watch examples/changing.toml
      feasibee watch results --pick wrong
      feasibee watch logs
    """
    catalogue = _catalogue(source, changes, seed, run, pick, trust)
    from feasibee.live import server
    from feasibee.live.guard import is_loopback

    with server.listen(host, port) as listening:
        address = server.address_of(host, listening.getsockname()[1])
        click.echo(f"The arena is at {address}\nCtrl-C stops it.")
        if not is_loopback(host):
            click.echo(
                "feasibee: anyone who can reach this machine can watch, and use its processor", err=True
            )
        if not no_open:
            server.open_browser(address)
        with suppress(KeyboardInterrupt):  # Ctrl-C stops the server
            server.server_of(catalogue, host).run(sockets=[listening])


def _catalogue(
    source: Path | None,
    changes: tuple[str, ...],
    seed: int | None,
    run: int | None,
    pick: str,
    trust: bool,
) -> Catalogue | FieldCatalogue:
    """Return the catalogue of a scenario, or of the folder of a sweep or field."""
    from feasibee.field.recording import LOG
    from feasibee.live.catalogue import Catalogue, read_catalogue
    from feasibee.live.fieldsession import FieldCatalogue
    from feasibee.scenario.plugins import digest_of, is_own

    if source is not None and not source.exists():
        raise FeasibeeError(
            f"{source}: not found; name a scenario in TOML, or the folder of a sweep or field"
        )
    if source is not None and source.is_dir():
        if changes or (seed, run) != (None, None):
            raise FeasibeeError(f"{source}: what has run can't change; leave out --set, --seed and --run")
        if (source / LOG).exists():
            return FieldCatalogue(source)
        catalogue = read_catalogue(source, pick, trust)
        for manifest in {row.scenario.manifest: None for row in catalogue.points.values()}:
            if not is_own(manifest):  # what the journal kept of a strategy isn't the user's own file
                what = "runs from the text in the journal" if trust else "isn't replayed without --trust"
                click.echo(f"feasibee: {manifest.name}, SHA-256 {digest_of(manifest)}: {what}", err=True)
        return catalogue
    one = Runs.single(seed or 0, run or 0)
    scenario = with_flooding(Given(source, changes).read())
    return Catalogue(scenario, one.seed, one.first, source.name if source else "")
