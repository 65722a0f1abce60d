"""Comparisons of strategies or presets on the same worlds: accuracy, decision time, bits on the air."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.figures.tracking import infeasible_share
from feasibee.model.codes import DECISIONS, MODEL_VERSION, exact
from feasibee.model.record import Record
from feasibee.results.measures import (
    Declarations,
    Tracking,
    decided_right,
    declarations,
    ended_agreed,
    ended_right,
    right_shares,
    robot_steps,
    tracking,
)
from feasibee.results.responding import Judgement, judgement
from feasibee.results.statistics import (
    Interval,
    Quartiles,
    decision_times,
    mean_difference,
    paired_difference,
    wilson,
)
from feasibee.scenario.feasibility import truth
from feasibee.scenario.presets import PRESETS
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.studies.suitable import strategy_change, suitable
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds

TASKS = (10, 16, 18, 19, 20, 21, 22, 25, 40)
"""Numbers of tasks for 20 robots, most of them near ratio one, where strategies differ."""

DEFAULT = "default"
"""As a preset: the scenario as it is."""
CONTENDER = "contender"
"""In a journal, the name of what a comparison varies."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of one contender's runs at one number of tasks.

    Parameters
    ----------
    contender : str
        A strategy or a preset.
    robots, tasks : int
        Number of robots, and of tasks.
    feasible : bool
        Ground truth: whether the tasks are feasible; in a world that changes, before any change.
    right : bool array, shape (runs,)
        Whether the swarm was right at the last step: more than the threshold's share of the counted robots
        held the true opinion.
    first_right : bool array, shape (runs,)
        Whether the first collective decision was right.
    agreed : bool array, shape (runs,)
        Whether that share of them held either opinion.
    right_steps : float64 array, shape (runs,)
        Share of the steps at which the swarm was right; empty in a world that doesn't change.
    right_at : int64 array, shape (steps + 1,)
        Number of runs that were right at each step.
    decision : int8 array, shape (runs,)
        The first collective decision (model.md 4.7).
    decision_step : int32 array, shape (runs,)
        Step of that decision; -1 if undecided.
    bits : float64 array, shape (runs,)
        Bits sent per robot-step.
    committed, committed_wrong : float64 array, shape (runs,)
        Share of the counted robots that are committed at the last step, and committed to the wrong opinion.
    commit_step : int64 array, shape (runs,)
        First step at which more than the threshold's share were committed; -1 if never.
    declared : Declarations or None
        Declarations of the robots; None if the strategy doesn't define ``declare``.
    tracking : Tracking or None
        How the swarms tracked the truth; None in a world that doesn't change.
    judgement : Judgement or None
        How well the swarms were served; None if nobody responds to what they hold.
    infeasible_at : float64 array, shape (steps + 1,)
        Share of the runs whose tasks are infeasible at each step.
    """

    contender: str
    robots: int
    tasks: int
    feasible: bool
    right: NDArray[np.bool_]
    first_right: NDArray[np.bool_]
    agreed: NDArray[np.bool_]
    right_steps: NDArray[np.float64]
    right_at: NDArray[np.int64]
    decision: NDArray[np.int8]
    decision_step: NDArray[np.int32]
    bits: NDArray[np.float64]
    committed: NDArray[np.float64]
    committed_wrong: NDArray[np.float64]
    commit_step: NDArray[np.int64]
    declared: Declarations | None
    tracking: Tracking | None
    judgement: Judgement | None
    infeasible_at: NDArray[np.float64]

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.right.size

    @property
    def accuracy(self) -> Interval:
        """Share of the runs that were right at the last step, with its interval."""
        return wilson(int(self.right.sum()), self.runs)

    @property
    def judged(self) -> Interval:
        """Share that judges it: of runs right at the last step; in a world that changes, of steps."""
        return self.accuracy if self.tracking is None else self.tracking.right_share

    @property
    def first(self) -> Interval:
        """Share of the runs whose first collective decision was right, with its interval."""
        return wilson(int(self.first_right.sum()), self.runs)

    @property
    def times(self) -> Quartiles:
        """Steps by which a quarter, half and three quarters of the runs had decided."""
        return decision_times(self.decision_step)

    def to_dict(self) -> dict[str, Any]:
        """Return the outcome as plain tables, for programs."""
        return {
            "contender": self.contender,
            "robots": self.robots,
            "tasks": self.tasks,
            "truth": DECISIONS[int(self.feasible)],
            "runs": self.runs,
            "right_at_end": self.accuracy._asdict(),
            "first_decision_right": self.first._asdict(),
            "decision_step": self.times._asdict(),
            "bits_per_robot_and_step": float(self.bits.mean()),
            "declared": None if self.declared is None else self.declared.to_dict(),
            **({} if self.tracking is None else self.tracking.to_dict()),
            **({} if self.judgement is None else {"response": self.judgement.to_dict()}),
        }


def contenders_of(
    scenario: Scenario, strategies: Sequence[str] = (), presets: Sequence[str] = ()
) -> dict[str, Scenario]:
    """Return the scenario with each strategy, or with each preset, by name.

    Parameters
    ----------
    scenario : Scenario
        What all contenders have in common.
    strategies : sequence of str
        Names or files; with neither strategies nor presets, all built-in strategies that the scenario
        supports.
    presets : sequence of str
        Names. What the scenario sets itself wins over a preset's values; ``"default"`` has none.

    Raises
    ------
    FeasibeeError
        If a strategy or preset is unknown, or named twice.
    """
    if strategies and presets:
        raise FeasibeeError("strategies and presets: can't be compared at once; name one kind")
    names = list(presets or strategies or suitable(scenario)[0])
    check_distinct(names)
    changes = [_preset(name) if presets else strategy_change(scenario, name) for name in names]
    short = Counter(Path(name).name for name in names)
    labels = [Path(name).name if short[Path(name).name] == 1 else name for name in names]
    return {
        label: scenario.replace({**each, "run.stop_at_decision": False})
        for label, each in zip(labels, changes, strict=True)
    }


def check_distinct(names: Sequence[str]) -> None:
    """Raise an error for a contender that is named twice."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise FeasibeeError(f"{twice[0]}: is named twice; name it once")


def _preset(name: str) -> dict[str, Any]:
    """Return the changes that lay a preset under a scenario."""
    if name not in (DEFAULT, *PRESETS):
        raise FeasibeeError(f"{name}: is no preset; choose from {', '.join([DEFAULT, *PRESETS])}")
    return {} if name == DEFAULT else {"preset": name}


def compare(
    contenders: Mapping[str, Scenario],
    tasks: Sequence[int] = (),
    runs: int = 200,
    seed: int = 0,
    execution: Execution | None = None,
) -> list[Outcome]:
    """Simulate every contender in the same worlds: run r starts from the same places for all of them.

    Parameters
    ----------
    contenders : mapping of str to Scenario
        From `contenders_of`.
    tasks : sequence of int
        Numbers of tasks; by default that of the scenarios.
    runs : int
        Number of runs of each contender at each number of tasks.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Returns
    -------
    list of Outcome
        Contender by contender, in the order of ``tasks``.
    """
    designs = design_points(contenders, tasks, runs, seed)
    with Rounds(execution, len(designs) * runs) as rounds:
        return outcomes_of(rounds, designs, runs, seed)


def design_points(
    contenders: Mapping[str, Scenario], tasks: Sequence[int], runs: int, seed: int
) -> list[DesignPoint]:
    """Return a point for each contender at each number of tasks; all contenders have the same run numbers."""
    return [
        DesignPoint(
            {CONTENDER: name} if number is None else {CONTENDER: name, "tasks.count": number},
            scenario if number is None else scenario.replace({"tasks.count": number}),
            Runs.of_point(place, runs, seed).first,
        )
        for name, scenario in contenders.items()
        for place, number in enumerate([*tasks] or [None])
    ]


def outcomes_of(rounds: Rounds, designs: Sequence[DesignPoint], runs: int, seed: int) -> list[Outcome]:
    """Run one round of points; return their outcomes in the same order, by contender if they have any."""
    records = rounds.run(Study(designs, runs, seed, curves=True))
    return [
        outcome_of(design.values.get(CONTENDER, ""), design.scenario, record)
        for design, record in zip(designs, records, strict=True)
    ]


def right_at_end(
    rounds: Rounds, designs: Sequence[DesignPoint], runs: int, seed: int
) -> list[NDArray[np.bool_]]:
    """Run one round; return for each point whether each swarm was right at the last step."""
    records = rounds.run(Study(designs, runs, seed))
    scenarios = [design.scenario for design in designs]
    return [ended_right(record, scenario) for scenario, record in zip(scenarios, records, strict=True)]


def outcome_of(contender: str, scenario: Scenario, record: Record) -> Outcome:
    """Summarise the runs of one contender at one number of tasks."""
    feasible = truth(scenario)
    counted = max(1, scenario.counted(scenario.run.steps))
    steps = scenario.robots.count * scenario.run.steps
    committed = np.stack([record.committed_infeasible, record.committed_feasible])
    return Outcome(
        contender=contender,
        robots=scenario.robots.count,
        tasks=scenario.tasks.count,
        feasible=feasible,
        right=ended_right(record, scenario),
        first_right=decided_right(record, scenario),
        agreed=ended_agreed(record, scenario),
        right_steps=right_shares(record) if scenario.dynamic else np.empty(0),
        right_at=_right_at(record, scenario, feasible),
        decision=record.decision,
        decision_step=record.decision_step,
        bits=record.bits_sent / (robot_steps(record) if scenario.dynamic else steps),
        committed=committed.sum(axis=0) / counted,
        committed_wrong=committed[0 if feasible else 1] / counted,
        commit_step=record.commit_step,
        declared=declarations(record, scenario),
        tracking=tracking(record, scenario),
        judgement=judgement(record, scenario),
        infeasible_at=(
            infeasible_share(record.truth)
            if scenario.dynamic
            else np.full(scenario.run.steps + 1, float(not feasible))
        ),
    )


def _right_at(record: Record, scenario: Scenario, feasible: bool) -> NDArray[np.int64]:
    """Return the number of runs that were right at each step: shape (steps + 1,)."""
    if scenario.dynamic:
        followed: NDArray[np.int64] = (record.held == record.truth).sum(axis=0)
        return followed
    held = record.feasible_count if feasible else record.infeasible_count
    stop = scenario.faults.stop_step
    counted = np.where(np.arange(held.shape[1]) < stop, scenario.counted(0), scenario.counted(stop))
    needed = exact(scenario.decision.threshold)
    right: NDArray[np.int64] = (held * needed.denominator > counted * needed.numerator).sum(axis=0)
    return right


def as_dict(outcomes: Sequence[Outcome], runs: int, seed: int) -> dict[str, Any]:
    """Return a comparison as plain tables, for programs."""
    return {
        "runs": runs,
        "seed": seed,
        "version": version("feasibee"),
        "model_version": MODEL_VERSION,
        "outcomes": [each.to_dict() for each in outcomes],
    }


def by_contender(outcomes: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """Return the outcomes of each contender."""
    groups: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault(outcome.contender, []).append(outcome)
    return groups


def declared_of(group: Sequence[Outcome]) -> list[Declarations]:
    """Return the declarations of a contender by number of tasks; none if its strategy doesn't declare."""
    return [each.declared for each in group if each.declared is not None]


def overall(group: Sequence[Outcome]) -> Interval:
    """Return the share of right runs of a contender over all numbers of tasks."""
    return wilson(sum(int(each.right.sum()) for each in group), sum(each.runs for each in group))


def overall_difference(group: Sequence[Outcome], baseline: Sequence[Outcome]) -> Interval:
    """Return a contender's share of right runs less that of the baseline, paired by run; else of steps."""
    if group[0].tracking is not None:
        return mean_difference(
            np.concatenate([each.right_steps for each in group]),
            np.concatenate([each.right_steps for each in baseline]),
        )
    return paired_difference(
        np.concatenate([each.right for each in group]), np.concatenate([each.right for each in baseline])
    )


def difference(one: Outcome, other: Outcome) -> Interval:
    """Return by how much one outcome's share that judges it exceeds that of another, paired by run."""
    return overall_difference([one], [other])


def mean_bits(group: Sequence[Outcome]) -> float:
    """Return the mean number of bits sent per robot-step."""
    return float(np.mean([each.bits.mean() for each in group]))
