"""Parts of an assessment as HTML, for its page and for notebooks: sections and tables."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping, Sequence

from feasibee.studies.advice import Section
from feasibee.studies.findings import Trial
from feasibee.studies.shares import percent, points


def section_as_html(section: Section) -> str:
    """Return a section as a heading and a list."""
    lines = "".join(f"<li>{html.escape(line).replace(' %', '&nbsp;%')}</li>" for line in section.lines)
    return f"<h2>{html.escape(section.title)}</h2><ul>{lines}</ul>"


def table_of(title: str, trials: Sequence[Trial]) -> str:
    """Return trials as a table in HTML that scrolls where it is too wide."""
    if not trials:
        return ""
    turned = {trial.opposite.tasks for trial in trials if trial.opposite}
    columns: dict[str, Callable[[Trial], str]] = {
        "right at the end" if trials[0].outcome.tracking is None else "right in the steps": lambda trial: (
            percent(trial.outcome.judged)
        ),
        "difference": lambda trial: points(trial.difference),
        **{f"right with {tasks} tasks": _opposite_share for tasks in turned},
        "bits": lambda trial: f"{trial.outcome.bits.mean():.3g}",
    }
    head = "".join(f'<th scope="col">{name}</th>' for name in ("", *columns))
    rows = "".join(
        f'<tr><th scope="row">{html.escape(trial.name)}</th>'
        f"{''.join(f'<td>{shown(trial)}</td>' for shown in columns.values())}</tr>"
        for trial in trials
    )
    return _framed(title, f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>")


def excluded_as_html(excluded: Mapping[str, str]) -> str:
    """Return why strategies aren't recommended, as a table in HTML."""
    rows = "".join(
        f'<tr><th scope="row">{html.escape(name)}</th><td class="text">{html.escape(why)}</td></tr>'
        for name, why in excluded.items()
    )
    return _framed("Not recommended", f"<table><tbody>{rows}</tbody></table>") if rows else ""


def _framed(title: str, table: str) -> str:
    label = html.escape(title, quote=True)
    return f'<h2>{label}</h2><div class="wide" tabindex="0" role="region" aria-label="{label}">{table}</div>'


def _opposite_share(trial: Trial) -> str:
    return percent(trial.opposite.accuracy) if trial.opposite else ""
