"""The text of a sweep's figure in a paper: a caption, and a paragraph on methods with all that repeats it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version

from feasibee.results.measures import MEASURES
from feasibee.scenario.comments import meaning_of
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import symbol_of
from feasibee.sweeps.table import Summary, leaves, value_of


def text_of(
    points: Sequence[Summary],
    axes: Sequence[str],
    varying: Sequence[str],
    show: str,
    over: Sequence[str],
    about: Mapping[str, str],
) -> str:
    """Return the caption of a sweep's figure, its methods, and a line for each point.

    ``axes`` are the fields that the figure shows, that of the horizontal axis first; ``varying`` all fields
    that the sweep varies; ``over`` those over which the measure ``show`` is averaged. ``about`` has versions.
    """
    caption, methods = _caption(axes, show, over), _methods(points, varying, about)
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
