"""feasibee predict: how often, when and why a swarm decides, by theory; runs of the engine check it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.base.errors import FeasibeeError, ScenarioError
from feasibee.base.files import FIGURES, check_output
from feasibee.cli.options import (
    GivenScenario,
    command,
    complete_field,
    console,
    file_type,
    option,
    percents,
    print_json,
    print_lines,
    print_numbers,
    progress,
)

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.theory.predict import Agreement, Prediction

    Point = tuple[Any, Prediction | str, Agreement | None]

POINTS = 9
"""Number of values of --over."""


@command()
def predict(
    *,
    given: GivenScenario,
    against: int | None = option(
        "Also simulate so many runs, and say whether they agree.", click.IntRange(1), metavar="RUNS"
    ),
    over: str | None = option(
        "Predict for nine values of a field, such as decision.gain=3:40.",
        metavar="FIELD=LOW:HIGH",
        shell_complete=complete_field,
    ),
    plot: Path | None = option(
        "Draw a figure: decisions over time, drift, and noise; with --over, shares, tipping point and times.",
        file_type,
        metavar="FILE",
    ),
    seed: int,
    workers: int | None,
    details: bool = option("Also print why: where opinions tip, and what noise does."),
    as_json: bool,
) -> None:
    """Predict how often and when a swarm decides, without simulating it, and why.

    The theory has no parameter that was fitted to simulations. It covers opinions on a torus; other scenarios
    are refused, with the field and a value to use. The error is the largest measured in such scenarios.

    With --against, theory and engine agree if both shares lie within that error of the engine's 95 %
    intervals, and the median step lies within 12 % of a median in the engine's 95 % interval. Where a
    larger error of the median step was measured, a warning states it, and it is taken instead.

    \b
    Examples:
      feasibee predict --set tasks.count=10
      feasibee predict mine.toml --against 2000
      feasibee predict --set tasks.count=10 --over decision.gain=3:40 --plot gain.png
      feasibee predict mine.toml --json
    """
    scenario = given.read()
    if plot is not None:
        check_output(plot, FIGURES, "--plot")
    path, values = "", [None]
    if over is not None:
        from feasibee.studies.size import dimension

        varied = dimension(scenario, over)
        path, shares = varied.path, (k / (POINTS - 1) for k in range(POINTS))
        values = list(varied.choices or dict.fromkeys(map(varied.at, shares)))
    found = _points(scenario, path, values, against, seed, workers)
    if plot is not None:
        _draw(found, path, plot)
    if as_json:
        about = {"scenario": scenario.to_dict(), "scenario_hash": scenario.hash}
        points = [{"value": each[0], **_json_of(each)} for each in found]
        print_json({"field": path, "points": points} if over else {**_json_of(found[0]), **about})
    elif over:
        _print_over(found, path)
    else:
        _print_one(found[0], details)


def _points(
    scenario: Scenario, path: str, values: Any, against: int | None, seed: int, workers: int | None
) -> list[Point]:
    """Return for each value the prediction, or why there is none, and what the engine found."""
    from feasibee.scenario.runs import Runs
    from feasibee.theory.predict import compare
    from feasibee.theory.predict import predict as predicted

    wanted = Runs(against or 1, seed)
    found: list[Point] = []
    for value in values:
        here = scenario.replace({path: value}) if path else scenario
        try:
            prediction = predicted(here)
        except ScenarioError as error:
            if not path:
                raise
            found.append((value, str(error.problems[0]), None))
            continue
        agreement = None
        if against is not None:
            from feasibee.simulation.ensemble import simulate_record

            with progress("Simulating") as advance:
                record = simulate_record(here, wanted, threads=workers, progress=advance)
            agreement = compare(prediction, record)
        found.append((value, prediction, agreement))
    if all(isinstance(prediction, str) for _, prediction, _ in found):
        raise FeasibeeError(str(found[0][1]))
    return found


def _json_of(point: Point) -> dict[str, Any]:
    _, prediction, agreement = point
    if isinstance(prediction, str):
        return {"beyond_reach": prediction}
    answer = prediction.to_dict()
    if agreement is not None:
        answer["engine"] = {
            "runs": agreement.runs,
            **{name: rate._asdict() for name, rate in agreement.rates.items()},
            "decision_step": agreement.steps._asdict(),
        }
        answer["agree"] = agreement.agree
    return answer


def _share(value: float) -> str:
    return f"{100 * value:.1f}"


def _print_one(point: Point, details: bool) -> None:
    _, prediction, agreement = point
    assert not isinstance(prediction, str)
    print_lines(_lines(prediction, agreement))
    if agreement:
        names = ("feasible", "infeasible", "undecided")
        rows = [[name, _share(getattr(prediction, name)), *percents(agreement.rates[name])] for name in names]
        print_numbers("", ["decision", "theory (%)", "engine (%)", "95 % interval"], rows)
    print_lines(_why(prediction) if details else [])


def _lines(prediction: Prediction, agreement: Agreement | None) -> Iterator[str]:
    """Yield the answer: what swarms decide, when, and whether the engine agrees; then warnings."""
    from feasibee.scenario.feasibility import truth
    from feasibee.scenario.units import when_in_words

    scenario, true = prediction.scenario, "feasible" if truth(prediction.scenario) else "infeasible"
    shares = {name: getattr(prediction, name) for name in ("feasible", "infeasible", "undecided")}
    right, error = 100 * shares.pop(true), 100 * prediction.error
    others = " and ".join(f"{100 * share:.0f} % {name}" for name, share in shares.items())
    yield (
        f"By theory, {right:.0f} % of the swarms rightly decide {true} (the largest error in tests was "
        f"{error:.2g} points), {others}."
    )
    q25, median, q75 = (when_in_words(scenario, each) for each in prediction.steps.values())
    yield f"Half have decided {median}, a quarter {q25}, three quarters {q75}."
    if agreement is not None:
        agrees = {"shares": agreement.shares_agree, "times": agreement.times_agree}
        parts = [name for name, same in agrees.items() if not same]
        verdict = f"differ in {' and '.join(parts)}" if parts else "agree"
        half = when_in_words(scenario, agreement.steps.median)
        yield f"Theory and engine {verdict} (half {half} in {agreement.runs:,} runs)."
    yield from (f"Warning: {each}." for each in prediction.warnings)


def _why(prediction: Prediction) -> Iterator[str]:
    """Yield where opinions tip, and what noise does, if they tip."""
    if (tips := prediction.tipping) is not None:
        yield (
            f"Opinions tip where {_share(tips.point)} % are for feasible; a deviation grows e-fold in "
            f"{tips.e_fold:.0f} steps."
        )
        coins, later = _share(tips.coins_share), _share(1 - tips.coins_share)
        yield f"Noise: {coins} % from the coins at the start, {later} % from all later steps."


def _print_over(found: list[Point], path: str) -> None:
    engine = any(agreement for _, _, agreement in found)
    heads = [path, "feasible", "infeasible", "step", "tips at", *(["engine (%)", "agree"] if engine else [])]
    rows, beyond = [], []
    for value, prediction, agreement in found:
        row = [_number(value)]
        if isinstance(prediction, str):
            rows.append([*row, *["-"] * (len(heads) - 1)])
            beyond.append(prediction)
            continue
        row += [_share(prediction.feasible), _share(prediction.infeasible)]
        row.append(str(prediction.steps["median"] or "never"))
        row.append("-" if prediction.tipping is None else _share(prediction.tipping.point))
        if agreement:
            row += [_share(agreement.rates["feasible"].estimate), "yes" if agreement.agree else "no"]
        rows.append(row)
    print_lines([_range_in_words(found, path)])
    print_numbers("", heads, rows)
    for line in beyond:
        console().print(f"Beyond reach: {line}", soft_wrap=True)


def _range_in_words(found: list[Point], path: str) -> str:
    known = [(value, each.right) for value, each, _ in found if not isinstance(each, str)]
    (worst, least), (best, most) = (pick(known, key=lambda pair: pair[1]) for pick in (min, max))
    return (
        f"By theory, {100 * most:.0f} % of the swarms are right with {path} = {_number(best)}, the best of "
        f"these values, and {100 * least:.0f} % with {_number(worst)}, the worst."
    )


def _number(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _draw(found: list[Point], path: str, plot: Path) -> None:
    from feasibee.figures.style import save_figure
    from feasibee.figures.theory import draw_field, draw_prediction

    known = [(value, each, agreement) for value, each, agreement in found if not isinstance(each, str)]
    save_figure(draw_field(path, known) if path else draw_prediction(*known[0][1:]), plot)
