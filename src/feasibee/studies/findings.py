"""What an assessment of a swarm found: its results as plain tables, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final, NamedTuple

from feasibee.model.codes import MODEL_VERSION
from feasibee.results.statistics import Interval
from feasibee.scenario.feasibility import Verdict as Truth
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import Outcome, difference, wait_for
from feasibee.studies.needs import Asked
from feasibee.studies.recommend import Candidate, Recommendation
from feasibee.studies.size import Band, Sizing

READY, UNCERTAIN, NOT_READY = "ready", "uncertain", "not ready"
SIGNS: Final = {READY: ("green", "●"), UNCERTAIN: ("amber", "▲"), NOT_READY: ("red", "■")}
"""The colour and the shape of each verdict."""


@dataclass(frozen=True)
class Trial:
    """A changed scenario, simulated on the same worlds."""

    name: str
    """Name of the change."""
    outcome: Outcome
    """Outcome of its runs."""
    difference: Interval
    """Share of swarms that are right at the end, less that share without the change; in a world that changes,
    share of steps."""
    opposite: Outcome | None = None
    """Outcome at the reciprocal ratio, where the truth is the opposite."""


class Judged(NamedTuple):
    """Whether a swarm can be deployed."""

    level: str
    """``"ready"``, ``"uncertain"`` or ``"not ready"``."""
    right: Interval
    """Share of swarms that are right, of the two worlds in the one where it is smaller; or share of steps."""
    tasks: int
    """Number of tasks of that world."""

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict as plain tables, for programs."""
        colour, shape = SIGNS[self.level]
        return {
            "level": self.level,
            "colour": colour,
            "shape": shape,
            "right": self.right._asdict(),
            "tasks": self.tasks,
        }


@dataclass(frozen=True)
class Findings:
    """Expected behaviour of a swarm, and what would improve it."""

    scenario: Scenario
    """The assessed scenario."""
    truth: Truth
    """Ground truth, with its proof."""
    target: float
    """Share of swarms that must be right."""
    outcome: Outcome
    """Outcome of the unchanged scenario."""
    right: Interval
    wrong: Interval
    split: Interval
    """Share of the swarms of each kind at the last step. More than the threshold's share of the robots holds
    the true opinion, the other one, or neither."""
    wait: int | None
    """First step from which the target's share of the swarms is right until the end; None without one."""
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
    recommended_asked: Asked | None
    """What it asks of the robots."""
    recommended_band: Band | None
    """Its blind band."""
    faults: list[Trial]
    """The recommended strategy with single faults, or its own one if none is recommended."""
    seed: int
    """Seed of the runs."""

    @property
    def better(self) -> list[Trial]:
        """Strategies that are significantly better here, and not worse at the opposite truth."""
        return [
            trial
            for trial in self.strategies
            if trial.difference.low > 0 and not _is_worse(trial.opposite, self.opposite)
        ]

    @property
    def verdict(self) -> Judged:
        """Whether the swarm can be deployed: judged in its world and at the opposite truth."""
        own = self.right if self.outcome.tracking is None else self.outcome.judged
        worlds = [(own, self.outcome.tasks)]
        if self.opposite is not None:
            worlds.append((self.opposite.accuracy, self.opposite.tasks))
        worst, tasks = min(worlds, key=lambda world: world[0].estimate)
        level = READY if worst.low >= self.target else UNCERTAIN
        return Judged(NOT_READY if worst.high < self.target else level, worst, tasks)

    def to_dict(self) -> dict[str, Any]:
        """Return the assessment as plain tables, for programs."""
        return {
            "verdict": {**self.verdict.to_dict(), "target": self.target},
            "scenario": self.scenario.to_dict(),
            "scenario_hash": self.scenario.hash,
            "runs": self.outcome.runs,
            "steps": self.scenario.run.steps,
            "truth": self.truth.to_dict(),
            **{name: getattr(self, name)._asdict() for name in ("right", "wrong", "split")},
            "first_decision_right": self.outcome.first._asdict(),
            "right_from_step": self.wait,
            "bits_per_robot_and_step": float(self.outcome.bits.mean()),
            "asked": self.asked._asdict(),
            **self.outcome.words_and_tracking(),
            "opposite": _opposite_as_dict(self.opposite),
            "size": None if self.sizing is None else self.sizing.to_dict(),
            "recommended": self._recommended_as_dict(),
            "excluded": dict(self.recommendation.excluded),
            "faults": [self._as_dict(trial) for trial in self.faults],
            "limits": [self._as_dict(trial) for trial in self.limits],
            "strategies": [self._as_dict(trial) for trial in self.strategies],
            "seed": self.seed,
            "version": version("feasibee"),
            "model_version": MODEL_VERSION,
        }

    def _recommended_as_dict(self) -> dict[str, Any] | None:
        if self.recommended is None or self.recommended_asked is None:
            return None
        band = None if self.recommended_band is None else self.recommended_band.to_dict()
        asked = self.recommended_asked._asdict()
        return {**self.recommended.to_dict(), "asked": asked, "blind_band": band}

    def _as_dict(self, trial: Trial) -> dict[str, Any]:
        return {
            "name": trial.name,
            "right": trial.outcome.accuracy._asdict(),
            "difference": trial.difference._asdict(),
            "right_from_step": wait_for(trial.outcome, self.target),
            "bits_per_robot_and_step": float(trial.outcome.bits.mean()),
            **trial.outcome.words_and_tracking(),
            "opposite": _opposite_as_dict(trial.opposite),
        }


def _is_worse(one: Outcome | None, other: Outcome | None) -> bool:
    return one is not None and other is not None and difference(one, other).high < 0


def _opposite_as_dict(outcome: Outcome | None) -> dict[str, Any] | None:
    return None if outcome is None else {"tasks": outcome.tasks, "right": outcome.accuracy._asdict()}
