"""The paper's study: its three figures, their data, and its claims checked.

References
----------
Fuady, Tarapore, Ehsan, Soorati, "Collective Decision-Making on Task Allocation Feasibility", 2024.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from feasibee.figures.arena import plot_arena
from feasibee.figures.decisions import draw_opinion_panels, plot_decisions
from feasibee.figures.style import figure, save_both
from feasibee.files import atomic_write, make_folder, write_csv
from feasibee.model.codes import COLOURS, DECISIONS, MODEL_VERSION
from feasibee.model.record import Record
from feasibee.results.statistics import decision_times, opinion_quartiles
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm
from feasibee.studies.claims import Claim, RatioSummary, check_claims
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds

TASKS = (2, 3, 4, 5, 6, 8, 10, 13, 16, 18, 20, 22, 25, 31, 40, 50, 67, 80, 100, 133, 200)
"""Numbers of tasks for 20 robots: ratios from 10 to 0.1, mirrored to within 2 % (m m' = 400)."""

CONVERGING = (2, 4, 10, 200, 100, 40)
DIVERGING = (16, 20, 25)
SHOWN_STEPS = 400


def reproduce(
    out: str | Path, runs: int = 2000, seed: int = 0, execution: Execution | None = None
) -> list[Claim]:
    """Run the study, write figures and data into a folder, and return the claims.

    Parameters
    ----------
    out : path
        Folder; made if need be.
    runs : int
        Number of runs at each ratio; the paper has 100, which leave some claims open.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in a journal in ``out``.

    Returns
    -------
    list of Claim
        As in ``claims.json``.
    """
    Runs.of_point(0, runs, seed)  # raises before anything is computed
    folder = make_folder(out)
    points = run_study(runs, seed, execution or Execution(folder))
    return write_study(folder, points, seed)


def run_study(runs: int, seed: int, execution: Execution | None = None) -> list[RatioSummary]:
    """Simulate the swarm at each number of tasks; keep curves only where they are drawn or compared."""
    drawn = {*CONVERGING, *DIVERGING}
    with Rounds(execution, len(TASKS) * runs) as rounds:
        found: dict[int, RatioSummary] = {}
        for tasks, curves in ((sorted(drawn), True), (sorted({*TASKS} - drawn), False)):
            designs = [
                DesignPoint(
                    {"tasks.count": m}, Scenario(tasks={"count": m}), Runs.of_point(m, runs, seed).first
                )
                for m in tasks
            ]
            records = rounds.run(Study(designs, runs, seed, curves))
            found |= {m: _summary(m, record) for m, record in zip(tasks, records, strict=True)}
    return [found[tasks] for tasks in TASKS]


def _summary(tasks: int, record: Record) -> RatioSummary:
    robots = Scenario().robots.count
    has_curves = record.feasible_count.size > 0
    return RatioSummary(
        robots=robots,
        tasks=tasks,
        first_run=record.first_run,
        decision=record.decision,
        decision_step=record.decision_step,
        quartiles=opinion_quartiles(record.feasible_count, robots) if has_curves else np.empty((3, 0)),
        thinned=(record.feasible_count[:, ::25] * (100.0 / robots)).astype("float32"),
    )


def write_study(folder: Path, points: Sequence[RatioSummary], seed: int) -> list[Claim]:
    """Check the claims; write them, the figures and their data."""
    claims = check_claims(points, seed)
    swarm = Swarm(Scenario(), seed)
    _write_arena(folder, swarm)
    _write_opinions(folder, points)
    _write_decisions(folder, points)
    about = {
        "runs_per_ratio": points[0].runs,
        "seed": seed,
        "model_version": MODEL_VERSION,
        "robots": swarm.scenario.robots.count,
    }
    with atomic_write(folder / "claims.json") as path:
        path.write_text(json.dumps({**about, "claims": [asdict(claim) for claim in claims]}, indent=2) + "\n")
    return claims


def _write_arena(folder: Path, swarm: Swarm) -> None:
    with figure(3.6, 3.7) as (drawn, ax):
        plot_arena(swarm, ax)
    save_both(drawn, folder / "fig1_arena")
    places = [("robot", swarm.positions), ("task", swarm.tasks)]
    rows = [(kind, i, *place) for kind, group in places for i, place in enumerate(group.tolist(), start=1)]
    write_csv(folder / "fig1_arena.csv", ("kind", "number", "x", "y"), rows)


def _write_opinions(folder: Path, points: Sequence[RatioSummary]) -> None:
    by_tasks = {point.tasks: point for point in points}
    for name, chosen in (("fig2a_converging", CONVERGING), ("fig2b_diverging", DIVERGING)):
        bands = {f"n/m = {by_tasks[tasks].ratio:.3g}": by_tasks[tasks].quartiles for tasks in chosen}
        colours = [_colour(by_tasks[tasks].ratio) for tasks in chosen]
        drawn = draw_opinion_panels(bands, colours, SHOWN_STEPS)
        save_both(drawn, folder / name)
        rows = (
            (tasks, by_tasks[tasks].ratio, step, *values)
            for tasks in chosen
            for step, values in enumerate(by_tasks[tasks].quartiles.T.tolist())
        )
        write_csv(folder / f"{name}.csv", ("tasks", "ratio", "step", "q25", "median", "q75"), rows)


def _colour(ratio: float) -> str:
    """Return the colour of the truth at a ratio; black at 1, where both answers are near."""
    return "black" if ratio == 1 else COLOURS["feasible" if ratio > 1 else "infeasible"]


def _write_decisions(folder: Path, points: Sequence[RatioSummary]) -> None:
    rates = {name: [point.rate(code) for point in points] for code, name in DECISIONS.items()}
    with figure(4.6, 2.8) as (drawn, ax):
        plot_decisions([point.ratio for point in points], rates, ax)
    save_both(drawn, folder / "fig3_decisions")
    columns = [f"{name}{part}" for name in rates for part in ("", "_low", "_high")]
    rows = (
        (
            point.tasks,
            point.ratio,
            point.first_run,
            point.runs,
            *(value for intervals in rates.values() for value in intervals[row]),
            *("" if step is None else step for step in decision_times(point.decision_step)),
        )
        for row, point in enumerate(points)
    )
    header = ("tasks", "ratio", "first_run", "runs", *columns, "step_q25", "step_median", "step_q75")
    write_csv(folder / "fig3_decisions.csv", header, rows)
