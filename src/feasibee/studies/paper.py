"""The paper's study: its figures, its claims checked, and its Fig. 3 in worlds closer to robots at work.

The interval of a claim has 95 % confidence for the claim as a whole. A claim about several ratios gives each
its share of the error (Bonferroni). A claim holds if its whole interval lies on its side of the bar. It fails
if the whole interval lies on the other side. Otherwise there are too few runs to tell.

References
----------
Fuady, Tarapore, Ehsan, Soorati, "Collective Decision-Making on Task Allocation Feasibility", 2024.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import COLOURS, DECISIONS, FEASIBLE, INFEASIBLE, MODEL_VERSION
from feasibee.base.files import write_csv, write_table, write_text
from feasibee.base.record import Record
from feasibee.figures.arena import plot_arena
from feasibee.figures.decisions import Panel, draw_opinion_panels, draw_panels, plot_decisions
from feasibee.figures.style import figure, save_both
from feasibee.results.measures import columns
from feasibee.results.statistics import (
    CONFIDENCE,
    Interval,
    decision_times,
    normal_quantile,
    opinion_quartiles,
    wilson,
)
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.plan import DesignPoint, Study
from feasibee.simulation.swarm import Swarm
from feasibee.simulation.sweep import Execution, Rounds

HOLDS, FAILS, CANNOT_TELL = "holds", "fails", "can't tell"
RESAMPLES = 1000


@dataclass(frozen=True)
class RatioSummary:
    """Outcome of the runs in one world at one ratio of robots to tasks."""

    panel: str
    """Name of the world, a key of `WORLDS`."""
    robots: int
    tasks: int
    """Number of robots, and number of robots that the tasks need: one each, unless they have classes."""
    feasible: bool
    """Whether the tasks are feasible."""
    first_run: int
    """Number of the first run."""
    decision: NDArray[np.int8]
    """1 feasible, 0 infeasible, -1 undecided; shape (runs,)."""
    decision_step: NDArray[np.int32]
    """First step at which the swarm had decided, shape (runs,); -1 if undecided."""
    quartiles: NDArray[np.float64]
    """Quartiles over the runs of the percentage of robots with opinion 1, shape (3, steps + 1); empty where
    nothing draws them."""
    thinned: NDArray[np.float32]
    """That percentage in each run at every 25th step, shape (runs, steps // 25 + 1); empty likewise."""

    @property
    def ratio(self) -> float:
        """Robots per robot that the tasks need."""
        return self.robots / self.tasks

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.decision.size

    def rate(self, decision: int, confidence: float = CONFIDENCE) -> Interval:
        """Return the share of runs with a decision, with its interval."""
        return wilson(int((self.decision == decision).sum()), self.runs, confidence)

    @property
    def rates(self) -> dict[str, Interval]:
        """Shares of the runs by decision."""
        return {name: self.rate(code) for code, name in DECISIONS.items()}

    @property
    def accuracy(self) -> Interval:
        """Share of the runs whose decision is the truth."""
        return self.rate(int(self.feasible))


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper, the statistic that tests it, and the verdict."""

    claim: str
    source: str
    statistic: str
    estimate: float
    low: float
    high: float
    bar: str
    verdict: str


def check_claims(points: Sequence[RatioSummary], seed: int) -> list[Claim]:
    """Check every claim of the paper's results.

    The ratios of the points are symmetrical on a log scale, with 1, 2 and 10 among them; the last two have
    curves. The seed is that of the bootstrap.
    """
    ordered = sorted(points, key=lambda point: point.ratio)
    return [
        _correct(
            "more than 75 % of runs decide feasible at ratios larger than 2",
            FEASIBLE,
            [point for point in ordered if point.ratio > 2],
        ),
        _correct(
            "more than 75 % of runs decide infeasible at ratios smaller than 0.5",
            INFEASIBLE,
            [point for point in ordered if point.ratio < 0.5],
        ),
        _symmetrical(ordered),
        _diverging(_at(ordered, 1.0)),
        _earlier([point for point in ordered if point.ratio >= 2]),
        _narrower(_at(ordered, 10.0), _at(ordered, 2.0), seed),
    ]


def _correct(claim: str, decision: int, points: Sequence[RatioSummary]) -> Claim:
    """Compare the least share of right decisions over several ratios with 75 %."""
    each = [point.rate(decision, 1 - (1 - CONFIDENCE) / len(points)) for point in points]
    worst = points[int(np.argmin([rate.estimate for rate in each]))]
    least = Interval(*(min(values) for values in zip(*each, strict=True)))
    statistic = f"least share of right decisions over {len(points)} ratios (at {worst.ratio:.3g})"
    return _claim(claim, "section III, Fig. 3", statistic, least, 0.75, above=True)


def _symmetrical(points: Sequence[RatioSummary]) -> Claim:
    """Compare the shares of right decisions at mirrored ratios: within 10 percentage points on average."""
    pairs = [(low, high) for low, high in zip(points, points[::-1], strict=True) if low.ratio < high.ratio]
    rates = [(high.rate(FEASIBLE), low.rate(INFEASIBLE)) for low, high in pairs]
    mean = sum(feasible.estimate - infeasible.estimate for feasible, infeasible in rates) / len(pairs)
    variance = sum(
        _variance(feasible.estimate, high.runs) + _variance(infeasible.estimate, low.runs)
        for (feasible, infeasible), (low, high) in zip(rates, pairs, strict=True)
    )
    half = normal_quantile(CONFIDENCE) * math.sqrt(variance) / len(pairs)
    claim = "feasible and infeasible decisions are symmetrical around ratio 1"
    statistic = f"right at n/m less right at m/n, on average over {len(pairs)} pairs"
    interval = Interval(mean, mean - half, mean + half)
    bar = "between -0.1 and 0.1 (our reading of symmetrical)"
    inside = interval.low > -0.1 and interval.high < 0.1
    outside = interval.high < -0.1 or interval.low > 0.1
    return Claim(claim, "section III, Fig. 3", statistic, *interval, bar, _verdict(inside, outside))


def _diverging(point: RatioSummary) -> Claim:
    """Compare the rarer decision's share at ratio 1 with the 25 % that a reliable swarm would stay under."""
    rarer = min((point.rate(FEASIBLE), point.rate(INFEASIBLE)), key=lambda rate: rate.estimate)
    claim = "the opinions diverge when the ratio is close to 1"
    return _claim(
        claim, "section III, Fig. 2b", "share of the rarer decision at ratio 1", rarer, 0.25, above=True
    )


def _earlier(points: Sequence[RatioSummary]) -> Claim:
    """Correlate, over runs, the ratio with the decision step; undecided runs come last."""
    from pandas import DataFrame

    ratio = np.concatenate([np.full(point.runs, point.ratio) for point in points])
    step = np.concatenate([point.decision_step for point in points])
    step = np.where(step < 0, np.iinfo(np.int32).max, step)
    if np.ptp(step) == 0:
        r, half = 0.0, math.inf  # all runs decided at one step, or none did
    else:
        ranked = DataFrame([ratio, step]).T.corr(method="spearman").fillna(0.0)
        r = float(np.clip(ranked.iloc[0, 1], -1 + 1e-12, 1 - 1e-12))
        # Fisher's transformation with Bonett and Wright's variance for ranks (Psychometrika, 2000).
        half = normal_quantile(CONFIDENCE) * math.sqrt((1 + r * r / 2) / (ratio.size - 3))
    interval = Interval(r, math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half))
    claim = "consensus is reached earlier when the ratio is larger"
    statistic = "rank correlation of ratio and decision step, ratios from 2 up"
    return _claim(claim, "section III, Fig. 2a", statistic, interval, 0.0, above=False)


def _narrower(large: RatioSummary, small: RatioSummary, seed: int) -> Claim:
    """Compare the quartile bands of Fig. 2a at ratios 10 and 2, averaged over time, by resampling runs."""
    random = np.random.Generator(np.random.Philox(key=seed))

    def band(percentages: NDArray[np.float32]) -> float:
        low, high = np.quantile(percentages, (0.25, 0.75), axis=0)
        return float((high - low).mean())

    def resampled(point: RatioSummary) -> float:
        return band(point.thinned[random.integers(point.runs, size=point.runs)])

    differences = [resampled(large) - resampled(small) for _ in range(RESAMPLES)]
    low, high = np.quantile(differences, (0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2))
    interval = Interval(band(large.thinned) - band(small.thinned), float(low), float(high))
    claim = "the interquartile range is smaller at ratio 10 than at ratio 2"
    statistic = (
        f"mean width of the quartile band, ratio 10 less ratio 2, percentage points; {RESAMPLES} resamples"
    )
    return _claim(claim, "section III, Fig. 2a", statistic, interval, 0.0, above=False)


def _claim(claim: str, source: str, statistic: str, interval: Interval, bar: float, *, above: bool) -> Claim:
    on_side = interval.low > bar if above else interval.high < bar
    on_other = interval.high <= bar if above else interval.low >= bar
    words = f"{'above' if above else 'below'} {bar:g}"
    return Claim(claim, source, statistic, *interval, words, _verdict(on_side, on_other))


def _verdict(holds: bool, fails: bool) -> str:
    return HOLDS if holds else FAILS if fails else CANNOT_TELL


def _at(points: Sequence[RatioSummary], ratio: float) -> RatioSummary:
    return min(points, key=lambda point: abs(math.log(point.ratio / ratio)))


def _variance(rate: float, runs: int) -> float:
    """Return the variance of a rate, with one added success and one added failure: 0 of 100 isn't certain."""
    shrunk = (rate * runs + 1) / (runs + 2)
    return shrunk * (1 - shrunk) / (runs + 2)


TASKS = (2, 3, 4, 5, 6, 8, 10, 13, 16, 18, 20, 22, 25, 31, 40, 50, 67, 80, 100, 133, 200)
"""Numbers of tasks for 20 robots: ratios from 10 to 0.1, mirrored to within 2 % (m m' = 400)."""

CONVERGING = (2, 4, 10, 200, 100, 40)
DIVERGING = (16, 20, 25)
SHOWN_STEPS = 400


def run_study(runs: int, seed: int, execution: Execution | None = None) -> list[RatioSummary]:
    """Simulate the swarm at each number of tasks; keep curves only where they are drawn or compared."""
    drawn = {*CONVERGING, *DIVERGING}
    with Rounds(execution, len(TASKS) * runs) as rounds:
        found: dict[int, RatioSummary] = {}
        for tasks, curves in ((sorted(drawn), True), (sorted({*TASKS} - drawn), False)):
            points = ((m, Scenario(tasks={"count": m}), Runs.of_point(m, runs, seed)) for m in tasks)
            designs = [DesignPoint({"tasks.count": m}, swarm, which.first) for m, swarm, which in points]
            found |= {each.tasks: each for each in _simulated(rounds, Study(designs, runs, seed, curves))}
    return [found[tasks] for tasks in TASKS]


def _simulated(rounds: Rounds, study: Study) -> list[RatioSummary]:
    records = rounds.run(study)
    return [_summary(design, record) for design, record in zip(study.points, records, strict=True)]


def _summary(design: DesignPoint, record: Record) -> RatioSummary:
    scenario, counts = design.scenario, record.feasible_count
    robots = scenario.robots.count
    return RatioSummary(
        panel=design.values.get("panel", BASELINE),
        robots=robots,
        tasks=design.values.get("places", scenario.tasks.count),
        feasible=truth(scenario),
        first_run=record.first_run,
        decision=record.decision,
        decision_step=record.decision_step,
        quartiles=opinion_quartiles(counts, robots) if counts.size else np.empty((3, 0)),
        thinned=(counts[:, ::25] * (100.0 / robots)).astype("float32"),
    )


def write_study(folder: Path, points: Sequence[RatioSummary], seed: int) -> list[Claim]:
    """Check the claims; write them, the figures and their data."""
    claims = check_claims(points, seed)
    swarm = Swarm(Scenario(), seed)
    with figure(3.6, 3.7) as (drawn, ax):
        plot_arena(swarm, ax)
    save_both(drawn, folder / "fig1_arena")
    places = [("robot", swarm.positions), ("task", swarm.tasks)]
    rows = [(kind, i, *place) for kind, group in places for i, place in enumerate(group.tolist(), start=1)]
    write_csv(folder / "fig1_arena.csv", ("kind", "number", "x", "y"), rows)
    _write_opinions(folder, points)
    with figure(4.6, 2.8) as (drawn, ax):
        plot_decisions([point.ratio for point in points], _by_decision(points), ax)
    save_both(drawn, folder / "fig3_decisions")
    write_table(folder / "fig3_decisions.csv", [_row(point, beyond=False) for point in points])
    about: dict[str, Any] = {"runs_per_ratio": points[0].runs, "seed": seed, "model_version": MODEL_VERSION}
    about |= {"robots": swarm.scenario.robots.count, "claims": [asdict(claim) for claim in claims]}
    write_text(folder / "claims.json", json.dumps(about, indent=2) + "\n")
    return claims


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


def _by_decision(points: Sequence[RatioSummary]) -> dict[str, list[Interval]]:
    return {name: [point.rates[name] for point in points] for name in DECISIONS.values()}


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


def simulate_panels(runs: int, seed: int, execution: Execution | None = None) -> list[RatioSummary]:
    """Simulate so many runs at each ratio; return panel by panel, from the fewest places to the most."""
    firsts = {places: Runs.of_point(places, runs, seed).first for places in PLACES}
    designs = [
        DesignPoint({"panel": panel, "places": places}, world(panel, places), first)
        for panel in WORLDS
        for places, first in firsts.items()
    ]
    with Rounds(execution) as rounds:
        return _simulated(rounds, Study(designs, runs, seed))


def write_panels(folder: Path, points: Sequence[RatioSummary]) -> None:
    """Write the figure as PNG and PDF, and its data as CSV."""
    panels = [_panel(panel, [point for point in points if point.panel == panel]) for panel in WORLDS]
    save_both(draw_panels(panels), folder / "beyond")
    write_table(folder / "beyond.csv", [_row(point, beyond=True) for point in points])


def summary(points: Sequence[RatioSummary]) -> list[list[str]]:
    """Return a short table: each panel's accuracy at four ratios, and its median decision step at ratio 2."""
    shown = (2, 10, 40, 200)
    ratios = [f"at {point.ratio:g}" for point in points if point.panel == BASELINE and point.tasks in shown]
    table = [["panel", *ratios, "half by (at 2)"]]
    for panel in WORLDS:
        chosen = [point for point in points if point.panel == panel and point.tasks in shown]
        step = decision_times(chosen[1].decision_step).median
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


def _panel(title: str, points: Sequence[RatioSummary]) -> Panel:
    last = max(point.tasks for point in points if point.feasible)
    first = min(point.tasks for point in points if not point.feasible)
    tip = points[0].robots / (last * first) ** 0.5
    return Panel(title, [point.ratio for point in points], _by_decision(points), tip)


def _row(point: RatioSummary, *, beyond: bool) -> dict[str, object]:
    """Return the columns of a point in ``beyond.csv``, or those in ``fig3_decisions.csv``."""
    world = {"panel": point.panel, "robots": point.robots, "places": point.tasks}
    row: dict[str, object] = world if beyond else {"tasks": point.tasks}
    row |= {"ratio": point.ratio, "first_run": point.first_run, "runs": point.runs}
    row |= {"truth": DECISIONS[int(point.feasible)]} if beyond else {}
    for name, rate in {**point.rates, **({"accuracy": point.accuracy} if beyond else {})}.items():
        row |= columns(name, rate)
    return row | columns("step", decision_times(point.decision_step))
