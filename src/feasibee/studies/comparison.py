"""Comparisons of strategies or presets on the same worlds: what to run, what came of it, and its files."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import DECISIONS, INFEASIBLE, MODEL_VERSION, exact
from feasibee.base.errors import FeasibeeError
from feasibee.base.record import Record
from feasibee.results.calibration import OWN, SHARES, Calibration, calibration, held_feasible, said_feasible
from feasibee.results.measures import (
    Declarations,
    Measured,
    Tracking,
    columns,
    ended_agreed,
    ended_right,
    measured,
    robot_steps,
    together,
)
from feasibee.results.statistics import (
    CONFIDENCE,
    Interval,
    in_percent,
    mean_difference,
    mean_share,
    plain,
    wilson,
)
from feasibee.scenario.feasibility import truth
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.tables import PRESETS
from feasibee.simulation.ensemble import check_size
from feasibee.simulation.plan import DesignPoint, Study
from feasibee.simulation.schedule import run_work
from feasibee.simulation.sequential import Finding, SequentialDesign
from feasibee.simulation.sweep import Execution, Rounds
from feasibee.studies.needs import strategy_change, suitable

TASKS = (10, 16, 18, 19, 20, 21, 22, 25, 40)
"""Numbers of tasks for 20 robots, most of them near ratio one, where strategies differ."""

DEFAULT = "default"
"""As a preset: the scenario as it is."""
RUNS: Final = "runs of each"
"""The phase of a comparison."""
FIRST_LOOK: Final = 20
"""Number of runs of each contender before its first answer, which later ones replace by twice as many."""
WHOLE: Final = 100
"""Number of a contender's first runs that go on to the last step. If its robots declare, others needn't."""
CONTENDER = "contender"
"""In a folder of runs, the name of what a comparison varies."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of one contender's runs at one number of tasks."""

    contender: str
    """A strategy or a preset."""
    robots: int
    tasks: int
    """Number of robots, and of tasks."""
    feasible: bool
    """Ground truth: whether the tasks are feasible; in a world that changes, before any change."""
    right: NDArray[np.bool_]
    """Whether the swarm was right at the last step: more than the threshold's share of the counted robots
    held the true opinion; shape (runs,)."""
    agreed: NDArray[np.bool_]
    """Whether that share of them held either opinion; shape (runs,)."""
    right_at: NDArray[np.int64]
    """Number of runs that were right at each step; shape (steps + 1,)."""
    said: NDArray[np.float64]
    """Probability that each swarm gave to feasible at the last step; shape (runs,), or (0,) in a world that
    changes."""
    held: NDArray[np.float64]
    """Share of its robots that held feasible, likewise."""
    said_by: str
    """What the probability is: ``OWN`` or ``SHARES`` of ``feasibee.results.calibration``."""
    bits: NDArray[np.float64]
    """Bits sent per robot-step; shape (runs,). If robots declare, those of the first 100 runs."""
    found: Measured
    """The measures of its runs."""
    infeasible_at: NDArray[np.float64]
    """Share of the runs whose tasks are infeasible at each step, if the world changes; shape (steps + 1,)."""
    test: Finding | None = None
    """What the test found that chose the number of runs, if one did."""

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.right.size

    @property
    def accuracy(self) -> Interval:
        """Share of the runs that were right at the last step, with its interval."""
        return wilson(int(self.right.sum()), self.runs)

    @property
    def brier(self) -> Interval | None:
        """Brier score of the probabilities that the swarms gave to feasible; None in a world that changes."""
        return mean_share((self.said - self.feasible) ** 2) if self.said.size else None

    @property
    def first(self) -> Interval:
        """Share of the runs whose first collective decision was right, with its interval."""
        return together([self.found], "accuracy")

    @property
    def tracking(self) -> Tracking | None:
        """How the swarms tracked the truth; None in a world that doesn't change."""
        return self.found.tracking

    @property
    def declared(self) -> Declarations | None:
        """Declarations of the robots; None if the strategy doesn't define ``declare``."""
        return self.found.declared

    @property
    def judged(self) -> Interval:
        """Share that judges it: of runs right at the last step; in a world that changes, of steps.

        If a test chose the number of runs, its interval holds for all tests together.
        """
        if self.test is not None:
            return self.test.interval
        return self.accuracy if self.tracking is None else self.tracking.right_share

    @property
    def shares(self) -> NDArray[np.float64]:
        """Whether each swarm was right, or in a world that changes, share of the steps; shape (runs,)."""
        return self.right.astype(np.float64) if self.found.followed is None else self.found.followed.shares

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
            "brier": plain(self.brier),
            "brier_of": self.said_by,
            "decision_step": self.found.times._asdict(),
            "bits_per_robot_and_step": float(self.bits.mean()),
            **self.found.to_dict(),
        }


@dataclass(frozen=True)
class Comparison:
    """What came of the runs of all contenders."""

    outcomes: Sequence[Outcome]
    runs: int
    """Number of runs of each that was asked for."""
    seed: int
    stopped: str = ""
    """Why the comparison ended early, if it did."""

    @property
    def missing(self) -> str:
        """Which runs are missing, in words; empty if none."""
        fewer = [each.runs for each in self.outcomes if each.runs < self.runs]
        several = f"{len(fewer)} of {len(self.outcomes)} have"
        return f"{several} {min(fewer):,} instead of {self.runs:,} runs" if fewer else ""

    @property
    def rows(self) -> list[dict[str, object]]:
        """The rows of ``compare.csv``; differences are from the first contender."""
        first = self.outcomes[0].contender
        baseline = {each.tasks: each for each in self.outcomes if each.contender == first}
        return [_row(each, baseline[each.tasks]) for each in self.outcomes]

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as plain tables, for programs."""
        own = [each for each in self.outcomes if each.said_by == OWN]
        shares = [replace(each, said=each.held, said_by=SHARES) for each in own]
        return {
            "runs": self.outcomes[0].runs,
            **origin(self.seed),
            "outcomes": [each.to_dict() for each in self.outcomes],
            "calibration": plain(calibrations(self.outcomes)),
            "calibration_of_shares": plain(calibrations(shares)),
            "stopped": self.stopped,
        }


def check_stays(scenario: Scenario, question: str) -> None:
    """Raise an error if the world of a scenario changes: then there is no single truth to be right about."""
    if scenario.dynamic:
        raise FeasibeeError(
            f"{question}: needs a world that stays, but the world of this scenario changes; leave out events "
            "and rates, or use feasibee compare without constraints, or feasibee assess"
        )


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
    execution: Execution | Rounds | None = None,
    *,
    curves: bool = True,
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
    execution : Execution or Rounds, optional
        Where to compute and keep the runs; by default on threads, and in memory. If it ends the study early,
        all outcomes have the same smaller number of runs.
    curves : bool
        Whether to count right swarms at each step; else `Outcome.right_at` is empty.

    Returns
    -------
    list of Outcome
        Contender by contender, in the order of ``tasks``.
    """
    designs = design_points(contenders, tasks, runs, seed)
    for each in designs:
        if each.scenario.dynamic:  # not after hours: the looks before need less
            check_size(each.scenario, Runs(runs, seed), curves=False)
    with rounds_of(execution, RUNS) as rounds:
        rounds.phases = {RUNS: runs * sum(run_work(each.scenario) for each in designs)}
        done = looks_at(
            rounds,
            runs,
            lambda number: studies_of(designs, number, seed, curves=curves),  # to read curves takes long
            lambda number: so_far(outcomes_of(rounds, designs, number, seed, curves=False)),
        )
        return outcomes_of(rounds, designs, done, seed, curves=curves)


def looks_at(
    rounds: Rounds,
    runs: int,
    studies: Callable[[int], Iterable[Study]],
    answer: Callable[[int], str],
) -> int:
    """Complete studies of so many runs, doubled at each look; return the number that time allowed.

    ``studies`` and ``answer`` give the studies of a number of runs, and the answer from them in words.
    """

    def see(looked: Mapping[str, None], number: int) -> dict[str, int]:
        rounds.place = f"{number:,} of {runs:,}"
        for study in studies(number):
            rounds.complete(study)
        if number < runs:
            rounds.so_far = answer(number)
        return dict.fromkeys(looked, number)

    return SequentialDesign(runs, FIRST_LOOK, growth=2).run({"": None}, see).get("", 0)


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


def outcomes_of(
    rounds: Rounds,
    designs: Sequence[DesignPoint],
    runs: int,
    seed: int,
    *,
    curves: bool = True,
) -> list[Outcome]:
    """Run one round of points; return their outcomes in the same order, by contender if they have any."""
    parts = [list(rounds.run(study)) for study in studies_of(designs, runs, seed, curves=curves)]
    return [
        outcome_of(design.values.get(CONTENDER, ""), design.scenario, *records)
        for design, *records in zip(designs, *parts, strict=True)
    ]


def studies_of(
    designs: Sequence[DesignPoint], runs: int, seed: int, *, curves: bool = True
) -> Iterator[Study]:
    """Yield what to run of some points: the first runs, and the others, which end at the declarations."""
    first = min(WHOLE, runs)
    yield Study(designs, first, seed, curves)
    if runs > first:
        later = [replace(each, first_run=each.first_run + first) for each in designs]
        ended = [replace(each, scenario=ending_early(each.scenario)) for each in later]
        yield Study(ended, runs - first, seed, curves)


def ending_early(scenario: Scenario) -> Scenario:
    """Return the scenario with runs that end once all robots have declared, if any do (model.md 6.15.8).

    No opinion or declaration of theirs can change after that. What they send can, and what they do.
    """
    ends = scenario.declares and not scenario.acts
    return scenario.replace({"run.stop_at_declarations": True}) if ends else scenario


def outcome_of(contender: str, scenario: Scenario, first: Record, *later: Record) -> Outcome:
    """Summarise the runs of one contender at one number of tasks, from the records of `studies_of`.

    If robots declare, bits are those of the first runs.
    """
    feasible, record = truth(scenario), first.followed_by(*later)
    whole, found = record, measured(record, scenario)
    if scenario.declares and later:
        whole, found = first, found._replace(bits=measured(first, scenario).bits)
    return Outcome(
        contender=contender,
        robots=scenario.robots.count,
        tasks=scenario.tasks.count,
        feasible=feasible,
        right=ended_right(record, scenario),
        agreed=ended_agreed(record, scenario),
        right_at=_right_at(record, scenario, feasible),
        said=said_feasible(record, scenario),
        held=held_feasible(record, scenario),
        said_by=OWN if scenario.gives_probability else SHARES,
        bits=whole.bits_sent / np.maximum(1, robot_steps(whole, scenario)),
        found=found,
        infeasible_at=(record.truth == INFEASIBLE).mean(axis=0) if scenario.dynamic else np.empty(0),
    )


def _right_at(record: Record, scenario: Scenario, feasible: bool) -> NDArray[np.int64]:
    """Return the number of runs that were right at each step: shape (steps + 1,)."""
    if scenario.dynamic:
        followed: NDArray[np.int64] = (record.held == record.truth).sum(axis=0)
        return followed
    name = "feasible" if feasible else "infeasible"
    held, last = getattr(record, f"{name}_count"), getattr(record, f"{name}_at_end")
    held = np.where(held < 0, last[:, None], held)  # after the end of a run
    stop = scenario.faults.stop_step
    counted = np.where(np.arange(held.shape[1]) < stop, scenario.counted(0), scenario.counted(stop))
    needed = exact(scenario.decision.threshold)
    right: NDArray[np.int64] = (held * needed.denominator > counted * needed.numerator).sum(axis=0)
    return right


def origin(seed: int, scenario: Scenario | None = None) -> dict[str, Any]:
    """Return how an answer was computed, as a part of plain tables."""
    scenario_hash = {} if scenario is None else {"scenario_hash": scenario.hash}
    versions = {"version": version("feasibee"), "model_version": MODEL_VERSION}
    return {"seed": seed, **scenario_hash, **versions}


@contextmanager
def rounds_of(execution: Execution | Rounds | None, phase: str) -> Iterator[Rounds]:
    """Begin a phase of a study of unknown length, which may be a part of another one with rounds."""
    with nullcontext(execution) if isinstance(execution, Rounds) else Rounds(execution, most=None) as rounds:
        rounds.phase = phase
        yield rounds


def by_contender(outcomes: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """Return the outcomes of each contender."""
    groups: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault(outcome.contender, []).append(outcome)
    return groups


def overall(group: Sequence[Outcome]) -> Interval:
    """Return the share of right runs of a contender over all numbers of tasks."""
    return wilson(sum(int(each.right.sum()) for each in group), sum(each.runs for each in group))


def overall_difference(group: Sequence[Outcome], baseline: Sequence[Outcome]) -> Interval:
    """Return a contender's share of right runs less that of the baseline, paired by run; else of steps."""
    one, other = (np.concatenate([each.shares for each in outcomes]) for outcomes in (group, baseline))
    return mean_difference(one, other)


def difference(one: Outcome, other: Outcome, confidence: float = CONFIDENCE) -> Interval:
    """Return by how much one outcome's share that judges it exceeds that of another, paired by run.

    If one of them has fewer runs, only as many of the other's first runs count.
    """
    runs = min(one.runs, other.runs)
    return mean_difference(one.shares[:runs], other.shares[:runs], confidence)


def calibration_of(group: Sequence[Outcome]) -> Calibration | None:
    """Return how good the probabilities of a contender are; None unless outcomes of both truths are given.

    If some have fewer runs, only as many of the first runs of the others count: worlds have the same weight.
    """
    runs = min(each.said.size for each in group)
    truths = np.repeat([each.feasible for each in group], runs)
    return calibration(np.concatenate([each.said[:runs] for each in group]), truths)


def calibrations(outcomes: Sequence[Outcome]) -> dict[str, Calibration]:
    """Return how good the probabilities of each contender are, of those with outcomes of both truths."""
    found = {name: calibration_of(group) for name, group in by_contender(outcomes).items()}
    return {name: each for name, each in found.items() if each is not None}


def mean_bits(group: Sequence[Outcome]) -> float:
    """Return the mean number of bits sent per robot-step."""
    return float(np.mean([each.bits.mean() for each in group]))


def in_bits(bits: float) -> str:
    """Return a number of bits in three digits, with commas in thousands.

    Examples
    --------
    >>> in_bits(2.0649), in_bits(548.2), in_bits(1043.7)
    ('2.06', '548', '1,040')
    """
    return f"{float(f'{bits:.3g}'):,.10g}"


SURE: Final = 0.95
"""Share of swarms that must be right for a time to be called sufficient."""


def wait_for(outcome: Outcome, share: float = SURE) -> int | None:
    """Return the first step from which a share of the swarms is right until the end; None without one."""
    return _last_from(outcome, math.ceil(exact(share) * outcome.runs))


def wait_interval(outcome: Outcome, share: float = SURE) -> tuple[int | None, int | None]:
    """Return an interval of `wait_for`: first steps from which a share is possible, and is shown.

    Possible: no later step has a 95 % interval that lies below the share. Shown: all later ones lie above it.
    """
    runs = outcome.runs
    counts = [wilson(right, runs) for right in range(runs + 1)]
    possible = sum(each.high < share for each in counts)
    return _last_from(outcome, possible), _last_from(outcome, sum(each.low < share for each in counts))


def _last_from(outcome: Outcome, least: int) -> int | None:
    """Return the first step from which so many runs are right until the end; None without one."""
    short = np.flatnonzero(outcome.right_at < least)
    step = int(short[-1]) + 1 if short.size else 0
    return step if step < outcome.right_at.size else None


def latest(steps: Iterable[int | None]) -> int | None:
    """Return the latest of some steps; None if one is never."""
    late = max(math.inf if step is None else step for step in steps)
    return int(late) if math.isfinite(late) else None


def percent(share: Interval) -> str:
    """Return a share with its interval, in percent."""
    return f"{100 * share.estimate:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f})"


def answer(outcomes: Sequence[Outcome]) -> list[str]:
    """Return which contender is right most often, which others may be, its step and its bits, in words."""
    groups = by_contender(outcomes)
    tracks = outcomes[0].tracking is not None
    kind, measure = (" of the steps", "right_share") if tracks else (" of the runs", "right_at_end")
    shares = {name: together([each.found for each in group], measure) for name, group in groups.items()}
    best = max(shares, key=lambda name: shares[name].estimate)
    group = groups.pop(best)
    level = [name for name, each in groups.items() if overall_difference(group, each).low <= 0]
    most = " most often:" if groups else ""
    numbers = [each.tasks for each in group]
    tasks = f"{numbers[0]}" if len(numbers) == 1 else f"{min(numbers)} to {max(numbers)}"
    same = f" No difference is shown from {' and '.join(level)}." if level else ""
    soon = _delay_in_words(group) if tracks else _half_in_words(group)
    return [
        f"{best} is right{most} in {in_percent(shares[best], kind)}, with {tasks} tasks.{same}",
        f"{soon}; it sends {in_bits(mean_bits(group))} bits per robot-step.",
    ]


def so_far(outcomes: Sequence[Outcome]) -> str:
    """Return which contender is right most often by the runs that are there, in words."""
    return f"after {outcomes[0].runs:,} runs of each: {answer(outcomes)[0]}"


def half_by(group: Sequence[Outcome]) -> float:
    """Return the step by which half of the runs had decided, as median over numbers of tasks; inf: never."""
    steps = sorted(each.found.times.median or math.inf for each in group)
    return steps[len(steps) // 2]


def _half_in_words(group: Sequence[Outcome]) -> str:
    half = half_by(group)
    return f"Half of its swarms had decided by step {half:g}" if math.isfinite(half) else "Most never decide"


def _delay_in_words(group: Sequence[Outcome]) -> str:
    delay = together([each.found for each in group], "detection_delay").estimate
    if math.isnan(delay):
        return "Most changes were never followed"
    return f"It follows half of the changes within {delay:g} steps"


def _row(each: Outcome, baseline: Outcome) -> dict[str, object]:
    """Return the columns of an outcome in ``compare.csv``."""
    declared, tracked = each.declared, each.tracking
    steps = (None, None) if declared is None else declared.step_90[:2]
    words = declared and (round(declared.feasible, 6), round(declared.infeasible, 6))
    row = {
        **{"contender": each.contender, "robots": each.robots, "tasks": each.tasks},
        "truth": DECISIONS[int(each.feasible)],
        "runs": each.runs,
        **columns("accuracy", each.accuracy),
        **columns("first_decision", each.first),
        **columns("brier", each.brier),
        "brier_of": each.said_by,
        **columns(f"difference_from_{baseline.contender}", difference(each, baseline)),
        **columns("step", each.found.times),
        "bits_per_robot_and_step": f"{each.bits.mean():.6g}",
        **{"robots_declared": words and sum(words), "robots_declared_wrong": words and words[each.feasible]},
        **columns("declared_ok", declared and declared.ok),
        **columns("declared_wrong", declared and declared.wrong),
        **dict(zip(("declare_step_median", "declare_step_p95"), steps, strict=True)),
    }
    if tracked is not None:
        for name, measured in tracked._asdict().items():
            row |= {name: measured} if isinstance(measured, int | float) else columns(name, measured)
    return row
