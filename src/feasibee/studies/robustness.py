"""What changes beyond the paper: its Fig. 3 again, in worlds nearer to those of robots at work."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from feasibee.figures.decisions import Panel, draw_panels
from feasibee.figures.style import save_both
from feasibee.files import make_folder, write_csv
from feasibee.results.statistics import DecisionTimes, Interval, accuracy, decision_rates, decision_times
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import simulate_record

PLACES = (2, 4, 8, 10, 13, 16, 20, 25, 31, 40, 50, 100, 200)
"""How many robots the tasks ask for, of 20: ratios from 10 to 0.1, mirrored to within 2 % (m m' = 400)."""

BASELINE, MIXED = "as in the paper", "mixed team"
WORLDS: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    BASELINE: {},
    "walls and collisions": {"arena": {"boundary": "walls"}, "robots": {"avoid_collisions": True}},
    "unique observation": {"sensing": {"observation": "unique"}},
    "10 % message loss": {"radio": {"loss": 0.1}},
    "10 % Byzantine": {"faults": {"byzantine": 0.1}},
    "both clustered": {"robots": {"placement": "clusters"}, "tasks": {"placement": "clusters"}},
    "robots in a corner": {"robots": {"placement": "corner"}},
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
"""What differs from the paper, by panel."""


@dataclass(frozen=True)
class Row:
    """What the swarms of one panel decide at one ratio.

    Parameters
    ----------
    panel : str
        Name of the panel, a key of `WORLDS`.
    robots, places : int
        Number of robots, and how many the tasks ask for.
    first_run, runs : int
        Number of the first run, and how many there are.
    truth : bool
        Whether the tasks are feasible.
    rates : mapping of str to Interval
        Shares of the runs by decision.
    accuracy : Interval
        Share of the runs that decide as the truth.
    times : DecisionTimes
        By when a quarter, half and three quarters of the runs had decided.
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
    out: str | Path,
    runs: int = 2000,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Row]:
    """Run the study, write ``beyond.png``, ``.pdf`` and ``.csv`` into a folder, and return the rows.

    Parameters
    ----------
    out : path
        Folder; made if need be.
    runs : int
        Runs at each ratio of each panel.
    seed : int
        64 bits.
    threads : int, optional
        By default one for each processor.
    progress : callable, optional
        Called with the share of the work done.

    Returns
    -------
    list of Row
        Panel by panel, from the fewest places to the most.
    """
    Runs.of_point(0, runs, seed)  # raises before anything is computed
    folder = make_folder(out)
    rows = []
    for panel in WORLDS:
        for places in PLACES:
            rows.append(_simulate(panel, places, runs, seed, threads))
            if progress is not None:
                progress(len(rows) / (len(WORLDS) * len(PLACES)))
    drawn = draw_panels([_panel(panel, [row for row in rows if row.panel == panel]) for panel in WORLDS])
    save_both(drawn, folder / "beyond")
    _write_rows(folder / "beyond.csv", rows)
    return rows


def summary(rows: Sequence[Row]) -> list[list[str]]:
    """Return a short table: a header, then for each panel its accuracy at some ratios and its usual step."""
    shown = (2, 10, 40, 200)
    ratios = [f"at {row.ratio:g}" for row in rows if row.panel == BASELINE and row.places in shown]
    table = [["panel", *ratios, "half by (at 2)"]]
    for panel in WORLDS:
        chosen = [row for row in rows if row.panel == panel and row.places in shown]
        step = chosen[1].times.median
        shares = (f"{row.accuracy.estimate:.1%}" for row in chosen)
        table.append([panel, *shares, "not reached" if step is None else f"step {step}"])
    return table


def world(panel: str, places: int) -> Scenario:
    """Return the scenario of a panel whose tasks ask for so many robots."""
    tables = {name: dict(table) for name, table in WORLDS[panel].items()}
    tasks = _mixed_tasks(places) if panel == MIXED else {"count": places}
    tables["tasks"] = {**tables.get("tasks", {}), **tasks}
    tables["run"] = {"stop_at_decision": True}
    return Scenario.model_validate(tables)


def _mixed_tasks(places: int) -> dict[str, Any]:
    """Return tasks of which about three places in five are with a load that two lift and one scans."""
    carries = (2 * places + 5) // 10
    return {
        "classes": [
            {"name": "carry", "count": carries, "needs": {"lift": 2, "scan": 1}},
            {"name": "survey", "count": places - 3 * carries, "needs": {"scan": 1}},
        ]
    }


def _simulate(panel: str, places: int, runs: int, seed: int, threads: int | None) -> Row:
    scenario = world(panel, places)
    record = simulate_record(scenario, Runs.of_point(places, runs, seed), threads=threads)
    feasible = truth(scenario)
    return Row(
        panel,
        scenario.robots.count,
        places,
        record.first_run,
        runs,
        feasible,
        decision_rates(record.decision),
        accuracy(record.decision, feasible),
        decision_times(record.decision_step),
    )


def _panel(title: str, rows: Sequence[Row]) -> Panel:
    last = max(row.places for row in rows if row.truth)
    first = min(row.places for row in rows if not row.truth)
    rates = {name: [row.rates[name] for row in rows] for name in rows[0].rates}
    tip = rows[0].robots / (last * first) ** 0.5
    return Panel(title, [row.ratio for row in rows], rates, tip)


def _write_rows(path: Path, rows: Sequence[Row]) -> None:
    rates = [f"{name}{part}" for name in rows[0].rates for part in ("", "_low", "_high")]
    header = ["panel", "robots", "places", "ratio", "first_run", "runs", "truth", *rates]
    header += ["accuracy", "accuracy_low", "accuracy_high", "step_q25", "step_median", "step_q75"]
    lines = (
        [
            *(row.panel, row.robots, row.places, row.ratio, row.first_run, row.runs),
            "feasible" if row.truth else "infeasible",
            *(value for interval in row.rates.values() for value in interval),
            *row.accuracy,
            *("" if step is None else step for step in row.times),
        ]
        for row in rows
    )
    write_csv(path, header, lines)
