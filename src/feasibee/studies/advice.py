"""Assessments in words: sections of short lines, the verdict first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from feasibee.results.statistics import Interval, pareto
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import length_in_words, step_in_words, steps_in_words
from feasibee.studies.comparison import Outcome
from feasibee.studies.findings import (
    NOT_READY,
    READY,
    SIGNS,
    UNCERTAIN,
    Findings,
    Trial,
)
from feasibee.studies.needs import IDS, NAMES, Asked, needs_of, quiet_times_in_words
from feasibee.studies.shares import percent, points, wait_for
from feasibee.studies.sizing import Band, band_sentence, edge_sentence

WORDS = {READY: "Ready", UNCERTAIN: "Uncertain", NOT_READY: "Not ready"}


class Section(NamedTuple):
    """A part of an assessment in words."""

    title: str
    lines: Sequence[str]


def sections(assessment: Findings) -> list[Section]:
    """Return an assessment in words."""
    found = [
        Section("Verdict", [verdict_sentence(assessment)]),
        Section("Recommended", _recommended(assessment)),
        Section("What to expect", _expected(assessment)),
        Section("How many robots, for how many tasks", _sized(assessment)),
        Section("What is asked of the robots", _asked(assessment)),
        Section("If something fails", _faults(assessment)),
        Section("What would help", _changes(assessment)),
    ]
    return [each for each in found if each.lines]


def verdict_sentence(assessment: Findings) -> str:
    """Return the verdict in a sentence, with one number and its interval."""
    level, right, tasks = assessment.verdict
    shape = SIGNS[level][1]
    steps = steps_in_words(assessment.scenario, assessment.scenario.run.steps)
    other = (
        "" if tasks == assessment.outcome.tasks else f" with {tasks} tasks, where the truth is the opposite"
    )
    wanted = f"{100 * assessment.target:g} % are asked for"
    text = (
        f"{percent(right)} of such swarms are right after {steps}{other}; {wanted}."
        if assessment.outcome.tracking is None
        else f"such swarms are right in {percent(right)} of {steps}; {wanted}."
    )
    return f"{shape} {WORDS[level]}: {text}"


def _expected(assessment: Findings) -> list[str]:
    outcome, target = assessment.outcome, f"{100 * assessment.target:g} %"
    shares = [
        f"{percent(getattr(assessment, name))} {answer}"
        for name, answer in (("right", "are right"), ("wrong", "are wrong"), ("split", "are undecided"))
    ]
    waiting = (
        f"From {step_in_words(assessment.scenario, assessment.wait)} on, at least {target} of the swarms are "
        "right."
        if assessment.wait is not None
        else f"The share of right swarms never stays at {target} or more."
    )
    lines = [
        _truth(assessment),
        f"With {assessment.scenario.decision.strategy}, of {outcome.runs} simulated swarms "
        f"{', '.join(shares)}{'' if outcome.tracking is None else ', at the end'}.",
        waiting,
        f"The first collective decision is right in {percent(outcome.first)} of the swarms.",
        *_declared(outcome, assessment.scenario),
        *_tracking(outcome, assessment.scenario),
    ]
    other = assessment.opposite
    if other is not None:
        lines.append(
            f"With {other.tasks} tasks, where the truth is the opposite, {percent(other.accuracy)} are right."
        )
    return lines


def _truth(assessment: Findings) -> str:
    robots, truth = assessment.scenario.robots.count, assessment.truth
    if assessment.outcome.tracking is not None:
        answer = "feasible" if truth.feasible else "infeasible"
        return f"The world changes. Before any change, the tasks are {answer}."
    if truth.violator is None:
        free = robots - sum(truth.assignment.values())
        left = "1 robot is" if free == 1 else f"{free} robots are"
        return f"The tasks are feasible: each place has a robot of its own, and {left} left over."
    skills, demand, able = truth.violator
    named = f" that can {' or '.join(skills)}" if assessment.scenario.tasks.classes else ""
    return f"The tasks are infeasible: they need {demand} robots{named}, and there are {able}."


def _declared(outcome: Outcome, scenario: Scenario) -> list[str]:
    if outcome.declared is None:
        return []
    ok, wrong, steps = outcome.declared
    when = (
        "Fewer than 95 % of the swarms declare."
        if steps.p95 is None
        else f"By {step_in_words(scenario, steps.p95)}, 95 % of the swarms have declared."
    )
    told = f"By their own word, {percent(ok)} are right; a robot is wrong in {percent(wrong)}. {when}"
    waits = scenario.decision.parameters.get("quiet", scenario.manifest.parameters.get("quiet")) == 0
    return [told, *(quiet_times_in_words(scenario) if waits else [])]


def _tracking(outcome: Outcome, scenario: Scenario) -> list[str]:
    """Return how the swarms tracked the truth, in words."""
    if outcome.tracking is None:
        return []
    _, delay, missed, changes, alarms = outcome.tracking
    rate = f"{alarms.estimate:.3g} ({alarms.low:.3g} to {alarms.high:.3g}) false alarms per 1,000 steps."
    if missed is None:
        return [f"No swarm was right just before a change of truth. There are {rate}"]
    half = "never" if delay.median is None else f"within {steps_in_words(scenario, delay.median)}"
    return [
        f"Of {changes:,} changes of truth just before which a swarm was right, it follows half {half}, and "
        f"misses {percent(missed)}. There are {rate}"
    ]


def _sized(assessment: Findings) -> list[str]:
    sizing = assessment.sizing
    if sizing is None:
        return []
    lines = [edge_sentence(sizing)]
    if sizing.band is not None:
        robots = assessment.scenario.robots.count
        lines += [
            band_sentence(sizing.band, robots, assessment.target),
            *bias_in_words(sizing.band, assessment.scenario),
        ]
    return lines


def bias_in_words(band: Band, scenario: Scenario) -> list[str]:
    """Return how often a swarm is right on both sides of the truth, and why one is harder, if it is."""
    robots = scenario.robots.count
    shares = {value: each.interval for edge in (band.below, band.above) for value, each in edge.tested}
    here, there = shares[robots], shares[robots + 1]
    lines = [f"With {robots} tasks {percent(here)} are right, with {robots + 1} tasks {percent(there)}."]
    if here.high < there.low:
        why = f"The swarm leans to infeasible around {robots} tasks."
        if not scenario.sensing.count_self and NAMES not in needs_of(scenario):
            why += (
                f" Robots don't see themselves: each can see {robots - 1} others, so that {robots} tasks "
                "look like one too many. The strategy estimate corrects for it; so does sensing.count_self."
            )
        lines.append(why)
    elif there.high < here.low:
        lines.append(f"The swarm leans to feasible around {robots} tasks.")
    return lines


def _asked(assessment: Findings) -> list[str]:
    lines = [
        f"{assessment.scenario.decision.strategy}: {_asked_in_words(assessment.asked, assessment.scenario)}."
    ]
    recommended, asked = assessment.recommended, assessment.recommended_asked
    if (
        recommended is not None
        and asked is not None
        and recommended.strategy != assessment.scenario.decision.strategy
    ):
        lines.append(f"{recommended.strategy}: {_asked_in_words(asked, assessment.scenario)}.")
    return lines


def _asked_in_words(asked: Asked, scenario: Scenario) -> str:
    needs = {
        IDS: "every robot must have an id that is never mistaken",
        NAMES: "all robots must have the same name for a task, such as its position in a shared frame",
    }
    needed = "; ".join(needs.get(each, f"each robot must know {each}") for each in asked.needs)
    parts = [
        needed or "no ids that are never mistaken, no names of tasks, no known number of robots",
        f"messages of up to {asked.message_bits} bits",
        f"sight {length_in_words(scenario, asked.sight)}, radio {length_in_words(scenario, asked.radio)}",
        f"{math.ceil(asked.memory_bits / 8):,} bytes of memory",
    ]
    return "; ".join(parts)


def _recommended(assessment: Findings) -> list[str]:
    found = assessment.recommended
    target = f"{100 * assessment.target:g} %"
    if assessment.outcome.tracking is not None:
        return _best_tracker(assessment)
    if found is None:
        return [
            f"No strategy is shown to be right in {target} of the swarms, here and at the opposite truth."
            " feasibee recommend says which constraint to relax."
        ]
    text = (
        f"right in {percent(found.worst.right)}, with {found.worst.tasks} tasks; "
        f"{found.bits:.3g} bits per robot-step"
        + (
            ""
            if found.step is None
            else f"; {target} are right from {step_in_words(found.scenario, found.step)} on"
        )
    )
    own = found.strategy == assessment.scenario.decision.strategy
    lines = [f"{found.strategy}{', as it is' if own else ''}: {text}."]
    lines += _declared(found.worst.outcome, found.scenario)
    if assessment.recommended_band is not None:
        robots = assessment.scenario.robots.count
        lines.append(band_sentence(assessment.recommended_band, robots, assessment.target))
    return lines


def _best_tracker(assessment: Findings) -> list[str]:
    """Return the strategy that is right in most steps of a world that changes."""
    own = assessment.scenario.decision.strategy
    tried = {own: assessment.outcome, **{trial.name: trial.outcome for trial in assessment.strategies}}
    name = max(tried, key=lambda each: tried[each].judged.estimate)
    same = " (as it is)" if name == own else ""
    found = tried[name]
    return [
        f"Of {len(tried)} strategies, {name}{same} is right in the most steps: {percent(found.judged)}; "
        f"{found.bits.mean():.3g} bits per robot-step.",
        *_tracking(found, assessment.scenario),
    ]


def _faults(assessment: Findings) -> list[str]:
    chosen = assessment.scenario if assessment.recommended is None else assessment.recommended.scenario
    name = chosen.decision.strategy
    return [
        f"{name}, {trial.name}: {_right(trial.outcome)}, {_gain(trial.difference)}."
        for trial in assessment.faults
    ]


def _changes(assessment: Findings) -> list[str]:
    helps = [trial for trial in assessment.limits if trial.difference.low > 0]
    lines = [f"{trial.name}: {points(trial.difference)}." for trial in helps]
    if not helps:
        lines = ["None of the tried changes makes the swarm right significantly more often."]
    better = _chosen(assessment.better)
    return lines + [_strategy_in_words(trial, assessment.target) for trial in better]


def _strategy_in_words(trial: Trial, target: float) -> str:
    step, other = wait_for(trial.outcome, target), trial.opposite
    return (
        f"strategy {trial.name}: {points(trial.difference)}, "
        f"{trial.outcome.bits.mean():.3g} bits per robot-step"
        + ("" if step is None else f", {100 * target:g} % right from step {step}")
        + ("" if other is None else f", {percent(other.accuracy)} right with {other.tasks} tasks")
        + "."
    )


def _chosen(better: Sequence[Trial]) -> list[Trial]:
    """Return the three best of the Pareto front of bits and right swarms."""
    bits = [float(trial.outcome.bits.mean()) for trial in better]
    best = pareto(bits, [trial.outcome.judged.estimate for trial in better])[-3:]
    return [better[place] for place in sorted(best, key=bits.__getitem__)]


def _right(outcome: Outcome) -> str:
    """Return the share that judges an outcome, in words."""
    share = percent(outcome.judged)
    return f"{share} are right" if outcome.tracking is None else f"right in {share} of the steps"


def _gain(difference: Interval) -> str:
    change = 100 * difference.estimate
    return "as without it" if round(change, 1) == 0 else f"{change:+.1f} points"
