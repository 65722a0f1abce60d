"""feasibee page: one HTML file that simulates."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import click

from feasibee.cli.options import path_type, read_scenario, run_option, scenario_options, seed_option


@click.command()
@scenario_options
@seed_option
@run_option
@click.option(
    "--out", type=path_type, default="run.html", show_default=True, help="HTML file to write; about 100 KB."
)
@click.option("--open", "opens", is_flag=True, help="Open the file in the browser.")
def page(file: Path | None, changes: tuple[str, ...], seed: int, run: int, out: Path, opens: bool) -> None:
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
    scenario = read_scenario(file, changes)
    write_page(scenario, out, seed, run, name=file.name if file else "")
    click.echo(f"Wrote {out}")
    if opens:
        webbrowser.open(out.resolve().as_uri())
