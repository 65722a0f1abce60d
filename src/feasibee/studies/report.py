"""What an assessment of a swarm found: plain tables, the verdict, and words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final, NamedTuple

from feasibee.model.codes import MODEL_VERSION
from feasibee.results.calibration import SHARES, Calibration
from feasibee.results.statistics import CONFIDENCE, Interval, pareto, plain, wilson
from feasibee.scenario.feasibility import Verdict as Truth
from feasibee.scenario.feasibility import who_counts
from feasibee.scenario.html import render
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import length_in_words, step_in_words, steps_in_words, when_in_words
from feasibee.studies.comparison import (
    Outcome,
    calibration_of,
    difference,
    origin,
    percent,
    points,
    wait_for,
    wait_interval,
)
from feasibee.studies.needs import (
    IDS,
    NAMES,
    Asked,
    needs_of,
    noisy_names_in_words,
    waiting_in_words,
)
from feasibee.studies.race import MARGIN, is_clear, is_none
from feasibee.studies.recommend import Candidate, Recommendation
from feasibee.studies.size import Band, Sizing, band_sentence, sentences

READY, UNCERTAIN, NOT_READY = "ready", "uncertain", "not ready"
SIGNS: Final = {READY: ("green", "●"), UNCERTAIN: ("amber", "▲"), NOT_READY: ("red", "■")}
"""The colour and the shape of each verdict."""


@dataclass(frozen=True)
class Trial:
    """A changed scenario, simulated on the same worlds."""

    outcome: Outcome
    """Outcome of its runs; its contender is the name of the change."""
    difference: Interval
    """Share of swarms that are right at the end, less that share without the change; in a world that changes,
    share of steps."""
    opposite: Outcome | None = None
    """Outcome at the reciprocal ratio, where the truth is the opposite."""
    price: int = 0
    """Place among the changes in the order of what they cost, 0 for the cheapest."""


class Judged(NamedTuple):
    """Whether a swarm can be deployed."""

    level: str
    """``"ready"``, ``"uncertain"`` or ``"not ready"``."""
    right: Interval
    """Share of swarms that are right, of the two worlds in the one where it is smaller; or share of steps."""
    tasks: int
    """Number of tasks of that world."""


def judge(worlds: Sequence[Outcome], target: float) -> Judged:
    """Return whether a swarm can be deployed, from its outcomes in its world and at the opposite truth."""
    worst = min(worlds, key=lambda world: world.judged.estimate)
    level = READY if worst.judged.low >= target else UNCERTAIN
    return Judged(NOT_READY if worst.judged.high < target else level, worst.judged, worst.tasks)


@dataclass(frozen=True)
class Assessment:
    """Expected behaviour of a swarm, and what would improve it."""

    scenario: Scenario
    """The assessed scenario."""
    truth: Truth
    """Ground truth, with its proof."""
    target: float
    """Share of swarms that must be right."""
    outcome: Outcome
    """Outcome of the unchanged scenario."""
    asked: Asked
    """What the strategy asks of the robots."""
    sizing: Sizing | None
    """How many robots are enough for the tasks, and the blind band; None if robots have classes or given
    places."""
    limits: list[Trial]
    """Changes that show what limits the swarm, the most helpful first."""
    strategies: list[Trial]
    """The other strategies, the best first."""
    opposite: Outcome | None
    """Outcome at the reciprocal ratio, where the truth is the opposite; None if robots or tasks have classes
    or tasks have given places."""
    recommendation: Recommendation
    """Strategies that reach the target in both worlds."""
    recommended: Candidate | None
    """The scenario's own strategy if it is among these, or the first of them; None without any."""
    recommended_band: Band | None
    """Its blind band."""
    faults: list[Trial]
    """The recommended strategy with single faults, or its own one if none is recommended."""
    seed: int
    """Seed of the runs."""
    confidence: float = CONFIDENCE
    """Confidence of each difference, so that all hold together."""
    stopped: str = ""
    """Why the assessment ended early, if it did."""
    missing: tuple[str, ...] = ()
    """Phases that then were not complete."""

    @property
    def shares(self) -> dict[str, Interval]:
        """Shares of the swarms that are right, wrong and split at the last step.

        More than the threshold's share of the robots holds the true opinion, the other one, or neither.
        """
        right, held, runs = int(self.outcome.right.sum()), int(self.outcome.agreed.sum()), self.outcome.runs
        counts = {"right": right, "wrong": held - right, "split": runs - held}
        return {name: wilson(count, runs) for name, count in counts.items()}

    @property
    def wait(self) -> int | None:
        """First step from which the target's share of the swarms is right until the end; None without one."""
        return wait_for(self.outcome, self.target)

    @property
    def calibration(self) -> Calibration | None:
        """How good the probabilities are that swarms give to *feasible*; None without the opposite truth."""
        return calibration_of([each for each in (self.outcome, self.opposite) if each])

    @property
    def better(self) -> list[Trial]:
        """Strategies that are significantly better here, and not worse at the opposite truth."""
        return [
            trial for trial in self.strategies if trial.difference.low > 0 and not self._is_worse_there(trial)
        ]

    def _is_worse_there(self, trial: Trial) -> bool:
        """Whether a strategy is shown to be worse at the opposite truth."""
        if trial.opposite is None or self.opposite is None:
            return False
        return difference(trial.opposite, self.opposite, self.confidence).high < 0

    @property
    def verdict(self) -> Judged:
        """Whether the swarm can be deployed: judged in its world and at the opposite truth."""
        return judge([each for each in (self.outcome, self.opposite) if each is not None], self.target)

    def to_dict(self) -> dict[str, Any]:
        """Return the assessment as plain tables, for programs."""
        level, right, tasks = self.verdict
        colour, shape = SIGNS[level]
        sign = {"level": level, "colour": colour, "shape": shape}
        return {
            "verdict": {**sign, "right": right._asdict(), "tasks": tasks, "target": self.target},
            "action": action(self),
            "scenario": self.scenario.to_dict(),
            "runs": self.outcome.runs,
            "stopped": self.stopped,
            "missing": list(self.missing),
            "steps": self.scenario.run.steps,
            "truth": self.truth.to_dict(),
            **{name: share._asdict() for name, share in self.shares.items()},
            "first_decision_right": self.outcome.first._asdict(),
            "right_from_step": self.wait,
            "bits_per_robot_and_step": float(self.outcome.bits.mean()),
            "asked": self.asked.to_dict(),
            **self.outcome.found.to_dict(),
            "opposite": _opposite_as_dict(self.opposite),
            "calibration": plain(self.calibration),
            "brier_of": self.outcome.said_by,
            "size": None if self.sizing is None else self.sizing.to_dict(),
            "recommended": self._recommended_as_dict(),
            "excluded": dict(self.recommendation.excluded),
            "faults": [self._as_dict(trial) for trial in self.faults],
            "limits": [self._as_dict(trial) for trial in self.limits],
            "strategies": [self._as_dict(trial) for trial in self.strategies],
            **origin(self.seed, self.scenario),
        }

    def _repr_html_(self) -> str:
        """Return the assessment as HTML, for notebooks."""
        return render("cell.html", a=self, words=sections(self), percent=percent, points=points)

    def _recommended_as_dict(self) -> dict[str, Any] | None:
        if self.recommended is None:
            return None
        band = None if self.recommended_band is None else self.recommended_band.to_dict()
        asked = self.recommended.asked.to_dict()
        return {**self.recommended.to_dict(), "asked": asked, "blind_band": band}

    def _as_dict(self, trial: Trial) -> dict[str, Any]:
        return {
            "name": trial.outcome.contender,
            "runs": trial.outcome.runs,
            "right": trial.outcome.accuracy._asdict(),
            "difference": trial.difference._asdict(),
            "right_from_step": wait_for(trial.outcome, self.target),
            "bits_per_robot_and_step": float(trial.outcome.bits.mean()),
            **trial.outcome.found.to_dict(),
            "opposite": _opposite_as_dict(trial.opposite),
        }


def _opposite_as_dict(outcome: Outcome | None) -> dict[str, Any] | None:
    return None if outcome is None else {"tasks": outcome.tasks, "right": outcome.accuracy._asdict()}


def sections(assessment: Assessment) -> dict[str, list[str]]:
    """Return an assessment in words: the lines of each section, by its title; see ``assessment.txt``."""
    found: dict[str, list[str]] = {}
    for line in render("assessment.txt", a=assessment, **_words(assessment)).splitlines():
        if line.startswith("# "):
            lines = found[line[2:]] = []
        elif line.startswith("- "):
            lines.append(line[2:].strip())
        elif more := line.strip():
            lines[-1] += f" {more}"
    return {title: lines for title, lines in found.items() if lines}


def _words(assessment: Assessment) -> dict[str, Any]:
    """Return what the words of an assessment need in addition to it: what is computed, and functions."""
    scenario, recommended, sizing = assessment.scenario, assessment.recommended, assessment.sizing
    asked = {scenario.decision.strategy: assessment.asked}
    if recommended is not None:
        asked.setdefault(recommended.strategy, recommended.asked)
    return {
        "sign": SIGNS[assessment.verdict.level],
        "action": action(assessment),
        "who": who_counts(scenario),
        "waits": wait_interval(assessment.outcome, assessment.target),
        "warnings": [
            *waiting_in_words(scenario),
            *noisy_names_in_words(scenario),
        ],
        "waiting_there": [] if recommended is None else waiting_in_words(recommended.scenario),
        "sides": _sides(sizing.band, scenario.robots.count) if sizing is not None and sizing.band else None,
        "unseen": not scenario.sensing.count_self and NAMES not in needs_of(scenario),
        "asked": asked,
        "chosen": _chosen(assessment.better),
        "version": version("feasibee"),
        "model_version": MODEL_VERSION,
        "needs": NEEDS,
        "MARGIN": MARGIN,
        "SHARES": SHARES,
        **{each.__name__: each for each in CALLED},
    }


def _sides(band: Band, robots: int) -> tuple[Interval, Interval]:
    """Return the shares of right swarms with as many tasks as robots, and with one more."""
    shares = {value: each.interval for edge in (band.below, band.above) for value, each in edge.tested}
    return shares[robots], shares[robots + 1]


def action(assessment: Assessment) -> str:
    """Return the cheapest change that is shown to reach the target in both worlds, as an instruction.

    Cheap to expensive: no change, another strategy, then the other changes in the order of their prices.
    """
    own, found = assessment.scenario.decision.strategy, assessment.recommended
    if assessment.verdict.right.low >= assessment.target:
        return f"Use the swarm as it is, with {own}."
    if found is not None and found.strategy == own:
        return f"Use the swarm as it is, with {own}. Further runs show that it is enough."
    if found is not None:
        needs = f" It needs {' and '.join(found.asked.needs)}." if found.asked.needs else ""
        right = f"{percent(found.worst.right)} are right with {found.worst.outcome.tasks} tasks."
        return f"Use the strategy {found.strategy} instead of {own}. Then {right}{needs}"
    if assessment.outcome.tracking is not None and (enough := _shown(assessment, assessment.strategies)):
        best = min(enough, key=lambda trial: float(trial.outcome.bits.mean())).outcome
        return f"Use the strategy {best.contender} instead of {own}. Then {_swarms_right(best)}."
    changes = [*_more_robots(assessment), *_cheap_changes(assessment)]
    nothing = "None of the strategies and changes that were tried is shown to be enough."
    if assessment.missing:
        nothing += " Allow more time: not all of them were tried."
    probably = assessment.recommendation.probably
    if not changes:
        return " Of the strategies, ".join([nothing, *probably])
    return min(changes, key=lambda each: each[0])[1]


def _swarms_right(outcome: Outcome) -> str:
    kind = "swarms" if outcome.tracking is None else "steps"
    return f"{percent(outcome.judged)} of the {kind} are right"


def _shown(assessment: Assessment, trials: list[Trial]) -> list[Trial]:
    """Return the better ones that reach the target, where they were tried also at the opposite truth."""
    return [
        trial
        for trial in trials
        if trial.difference.low > 0
        and all(each.judged.low >= assessment.target for each in (trial.outcome, trial.opposite) if each)
    ]


def _more_robots(assessment: Assessment) -> Iterator[tuple[int, str]]:
    """Yield the price and the least number of robots that is enough, if more robots are."""
    scenario, sizing, other = assessment.scenario, assessment.sizing, assessment.opposite
    least, robots = (None if sizing is None else sizing.edge.enough), scenario.robots.count
    if least is None or least <= robots or (other is not None and other.judged.low < assessment.target):
        return
    price = next((each.price for each in assessment.limits if each.outcome.robots > robots), 0)
    yield (
        price,
        f"Use {least:g} robots, {least - robots:g} more. That was tested with {scenario.tasks.count} tasks.",
    )


def _cheap_changes(assessment: Assessment) -> Iterator[tuple[int, str]]:
    """Yield the price of each change that is enough, and the instruction."""
    scenario, steps = assessment.scenario, assessment.scenario.run.steps
    for trial in _shown(assessment, assessment.limits):
        then = f"Then {_swarms_right(trial.outcome)}."
        waits = [
            wait_interval(each, assessment.target)[1] for each in (trial.outcome, trial.opposite) if each
        ]
        last = None if None in waits else max(wait for wait in waits if wait is not None)
        if trial.outcome.right_at.size - 1 > steps and last is not None and last > steps:
            longer = steps_in_words(scenario, last - steps)
            yield (
                trial.price,
                f"Let the swarm run until {step_in_words(scenario, last)}, {longer} longer. {then}",
            )
        else:
            yield trial.price, f"Change this: {trial.outcome.contender}. {then}"


def _chosen(better: Sequence[Trial]) -> list[Trial]:
    """Return the three best of the Pareto front of bits and right swarms."""
    bits = [float(trial.outcome.bits.mean()) for trial in better]
    best = pareto(bits, [trial.outcome.judged.estimate for trial in better])[-3:]
    return [better[place] for place in sorted(best, key=bits.__getitem__)]


NEEDS: Final = {
    IDS: "every robot must have an id that is never misread",
    NAMES: "all robots must have the same name for a task, such as its position in a shared frame",
}
CALLED: Final = (
    *(percent, points, is_clear, is_none, wait_for, sentences, band_sentence),
    *(length_in_words, step_in_words, steps_in_words, when_in_words),
)
"""Functions that the words of an assessment call."""
