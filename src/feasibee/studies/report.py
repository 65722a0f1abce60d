"""Write an assessment as a page of HTML."""

from __future__ import annotations

import base64
import html
import io
from pathlib import Path

from matplotlib.figure import Figure

from feasibee.figures.comparison import draw_against_bits, draw_against_time
from feasibee.files import atomic_write
from feasibee.studies.assessment import Assessment, html_table, paragraphs


def write_report(assessment: Assessment, path: Path) -> None:
    """Write an assessment as one HTML file that includes its figures."""
    chosen = [assessment.outcome, *(trial.outcome for trial in assessment.strategies)]
    totals = {each.contender: (float(each.bits.mean()), each.accuracy) for each in chosen}
    shares = {each.contender: each.right_at[None, :] / each.runs for each in chosen[:7]}
    figures = {
        "Share of right swarms at each step, unchanged and with the best strategies": (
            draw_against_time(shares)
        ),
        "Share of right swarms against bits on the air": draw_against_bits(totals),
    }
    body = "".join(f"<p>{html.escape(each)}</p>" for each in paragraphs(assessment))
    body += "".join(
        f"<figure>{_image(drawn)}<figcaption>{title}</figcaption></figure>"
        for title, drawn in figures.items()
    )
    body += "<h2>Strategies</h2>" + html_table(assessment.strategies)
    body += "<h2>Changes</h2>" + html_table(assessment.limits)
    body += f"<h2>Scenario</h2><pre>{html.escape(assessment.scenario.to_toml())}</pre>"
    text = PAGE.replace("{body}", body).replace("{hash}", assessment.scenario.hash[:12])
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _image(drawn: Figure) -> str:
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png", dpi=150)
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'


PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>feasibee: assessment</title><style>
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 52rem; margin: 2rem auto; padding: 0 1rem; }
img { max-width: 100%; background: white; } figure { margin: 1.5rem 0; }
table { border-collapse: collapse; width: 100%; } td, th { text-align: left; padding: .2rem .6rem; }
tr + tr { border-top: 1px solid color-mix(in srgb, currentColor 25%, transparent); }
pre { overflow-x: auto; font-size: 13px; }
</style></head><body><h1>Assessment of a swarm</h1>{body}<p>Scenario {hash}.</p></body></html>
"""
