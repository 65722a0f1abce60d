"""A sweep's figure: what it shows, which its file says, and its text in a paper.

That text is a caption, and a paragraph on methods with all that repeats the figure.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote, unquote

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError
from feasibee.base.outcomes import ACTS, CHANGES
from feasibee.figures.sweep import Shown, draw_lines, draw_maps
from feasibee.results.measures import MEASURES
from feasibee.scenario.comments import meaning_of
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import outside, symbol_of
from feasibee.simulation.table import (
    Summary,
    by_value,
    leaves,
    pooled_fields,
    shares_by_line,
    value_of,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARK = "feasibee results plot "
"""What stands in a figure's file before the table of what it shows."""
WIDTHS = 1.0, 20.0
"""Least and largest width and height of a figure, in inches."""
MOST_PANELS = 12
"""Largest number of panels of a figure."""


class View(Shown):
    """What a figure of a sweep shows, and how to draw it."""

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

        made = MARK + quote(json.dumps(self._asdict()), safe=":,")  # letters that all formats keep
        save_figure(self._drawn(points, over), path, JOURNAL if self.journal else STYLE, made)

    def _drawn(self, points: Sequence[Summary], over: Sequence[str]) -> Figure:
        titled = () if self.journal else over  # the caption says it
        scenario, *others = (each.row.scenario for each in points)
        alike = scenario if all(each.units == scenario.units for each in others) else Scenario()
        shown = {path: outside(alike, dimension_of(path)) for path in self.axes}
        sizes = {path: size for path, (_, size) in shown.items()}
        groups = by_value(points, self.facet, sizes)
        if len(groups) > MOST_PANELS:
            rule = f"has {len(groups)} values; must have at most {MOST_PANELS}; use --hue {self.facet}"
            raise FeasibeeError(f"--facet {self.facet}: {rule}, or sweep fewer values")
        rows = self.y or self.hue
        panels = {
            value: shares_by_line(each, self.x, rows, self.show, sizes) for value, each in groups.items()
        }
        units = {path: unit for path, (unit, _) in shown.items()}
        return (draw_maps if self.y else draw_lines)(panels, self, titled, units)


def view_in(path: Path) -> View | None:
    """Return what the figure in a file shows; None if it isn't that of a sweep."""
    found = re.search(re.escape(MARK).encode() + rb"([\w%:,.~-]+)", path.read_bytes())
    try:
        view = View(**json.loads(unquote(found[1].decode()))) if found else None
    except (TypeError, ValueError):
        return None
    return view if view is not None and _is_valid(view) else None


def _is_valid(view: View) -> bool:
    low, high = WIDTHS
    texts = view.show, *view.axes, view.title, view.xlabel, view.ylabel
    fields = all(isinstance(each, str) for each in texts) and isinstance(view.journal, bool)
    sizes = [each for each in (view.width, view.height) if each is not None]
    fits = all(isinstance(each, float) and low <= each <= high for each in sizes)
    return fields and fits and view.show in MEASURES


def text_of(view: View, points: Sequence[Summary], varying: Sequence[str], made_by: str) -> str:
    """Return the caption of a sweep's figure, its methods, and a line for each point.

    ``varying`` are all fields that the sweep varies; ``made_by`` is the version of feasibee.
    """
    caption = _caption(view.axes, view.show, view.over(points, varying))
    methods = _methods(points, varying, made_by)
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


def _methods(points: Sequence[Summary], varying: Sequence[str], made_by: str) -> str:
    runs, seeds = [found.runs for _, found in points], sorted({row.seed for row, _ in points})
    each = f"{min(runs):,}" if min(runs) == max(runs) else f"{min(runs):,} to {max(runs):,}"
    fixed = ", ".join(f"{path} = {value}" for path, value in _fixed(points, varying))
    return (
        f"We simulated {sum(runs):,} runs with feasibee {made_by} (model version "
        f"{MODEL_VERSION}): {each} runs of each of {len(points)} points, with seed "
        f"{', '.join(map(str, seeds))}. Scenario, seed and number of a run determine all its results. Points "
        f"differ in {', '.join(varying) or 'nothing'}. All other fields of the scenario have the defaults of "
        f"feasibee{f', except {fixed}' if fixed else ''}. The figure was drawn with matplotlib "
        f"{version('matplotlib')}. The command `feasibee run --again` simulates the runs again."
    )


def _fixed(points: Sequence[Summary], varying: Sequence[str]) -> Iterator[tuple[str, object]]:
    """Yield the fields that don't vary and differ from the default, with their values."""
    tables = [dict(leaves(row.scenario.to_dict())) for row, _ in points]
    usual = dict(leaves(Scenario().to_dict()))
    for path, value in tables[0].items():
        same = all(table.get(path) == value for table in tables)
        if same and path not in varying and value != usual.get(path):
            yield path, value
