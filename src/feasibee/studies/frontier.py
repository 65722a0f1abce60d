"""The frontier: what strategies reach by their robots' own word, against what is physically possible.

Robots of some strategies declare (model.md 6.15). Those of others commit to an opinion (6.14). Both are
simulated near ratio one, and drawn with the limits of their scenario behind.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

from feasibee.figures.frontier import Panel, Word, draw_frontier
from feasibee.figures.style import save_both
from feasibee.files import write_csv
from feasibee.model.record import Record
from feasibee.results.measures import declared_right, declared_wrong
from feasibee.results.statistics import DeclareTimes, Interval, declare_times, wilson
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import CONTENDER, check_distinct, design_points
from feasibee.studies.limits import Limits, limits
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds

RULE: Final = {"quorum": 0.9, "rounds": 3, "heard": 3}
"""The rule to commit of strategies whose robots don't declare."""
OFFSETS: Final = (-1, 0, 1, 2)
"""Numbers of tasks, less the number of robots."""


@dataclass(frozen=True)
class Contender:
    """A strategy with parameters, as a row of the figure.

    Parameters
    ----------
    name : str
        Name of the row.
    strategy : str
        Name of the strategy, or the path of its file.
    parameters : mapping of str to float
        Its parameters that differ from their defaults.
    knows_count : bool, optional
        Whether robots know their number; by default if the strategy needs it, or the scenario says so.
    """

    name: str
    strategy: str
    parameters: dict[str, float] = field(default_factory=dict)
    knows_count: bool | None = None

    def scenario(self, base: Scenario) -> Scenario:
        """Return a scenario with this contender; robots that don't declare commit."""
        own = {"decision.strategy": self.strategy, "decision.parameters": self.parameters}
        apt = {**own, "decision.commit": None, "robots.know_count": True, "run.stop_at_decision": False}
        manifest = base.replace(apt).manifest
        knows = self.knows_count
        if knows is None:
            knows = manifest.needs_count or base.robots.know_count
        return base.replace(
            {**apt, "decision.commit": None if manifest.declares else RULE, "robots.know_count": knows}
        )


CONTENDERS: Final = (
    Contender("turns, alarm only", "turns", {"names": 0.0}),
    Contender("turns, 1 name", "turns", {"names": 1.0}),
    Contender("turns, 3 names", "turns", {"names": 3.0}),
    Contender("turns, 6 names", "turns", {"names": 6.0}),
    Contender("turns, all names", "turns", {"names": -1.0}),
    Contender("quiet census, n known", "quiet-census", knows_count=True),
    Contender("quiet census, n unknown", "quiet-census", knows_count=False),
    Contender("map", "map"),
    Contender("tally, committed", "tally"),
    Contender("census, committed", "census"),
)
"""What is compared by default."""


@dataclass(frozen=True)
class Spoken:
    """What the robots of a contender said by their own word at one number of tasks.

    Parameters
    ----------
    contender : str
        Its name.
    declares : bool
        Whether robots declare; otherwise they commit.
    robots, tasks : int
        Number of robots, and of tasks.
    feasible : bool
        Ground truth: whether the tasks are feasible.
    runs : int
        Number of runs.
    ok, wrong : Interval
        Share of runs in which more than the threshold's share of robots spoke rightly and none wrongly, and
        in which any robot spoke wrongly.
    times : DeclareTimes
        Steps by which more than the threshold's share had spoken.
    bits : float
        Bits sent per robot-step, over the whole runs.
    """

    contender: str
    declares: bool
    robots: int
    tasks: int
    feasible: bool
    runs: int
    ok: Interval
    wrong: Interval
    times: DeclareTimes
    bits: float

    def to_dict(self) -> dict[str, Any]:
        """Return what was said, for programs."""
        steps = {"median": self.times.median, "p95": self.times.p95}
        return {**asdict(self), "ok": self.ok._asdict(), "wrong": self.wrong._asdict(), "times": steps}


def contenders_named(strategies: Sequence[str]) -> list[Contender]:
    """Return contenders of strategies with their default parameters; without names, `CONTENDERS`."""
    names = [Path(name).name for name in strategies]
    check_distinct(names)
    return [Contender(*pair) for pair in zip(names, strategies, strict=True)] or list(CONTENDERS)


def frontier(
    scenario: Scenario,
    contenders: Sequence[Contender] = CONTENDERS,
    tasks: Sequence[int] = (),
    runs: int = 1000,
    seed: int = 0,
    execution: Execution | None = None,
) -> list[Spoken]:
    """Simulate contenders at numbers of tasks near ratio one, all in the same worlds.

    Parameters
    ----------
    scenario : Scenario
        What all contenders have in common.
    contenders : sequence of Contender
        What to compare.
    tasks : sequence of int
        Numbers of tasks; by default from one less than robots to two more.
    runs : int
        Number of runs of each contender at each number of tasks.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Returns
    -------
    list of Spoken
        Contender by contender, in the order of ``tasks``.
    """
    designs = designs_of(scenario, contenders, tasks_near(scenario, tasks), runs, seed)
    with Rounds(execution, len(designs) * runs) as rounds:
        records = rounds.run(Study(designs, runs, seed))
        return [
            spoken(str(design.values[CONTENDER]), design.scenario, record)
            for design, record in zip(designs, records, strict=True)
        ]


def designs_of(
    scenario: Scenario, contenders: Sequence[Contender], tasks: Sequence[int], runs: int, seed: int
) -> list[DesignPoint]:
    """Return a point for each contender at each number of tasks; all contenders have the same run numbers."""
    worlds = {each.name: each.scenario(scenario) for each in contenders}
    return design_points(worlds, tasks, runs, seed)


def tasks_near(scenario: Scenario, tasks: Sequence[int] = ()) -> list[int]:
    """Return the given numbers of tasks, or those near ratio one."""
    return list(tasks) or [max(0, scenario.robots.count + offset) for offset in OFFSETS]


def spoken(contender: str, scenario: Scenario, record: Record) -> Spoken:
    """Summarise the declarations of a contender's runs, or its commitments if robots don't declare."""
    feasible, declares = truth(scenario), scenario.manifest.declares
    words: Any = record if declares else _commitments(record)
    right, wrong = declared_right(words, scenario, feasible), declared_wrong(words, scenario, feasible)
    return Spoken(
        contender=contender,
        declares=declares,
        robots=scenario.robots.count,
        tasks=scenario.tasks.count,
        feasible=feasible,
        runs=record.runs,
        ok=wilson(int(right.sum()), record.runs),
        wrong=wilson(int(wrong.sum()), record.runs),
        times=declare_times(words.declare_step),
        bits=float(record.bits_sent.mean()) / (scenario.robots.count * scenario.run.steps),
    )


def _commitments(record: Record) -> SimpleNamespace:
    """Return the commitments of a record as declarations."""
    return SimpleNamespace(
        decision=record.decision,
        decision_step=record.decision_step,
        declare_step=record.commit_step,
        declared_feasible=record.committed_feasible,
        declared_infeasible=record.committed_infeasible,
    )


def limits_near(
    scenario: Scenario,
    tasks: Sequence[int],
    runs: int,
    seed: int,
    cells: int = 4,
    threads: int | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> dict[int, Limits]:
    """Return the limits of a scenario at each number of tasks."""
    found: dict[int, Limits] = {}
    for number in tasks:
        progress(len(found) / len(tasks))
        world = scenario.replace({"tasks.count": number})
        found[number] = limits(world, runs, seed, cells_per_range=cells, threads=threads)
    return found


def write_frontier(folder: Path, found: Sequence[Spoken], bounds: dict[int, Limits]) -> None:
    """Write the figure (PNG, PDF) and its data, ``frontier.csv``, into a folder."""
    panels = []
    for number, limit in bounds.items():
        group = [each for each in found if each.tasks == number]
        verdict = "feasible" if group[0].feasible else "infeasible"
        words = [
            Word(each.contender, each.declares, each.bits, each.ok.estimate, *each.times[:2])
            for each in group
        ]
        steps = {name: times[:2] for name, times in limit.times.items()}
        panels.append(Panel(f"m = {number}: {verdict}", words, steps))
    most = next(iter(bounds.values())).scenario.run.steps
    save_both(draw_frontier(panels, most), folder / "frontier")
    header = ["contender", "word", "robots", "tasks", "truth", "runs", "ok", "ok_low", "ok_high"]
    header += ["wrong", "wrong_low", "wrong_high", "step_median", "step_p95", "bits_per_robot_and_step"]
    write_csv(folder / "frontier.csv", header, (_row(each) for each in found))


def write_limits(path: Path, bounds: dict[int, Limits]) -> None:
    """Write the limits at each number of tasks."""
    rows = [
        [number, name, *("" if step is None else step for step in times[:2])]
        for number, limit in bounds.items()
        for name, times in limit.times.items()
    ]
    write_csv(path, ["tasks", "limit", "step_median", "step_p95"], rows)


def _row(each: Spoken) -> list[object]:
    return [
        *(each.contender, "declares" if each.declares else "commits", each.robots, each.tasks),
        *("feasible" if each.feasible else "infeasible", each.runs, *each.ok, *each.wrong),
        *("" if step is None else step for step in each.times[:2]),
        f"{each.bits:.6g}",
    ]
