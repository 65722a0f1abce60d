"""Robustness: the paper's Fig. 3 in six worlds closer to those of robots at work."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from feasibee.figures.decisions import Panel, draw_panels
from feasibee.figures.style import save_both
from feasibee.files import make_folder, write_csv
from feasibee.model.record import Record
from feasibee.results.statistics import DecisionTimes, Interval, accuracy, decision_rates, decision_times
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds

PLACES = (2, 4, 8, 10, 13, 16, 20, 25, 31, 40, 50, 100, 200)
"""Numbers of robots that the tasks need; with 20 robots, ratios from 10 to 0.1, mirrored to within 2 %."""

BASELINE, MIXED = "as in the paper", "mixed team"
WORLDS: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    BASELINE: {},
    "walls and collisions": {"arena": {"boundary": "walls"}, "robots": {"avoid_collisions": True}},
    "unique observation": {"sensing": {"observation": "unique"}},
    "10 % message loss": {"radio": {"loss": 0.1}},
    "10 % Byzantine": {"faults": {"byzantine": 0.1}},
    "both clustered": {"robots": {"placement": "clusters"}, "tasks": {"placement": "clusters"}},
    MIXED: {
        "robots": {
            "classes": [
                {"name": "lifter", "count": 2, "skills": ["lift"]},
                {"name": "scout", "count": 16, "skills": ["scan"]},
                {"name": "all-rounder", "count": 2, "skills": ["lift", "scan"]},
            ]
        }
    },
}
"""Values that differ from the paper's, by panel."""


@dataclass(frozen=True)
class PanelPoint:
    """Decisions of the swarms of one panel at one ratio.

    Parameters
    ----------
    panel : str
        Name of the panel, a key of `WORLDS`.
    robots, places : int
        Number of robots, and number of robots that the tasks need.
    first_run, runs : int
        Number of the first run, and number of runs.
    truth : bool
        Whether the tasks are feasible.
    rates : mapping of str to Interval
        Shares of the runs by decision.
    accuracy : Interval
        Share of the runs whose decision is the truth.
    times : DecisionTimes
        Steps by which a quarter, half and three quarters of the runs had decided.
    """

    panel: str
    robots: int
    places: int
    first_run: int
    runs: int
    truth: bool
    rates: Mapping[str, Interval]
    accuracy: Interval
    times: DecisionTimes

    @property
    def ratio(self) -> float:
        """Robots per place."""
        return self.robots / self.places


def reproduce_beyond(
    out: str | Path, runs: int = 2000, seed: int = 0, execution: Execution | None = None
) -> list[PanelPoint]:
    """Run the study, write ``beyond.png``, ``.pdf`` and ``.csv`` into a folder, and return what they show.

    Parameters
    ----------
    out : path
        Folder; made if need be.
    runs : int
        Number of runs at each ratio of each panel.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in a journal in ``out``.

    Returns
    -------
    list of PanelPoint
        Panel by panel, from the fewest places to the most.
    """
    Runs.of_point(0, runs, seed)  # raises before anything is computed
    folder = make_folder(out)
    points = simulate_panels(runs, seed, execution or Execution(folder))
    write_panels(folder, points)
    return points


def simulate_panels(runs: int, seed: int, execution: Execution | None = None) -> list[PanelPoint]:
    """Simulate all panels; see `reproduce_beyond`."""
    designs = [
        DesignPoint(
            {"panel": panel, "places": places},
            world(panel, places),
            Runs.of_point(places, runs, seed).first,
        )
        for panel in WORLDS
        for places in PLACES
    ]
    with Rounds(execution, len(designs) * runs) as rounds:
        records = rounds.run(Study(designs, runs, seed))
        return [_panel_point(design, record) for design, record in zip(designs, records, strict=True)]


def write_panels(folder: Path, points: Sequence[PanelPoint]) -> None:
    """Write the figure as PNG and PDF, and its data as CSV."""
    drawn = draw_panels(
        [_panel(panel, [point for point in points if point.panel == panel]) for panel in WORLDS]
    )
    save_both(drawn, folder / "beyond")
    _write_rows(folder / "beyond.csv", points)


def summary(points: Sequence[PanelPoint]) -> list[list[str]]:
    """Return a short table: each panel's accuracy at four ratios, and its median decision step at ratio 2."""
    shown = (2, 10, 40, 200)
    ratios = [f"at {point.ratio:g}" for point in points if point.panel == BASELINE and point.places in shown]
    table = [["panel", *ratios, "half by (at 2)"]]
    for panel in WORLDS:
        chosen = [point for point in points if point.panel == panel and point.places in shown]
        step = chosen[1].times.median
        shares = (f"{point.accuracy.estimate:.1%}" for point in chosen)
        table.append([panel, *shares, "not reached" if step is None else f"step {step}"])
    return table


def world(panel: str, places: int) -> Scenario:
    """Return the scenario of a panel whose tasks need so many robots."""
    tables = {name: dict(table) for name, table in WORLDS[panel].items()}
    tasks = _mixed_tasks(places) if panel == MIXED else {"count": places}
    tables["tasks"] = {**tables.get("tasks", {}), **tasks}
    tables["run"] = {"stop_at_decision": True}
    return Scenario.model_validate(tables)


def _mixed_tasks(places: int) -> dict[str, Any]:
    """Return tasks of which about three places in five are at a load that two robots lift and one scans."""
    carries = (2 * places + 5) // 10
    return {
        "classes": [
            {"name": "carry", "count": carries, "needs": {"lift": 2, "scan": 1}},
            {"name": "survey", "count": places - 3 * carries, "needs": {"scan": 1}},
        ]
    }


def _panel_point(design: DesignPoint, record: Record) -> PanelPoint:
    feasible = truth(design.scenario)
    return PanelPoint(
        panel=design.values["panel"],
        robots=design.scenario.robots.count,
        places=design.values["places"],
        first_run=record.first_run,
        runs=record.runs,
        truth=feasible,
        rates=decision_rates(record.decision),
        accuracy=accuracy(record.decision, feasible),
        times=decision_times(record.decision_step),
    )


def _panel(title: str, points: Sequence[PanelPoint]) -> Panel:
    last = max(point.places for point in points if point.truth)
    first = min(point.places for point in points if not point.truth)
    rates = {name: [point.rates[name] for point in points] for name in points[0].rates}
    tip = points[0].robots / (last * first) ** 0.5
    return Panel(title, [point.ratio for point in points], rates, tip)


def _write_rows(path: Path, points: Sequence[PanelPoint]) -> None:
    rates = [f"{name}{part}" for name in points[0].rates for part in ("", "_low", "_high")]
    header = ["panel", "robots", "places", "ratio", "first_run", "runs", "truth", *rates]
    header += ["accuracy", "accuracy_low", "accuracy_high", "step_q25", "step_median", "step_q75"]
    lines = (
        [
            *(point.panel, point.robots, point.places, point.ratio, point.first_run, point.runs),
            "feasible" if point.truth else "infeasible",
            *(value for interval in point.rates.values() for value in interval),
            *point.accuracy,
            *("" if step is None else step for step in point.times),
        ]
        for point in points
    )
    write_csv(path, header, lines)
