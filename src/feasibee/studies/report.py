"""Write an assessment as a page of HTML."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from feasibee.figures.comparison import draw_against_bits, draw_against_time
from feasibee.figures.sizing import draw_sizing
from feasibee.files import atomic_write
from feasibee.model.codes import MODEL_VERSION
from feasibee.scenario.units import steps_in_words
from feasibee.studies.advice import WORDS, sections
from feasibee.studies.comparison_files import tracking_figures
from feasibee.studies.findings import SIGNS, Findings
from feasibee.studies.markup import excluded_as_html, section_as_html, table_of
from feasibee.studies.shares import percent
from feasibee.studies.sizing import panels_of, sentences

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


def write_report(assessment: Findings, path: Path, command: str = "feasibee.studies.assess") -> None:
    """Write an assessment as one HTML file that includes its figures.

    Parameters
    ----------
    assessment : Findings
        What to write.
    path : Path
        The file.
    command : str
        The command that made it, for the footer.
    """
    _, *others = sections(assessment)
    body = _verdict(assessment) + "".join(map(section_as_html, others))
    body += "".join(map(_figure, _figures(assessment)))
    body += table_of("Strategies", assessment.strategies) + table_of("Changes", assessment.limits)
    body += table_of("Faults", assessment.faults) + excluded_as_html(assessment.recommendation.excluded)
    written = html.escape(assessment.scenario.to_toml())
    body += f"<details><summary>Scenario</summary><pre>{written}</pre></details>"
    text = PAGE.replace("{body}", body).replace("{footer}", _footer(assessment, command))
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _verdict(assessment: Findings) -> str:
    level, right, tasks = assessment.verdict
    colour, shape = SIGNS[level]
    middle, low, high = (100 * value for value in right)
    scenario, target = assessment.scenario, 100 * assessment.target
    steps = steps_in_words(scenario, scenario.run.steps)
    world = f"{scenario.robots.count} robots, {tasks} tasks"
    what = (
        f"of the swarms are right after {steps} ({world})"
        if assessment.outcome.tracking is None
        else f"of {steps}, these swarms are right ({world} before any change)"
    )
    return (
        f'<section class="verdict {colour}"><p class="level"><span aria-hidden="true">{shape}</span> '
        f'{WORDS[level]}</p><p class="number">{middle:.1f} %</p>'
        f"<p>{what}. 95 % interval: {low:.1f} to {high:.1f} %. Asked for: {target:g} %.</p></section>"
    )


def _figures(assessment: Findings) -> Iterator[Shown]:
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
        **{trial.name: trial.outcome for trial in assessment.strategies},
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
    totals = {name: (float(each.bits.mean()), each.accuracy) for name, each in outcomes.items()}
    yield Shown(
        "Share of right swarms against bits on the air",
        _best_in_words(assessment),
        draw_against_bits(totals, keep=keep),
    )


def _best_in_words(assessment: Findings) -> str:
    """Return the shares at the end of this swarm and of the best other strategies, in words."""
    best = [f"{trial.name} {percent(trial.outcome.judged)}" for trial in assessment.strategies[:4]]
    when = "At the end" if assessment.outcome.tracking is None else "Of the steps"
    return f"{when}: {OWN} {percent(assessment.outcome.judged)}; {'; '.join(best)}."


def _figure(shown: Shown) -> str:
    buffer = io.BytesIO()
    shown.drawn.savefig(buffer, format="png", dpi=150)
    data = base64.b64encode(buffer.getvalue()).decode()
    alt = html.escape(f"{shown.title}. {shown.text}", quote=True)
    return (
        f'<figure><div class="wide"><img alt="{alt}" src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{html.escape(shown.title)}</figcaption></figure>"
    )


def _footer(assessment: Findings, command: str) -> str:
    parts = (
        f"<code>{html.escape(command)}</code>",
        f"scenario {assessment.scenario.hash[:12]}",
        f"seed {assessment.seed}",
        f"{assessment.outcome.runs} runs of each variant",
        f"feasibee {version('feasibee')}, model {MODEL_VERSION}",
        f"{datetime.now(UTC):%Y-%m-%d}",
    )
    return "; ".join(parts)


PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>feasibee: assessment</title><style>
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
tr + tr, tbody tr { border-top: 1px solid var(--line); }
pre { overflow-x: auto; font-size: 13px; } summary { cursor: pointer; margin-top: 2rem; }
footer { border-top: 1px solid var(--line); margin-top: 2rem; padding-top: .6rem; font-size: .85rem; }
footer code { overflow-wrap: anywhere; }
@media (prefers-color-scheme: dark) {
  .green { border-color: #35c08a; } .amber { border-color: #e0a33a; } .red { border-color: #ff8a5c; }
  .green .level { color: #35c08a; } .amber .level { color: #e0a33a; } .red .level { color: #ff8a5c; }
  img { filter: invert(0.92) hue-rotate(180deg); }
}
@media print {
  body { max-width: none; margin: 0; font-size: 10.5pt; } img { filter: none; min-width: 0; }
  figure, .verdict, tr { break-inside: avoid; } h2 { break-after: avoid; } .wide { overflow: visible; }
  td, th { padding-right: .5rem; font-size: 8.5pt; }
}
</style></head><body><main><h1>Assessment of a swarm</h1>{body}</main><footer>{footer}</footer></body></html>
"""
