"""A sweep's figure: what it shows, which its file says, and its text in a paper.

That text is a caption, and a paragraph on methods with all that repeats the figure.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from feasibee.errors import FeasibeeError
from feasibee.model.outcomes import ACTS, CHANGES
from feasibee.results.measures import MEASURES
from feasibee.scenario.comments import meaning_of
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import outside, symbol_of
from feasibee.sweeps.table import (
    Summary,
    leaves,
    pooled_fields,
    shares_by_cell,
    shares_by_line,
    value_of,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARK = "feasibee results plot "
"""What stands in a figure's file before the table of what it shows."""
WIDTHS = 2.0, 20.0
"""Least and largest width of a journal's column, in inches."""


class View(NamedTuple):
    """What a figure of a sweep shows."""

    x: str
    """Field along the horizontal axis."""
    hue: str | None
    """Field with one line per value."""
    y: str | None
    """Field along the vertical axis of a heat map."""
    show: str
    """Name of the measure."""
    journal: float
    """Width in inches of a journal's column; 0 for the default style."""

    @property
    def axes(self) -> list[str]:
        """The fields that it shows, that of the horizontal axis first."""
        return [field for field in (self.x, self.hue, self.y) if field]

    def drawable(self, found: Sequence[Summary], folder: Path) -> list[Summary]:
        """Return the points that have runs and the measure; raise an error without any."""
        points = [each for each in found if each.found.runs]
        if not points:
            raise FeasibeeError(f"{folder}: has no runs yet; run feasibee sweep first")
        needs = MEASURES[self.show].needs
        points = [each for each in points if needs is None or needs.is_met(each.row.scenario)]
        if not points:
            lacks = f"no robots of {folder} {'act' if needs is ACTS else 'declare'}"
            lacks = f"no world of {folder} changes" if needs is CHANGES else lacks
            raise FeasibeeError(f"--show {self.show}: {lacks}; use --show accuracy")
        return points

    def over(self, points: Sequence[Summary], varying: Sequence[str]) -> list[str]:
        """Return the fields over which the measure is averaged, of all that the sweep varies."""
        others = [field for field in varying if field not in self.axes]
        return pooled_fields([each.row for each in points], self.axes, others)

    def save(self, points: Sequence[Summary], over: Sequence[str], path: Path) -> None:
        """Draw the figure into a file, which says what it shows."""
        from feasibee.figures.style import JOURNAL, STYLE, save_figure

        made = MARK + json.dumps(self._asdict())
        save_figure(self._drawn(points, over), path, JOURNAL if self.journal else STYLE, made)

    def _drawn(self, points: Sequence[Summary], over: Sequence[str]) -> Figure:
        from feasibee.figures.sweep import draw_lines, draw_map

        titled = () if self.journal else over  # the caption says it
        x, hue, y, show, journal = self
        scenario, *others = (each.row.scenario for each in points)
        alike = scenario if all(each.units == scenario.units for each in others) else Scenario()
        axes = {path: outside(alike, dimension_of(path)) for path in self.axes}
        units = {path: unit for path, (unit, _) in axes.items()}
        sizes = {path: size for path, (_, size) in axes.items()}
        if y:
            return draw_map(shares_by_cell(points, x, y, show, sizes), x, y, show, titled, journal, units)
        return draw_lines(shares_by_line(points, x, hue, show, sizes), x, hue, show, titled, journal, units)


def view_in(path: Path) -> View | None:
    """Return what the figure in a file shows; None if it isn't that of a sweep."""
    found = re.search(re.escape(MARK).encode() + rb"(\{[^{}]*\})", path.read_bytes())
    try:
        view = View(**json.loads(found[1])) if found else None
    except (TypeError, ValueError):
        return None
    return view if view is not None and _is_valid(view) else None


def _is_valid(view: View) -> bool:
    low, high = WIDTHS
    fields = isinstance(view.x, str) and all(isinstance(each, str | None) for each in (view.hue, view.y))
    width = isinstance(view.journal, float) and (view.journal == 0 or low <= view.journal <= high)
    return fields and width and isinstance(view.show, str) and view.show in MEASURES


def text_of(view: View, points: Sequence[Summary], varying: Sequence[str], about: Mapping[str, str]) -> str:
    """Return the caption of a sweep's figure, its methods, and a line for each point.

    ``varying`` are all fields that the sweep varies; ``about`` has versions.
    """
    caption = _caption(view.axes, view.show, view.over(points, varying))
    methods = _methods(points, varying, about)
    lines = [
        f"{', '.join(f'{path} = {value_of(row, path)}' for path in varying) or 'the only point'}: "
        f"{found.runs:,} runs, seed {row.seed}, scenario {row.hash}"
        for row, found in points
    ]
    return "\n".join(["Caption", "", caption, "", "Methods", "", methods, "", "Points", "", *lines, ""])


def _caption(axes: Sequence[str], show: str, over: Sequence[str]) -> str:
    measure, names = MEASURES[show], [symbol_of(path) for path in axes]
    shown = measure.label[0].upper() + measure.label[1:]
    parts = [
        f"{shown} against {' and '.join(names)}",
        f"Intervals: {measure.ends or '95 %'}",
        *(f"{name}: {meaning_of(path).rstrip('.')}" for name, path in zip(names, axes, strict=True)),
        *([f"Averaged over {', '.join(over)}"] if over else []),
    ]
    return "".join(f"{part}. " for part in parts).rstrip()


def _methods(points: Sequence[Summary], varying: Sequence[str], about: Mapping[str, str]) -> str:
    runs, seeds = [found.runs for _, found in points], sorted({row.seed for row, _ in points})
    each = f"{min(runs):,}" if min(runs) == max(runs) else f"{min(runs):,} to {max(runs):,}"
    fixed = ", ".join(f"{path} = {value}" for path, value in _fixed(points, varying))
    return (
        f"We simulated {sum(runs):,} runs with feasibee {about['version']} (model version "
        f"{about['model_version']}): {each} runs of each of {len(points)} points, with seed "
        f"{', '.join(map(str, seeds))}. Scenario, seed and number of a run determine all its results. Points "
        f"differ in {', '.join(varying) or 'nothing'}. All other fields of the scenario have the defaults of "
        f"feasibee{f', except {fixed}' if fixed else ''}. The figure was drawn with matplotlib "
        f"{version('matplotlib')}. The command `feasibee reproduce` simulates the runs again."
    )


def _fixed(points: Sequence[Summary], varying: Sequence[str]) -> Iterator[tuple[str, object]]:
    """Yield the fields that don't vary and differ from the default, with their values."""
    tables = [dict(leaves(row.scenario.to_dict())) for row, _ in points]
    usual = dict(leaves(Scenario().to_dict()))
    for path, value in tables[0].items():
        same = all(table.get(path) == value for table in tables)
        if same and path not in varying and value != usual.get(path):
            yield path, value
