"""feasibee tune, feasibee sensitivity: which parameters are good, and which matter."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from feasibee.cli.completion import complete_field
from feasibee.cli.options import (
    check_figure,
    file_type,
    folder_type,
    json_option,
    keep_matplotlib_in_cache,
    listed,
    progress,
    read_scenario,
    scenario_options,
    seed_option,
    threads_option,
)

_over = click.option(
    "--over",
    callback=listed,
    shell_complete=complete_field,
    required=True,
    metavar="FIELD,FIELD=LOW:HIGH,FIELD=A|B,...",
    help="What to vary; by default from a fifth of its value to five times it.",
)
_within = click.option("--within", type=int, help="Steps: short for --set run.steps=...")


@click.command()
@scenario_options
@_over
@_within
@click.option("--trials", type=click.IntRange(2, 100_000), default=60, show_default=True, help="In all.")
@click.option("--runs", type=click.IntRange(1), default=200, show_default=True, help="Swarms of each trial.")
@seed_option
@threads_option
@click.option(
    "--out",
    type=folder_type,
    default=Path("tune"),
    show_default=True,
    help="Folder of the search; the same command goes on with what is there.",
)
@json_option
def tune(
    file: Path | None,
    changes: tuple[str, ...],
    over: tuple[str, ...],
    within: int | None,
    trials: int,
    runs: int,
    seed: int,
    threads: int | None,
    out: Path,
    as_json: bool,
) -> None:
    """Search for good parameters: those with which the swarm is right most often within a given time.

    What is gained is judged on fresh runs, since the best of many trials has also been lucky. Needs
    the extra 'tune'.

    \b
    Examples:
      feasibee tune mine.toml --over decision.exploration,decision.gain --within 500
      feasibee tune --over "decision.gain=1:100,decision.strategy=dmmd|dmvd" --trials 100
    """
    keep_matplotlib_in_cache()
    from feasibee.figures.style import save_figure
    from feasibee.files import make_folder
    from feasibee.scenario.runs import Runs
    from feasibee.studies.space import dimensions
    from feasibee.studies.tuning import draw_search
    from feasibee.studies.tuning import tune as search

    more = () if within is None else (f"run.steps={within}",)
    scenario = read_scenario(file, (*changes, *more))
    space = dimensions(scenario, over)
    Runs(10 * runs, seed)  # raises before the folder is made
    picture = make_folder(out) / "tune.png"
    check_figure("--out", picture)
    with progress("Tuning") as advance:
        tuned = search(scenario, space, out, trials, runs, seed, threads, advance)
    save_figure(draw_search(tuned), picture)
    if as_json:
        intervals = {name: getattr(tuned, name)._asdict() for name in ("start", "best", "gain")}
        click.echo(json.dumps({"values": tuned.values, **intervals}, indent=2))
        return
    for path, value in tuned.values.items():
        click.echo(f"--set {path}={value:.4g}" if isinstance(value, float) else f"--set {path}={value}")
    middle, low, high = (100 * value for value in tuned.gain)
    click.echo(
        f"Right within {scenario.run.steps} steps: {100 * tuned.best.estimate:.1f} %, at the start "
        f"{100 * tuned.start.estimate:.1f} %: {middle:+.1f} points ({low:+.1f} to {high:+.1f}) on "
        f"{10 * runs} fresh runs. The search: {picture}"
    )


@click.command()
@scenario_options
@_over
@_within
@click.option(
    "--points", type=click.IntRange(10, 10_000), default=200, show_default=True, help="Of the hypercube."
)
@click.option("--runs", type=click.IntRange(1), default=20, show_default=True, help="Swarms at each point.")
@seed_option
@threads_option
@click.option("--plot", type=file_type, metavar="FILE.png", help="Draw it.")
@json_option
def sensitivity(
    file: Path | None,
    changes: tuple[str, ...],
    over: tuple[str, ...],
    within: int | None,
    points: int,
    runs: int,
    seed: int,
    threads: int | None,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Say which parameters matter: rank correlations with right decisions over a Latin hypercube.

    \b
    Examples:
      feasibee sensitivity --over decision.exploration,decision.gain,sensing.range,walk.mean_run
      feasibee sensitivity mine.toml --over radio.loss=0:0.5,faults.byzantine=0:0.2 --plot which.png
    """
    keep_matplotlib_in_cache()
    from feasibee.figures.style import save_figure
    from feasibee.studies.sensitivity import draw_sensitivities, sensitivities
    from feasibee.studies.space import dimensions

    more = () if within is None else (f"run.steps={within}",)
    scenario = read_scenario(file, (*changes, *more))
    check_figure("--plot", plot)
    with progress("Varying") as advance:
        found, _, _ = sensitivities(
            scenario, dimensions(scenario, over), points, runs, seed, threads, advance
        )
    if plot is not None:
        save_figure(draw_sensitivities(found), plot)
    if as_json:
        click.echo(json.dumps([_as_dict(each) for each in found], indent=2))
        return
    width = max(len(each.path) for each in found)
    click.echo(f"Rank correlation with right decisions, {points} points of {runs} runs, 95 % interval:")
    for each in found:
        middle, low, high = each.correlation
        told = "" if each.matters else "  (can't tell)"
        click.echo(f"  {each.path:{width}}  {middle:+.2f} ({low:+.2f} to {high:+.2f}){told}")


def _as_dict(each: Any) -> dict[str, Any]:
    return {"field": each.path, "correlation": each.correlation._asdict(), "matters": each.matters}
