"""The paper's study, whole: its three figures, the data behind them, and its claims checked.

References
----------
Fuady, Tarapore, Ehsan, Soorati, "Collective Decision-Making on Task Allocation Feasibility", 2024.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from matplotlib import colormaps

from feasibee.figures.arena import plot_arena
from feasibee.figures.decisions import draw_opinion_bands, plot_decisions
from feasibee.figures.style import figure, save_both
from feasibee.files import atomic_write, make_folder, write_csv
from feasibee.model.codes import DECISIONS, MODEL_VERSION
from feasibee.results.statistics import decision_times, opinion_quartiles
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.swarm import Swarm
from feasibee.studies.claims import Claim, Point, check_claims

TASKS = (2, 3, 4, 5, 6, 8, 10, 13, 16, 18, 20, 22, 25, 31, 40, 50, 67, 80, 100, 133, 200)
"""With 20 robots, ratios from 10 to 0.1 whose mirror images (m m' = 400) are there too, to within 2 %."""

CONVERGING = (2, 4, 10, 40, 100, 200)
DIVERGING = (16, 20, 25)
SHOWN_STEPS = 400


def reproduce(
    out: str | Path,
    runs: int = 2000,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Claim]:
    """Run the study, write figures and data into a folder, and return the claims.

    Parameters
    ----------
    out : path
        Folder; made if need be.
    runs : int
        Runs at each ratio; the paper has 100, which leave some claims open.
    seed : int
        64 bits.
    threads : int, optional
        By default one for each processor.
    progress : callable, optional
        Called with the share of the work done.

    Returns
    -------
    list of Claim
        As in ``claims.json``.
    """
    Runs.of_point(0, runs, seed)  # raises before anything is computed
    folder = make_folder(out)
    points = run_study(runs, seed, threads, progress)
    claims = check_claims(points, seed)
    swarm = Swarm(Scenario(), seed)
    _write_arena(folder, swarm)
    _write_opinions(folder, points)
    _write_decisions(folder, points)
    about = {
        "runs_per_ratio": runs,
        "seed": seed,
        "model_version": MODEL_VERSION,
        "robots": swarm.scenario.robots.count,
    }
    with atomic_write(folder / "claims.json") as path:
        path.write_text(json.dumps({**about, "claims": [asdict(claim) for claim in claims]}, indent=2) + "\n")
    return claims


def run_study(
    runs: int, seed: int, threads: int | None = None, progress: Callable[[float], None] | None = None
) -> list[Point]:
    """Simulate the swarm at each number of tasks."""
    points = []
    for done, tasks in enumerate(TASKS):
        scenario = Scenario(tasks={"count": tasks})
        share = None if progress is None else _part_of(progress, done, len(TASKS))
        record = simulate_record(
            scenario, Runs.of_point(tasks, runs, seed), curves=True, threads=threads, progress=share
        )
        robots = scenario.robots.count
        quartiles = opinion_quartiles(record.feasible_count, robots)
        thinned = (record.feasible_count[:, ::25] * (100.0 / robots)).astype("float32")
        points.append(
            Point(robots, tasks, record.first_run, record.decision, record.decision_step, quartiles, thinned)
        )
    return points


def _part_of(progress: Callable[[float], None], done: int, parts: int) -> Callable[[float], None]:
    return lambda share: progress((done + share) / parts)


def _write_arena(folder: Path, swarm: Swarm) -> None:
    with figure(3.6, 3.7) as (drawn, ax):
        plot_arena(swarm, ax)
    save_both(drawn, folder / "fig1_arena")
    places = [("robot", swarm.positions), ("task", swarm.tasks)]
    rows = [(kind, i, *place) for kind, group in places for i, place in enumerate(group.tolist(), start=1)]
    write_csv(folder / "fig1_arena.csv", ("kind", "number", "x", "y"), rows)


def _write_opinions(folder: Path, points: Sequence[Point]) -> None:
    by_tasks = {point.tasks: point for point in points}
    for name, chosen in (("fig2a_converging", CONVERGING), ("fig2b_diverging", DIVERGING)):
        bands = {f"{by_tasks[tasks].ratio:.3g}": by_tasks[tasks].quartiles for tasks in chosen}
        with figure(4.2, 2.7) as (drawn, ax):
            draw_opinion_bands(bands, ax, SHOWN_STEPS, [_shade(by_tasks[tasks].ratio) for tasks in chosen])
            ax.legend(title="ratio n/m", loc="center left", bbox_to_anchor=(1.0, 0.5))
        save_both(drawn, folder / name)
        rows = (
            (tasks, by_tasks[tasks].ratio, step, *values)
            for tasks in chosen
            for step, values in enumerate(by_tasks[tasks].quartiles.T.tolist())
        )
        write_csv(folder / f"{name}.csv", ("tasks", "ratio", "step", "q25", "median", "q75"), rows)


def _shade(ratio: float) -> tuple[float, float, float]:
    """Return blue for ratios above 1, red for those below, darker the farther from 1; black at 1."""
    if ratio == 1:
        return (0.0, 0.0, 0.0)
    colours = colormaps["Blues" if ratio > 1 else "Oranges"]
    red, green, blue, _ = colours(0.45 + 0.5 * min(1.0, abs(math.log10(ratio))))
    return (red, green, blue)


def _write_decisions(folder: Path, points: Sequence[Point]) -> None:
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
