"""The files of a comparison: its figures, and a table with a row per contender and number of tasks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from feasibee.figures.comparison import draw_against_bits, draw_against_ratio, draw_against_time
from feasibee.figures.responding import draw_service
from feasibee.figures.style import looks, save_both
from feasibee.figures.tracking import Tracked, draw_delay_against_bits, draw_right_over_time
from feasibee.files import write_csv
from feasibee.results.measures import Declarations, Tracking
from feasibee.results.responding import Judgement
from feasibee.results.statistics import decision_times
from feasibee.studies.comparison import Outcome, by_contender, declared_of, difference, mean_bits, overall


def write_comparison(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write ``compare.csv`` and its figures into a folder, as PNG and PDF.

    In a world that changes, the figures are those of `tracking_figures`, for each number of tasks. In others,
    they show accuracy by ratio, by step and by bits, and declarations if robots declare.
    """
    if outcomes[0].tracking is None:
        figures = _figures(by_contender(outcomes))
    else:
        figures = _figures_by_tasks(outcomes)
    for name, drawn in figures.items():
        save_both(drawn, folder / name)
    _write_rows(folder / "compare.csv", outcomes)


def _figures_by_tasks(outcomes: Sequence[Outcome]) -> dict[str, Figure]:
    """Return the figures of a world that changes, for each number of tasks."""
    numbers = list(dict.fromkeys(each.tasks for each in outcomes))
    figures: dict[str, Figure] = {}
    for number in numbers:
        same = {each.contender: each for each in outcomes if each.tasks == number}
        suffix = f"_{number}" if len(numbers) > 1 else ""
        figures |= {f"compare_{name}{suffix}": drawn for name, drawn in tracking_figures(same).items()}
    return figures


def tracking_figures(same: Mapping[str, Outcome]) -> dict[str, Figure]:
    """Return figures of contenders in one world that changes: right swarms by step and by bits, and delay."""
    tracked = {name: each.tracking for name, each in same.items() if each.tracking is not None}
    bits = {name: float(each.bits.mean()) for name, each in same.items()}
    before = looks({name: each.right_share.estimate for name, each in tracked.items()})
    some = next(iter(same.values()))
    judged = {name: each.judgement for name, each in same.items() if each.judgement is not None}
    return {
        **({"asking": draw_service(judged, before=before)} if judged else {}),
        "time": draw_right_over_time(
            {name: each.right_at / each.runs for name, each in same.items()},
            some.infeasible_at,
            before=before,
        ),
        "bits": draw_against_bits(
            {name: (bits[name], each.right_share) for name, each in tracked.items()},
            "steps at which swarms are right (%)",
            before=before,
        ),
        "delay": draw_delay_against_bits(
            {name: Tracked(bits[name], each.detection_delay) for name, each in tracked.items()},
            some.right_at.size - 1,
            before=before,
        ),
    }


def _figures(groups: Mapping[str, Sequence[Outcome]]) -> dict[str, Figure]:
    """Return the figures of a world that doesn't change: a fourth if robots declare."""
    some = next(iter(groups.values()))
    labels = [f"{each.robots / each.tasks:.3g}" if each.tasks else "no task" for each in some]
    numbers = [each.tasks for each in some]
    accuracies = {name: [each.accuracy for each in group] for name, group in groups.items()}
    shares = {name: np.array([each.right_at / each.runs for each in group]) for name, group in groups.items()}
    totals = {name: (mean_bits(group), overall(group)) for name, group in groups.items()}
    before = looks({name: share.estimate for name, (_, share) in totals.items()})
    figures = {
        "compare_ratio": draw_against_ratio(labels, numbers, accuracies, before=before),
        "compare_time": draw_against_time(shares, before=before),
        "compare_bits": draw_against_bits(
            totals, "swarms that are right at the end,\nover all ratios (%)", before=before
        ),
    }
    declared = {name: declared_of(group) for name, group in groups.items()}
    if any(declared.values()):
        figures["compare_declared"] = draw_against_ratio(
            labels,
            numbers,
            {name: [each.ok for each in group] or None for name, group in declared.items()},
            "swarms that declared rightly (%)",
            {name: [each.wrong for each in group] for name, group in declared.items()},
            before=before,
        )
    return figures


def _write_rows(path: Path, outcomes: Sequence[Outcome]) -> None:
    baseline = {each.tasks: each for each in outcomes if each.contender == outcomes[0].contender}
    header = ["contender", "robots", "tasks", "truth", "runs"]
    for name in ("accuracy", "first_decision", f"difference_from_{outcomes[0].contender}"):
        header += [name, f"{name}_low", f"{name}_high"]
    header += ["step_q25", "step_median", "step_q75", "bits_per_robot_and_step"]
    header += ["committed", "committed_wrong", "commit_step_median"]
    for name in ("declared_ok", "declared_wrong"):
        header += [name, f"{name}_low", f"{name}_high"]
    header += ["declare_step_median", "declare_step_p95"]
    if outcomes[0].tracking is not None:
        header += ["right_share", "right_share_low", "right_share_high"]
        header += ["detection_delay_q25", "detection_delay_median", "detection_delay_q75"]
        header += ["missed", "missed_low", "missed_high", "changes"]
        header += ["false_alarms", "false_alarms_low", "false_alarms_high"]
    if outcomes[0].judgement is not None:
        header += _service_header("") + _service_header("oracle_")
        header += ["fixed_robots", *_service_header("fixed_")]
    write_csv(path, header, (_row(each, baseline[each.tasks]) for each in outcomes))


def _row(each: Outcome, baseline: Outcome) -> list[object]:
    numbers = (*each.times, each.bits.mean(), each.committed.mean(), each.committed_wrong.mean())
    return [
        *(each.contender, each.robots, each.tasks),
        "feasible" if each.feasible else "infeasible",
        each.runs,
        *each.accuracy,
        *each.first,
        *difference(each, baseline),
        *("" if value is None else f"{value:.6g}" for value in numbers),
        *("" if step is None else step for step in decision_times(each.commit_step)[1:2]),
        *_declared_cells(each.declared),
        *([] if each.tracking is None else _tracking_cells(each.tracking)),
        *([] if each.judgement is None else _judgement_cells(each.judgement)),
    ]


def _service_header(whose: str) -> list[str]:
    names = [f"{name}{end}" for name in ("feasible_share", "idle", "calls") for end in ("", "_low", "_high")]
    return [f"{whose}{name}" for name in (*names, "too_many_per_call", "too_few_per_call")]


def _judgement_cells(found: Judgement) -> list[object]:
    cells: list[list[object]] = [
        [*each.feasible_share, *each.idle, *each.calls, each.too_many, each.too_few]
        for each in (found.own, found.oracle, found.as_often)
    ]
    return [*cells[0], *cells[1], found.robots, *cells[2]]


def _declared_cells(declared: Declarations | None) -> list[object]:
    if declared is None:
        return [""] * 8
    steps = declared.step_90[:2]
    return [*declared.ok, *declared.wrong, *("" if step is None else step for step in steps)]


def _tracking_cells(found: Tracking) -> list[object]:
    missed: Sequence[object] = found.missed or ("", "", "")
    delays = ("" if step is None else step for step in found.detection_delay)
    return [*found.right_share, *delays, *missed, found.changes, *found.false_alarms]
