"""What studies write: the table and figures of a comparison, and pages of HTML with figures.

A page needs no other file. The first sheet of A4 of an assessment has all in brief when printed.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from feasibee.base.files import write_table, write_text
from feasibee.figures.arena import plot_arena
from feasibee.figures.comparison import (
    draw_against_bits,
    draw_against_ratio,
    draw_against_time,
    draw_calibration,
    draw_delay_against_bits,
    draw_right_over_time,
    draw_sizing,
)
from feasibee.figures.style import figure, looks, save_both
from feasibee.results.calibration import Bin, Calibration
from feasibee.results.measures import columns
from feasibee.results.statistics import in_percent
from feasibee.scenario.shown import render
from feasibee.scenario.units import steps_in_words
from feasibee.simulation.swarm import Swarm
from feasibee.studies.comparison import (
    Comparison,
    Outcome,
    by_contender,
    calibration_of,
    calibrations,
    in_bits,
    mean_bits,
    overall,
)
from feasibee.studies.constraints import Constrained
from feasibee.studies.report import SIGNS, Assessment, in_points, sections
from feasibee.studies.size import panels_of


def write_comparison(folder: Path, found: Comparison | Constrained) -> None:
    """Write ``compare.csv`` and its figures into a folder, as PNG and PDF.

    In a world that changes, the figures are those of `tracking_figures`, for each number of tasks. In others,
    they show accuracy by ratio, by step and by bits, calibration if both truths are among the numbers of
    tasks, and declarations if robots declare. Under constraints, there is one of right swarms against bits.
    """
    curves: dict[str, Calibration] = {}
    if isinstance(found, Constrained):
        figures = _figures_under(found)
    elif found.outcomes[0].tracking is None:
        curves = calibrations(found.outcomes)
        figures = _figures(by_contender(found.outcomes), curves)
    else:
        figures = _figures_by_tasks(found.outcomes)
    for name, drawn in figures.items():
        save_both(drawn, folder / name)
    write_table(folder / "compare.csv", found.rows)
    if rows := [{"contender": name, **_bin_row(each)} for name in curves for each in curves[name].bins]:
        write_table(folder / "calibration.csv", rows)


def _bin_row(each: Bin) -> dict[str, object]:
    return {"said": round(each.said, 6), "runs": each.runs, **columns("feasible", each.feasible)}


def _figures_by_tasks(outcomes: Sequence[Outcome]) -> dict[str, Figure]:
    """Return the figures of a world that changes, for each number of tasks."""
    numbers = list(dict.fromkeys(each.tasks for each in outcomes))
    figures: dict[str, Figure] = {}
    for number in numbers:
        same = {each.contender: each for each in outcomes if each.tasks == number}
        suffix = f"_{number}" if len(numbers) > 1 else ""
        figures |= {f"compare_{name}{suffix}": drawn for name, drawn in tracking_figures(same).items()}
    return figures


def tracking_figures(same: Mapping[str, Outcome]) -> dict[str, Figure]:
    """Return figures of contenders in one world that changes: right swarms by step and by bits, and delay."""
    tracked = {name: each.tracking for name, each in same.items() if each.tracking is not None}
    bits = {name: float(each.bits.mean()) for name, each in same.items()}
    before = looks({name: each.right_share.estimate for name, each in tracked.items()})
    some = next(iter(same.values()))
    return {
        "time": draw_right_over_time(
            {name: each.right_at / each.runs for name, each in same.items()},
            some.infeasible_at,
            before=before,
        ),
        "bits": draw_against_bits(
            {name: (bits[name], each.right_share) for name, each in tracked.items()},
            "steps at which swarms are right (%)",
            before=before,
        ),
        "delay": draw_delay_against_bits(
            {name: (bits[name], each.detection_delay) for name, each in tracked.items()},
            some.right_at.size - 1,
            before=before,
        ),
    }


def _figures(groups: Mapping[str, Sequence[Outcome]], curves: Mapping[str, Calibration]) -> dict[str, Figure]:
    """Return the figures of a world that doesn't change, with those of calibration and declarations."""
    some = next(iter(groups.values()))
    swarm = some[0].robots, [each.tasks for each in some]
    accuracies = {name: [each.accuracy for each in group] for name, group in groups.items()}
    shares = {name: np.array([each.right_at / each.runs for each in group]) for name, group in groups.items()}
    totals = {name: (mean_bits(group), overall(group)) for name, group in groups.items()}
    before = looks({name: share.estimate for name, (_, share) in totals.items()})
    figures = {
        "compare_ratio": draw_against_ratio(*swarm, accuracies, before=before),
        "compare_time": draw_against_time(shares, before=before),
        "compare_bits": draw_against_bits(
            totals, "swarms that are right at the end,\nover all ratios (%)", before=before
        ),
    }
    if curves:
        figures["calibration"] = draw_calibration(curves, before=before)
    declared = {
        name: [each.declared for each in group if each.declared is not None] for name, group in groups.items()
    }
    if any(declared.values()):
        figures["compare_declared"] = draw_against_ratio(
            *swarm,
            {name: [each.ok for each in group] or None for name, group in declared.items()},
            "swarms that declared rightly (%)",
            {name: [each.wrong for each in group] for name, group in declared.items()},
            before=before,
        )
    return figures


def _figures_under(found: Constrained) -> dict[str, Figure]:
    """Return the figure of the tested strategies; none without any."""
    totals = {each.strategy: (each.bits, each.worst.judged) for each in found.tested}
    label = "swarms that are right at the end,\nwhere they are right least (%)"
    return {"compare_bits": draw_against_bits(totals, label)} if totals else {}


OWN = "this swarm"
TRACKING = {
    "time": "Share of right swarms at each step, with each strategy; grey: the tasks are infeasible",
    "bits": "Share of steps at which swarms are right against bits on the air",
    "delay": "Delay of detection against bits on the air",
}
"""Titles of the figures of a world that changes."""


def encoded(drawn: Figure) -> str:
    """Return a figure as PNG in base64."""
    drawn.savefig(buffer := io.BytesIO(), format="png", dpi=150)
    return base64.b64encode(buffer.getvalue()).decode()


def write_report(assessment: Assessment, path: Path, command: str = "feasibee.studies.assess") -> None:
    """Write an assessment as one HTML file that includes its figures; printed, page one stands alone.

    Parameters
    ----------
    assessment : Assessment
        What to write.
    path : Path
        The file.
    command : str
        The command that made it, for the footer.
    """
    write_page(
        path,
        "assessment.html",
        command,
        a=assessment,
        sign=SIGNS[assessment.level],
        steps=steps_in_words(assessment.scenario, assessment.scenario.run.steps),
        words=sections(assessment),
        percent=in_percent,
        points=in_points,
        in_bits=in_bits,
        own=OWN,
        figures=[(title, encoded(drawn)) for title, drawn in _figures_of(assessment)],
    )


def write_page(path: Path, template: str, command: str, **values: Any) -> None:
    """Write an HTML file that needs no other, with the command that made it in its footer."""
    write_text(path, render(template, command=command, date=f"{datetime.now(UTC):%Y-%m-%d}", **values))


def _figures_of(assessment: Assessment) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of a report with their titles."""
    scenario, recommended = assessment.scenario, assessment.recommended
    if assessment.sizing is not None:
        title = "Share of right swarms against the number of robots, and against the number of tasks"
        yield title, draw_sizing(panels_of(assessment.sizing), assessment.target)
    keep = [OWN] if recommended is None else [OWN, recommended.strategy]
    outcomes = {
        OWN: assessment.outcome,
        **{trial.name: trial.outcome for trial in assessment.strategies},
    }
    if assessment.outcome.tracking is not None:
        for name, drawn in tracking_figures(outcomes).items():
            yield TRACKING[name], drawn
        return
    shares = {name: each.right_at[None, :] / each.runs for name, each in outcomes.items()}
    title = "Share of right swarms at each step, with each strategy"
    yield title, draw_against_time(shares, keep=keep, seconds=scenario.units.seconds)
    totals = {name: (float(each.bits.mean()), each.accuracy) for name, each in outcomes.items()}
    yield "Share of right swarms against bits on the air", draw_against_bits(totals, keep=keep)
    if assessment.calibration is not None:
        found = {OWN: assessment.calibration} | {
            trial.name: each
            for trial in assessment.strategies
            if trial.opposite and (each := calibration_of([trial.outcome, trial.opposite]))
        }
        title = "Share of feasible tasks against the probability that swarms give to feasible, in both worlds"
        yield title, draw_calibration(found, keep=keep)
    if scenario.place.exists:
        with figure(5.0, 4.0) as (drawn, ax):
            plot_arena(Swarm(scenario, assessment.seed), ax)
        yield "Floor plan: where robots and tasks are at the start of a run", drawn
