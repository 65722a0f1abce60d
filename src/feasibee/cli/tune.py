"""feasibee tune: which parameters are good, and which matter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import (
    Given,
    MeasureChoice,
    Workforce,
    command,
    complete_field,
    count_type,
    folder_option,
    listed,
    option,
    print_json,
)
from feasibee.errors import FeasibeeError
from feasibee.files import make_folder
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.studies.space import Dimension
    from feasibee.studies.tuning import Tuned

LEAST_POINTS = 10
"""Least number of points whose ranks say anything."""


@command()
def tune(
    *,
    given: Given,
    over: tuple[str, ...] = option(
        "Fields to vary; by default from a fifth of a value to five times it.",
        callback=listed,
        shell_complete=complete_field,
        required=True,
        metavar="FIELD,FIELD=LOW:HIGH,FIELD=A|B,...",
    ),
    steps: int | None,
    sensitivity: bool = option(
        "Instead, show which of the fields matter: rank correlations with right decisions over a Latin "
        "hypercube.",
        is_flag=True,
    ),
    measure: str | None = option(
        "What to improve; by default right_at_end, and right_share in a world that changes.",
        MeasureChoice(improvable=True),
        name="--for",
    ),
    false_alarms: float | None = option(
        "Choose no parameters with more false alarms per 1,000 steps, in a world that changes.",
        click.FloatRange(0),
        metavar="RATE",
    ),
    trials: int | None = option(
        "Number of trials; by default 60, and 200 with --sensitivity, which needs 10.",
        click.IntRange(2, 100_000),
    ),
    runs: int | None = option(
        "Number of runs of each trial; by default 200, and 20 with --sensitivity.", count_type
    ),
    seed: int,
    workforce: Workforce,
    out: Path = folder_option("tune", "the figure"),
    as_json: bool,
) -> None:
    """Search for the parameters with which the swarm is right most often, or show which ones matter.

    In a world that changes, it may also follow changes as soon as possible, at few false alarms. The steps of
    a run are the time that it has.

    The gain is judged on fresh runs, since the best of many trials was also lucky. Where the theory of
    feasibee predict reaches, it scores the trials, and only the best two and the start are run. Needs the
    extra 'tune', except with --sensitivity.

    \b
    Examples:
      feasibee tune mine.toml --over decision.exploration,decision.gain --steps 500
      feasibee tune --over "decision.gain=1:100,decision.strategy=dmmd|dmvd" --trials 100
      feasibee tune changing.toml --over decision.gain --for detection_delay --false-alarms 0.1
      feasibee tune mine.toml --sensitivity --over radio.loss=0:0.5,faults.byzantine=0:0.2
    """
    from feasibee.studies.space import dimensions

    scenario = given.read({"run.steps": steps})
    space = dimensions(scenario, over)
    if sensitivity:
        if measure is not None or false_alarms is not None:
            raise FeasibeeError("--sensitivity: improves nothing; leave out --for and --false-alarms")
        _vary(scenario, space, trials or 200, runs or 20, seed, workforce, out, as_json)
        return
    from feasibee.figures.style import save_figure
    from feasibee.studies.tuning import draw_search, objective_for
    from feasibee.studies.tuning import tune as search

    objective, trials, runs = objective_for(scenario, measure, false_alarms), trials or 60, runs or 200
    Runs(10 * runs, seed)  # raises before the folder is made
    picture = make_folder(out) / "tune.png"
    with executing("Tuning", out, workforce) as execution:
        tuned = search(scenario, space, trials, runs, seed, execution, objective)
    save_figure(draw_search(tuned), picture)
    if as_json:
        print_json(_as_dict(tuned))
    else:
        _print_tuned(tuned, scenario.run.steps, 10 * runs, picture)


def _as_dict(tuned: Tuned) -> dict[str, Any]:
    intervals = {name: getattr(tuned, name)._asdict() for name in ("start", "best", "gain")}
    changing = tuned.objective.measure != "right_at_end"
    about = {"measure": tuned.objective.measure, "false_alarms": tuned.false_alarms} if changing else {}
    theory = {} if tuned.predicted is None else {"proposed_by": "theory", "predicted": tuned.predicted}
    return {"values": tuned.values, **intervals, "clear_gain": tuned.gains, **about, **theory}


def _print_tuned(tuned: Tuned, steps: int, fresh: int, picture: Path) -> None:
    for path, value in tuned.values.items():
        click.echo(f"--set {path}={value:.4g}" if isinstance(value, float) else f"--set {path}={value}")
    found = "" if tuned.gains else "Worse than the start. " if tuned.gain.high < 0 else "No clear gain. "
    most = tuned.objective.false_alarms
    if most is not None and tuned.false_alarms > most:
        found += "Too many false alarms. "
    click.echo(f"{found}{_result(tuned, steps)} on {fresh} fresh runs. The search: {picture}")
    if tuned.predicted is not None:
        share = 100 * tuned.predicted
        click.echo(f"Theory proposed parameters, and simulation judged them: {share:.1f} % predicted.")


def _result(tuned: Tuned, steps: int) -> str:
    """Return the measure with the best parameters and at the start, and their difference."""
    measure = tuned.objective.measure
    alarms = f", {tuned.false_alarms:.2g} false alarms per 1,000 steps," if measure != "right_at_end" else ""
    if measure == "detection_delay":
        middle, low, high = tuned.gain
        return (
            f"Mean delay of detection: {tuned.best.estimate:.1f} steps, at the start "
            f"{tuned.start.estimate:.1f}: {middle:.1f} steps sooner ({low:.1f} to {high:.1f})"
            f"{alarms}"
        )
    middle, low, high = (100 * value for value in tuned.gain)
    words = f"Right within {steps} steps" if measure == "right_at_end" else f"Right, of {steps} steps"
    return (
        f"{words}: {100 * tuned.best.estimate:.1f} %, at the start {100 * tuned.start.estimate:.1f} %: "
        f"{middle:+.1f} points ({low:+.1f} to {high:+.1f}){alarms}"
    )


def _vary(
    scenario: Scenario,
    space: list[Dimension],
    points: int,
    runs: int,
    seed: int,
    workforce: Workforce,
    out: Path,
    as_json: bool,
) -> None:
    """Show which fields matter."""
    from feasibee.figures.style import save_figure
    from feasibee.studies.tuning import draw_sensitivities, sensitivities

    if points < LEAST_POINTS:
        raise FeasibeeError(f"--trials {points}: must be at least {LEAST_POINTS} with --sensitivity")
    Runs(points * runs, seed)  # raises before the folder is made
    picture = make_folder(out) / "sensitivity.png"
    with executing("Varying", out, workforce) as execution:
        found, _, _ = sensitivities(scenario, space, points, runs, seed, execution)
    save_figure(draw_sensitivities(found), picture)
    if as_json:
        rows = [
            {"field": each.path, "correlation": each.correlation._asdict(), "matters": each.matters}
            for each in found
        ]
        print_json(rows)
        return
    click.echo(f"Rank correlation with right decisions, {points} points of {runs} runs, 95 % interval:")
    width = max(len(each.path) for each in found)
    for each in found:
        middle, low, high = each.correlation
        verdict = "" if each.matters else "  (can't tell)"
        click.echo(f"  {each.path:{width}}  {middle:+.2f} ({low:+.2f} to {high:+.2f}){verdict}")
    click.echo(f"The figure is {picture}")
