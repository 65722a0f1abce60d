"""feasibee page: one HTML file that simulates."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import click

from feasibee.cli.options import Given, command, option, path_type


@command()
def page(
    *,
    given: Given,
    seed: int,
    run: int,
    out: Path = option("HTML file to write; about 100 KB.", path_type, "run.html"),
    opens: bool = option("Open the file in the browser.", name="--open", is_flag=True),
) -> None:
    """Write one HTML file that simulates swarms, without server or network.

    FILE is a scenario in TOML; without one, the paper's defaults. The page begins with its values, and has
    sliders for robots, tasks, strategy, seed and run. Its opinions are those of `feasibee run` at every step.
    It simulates the paper's world with up to 200 robots and 400 tasks.

    \b
    Examples:
      feasibee page --set tasks.count=50 --seed 1 --out fifty.html
      feasibee page mine.toml --open
    """
    from feasibee.files import check_output
    from feasibee.live.page import write_page

    check_output(out, (".html",), "--out")
    write_page(given.read(), out, seed, run, name=given.file.name if given.file else "")
    click.echo(f"Wrote {out}")
    if opens:
        webbrowser.open(out.resolve().as_uri())
