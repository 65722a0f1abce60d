"""feasibee assess: what to expect of a swarm before it is deployed."""

from __future__ import annotations

import json
from pathlib import Path
from shutil import get_terminal_size

import click

from feasibee.cli.options import (
    file_type,
    json_option,
    keep_matplotlib_in_cache,
    progress,
    read_scenario,
    scenario_options,
    seed_option,
    threads_option,
)


@click.command()
@scenario_options
@click.option("--robots", type=int, help="Short for --set robots.count=...")
@click.option("--tasks", type=int, help="Short for --set tasks.count=...")
@click.option("--arena", type=float, help="Side of the arena, in units: short for --set arena.side=...")
@click.option("--range", "reach", type=float, help="Short for --set sensing.range=...")
@click.option("--steps", type=int, help="Short for --set run.steps=...")
@click.option("--runs", type=click.IntRange(1), default=400, show_default=True, help="Swarms of each kind.")
@seed_option
@threads_option
@click.option("--report", type=file_type, metavar="FILE.html", help="Write a page.")
@json_option
def assess(
    file: Path | None,
    changes: tuple[str, ...],
    robots: int | None,
    tasks: int | None,
    arena: float | None,
    reach: float | None,
    steps: int | None,
    runs: int,
    seed: int,
    threads: int | None,
    report: Path | None,
    as_json: bool,
) -> None:
    """Say in plain words whether a swarm would decide rightly, how soon, what limits it, what would help.

    FILE is a scenario in TOML; without one, the paper's defaults. Changes and other strategies are run on the
    same worlds, so that differences are not chance.

    \b
    Examples:
      feasibee assess mine.toml --report mine.html
      feasibee assess --robots 40 --tasks 30 --arena 50 --range 4
    """
    keep_matplotlib_in_cache()
    from feasibee.files import check_output
    from feasibee.studies.assess import assess as simulate_all
    from feasibee.studies.assessment import words
    from feasibee.studies.report import write_report

    fields = {
        "robots.count": robots,
        "tasks.count": tasks,
        "arena.side": arena,
        "sensing.range": reach,
        "run.steps": steps,
    }
    more = (f"{field}={value}" for field, value in fields.items() if value is not None)
    scenario = read_scenario(file, (*changes, *more))
    if report is not None:
        check_output(report, (".html", ".htm"), "--report")
    with progress("Assessing") as advance:
        assessment = simulate_all(scenario, runs, seed, threads, advance)
    if report is not None:
        write_report(assessment, report)
    if as_json:
        click.echo(json.dumps(assessment.to_dict(), indent=2))
        return
    for paragraph in words(assessment):
        click.echo(_wrapped(paragraph) + "\n")
    if report is not None:
        click.echo(f"The page is {report}")


def _wrapped(paragraph: str) -> str:
    """Break a paragraph into lines for the terminal, never between a number and its %."""
    width = min(88, get_terminal_size().columns)
    return click.wrap_text(paragraph.replace(" %", "\u00a0%"), width).replace("\u00a0%", " %")
