"""What only the first page of an assessment has: the one action, how sure the swarm is, and the evidence."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import version
from typing import TYPE_CHECKING

from feasibee.model.codes import MODEL_VERSION
from feasibee.results.calibration import Calibration
from feasibee.scenario.units import step_in_words, steps_in_words
from feasibee.studies.comparison import Outcome, percent, wait_interval

if TYPE_CHECKING:
    from feasibee.studies.report import Assessment, Trial


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
        return f"Use the strategy {best.contender} instead of {own}. Then {_right(best)}."
    changes = [*_robots(assessment), *_changes(assessment)]
    nothing = "None of the strategies and changes that were tried is shown to be enough."
    if assessment.missing:
        nothing += " Allow more time: not all of them were tried."
    probably = assessment.recommendation.probably
    if not changes:
        return " Of the strategies, ".join([nothing, *probably])
    return min(changes, key=lambda each: each[0])[1]


def _right(outcome: Outcome) -> str:
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


def _robots(assessment: Assessment) -> Iterator[tuple[int, str]]:
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


def _changes(assessment: Assessment) -> Iterator[tuple[int, str]]:
    """Yield the price of each change that is enough, and the instruction."""
    scenario, steps = assessment.scenario, assessment.scenario.run.steps
    for trial in _shown(assessment, assessment.limits):
        then = f"Then {_right(trial.outcome)}."
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


def agreement(found: Calibration | None) -> list[str]:
    """Return how far the agreement of the robots can be trusted; nothing without worlds of both truths."""
    if found is None:
        return []
    score, sure = found.brier, found.sure
    agreed = "In no run do 90 % of the robots agree."
    if sure is not None:
        agreed = f"Where at least 90 % of the robots agree, {percent(sure)} of the swarms are right."
    interval = f"{score.estimate:.3f} ({score.low:.3f} to {score.high:.3f})"
    return [f"{agreed} Brier score of the robots' shares: {interval}; 0 is best, always 1/2 has 0.25."]


def evidence(assessment: Assessment) -> list[str]:
    """Return what an assessment rests on: runs, seed, assumptions and versions."""
    runs = f"{assessment.outcome.runs:,} simulated runs of the swarm"
    scenario, sizing = assessment.scenario, assessment.sizing
    assumed = [] if sizing is None else [f"For numbers of robots and tasks, {sizing.assumption}."]
    return [
        f"{runs}, seed {assessment.seed}. Shares have 95 % intervals; differences hold together with 95 %.",
        "Sensors, radio and motion are as the scenario says. No experiment with robots is included.",
        *assumed,
        f"feasibee {version('feasibee')}, model {MODEL_VERSION}, scenario {scenario.hash[:12]}.",
    ]
