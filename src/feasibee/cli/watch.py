"""feasibee watch: show swarms live in the browser."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import named
from feasibee.cli.options import (
    GivenScenario,
    argument,
    command,
    exclude,
    only,
    option,
    path_type,
    with_flooding,
)
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.live.serve import Routes

PICKS = ("wrong", "right", "undecided", "feasible", "infeasible", "all")


@command()
def watch(
    *,
    source: Path | None = argument(path_type, metavar="[FILE|FOLDER]", required=False),
    changes: tuple[str, ...],
    seed: int | None = option("Seed, 0 to 2**64 - 1; by default 0, or that of the sweep.", int),
    run: int | None = option("Number of the run; by default 0, or the first that --pick selects.", int),
    pick: str = option("Runs of a sweep to list, by their decision.", click.Choice(PICKS), "wrong"),
    trust: bool,
    lesson: bool = option("Teach by questions: predict what swarms decide, then watch them."),
    out: Path | None = option("With --lesson: write it as one .html file, to send.", path_type),
    host: str = option(
        "Address or name to listen on; 0.0.0.0 is reachable from other machines.", default="127.0.0.1"
    ),
    port: int | None = option("Port; by default the first free one from 8765.", click.IntRange(0, 65535)),
    no_open: bool = option("Print the address without opening a browser."),
) -> None:
    """Watch a swarm in the browser, step by step, and change it on the page.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks. FOLDER is the output
    of feasibee sweep: the page lists the runs that --pick selects, and replays them. FOLDER may also be the
    output of feasibee robot launch: the page shows its processes, while they run and later.

    \b
    Examples:
      feasibee watch
      feasibee watch mine.toml --set robots.count=30 --seed 7 --run 417
      feasibee watch examples/changing.toml
      feasibee watch results --pick wrong
      feasibee watch logs
      feasibee watch --lesson
    """
    from feasibee.live import serve
    from feasibee.live.guard import is_loopback

    if lesson:
        only("--lesson", "it has its own swarms", "lesson", "out", "host", "port", "no_open")
    elif out is not None:
        raise FeasibeeError(f"--out {named(out)}: is for --lesson; for a scenario, use feasibee run --out")
    if source is not None and source.is_dir():
        exclude(str(source), "what has run can't change", "changes", "seed", "run")
    routes = _lesson(out) if lesson else _routes(source, changes, seed, run, pick, trust)
    if out is not None:
        return
    with serve.listen(host, port) as listening:
        address = serve.address_of(host, listening.getsockname()[1])
        click.echo(f"The arena is at {address}\nCtrl-C stops it.")
        if not is_loopback(host):
            click.echo(
                "feasibee: anyone who can reach this machine can watch, and use its processor", err=True
            )
        if not no_open:
            serve.open_browser(address)
        with suppress(KeyboardInterrupt):  # Ctrl-C stops the server
            serve.Server(routes, host, listening).serve_forever()


def _lesson(out: Path | None) -> Routes:
    """Return what the server answers of the lesson; write it, if a file is named."""
    from feasibee.base.files import check_output, write_text
    from feasibee.live.lesson import lesson

    page = lesson()
    if out is not None:
        check_output(out, (".html",), "--out")
        write_text(out, page)
        click.echo(f"Wrote {out}")
    return {("GET", "/"): lambda _: page}


def _routes(
    source: Path | None,
    changes: tuple[str, ...],
    seed: int | None,
    run: int | None,
    pick: str,
    trust: bool,
) -> Routes:
    """Return what the server answers of a scenario, or of the folder of a sweep or field."""
    from feasibee.field.recording import LOG
    from feasibee.live.catalogue import Catalogue, read_catalogue
    from feasibee.live.field import routes_of_field
    from feasibee.live.serve import routes_of
    from feasibee.scenario.plugins import digest_of, is_own

    if source is not None and not source.exists():
        raise FeasibeeError(
            f"{source}: not found; name a scenario in TOML, or the folder of a sweep or field"
        )
    if source is not None and source.is_dir():
        if (source / LOG).exists():
            return routes_of_field(source)
        catalogue = read_catalogue(source, pick, trust)
        for manifest in {row.scenario.manifest: None for row in catalogue.points.values()}:
            if not is_own(manifest):  # what the folder kept of a strategy isn't the user's own file
                what = "runs from the text in the folder" if trust else "isn't replayed without --trust"
                click.echo(f"feasibee: {manifest.name}, SHA-256 {digest_of(manifest)}: {what}", err=True)
        return routes_of(catalogue)
    one = Runs.single(seed or 0, run or 0)
    scenario = with_flooding(GivenScenario(source, changes).read())
    return routes_of(Catalogue(scenario, one.seed, one.first, source.name if source else ""))
