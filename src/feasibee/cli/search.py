"""feasibee tune, feasibee sensitivity: which parameters are good, and which matter."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.completion import complete_field
from feasibee.cli.execution import (
    Workforce,
    executing,
    folder_option,
    journal_option,
    workforce_options,
)
from feasibee.cli.options import (
    MeasureChoice,
    check_figure,
    file_type,
    json_option,
    keep_matplotlib_in_cache,
    listed,
    read_scenario,
    scenario_options,
    seed_option,
)

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.studies.sensitivity import Sensitivity
    from feasibee.studies.space import Dimension
    from feasibee.studies.tuning import Tuned

_over = click.option(
    "--over",
    callback=listed,
    shell_complete=complete_field,
    required=True,
    metavar="FIELD,FIELD=LOW:HIGH,FIELD=A|B,...",
    help="Fields to vary; by default from a fifth of a value to five times it.",
)
_within = click.option("--within", type=int, help="Number of steps: short for --set run.steps=...")


def _read_space(
    file: Path | None, changes: tuple[str, ...], over: tuple[str, ...], within: int | None
) -> tuple[Scenario, list[Dimension]]:
    """Return the scenario, and the fields to vary."""
    from feasibee.studies.space import dimensions

    more = () if within is None else (f"run.steps={within}",)
    scenario = read_scenario(file, (*changes, *more))
    return scenario, dimensions(scenario, over)


@click.command()
@scenario_options
@_over
@_within
@click.option(
    "--for",
    "measure",
    type=MeasureChoice(improvable=True),
    help="What to improve; by default right_at_end, and right_share in a world that changes.",
)
@click.option(
    "--false-alarms",
    type=click.FloatRange(0),
    metavar="RATE",
    help="Choose no parameters with more false alarms per 1,000 steps, in a world that changes.",
)
@click.option(
    "--trials", type=click.IntRange(2, 100_000), default=60, show_default=True, help="Number of trials."
)
@click.option(
    "--runs", type=click.IntRange(1), default=200, show_default=True, help="Number of runs of each trial."
)
@seed_option
@workforce_options
@folder_option("tune", "the figure")
@json_option
def tune(
    file: Path | None,
    changes: tuple[str, ...],
    over: tuple[str, ...],
    within: int | None,
    measure: str | None,
    false_alarms: float | None,
    trials: int,
    runs: int,
    seed: int,
    workforce: Workforce,
    out: Path,
    as_json: bool,
) -> None:
    """Search for the parameters with which the swarm is right most often within a given time.

    In a world that changes, it may also follow changes as soon as possible, at few false alarms.

    The gain is judged on fresh runs, since the best of many trials was also lucky. Needs the extra 'tune'.

    \b
    Examples:
      feasibee tune mine.toml --over decision.exploration,decision.gain --within 500
      feasibee tune --over "decision.gain=1:100,decision.strategy=dmmd|dmvd" --trials 100
      feasibee tune changing.toml --over decision.gain --for detection_delay --false-alarms 0.1
    """
    keep_matplotlib_in_cache()
    from feasibee.figures.style import save_figure
    from feasibee.files import make_folder
    from feasibee.scenario.runs import Runs
    from feasibee.studies.objectives import objective_for
    from feasibee.studies.tuning import draw_search
    from feasibee.studies.tuning import tune as search

    scenario, space = _read_space(file, changes, over, within)
    Runs(10 * runs, seed)  # raises before the folder is made
    objective = objective_for(scenario, measure, false_alarms)
    folder = make_folder(out)
    picture = folder / "tune.png"
    check_figure("--out", picture)
    with executing("Tuning", folder, workforce) as execution:
        tuned = search(scenario, space, trials, runs, seed, execution, objective)
    save_figure(draw_search(tuned), picture)
    if as_json:
        intervals = {name: getattr(tuned, name)._asdict() for name in ("start", "best", "gain")}
        about = {"measure": objective.measure, "false_alarms": tuned.false_alarms}
        about = about if scenario.dynamic else {}
        click.echo(
            json.dumps({"values": tuned.values, **intervals, "clear_gain": tuned.gains, **about}, indent=2)
        )
    else:
        _print_tuned(tuned, scenario.run.steps, 10 * runs, picture)


def _print_tuned(tuned: Tuned, steps: int, fresh: int, picture: Path) -> None:
    for path, value in tuned.values.items():
        click.echo(f"--set {path}={value:.4g}" if isinstance(value, float) else f"--set {path}={value}")
    found = "" if tuned.gains else "Worse than the start. " if tuned.gain.high < 0 else "No clear gain. "
    most = tuned.objective.false_alarms
    if most is not None and tuned.false_alarms > most:
        found += "Too many false alarms. "
    click.echo(f"{found}{_result(tuned, steps)} on {fresh} fresh runs. The search: {picture}")


def _result(tuned: Tuned, steps: int) -> str:
    """Return the measure with the best parameters and at the start, and their difference."""
    measure = tuned.objective.measure
    if measure == "detection_delay":
        middle, low, high = tuned.gain
        return (
            f"Mean delay of detection: {tuned.best.estimate:.1f} steps, at the start "
            f"{tuned.start.estimate:.1f}: {middle:.1f} steps sooner ({low:.1f} to {high:.1f})"
            f"{_alarms(tuned)}"
        )
    middle, low, high = (100 * value for value in tuned.gain)
    words = f"Right within {steps} steps" if measure == "right_at_end" else f"Right, of {steps} steps"
    return (
        f"{words}: {100 * tuned.best.estimate:.1f} %, at the start {100 * tuned.start.estimate:.1f} %: "
        f"{middle:+.1f} points ({low:+.1f} to {high:+.1f}){_alarms(tuned)}"
    )


def _alarms(tuned: Tuned) -> str:
    if tuned.objective.measure == "right_at_end":
        return ""
    return f", {tuned.false_alarms:.2g} false alarms per 1,000 steps,"


@click.command()
@scenario_options
@_over
@_within
@click.option(
    "--points",
    type=click.IntRange(10, 10_000),
    default=200,
    show_default=True,
    help="Number of points of the hypercube.",
)
@click.option(
    "--runs", type=click.IntRange(1), default=20, show_default=True, help="Number of runs at each point."
)
@seed_option
@workforce_options
@click.option("--plot", type=file_type, metavar="FILE.png", help="Draw the correlations.")
@journal_option
@json_option
def sensitivity(
    file: Path | None,
    changes: tuple[str, ...],
    over: tuple[str, ...],
    within: int | None,
    points: int,
    runs: int,
    seed: int,
    workforce: Workforce,
    plot: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Show which fields matter: rank correlations with right decisions over a Latin hypercube.

    \b
    Examples:
      feasibee sensitivity --over decision.exploration,decision.gain,sensing.range,walk.mean_run
      feasibee sensitivity mine.toml --over radio.loss=0:0.5,faults.byzantine=0:0.2 --plot which.png
    """
    keep_matplotlib_in_cache()
    from feasibee.figures.style import save_figure
    from feasibee.studies.sensitivity import draw_sensitivities, sensitivities

    check_figure("--plot", plot)
    scenario, space = _read_space(file, changes, over, within)
    with executing("Varying", out, workforce) as execution:
        found, _, _ = sensitivities(scenario, space, points, runs, seed, execution)
    if plot is not None:
        save_figure(draw_sensitivities(found), plot)
    if as_json:
        click.echo(json.dumps([_as_dict(each) for each in found], indent=2))
        return
    click.echo(f"Rank correlation with right decisions, {points} points of {runs} runs, 95 % interval:")
    _print_sensitivities(found)


def _print_sensitivities(found: list[Sensitivity]) -> None:
    width = max(len(each.path) for each in found)
    for each in found:
        middle, low, high = each.correlation
        verdict = "" if each.matters else "  (can't tell)"
        click.echo(f"  {each.path:{width}}  {middle:+.2f} ({low:+.2f} to {high:+.2f}){verdict}")


def _as_dict(each: Sensitivity) -> dict[str, Any]:
    return {"field": each.path, "correlation": each.correlation._asdict(), "matters": each.matters}
