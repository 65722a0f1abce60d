"""Write an assessment as HTML or as PDF: its first page has all in brief, and details follow."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from feasibee.figures.comparison import draw_against_bits, draw_against_time, draw_calibration
from feasibee.figures.heat import RUNS, heat_of, plot_heat
from feasibee.figures.sheets import Sheets, sheets
from feasibee.figures.sizing import draw_sizing
from feasibee.files import write_text
from feasibee.scenario.units import steps_in_words
from feasibee.studies.comparison import Outcome, calibration_of, percent, tracking_figures
from feasibee.studies.report import (
    SIGNS,
    Assessment,
    Trial,
    acted_in_words,
    agreement,
    cells_of,
    excluded_as_html,
    section_as_html,
    sections,
    table_as_html,
)
from feasibee.studies.size import panels_of, sentences

OWN = "this swarm"


TRACKING = {
    "time": "Share of right swarms at each step, with each strategy; grey: the tasks are infeasible",
    "bits": "Share of steps at which swarms are right against bits on the air",
    "delay": "Delay of detection against bits on the air",
}
"""Titles of the figures of a world that changes."""


class Shown(NamedTuple):
    """A figure of the page."""

    title: str
    text: str
    """What it shows, for those who can't see it."""
    drawn: Figure


def write_report(assessment: Assessment, path: Path, command: str = "feasibee.studies.assess") -> None:
    """Write an assessment as one HTML file that includes its figures, or as PDF; page one stands alone.

    Parameters
    ----------
    assessment : Assessment
        What to write.
    path : Path
        The file; ``.pdf`` makes it a PDF of A4 pages.
    command : str
        The command that made it, for the footer.
    """
    if path.suffix.lower() == ".pdf":
        _write_sheets(assessment, path, command)
        return
    first, *figures = [*_figures(assessment), *_maps(assessment)]
    brief, details = _parted(assessment)
    body = (
        _verdict(assessment)
        + "".join(section_as_html(*each) for each in brief.items())
        + figure_as_html(first)
    )
    body = f'<div class="first"><h1>{TITLE}</h1>{body}</div><h1>Details</h1>'
    body += "".join(section_as_html(*each) for each in details.items()) + "".join(
        map(figure_as_html, figures)
    )
    body += "".join(table_as_html(title, cells_of(each)) for title, each in _tables(assessment).items())
    body += excluded_as_html(assessment.recommendation.excluded)
    written = html.escape(assessment.scenario.to_toml())
    body += f"<details><summary>Scenario</summary><pre>{written}</pre></details>"
    write_page(path, "assessment", body, command)


def write_page(path: Path, title: str, body: str, command: str) -> None:
    """Write an HTML file that needs no other, with the command that made it in its footer."""
    foot = f"<code>{html.escape(command)}</code>; {datetime.now(UTC):%Y-%m-%d}"
    write_text(path, PAGE.replace("{title}", title).replace("{body}", body).replace("{footer}", foot))


def _write_sheets(assessment: Assessment, path: Path, command: str) -> None:
    """Write an assessment as PDF."""
    first, *figures = [*_figures(assessment), *_maps(assessment)]
    brief, details = _parted(assessment)
    excluded = [f"{name}: {why}" for name, why in assessment.recommendation.excluded.items()]
    with sheets(path, f"{TITLE}, {datetime.now(UTC):%Y-%m-%d}") as document:
        shape, level, number, rest = _verdict_parts(assessment)
        document.text(TITLE, 13, weight="bold")
        document.text(f"{shape} {level}: {number}", 24, weight="bold")
        document.y -= 4
        document.text(rest, 10.5)
        _write_sections(document, brief)
        document.picture(first.drawn, first.title, here=True)
        document.turn()
        _write_sections(document, details)
        for shown in figures:
            document.picture(shown.drawn, shown.title)
        for title, trials in _tables(assessment).items():
            document.heading(title)
            document.table(cells_of(trials))
        _write_sections(document, {"Not recommended": excluded, "Command and scenario": [command]})
        document.table([[line] for line in assessment.scenario.to_toml().splitlines()])


def _write_sections(document: Sheets, found: Mapping[str, Sequence[str]]) -> None:
    for title, lines in found.items():
        document.heading(title)
        for line in lines:
            document.text(f"• {line}", indent=8)


def _parted(assessment: Assessment) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Return the sections of page one and the others; the verdict is drawn."""
    found = sections(assessment)
    _, *early = found.pop("Verdict")
    brief = {"Ended early": early} if early else {}
    return brief | {title: found.pop(title) for title in FIRST if title in found}, found


def _tables(assessment: Assessment) -> dict[str, list[Trial]]:
    tables = {"Strategies": assessment.strategies, "Changes": assessment.limits, "Faults": assessment.faults}
    return {title: trials for title, trials in tables.items() if trials}


def _verdict_parts(assessment: Assessment) -> tuple[str, str, str, str]:
    """Return the shape and the word of the verdict, its number, and what that is of."""
    level, right, tasks = assessment.verdict
    middle, low, high = (100 * value for value in right)
    scenario, target = assessment.scenario, 100 * assessment.target
    steps = steps_in_words(scenario, scenario.run.steps)
    world = f"{scenario.decision.strategy}, {scenario.robots.count} robots, {tasks} tasks"
    what = (
        f"of the swarms are right after {steps} ({world})"
        if assessment.outcome.tracking is None
        else f"of {steps}, these swarms are right ({world} before any change)"
    )
    rest = f"{what}. 95 % interval: {low:.1f} to {high:.1f} %. Asked for: {target:g} %."
    return SIGNS[level][1], level.capitalize(), f"{middle:.1f} %", rest


def _verdict(assessment: Assessment) -> str:
    shape, level, number, rest = _verdict_parts(assessment)
    return (
        f'<section class="verdict {SIGNS[assessment.verdict.level][0]}">'
        f'<p class="level"><span aria-hidden="true">{shape}</span> {level}</p>'
        f'<p class="number">{number}</p><p>{rest}</p></section>'
    )


def _figures(assessment: Assessment) -> Iterator[Shown]:
    if assessment.sizing is not None:
        yield Shown(
            "Share of right swarms against the number of robots, and against the number of tasks",
            " ".join(sentences(assessment.sizing)),
            draw_sizing(panels_of(assessment.sizing), assessment.target),
        )
    recommended = assessment.recommended
    keep = [OWN] if recommended is None else [OWN, recommended.strategy]
    outcomes = {
        OWN: assessment.outcome,
        **{trial.outcome.contender: trial.outcome for trial in assessment.strategies},
    }
    if assessment.outcome.tracking is not None:
        for name, drawn in tracking_figures(outcomes).items():
            yield Shown(TRACKING[name], _best_in_words(assessment), drawn)
        return
    shares = {name: each.right_at[None, :] / each.runs for name, each in outcomes.items()}
    yield Shown(
        "Share of right swarms at each step, with each strategy",
        _best_in_words(assessment),
        draw_against_time(shares, keep=keep, seconds=assessment.scenario.units.seconds),
    )
    yield from _acted(assessment, outcomes, keep)
    totals = {name: (float(each.bits.mean()), each.accuracy) for name, each in outcomes.items()}
    yield Shown(
        "Share of right swarms against bits on the air",
        _best_in_words(assessment),
        draw_against_bits(totals, keep=keep),
    )
    if assessment.calibration is not None:
        found = {OWN: assessment.calibration} | {
            trial.outcome.contender: each
            for trial in assessment.strategies
            if trial.opposite and (each := calibration_of([trial.outcome, trial.opposite]))
        }
        yield Shown(
            "Share of feasible tasks against the probability that swarms give to feasible, in both worlds",
            " ".join(agreement(assessment)),
            draw_calibration(found, keep=keep),
        )


def _acted(assessment: Assessment, outcomes: Mapping[str, Outcome], keep: list[str]) -> Iterator[Shown]:
    """Yield the share of swarms that stand at all tasks that they can do, at each step, if robots act."""
    found, scenario = {}, assessment.scenario
    for name, each in outcomes.items():
        if each.found.acts is not None:
            steps = each.found.acts.all_taken_step
            counts = np.bincount(steps[steps >= 0], minlength=each.right_at.size)
            found[name] = counts.cumsum()[None, :] / each.runs
    if found:
        yield Shown(
            "Share of swarms that stand at all tasks that they can do, at each step",
            " ".join(acted_in_words(assessment.outcome, scenario)),
            draw_against_time(
                found, keep=keep, seconds=scenario.units.seconds, label="swarms at all their tasks (%)"
            ),
        )


def _maps(assessment: Assessment) -> Iterator[Shown]:
    """Yield the plan with heat maps, if the scenario has a place; of fewer runs for large swarms."""
    scenario = assessment.scenario
    if not scenario.place.exists:
        return
    runs = max(1, min(RUNS, 100 * RUNS // scenario.robots.count))
    heat = heat_of(scenario, runs, assessment.seed)
    each = "1 run" if runs == 1 else f"{runs} runs"
    yield Shown(
        "Floor plan: robots per square unit, robots that see each place, and opinions of those there",
        f"Means over {each}. On average, {heat.sightings.mean():.2g} robots see a place.",
        plot_heat(scenario, heat),
    )


def _best_in_words(assessment: Assessment) -> str:
    """Return the shares at the end of this swarm and of the best other strategies, in words."""
    best = [
        f"{trial.outcome.contender} {percent(trial.outcome.judged)}" for trial in assessment.strategies[:4]
    ]
    when = "At the end" if assessment.outcome.tracking is None else "Of the steps"
    return f"{when}: {'; '.join([f'{OWN} {percent(assessment.outcome.judged)}', *best])}."


def figure_as_html(shown: Shown) -> str:
    """Return a figure in HTML, with its pixels and what it shows in words."""
    buffer = io.BytesIO()
    shown.drawn.savefig(buffer, format="png", dpi=150)
    data = base64.b64encode(buffer.getvalue()).decode()
    alt = html.escape(f"{shown.title}. {shown.text}", quote=True)
    return (
        f'<figure><div class="wide"><img alt="{alt}" src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{html.escape(shown.title)}</figcaption></figure>"
    )


TITLE: Final = "Assessment of a swarm"
FIRST: Final = ("What to do", "What to expect", "If something fails", "What this rests on")
"""Sections of page one, below the verdict."""
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>feasibee: {title}</title><style>
:root { color-scheme: light dark; --line: color-mix(in srgb, currentColor 22%, transparent); }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 52rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .4rem; }
ul { padding-left: 1.2rem; } li { margin: .25rem 0; }
.verdict { border: 2px solid; border-left-width: .6rem; border-radius: .4rem; padding: .6rem 1.2rem; }
.verdict p { margin: .2rem 0; } .level { font-weight: 600; font-size: 1.2rem; }
.number { font-size: 2.6rem; line-height: 1.1; font-weight: 600; }
.green { border-color: #0b7a53; } .amber { border-color: #b06d00; } .red { border-color: #c2410c; }
.green .level { color: #0b7a53; } .amber .level { color: #8f5800; } .red .level { color: #c2410c; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; min-width: 32rem; background: white; border-radius: .3rem; }
figcaption { font-size: .9rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
td, th { text-align: left; padding: .25rem .7rem .25rem 0; white-space: nowrap; font-weight: normal; }
thead th { font-weight: 600; } td.text { white-space: normal; }
td.share { padding-left: .4rem; --shade: calc(100% * max(0, var(--share) - .5));
  background: color-mix(in srgb, #0b7a53 var(--shade), transparent); }
tr + tr, tbody tr { border-top: 1px solid var(--line); }
pre { overflow-x: auto; font-size: 13px; } summary { cursor: pointer; margin-top: 2rem; }
footer { border-top: 1px solid var(--line); margin-top: 2rem; padding-top: .6rem; font-size: .85rem; }
footer code { overflow-wrap: anywhere; }
@media (prefers-color-scheme: dark) {
  .green { border-color: #35c08a; } .amber { border-color: #e0a33a; } .red { border-color: #ff8a5c; }
  .green .level { color: #35c08a; } .amber .level { color: #e0a33a; } .red .level { color: #ff8a5c; }
  img { filter: invert(0.92) hue-rotate(180deg); }
}
@page { size: A4; margin: 14mm; }
@media print {
  .first { break-after: page; font-size: 9.5pt; line-height: 1.3; } .first img { max-height: 70mm; }
  .first h1, .first h2, .first figure { margin: 3mm 0 1mm; } .first li { margin: 0; }
  .first ul { margin: 0; } .first .number { font-size: 22pt; }
  body { max-width: none; margin: 0; font-size: 10.5pt; } img { filter: none; min-width: 0; }
  figure, .verdict, tr { break-inside: avoid; } h2 { break-after: avoid; } .wide { overflow: visible; }
  td, th { padding-right: .5rem; font-size: 8.5pt; }
}
</style></head><body><main>{body}</main><footer>{footer}</footer></body></html>
"""
