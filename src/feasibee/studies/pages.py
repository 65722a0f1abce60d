"""Write pages of HTML with figures: an assessment, whose first sheet of A4 has all in brief when printed."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from feasibee.figures.arena import plot_arena
from feasibee.figures.comparison import draw_against_bits, draw_against_time, draw_calibration
from feasibee.figures.sizing import draw_sizing
from feasibee.figures.style import figure
from feasibee.files import write_text
from feasibee.scenario.html import render
from feasibee.scenario.units import steps_in_words
from feasibee.simulation.swarm import Swarm
from feasibee.studies.comparison import calibration_of, percent, points, tracking_figures
from feasibee.studies.report import SIGNS, Assessment, sections
from feasibee.studies.size import panels_of

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
        sign=SIGNS[assessment.verdict.level],
        steps=steps_in_words(assessment.scenario, assessment.scenario.run.steps),
        words=sections(assessment),
        percent=percent,
        points=points,
        own=OWN,
        figures=[(title, encoded(drawn)) for title, drawn in _figures(assessment)],
    )


def write_page(path: Path, template: str, command: str, **values: Any) -> None:
    """Write an HTML file that needs no other, with the command that made it in its footer."""
    write_text(path, render(template, command=command, date=f"{datetime.now(UTC):%Y-%m-%d}", **values))


def _figures(assessment: Assessment) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of a report with their titles."""
    scenario, recommended = assessment.scenario, assessment.recommended
    if assessment.sizing is not None:
        title = "Share of right swarms against the number of robots, and against the number of tasks"
        yield title, draw_sizing(panels_of(assessment.sizing), assessment.target)
    keep = [OWN] if recommended is None else [OWN, recommended.strategy]
    outcomes = {
        OWN: assessment.outcome,
        **{trial.outcome.contender: trial.outcome for trial in assessment.strategies},
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
            trial.outcome.contender: each
            for trial in assessment.strategies
            if trial.opposite and (each := calibration_of([trial.outcome, trial.opposite]))
        }
        title = "Share of feasible tasks against the probability that swarms give to feasible, in both worlds"
        yield title, draw_calibration(found, keep=keep)
    if scenario.place.exists:
        with figure(5.0, 4.0) as (drawn, ax):
            plot_arena(Swarm(scenario, assessment.seed), ax)
        yield "Floor plan: where robots and tasks are at the start of a run", drawn
