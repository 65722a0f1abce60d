"""feasibee run: simulate one scenario many times, or saved results again."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import FIGURES, RESULTS
from feasibee.cli.options import (
    ANIMATIONS,
    Film,
    GivenScenario,
    NamedPath,
    command,
    count_type,
    exclude,
    only,
    option,
    outputs_option,
    print_json,
    progress,
    with_flooding,
)
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.base.record import Record
    from feasibee.scenario.scenario import Scenario


@command()
def run(
    *,
    given: GivenScenario,
    runs: int = option("Number of runs.", count_type, 100),
    seed: int,
    run: int,
    steps: int | None,
    workers: int | None,
    outputs: dict[str, Path] = outputs_option(
        "File to write, repeatable; its ending says what. All runs: .nc is NetCDF, with opinions over time "
        "and the scenario; .csv has one row per run. A figure of them: .png, .pdf or .svg. The first run as "
        "an animation: .gif, .webp or .mp4 (needs the extra 'video'), or its last frame: .png with --frames. "
        "A page that simulates, without server or network: .html, about 400 KB.",
        runs=RESULTS,
        figure=FIGURES,
        animation=ANIMATIONS,
        page=(".html",),
    ),
    look: Film,
    again: tuple[Path, ...] = option(
        "Simulate saved results again, and compare every byte: .nc, the folder of a sweep, or the card of a "
        "benchmark, .json. Repeat it for figures; by default those named as the file, or in the folder.",
        NamedPath(exists=True, path_type=Path),
        metavar="FILE|FOLDER",
    ),
    trust: bool,
    details: bool = option("Print all measures by the names that --json has."),
    as_json: bool,
) -> None:
    """Simulate one scenario many times, and print how often the swarms were right, and when they decided.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks.
    The exit status with --again is 0 if all bytes are the same, 1 if some differ, and 2 after an error.

    \b
    Examples:
      feasibee run --set tasks.count=50 --runs 1000 --seed 1
      feasibee run mine.toml --out mine.png --out mine.nc
      feasibee run mine.toml --run 417 --runs 1 --out wrong.gif
      feasibee run mine.toml --out mine.html
      feasibee run --again mine.nc --again paper/mine.pdf
    """
    from feasibee.cli.summary import print_answer, summary_of
    from feasibee.simulation.ensemble import simulate_record

    if again:
        only("--again", "the results have scenario and runs", "again", "trust", "workers", "as_json")
        _compare(again, trust, workers, as_json)
        return
    exclude("no --again", "only saved results need it", "trust")
    is_png = outputs.get("figure", Path()).suffix.lower() == ".png"
    if is_png and look.frames and "animation" not in outputs:
        outputs["animation"] = outputs.pop("figure")
    if "animation" not in outputs:
        exclude("no animation", "only animations, such as --out run.gif, have it", *look._fields)
    scenario = with_flooding(given.read({"run.steps": steps}))
    wanted = Runs(runs, seed, run)
    _show(outputs, scenario, wanted, look, given.file.name if given.file else "")
    curves = "figure" in outputs or ("runs" in outputs and outputs["runs"].suffix.lower() == ".nc")
    with progress("Simulating") as advance:
        record = simulate_record(scenario, wanted, curves=curves, threads=workers, progress=advance)
    _save(outputs, record, scenario, seed)
    summary = summary_of(record, scenario, seed)
    if as_json:
        print_json(summary)
        return
    print_answer(summary, scenario, details)
    if outputs:
        click.echo(f"Wrote {', '.join(map(str, outputs.values()))}")


def _show(outputs: dict[str, Path], scenario: Scenario, runs: Runs, look: Film, name: str) -> None:
    """Write what needs no record of the runs, before these are simulated: errors come early."""
    if "page" in outputs:
        from feasibee.live.page import write_page

        write_page(scenario, outputs["page"], runs.seed, runs.first, name)
    if "animation" in outputs:
        from feasibee.figures.animation import animate

        look.draw(animate, scenario, outputs["animation"], runs.seed, runs.first)


def _save(outputs: dict[str, Path], record: Record, scenario: Scenario, seed: int) -> None:
    """Write the runs, and their figure."""
    if not outputs.keys() & {"runs", "figure"}:
        return
    from feasibee.results.dataset import save_results, to_dataset

    dataset = to_dataset(record, scenario, seed)
    if "runs" in outputs:
        save_results(dataset, outputs["runs"])
    if "figure" in outputs:
        from feasibee.figures.decisions import draw_runs
        from feasibee.figures.style import save_figure

        save_figure(draw_runs(dataset), outputs["figure"])


def _compare(paths: Sequence[Path], trust: bool, workers: int | None, as_json: bool) -> None:
    """Simulate results again; print what differs, and exit with 1 if anything does."""
    from feasibee.studies.reproduce import reproduce_card, reproduce_file, reproduce_folder

    figures = [path for path in paths if path.suffix.lower() in FIGURES]
    results = [path for path in paths if path not in figures]
    if len(results) != 1:
        raise FeasibeeError("--again: needs one file or folder of results, and figures of it, if any")
    (path,) = results
    kinds = {".json": reproduce_card}
    again = reproduce_folder if path.is_dir() else kinds.get(path.suffix.lower(), reproduce_file)
    with progress("Simulating again") as advance:
        found = again(path, figures, trust, workers, advance)
    if as_json:
        print_json(found._asdict())
    else:
        now = [f"{name} {now} (was {then})" for name, (then, now) in found.versions.items() if now != then]
        lines = (
            f"{path}: {found.runs:,} runs, written by feasibee {found.versions['feasibee'][0]}; now: "
            f"{', '.join(now) or 'the same versions'}.",
            *(f"Different: {each}." for each in found.differences),
            *([] if found.differences else ["All results are the same, byte for byte."]),
            *(
                f"{each}: {'the same, byte for byte' if same else 'differs'}."
                for each, same in found.figures.items()
            ),
        )
        click.echo("\n".join(lines))
    if found.differences or not all(found.figures.values()):
        sys.exit(1)
