"""feasibee assess: the expected behaviour of a swarm before deployment."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import (
    JOURNAL,
    Given,
    Workforce,
    command,
    count_type,
    keep_matplotlib_in_cache,
    option,
    outputs_option,
    print_json,
    wrapped,
)

if TYPE_CHECKING:
    from feasibee.studies.assess import Assessment


@command()
def assess(
    *,
    given: Given,
    robots: int | None = option("Short for --set robots.count=...", int),
    tasks: int | None = option("Short for --set tasks.count=...", int),
    arena: float | None = option("Side of the arena, in units: short for --set arena.side=...", float),
    reach: float | None = option("Short for --set sensing.range=...", float, name="--range"),
    steps: int | None,
    runs: int = option("Number of runs of each variant.", count_type, 400),
    right: float,
    seed: int,
    workforce: Workforce,
    outputs: dict[str, Path] = outputs_option(
        f"Write the assessment as a page, .html. A folder: {JOURNAL} Repeatable.",
        folder=True,
        page=(".html", ".htm"),
    ),
    as_json: bool,
) -> None:
    """Assess in plain words how often a swarm is right, how soon, what it takes, and what would help.

    FILE is a scenario in TOML; without one, the paper's defaults. The verdict comes first. Changes, faults
    and other strategies are run on the same worlds, so that their differences aren't chance.

    \b
    Examples:
      feasibee assess mine.toml --out mine.html
      feasibee assess --robots 40 --tasks 30 --arena 50 --range 4
    """
    keep_matplotlib_in_cache()
    from feasibee.studies.assess import assess as simulate_all
    from feasibee.studies.report import write_report

    fields = {
        "robots.count": robots,
        "tasks.count": tasks,
        "arena.side": arena,
        "sensing.range": reach,
        "run.steps": steps,
    }
    scenario = given.read(fields)
    with executing("Assessing", outputs.get("folder"), workforce) as execution:
        assessment = simulate_all(scenario, runs, seed, execution, right)
    if report := outputs.get("page"):
        write_report(assessment, report, shlex.join(("feasibee", *sys.argv[1:])))
    if as_json:
        print_json(assessment.to_dict())
    else:
        _print(assessment, report)


def _print(assessment: Assessment, report: Path | None) -> None:
    from feasibee.studies.report import sections

    for section in sections(assessment):
        click.echo(section.title)
        for line in section.lines:
            click.echo(wrapped(line, "  "))
        click.echo()
    if report is not None:
        click.echo(f"The page is {report}")
