"""Assessments of swarms: their results, in words and as plain tables."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from feasibee.results.statistics import Interval, paired_difference, pareto
from feasibee.scenario.feasibility import Verdict
from feasibee.scenario.html import folded, framed
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import Outcome

SURE = 0.95
"""Share of swarms that must be right for a time to be called sufficient."""


@dataclass(frozen=True)
class Trial:
    """A changed scenario, simulated on the same worlds.

    Parameters
    ----------
    name : str
        Name of the change.
    outcome : Outcome
        Outcome of its runs.
    difference : Interval
        Share of swarms that are right at the end, less that share without the change.
    opposite : Outcome, optional
        Outcome at the reciprocal ratio, where the truth is the opposite.
    """

    name: str
    outcome: Outcome
    difference: Interval
    opposite: Outcome | None = None


@dataclass(frozen=True)
class Assessment:
    """Expected behaviour of a swarm, and what would improve it.

    Parameters
    ----------
    scenario : Scenario
        The assessed scenario.
    verdict : Verdict
        Ground truth, with its proof.
    outcome : Outcome
        Outcome of the unchanged scenario.
    right, wrong, split : Interval
        Share of the swarms in which, at the last step, more than the threshold's share of the robots holds
        the true opinion, the other one, or neither.
    wait : int or None
        First step from which 95 % of the swarms are right until the end; None if there is no such step.
    limits : list of Trial
        Changes that show what limits the swarm, the most helpful first.
    strategies : list of Trial
        The other strategies, the best first.
    opposite : Outcome or None
        Outcome at the reciprocal ratio, where the truth is the opposite; None if robots or tasks have classes
        or tasks have given places.
    """

    scenario: Scenario
    verdict: Verdict
    outcome: Outcome
    right: Interval
    wrong: Interval
    split: Interval
    wait: int | None
    limits: list[Trial]
    strategies: list[Trial]
    opposite: Outcome | None

    @property
    def better(self) -> list[Trial]:
        """Strategies that are significantly better here, and not worse at the opposite truth."""
        return [
            trial
            for trial in self.strategies
            if trial.difference.low > 0 and not _is_worse(trial.opposite, self.opposite)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the assessment as plain tables, for programs."""
        return {
            "scenario": self.scenario.to_dict(),
            "scenario_hash": self.scenario.hash,
            "runs": self.outcome.runs,
            "steps": self.scenario.run.steps,
            "truth": self.verdict.to_dict(),
            **{name: getattr(self, name)._asdict() for name in ("right", "wrong", "split")},
            "first_decision_right": self.outcome.first._asdict(),
            "right_in_95_percent_from_step": self.wait,
            "bits_per_robot_and_step": float(self.outcome.bits.mean()),
            "declared": _declared_as_dict(self.outcome),
            "opposite": _opposite_as_dict(self.opposite),
            "limits": [_as_dict(trial) for trial in self.limits],
            "strategies": [_as_dict(trial) for trial in self.strategies],
        }

    def _repr_html_(self) -> str:
        """Return the assessment as HTML, for notebooks."""
        text = "".join(f"<p>{html.escape(each)}</p>" for each in paragraphs(self))
        tables = folded("strategies", html_table(self.strategies)) + folded(
            "changes", html_table(self.limits)
        )
        return framed(text + tables + folded("scenario", self.scenario._repr_html_()))


def wait_for(outcome: Outcome, share: float = SURE) -> int | None:
    """Return the first step from which a share of the swarms is right until the end; None without one."""
    short = np.flatnonzero(outcome.right_at < share * outcome.runs)
    step = int(short[-1]) + 1 if short.size else 0
    return step if step < outcome.right_at.size else None


def _is_worse(one: Outcome | None, other: Outcome | None) -> bool:
    return one is not None and other is not None and paired_difference(one.right, other.right).high < 0


def _as_dict(trial: Trial) -> dict[str, Any]:
    return {
        "name": trial.name,
        "right": trial.outcome.accuracy._asdict(),
        "difference": trial.difference._asdict(),
        "right_in_95_percent_from_step": wait_for(trial.outcome),
        "bits_per_robot_and_step": float(trial.outcome.bits.mean()),
        "declared": _declared_as_dict(trial.outcome),
        "opposite": _opposite_as_dict(trial.opposite),
    }


def _declared_as_dict(outcome: Outcome) -> dict[str, Any] | None:
    return None if outcome.declared is None else outcome.declared.to_dict()


def _opposite_as_dict(outcome: Outcome | None) -> dict[str, Any] | None:
    return None if outcome is None else {"tasks": outcome.tasks, "right": outcome.accuracy._asdict()}


def paragraphs(assessment: Assessment) -> list[str]:
    """Return the assessment in words: truth, expectation, limits and better strategies, a paragraph each."""
    return [
        _truth_in_words(assessment),
        _expectation_in_words(assessment),
        _limits_in_words(assessment),
        _strategies_in_words(assessment),
    ]


def _truth_in_words(assessment: Assessment) -> str:
    robots, verdict = assessment.scenario.robots.count, assessment.verdict
    if verdict.violator is None:
        free = robots - sum(verdict.assignment.values())
        left = "1 robot is" if free == 1 else f"{free} robots are"
        return f"The tasks are feasible: each place has a robot of its own, and {left} left over."
    skills, demand, able = verdict.violator
    named = f" that can {' or '.join(skills)}" if assessment.scenario.tasks.classes else ""
    return f"The tasks are infeasible: they need {demand} robots{named}, and there are {able}."


def _expectation_in_words(assessment: Assessment) -> str:
    steps, strategy = assessment.scenario.run.steps, assessment.scenario.decision.strategy
    shares = [
        f"{percent(getattr(assessment, name))} {answer}"
        for name, answer in (("right", "are right"), ("wrong", "are wrong"), ("split", "are undecided"))
    ]
    waiting = (
        f"From step {assessment.wait} on, at least 95 % of the swarms are right."
        if assessment.wait is not None
        else "The share of right swarms never stays at 95 % or more."
    )
    first = percent(assessment.outcome.first)
    return (
        f"With {strategy}, after {steps} steps, of {assessment.outcome.runs} simulated swarms "
        f"{', '.join(shares)}. {waiting} The first collective decision is right in {first} of the swarms."
        + _declared_in_words(assessment.outcome)
        + _opposite_in_words(assessment.opposite)
    )


def _declared_in_words(outcome: Outcome) -> str:
    if outcome.declared is None:
        return ""
    ok, wrong, steps = outcome.declared
    when = (
        "Fewer than 95 % of the swarms declare."
        if steps.p95 is None
        else f"By step {steps.p95}, 95 % of the swarms have declared."
    )
    return f" By their own word, {percent(ok)} are right; a robot is wrong in {percent(wrong)}. {when}"


def _opposite_in_words(opposite: Outcome | None) -> str:
    if opposite is None:
        return ""
    return (
        f" With {opposite.tasks} tasks, where the truth is the opposite, {percent(opposite.accuracy)} are "
        "right."
    )


def _limits_in_words(assessment: Assessment) -> str:
    helps = [trial for trial in assessment.limits if trial.difference.low > 0]
    if not helps:
        text = "None of the tried changes makes the swarm right significantly more often."
        return f"{text} The strategy limits it." if assessment.better else text
    text = "; ".join(f"{trial.name}: {points(trial.difference)}" for trial in helps)
    return f"Changes that help (difference in the share of right swarms, with 95 % interval): {text}."


def _strategies_in_words(assessment: Assessment) -> str:
    better = assessment.better
    if not better:
        return "No other strategy is right significantly more often here."
    own = assessment.outcome.bits.mean()
    text = "; ".join(_strategy_in_words(trial) for trial in _chosen(better))
    return f"Strategies that do better (now {own:.3g} bits per robot-step), by bits: {text}."


def _strategy_in_words(trial: Trial) -> str:
    step, other = wait_for(trial.outcome), trial.opposite
    return (
        f"{trial.name}: {points(trial.difference)}, {trial.outcome.bits.mean():.3g} bits per robot-step"
        + ("" if step is None else f", 95 % right from step {step}")
        + ("" if other is None else f", {percent(other.accuracy)} right with {other.tasks} tasks")
    )


def _chosen(better: Sequence[Trial]) -> list[Trial]:
    """Return the three best of the Pareto front of bits and right swarms, and the soonest right strategy."""
    bits = [float(trial.outcome.bits.mean()) for trial in better]
    best = pareto(bits, [trial.outcome.accuracy.estimate for trial in better])[-3:]
    soonest = min(range(len(better)), key=lambda place: wait_for(better[place].outcome) or math.inf)
    return [better[place] for place in sorted({*best, soonest}, key=bits.__getitem__)]


def percent(share: Interval) -> str:
    """Return a share with its interval, in percent."""
    return f"{100 * share.estimate:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f})"


def points(difference: Interval) -> str:
    """Return a difference of shares with its interval, in percentage points."""
    middle, low, high = (100 * value for value in difference)
    return f"{middle:+.1f} points ({low:+.1f} to {high:+.1f})"


def html_table(trials: list[Trial]) -> str:
    """Return trials as a table in HTML."""
    turned = {trial.opposite.tasks for trial in trials if trial.opposite}
    columns: dict[str, Callable[[Trial], str]] = {
        "": lambda trial: html.escape(trial.name),
        "right at the end": lambda trial: percent(trial.outcome.accuracy),
        "difference": lambda trial: points(trial.difference),
        **{f"right with {tasks} tasks": _opposite_share for tasks in turned},
        "bits per robot-step": lambda trial: f"{trial.outcome.bits.mean():.3g}",
    }
    head = "".join(f"<th>{name}</th>" for name in columns)
    rows = "".join(
        f"<tr>{''.join(f'<td>{shown(trial)}</td>' for shown in columns.values())}</tr>" for trial in trials
    )
    return f"<table><tr>{head}</tr>{rows}</table>"


def _opposite_share(trial: Trial) -> str:
    return percent(trial.opposite.accuracy) if trial.opposite else ""
