"""Assessments of swarms, as notebooks show them."""

from __future__ import annotations

from dataclasses import dataclass

from feasibee.scenario.html import folded, framed
from feasibee.studies.advice import sections
from feasibee.studies.findings import Findings
from feasibee.studies.markup import section_as_html, table_of


@dataclass(frozen=True)
class Assessment(Findings):
    """What an assessment found, with its words and tables in notebooks.

    Its fields are those of `feasibee.studies.findings.Findings`.
    """

    def _repr_html_(self) -> str:
        """Return the assessment as HTML, for notebooks."""
        tables = {"Strategies": self.strategies, "Changes": self.limits, "Faults": self.faults}
        parts = [section_as_html(each) for each in sections(self)]
        parts += [folded(name, table_of(name, trials)) for name, trials in tables.items()]
        return framed("".join(parts) + folded("Scenario", self.scenario._repr_html_()))
