"""The tables of a run's outcomes and of measures, from the package's own, so that they can't go stale."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from feasibee.base.outcomes import CURVES, OUTCOMES, TRACES
from feasibee.results.measures import MEASURES


class Outcomes(SphinxDirective):
    """All outcomes, a row for each."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        return self.parse_text_to_nodes("\n".join(lines()))


def lines() -> Iterator[str]:
    """Yield the table in the markup of the page that asks for it (MyST)."""
    yield from ("| outcome | per | type | unit | what it is |", "|---|---|---|---|---|")
    for per, outcomes in (("run", OUTCOMES), ("run, step", CURVES), ("run, step", TRACES)):
        for each in outcomes:
            needs = f"; only with {each.needs.words}" if each.needs else ""
            yield f"| `{each.name}` | {per} | {each.dtype} | {each.unit or 'code'} | {each.meaning}{needs} |"


class Measures(SphinxDirective):
    """All measures, a row for each."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        rows = ["| measure | unit | what it is |", "|---|---|---|"]
        for each in MEASURES.values():
            needs = f"; only with {each.needs.words}" if each.needs else ""
            rows.append(f"| `{each.name}` | {each.unit} | {each.words}{needs} |")
        return self.parse_text_to_nodes("\n".join(rows))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("outcomes", Outcomes)
    app.add_directive("measures", Measures)
    return {"parallel_read_safe": True}
