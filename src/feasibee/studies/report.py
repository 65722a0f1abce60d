"""What an assessment of a swarm found: plain tables, the verdict, and words."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any, Final, NamedTuple

from feasibee.model.codes import MODEL_VERSION
from feasibee.results.calibration import SHARES, Calibration
from feasibee.results.statistics import CONFIDENCE, Interval, pareto, plain, wilson
from feasibee.scenario.feasibility import Verdict as Truth
from feasibee.scenario.feasibility import who_counts
from feasibee.scenario.html import folded, framed
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
from feasibee.studies.flooding import go_on
from feasibee.studies.needs import (
    IDS,
    NAMES,
    Asked,
    give_up,
    needs_of,
    noisy_names_in_words,
    waiting_in_words,
)
from feasibee.studies.race import MARGIN, is_clear, is_none
from feasibee.studies.recommend import Candidate, Recommendation
from feasibee.studies.rooms import Split, rooms_in_words
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
    rooms: Mapping[str, Split] = field(default_factory=dict)
    """In a place with rooms: how swarms split into them as it is, under an empty name, and with changes."""

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
            **({"rooms": plain(self.rooms)} if self.rooms else {}),
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
        tables = {"Strategies": self.strategies, "Changes": self.limits, "Faults": self.faults}
        parts = [section_as_html(*each) for each in sections(self).items()]
        parts += [
            folded(name, table_as_html(name, cells_of(trials)) if trials else "")
            for name, trials in tables.items()
        ]
        return framed("".join(parts) + folded("Scenario", self.scenario._repr_html_()))

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
    """Return an assessment in words: the lines of each section, by its title."""
    sizing = assessment.sizing
    sized = [] if sizing is None else sentences(sizing)
    if sizing is not None and sizing.band:
        sized += bias_in_words(sizing.band, assessment.scenario)
    found = {
        "Verdict": [verdict_sentence(assessment), *_ended_early(assessment)],
        "What to do": [action(assessment)],
        "Recommended": _recommended(assessment),
        "What to expect": _expected(assessment),
        "How many robots, for how many tasks": sized,
        "What is asked of the robots": _asked(assessment),
        "If something fails": _faults(assessment),
        "What would help": _changes(assessment),
        "What this rests on": evidence(assessment),
    }
    return {title: lines for title, lines in found.items() if lines}


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


def agreement(assessment: Assessment) -> list[str]:
    """Return how far the robots' confidence can be trusted; nothing without worlds of both truths."""
    found, by = assessment.calibration, assessment.outcome.said_by
    if found is None:
        return []
    score, sure = found.brier, found.sure
    agreed = "In no run are 90 % on one side."
    if sure is not None:
        where = "the robots agree" if by == SHARES else "the probability goes to one truth"
        agreed = f"Where at least 90 % of {where}, {percent(sure)} of the swarms are right."
    interval = f"{score.estimate:.3f} ({score.low:.3f} to {score.high:.3f})"
    parts = f"{found.reliability:.3f} - {found.resolution:.3f} + {found.uncertainty:.3f}"
    return [
        f"{agreed} Brier score of the {by}: {interval}; 0 is best, always 1/2 has 0.25. It is "
        f"reliability - resolution + uncertainty: {parts}."
    ]


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


def _ended_early(assessment: Assessment) -> list[str]:
    if not assessment.stopped:
        return []
    missing = ", ".join(assessment.missing)
    return [f"The assessment ended early ({assessment.stopped}). More time would complete: {missing}."]


def verdict_sentence(assessment: Assessment) -> str:
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
    return f"{shape} {level.capitalize()}: {text}"


def _expected(assessment: Assessment) -> list[str]:
    outcome, target = assessment.outcome, f"{100 * assessment.target:g} %"
    answers = {"right": "are right", "wrong": "are wrong", "split": "are undecided"}
    shares = [f"{percent(share)} {answers[name]}" for name, share in assessment.shares.items()]
    steps = (assessment.wait, *wait_interval(outcome, assessment.target))
    since, first, last = (when_in_words(assessment.scenario, each).removeprefix("by ") for each in steps)
    interval = "" if first == last == "never" else f" (95 % interval: {first} to {last})"
    waiting = (
        f"From {since} on{interval}, at least {target} of the swarms are right."
        if assessment.wait is not None
        else f"The share of right swarms never stays at {target} or more{interval}."
    )
    lines = [
        _truth(assessment),
        *filter(None, [who_counts(assessment.scenario)]),
        f"With {assessment.scenario.decision.strategy}, of {outcome.runs} simulated swarms "
        f"{', '.join(shares)}{'' if outcome.tracking is None else ', at the end'}.",
        waiting,
        f"The first collective decision is right in {percent(outcome.first)} of the swarms.",
        *_declared(outcome, assessment.scenario),
        *_tracking(outcome, assessment.scenario),
        *acted_in_words(outcome, assessment.scenario),
        *waiting_in_words(assessment.scenario, give_up if assessment.stopped else go_on),
        *rooms_in_words(assessment.rooms),
        *noisy_names_in_words(assessment.scenario),
    ]
    other = assessment.opposite
    if other is not None:
        lines.append(
            f"With {other.tasks} tasks, where the truth is the opposite, {percent(other.accuracy)} are right."
        )
        lines += [
            f"With {other.tasks} tasks, {each[0].lower()}{each[1:]}"
            for each in acted_in_words(other, assessment.scenario)
        ]
    return lines + agreement(assessment)


def _truth(assessment: Assessment) -> str:
    robots, truth = assessment.scenario.robots.count, assessment.truth
    if assessment.outcome.tracking is not None:
        answer = "feasible" if truth.feasible else "infeasible"
        return f"The world changes. Before any change, the tasks are {answer}."
    if truth.violator is None:
        free = robots - sum(truth.assignment.values())
        left = "1 robot is" if free == 1 else f"{free} robots are"
        return f"The tasks are feasible: each task can have its own robots, and {left} left over."
    skills, demand, able = truth.violator
    named = f" that can {' or '.join(skills)}" if assessment.scenario.tasks.classes else ""
    where, of = (f"{truth.where}, ", f" of {robots}") if truth.where else ("", "")
    return f"The tasks are infeasible: {where}they need {demand} robots{named}, and there are {able}{of}."


def _declared(outcome: Outcome, scenario: Scenario) -> list[str]:
    if outcome.declared is None:
        return []
    _, _, ok, wrong, steps = outcome.declared
    when = (
        "Fewer than 95 % of the swarms declare."
        if steps.p95 is None
        else f"By {step_in_words(scenario, steps.p95)}, 95 % of the swarms have declared."
    )
    told = f"By their own word, {percent(ok)} are right; a robot is wrong in {percent(wrong)}. {when}"
    return [told]


def acted_in_words(outcome: Outcome, scenario: Scenario) -> list[str]:
    """Return whether and when robots that act did the tasks, in words."""
    found = outcome.found.acting
    if found is None:
        return []
    steps = found.all_taken_step.median, found.all_taken_step.p95
    half, most = (when_in_words(scenario, each) for each in steps)
    done = f"In {percent(found.done)} of the swarms, robots stand at all tasks that they can do"
    lines = [f"{done}: in half of the swarms {half}, in 95 % {most}."]
    if not outcome.feasible:
        vain = percent(found.started_in_vain)
        lines.append(f"In {vain} of the swarms, a robot takes a task although they are infeasible.")
    return lines


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


def _asked(assessment: Assessment) -> list[str]:
    asked = {assessment.scenario.decision.strategy: assessment.asked}
    if assessment.recommended is not None:
        asked.setdefault(assessment.recommended.strategy, assessment.recommended.asked)
    return [f"{name}: {_asked_in_words(each, assessment.scenario)}." for name, each in asked.items()]


def _asked_in_words(asked: Asked, scenario: Scenario) -> str:
    needs = {
        IDS: "every robot must have an id that is never misread",
        NAMES: "all robots must have the same name for a task, such as its position in a shared frame",
    }
    needed = "; ".join(needs.get(each, f"each robot must know {each}") for each in asked.needs)
    parts = [
        needed or "no ids that are never misread, no names of tasks, no known number of robots",
        f"messages of up to {asked.message_bits} bits",
        f"sight {length_in_words(scenario, asked.sight)}, radio {length_in_words(scenario, asked.radio)}",
        f"{math.ceil(asked.memory_bits / 8):,} bytes of memory",
    ]
    return "; ".join(parts)


def _recommended(assessment: Assessment) -> list[str]:
    found = assessment.recommended
    target = f"{100 * assessment.target:g} %"
    if assessment.outcome.tracking is not None:
        return _best_tracker(assessment)
    if found is None:
        return [
            f"No strategy is shown to be right in {target} of the swarms, here and at the opposite truth.",
            *assessment.recommendation.probably,
            "feasibee recommend says which constraint to relax.",
        ]
    text = (
        f"right in {percent(found.worst.right)}, with {found.worst.outcome.tasks} tasks; "
        f"{found.bits:.3g} bits per robot-step"
        + (
            ""
            if found.step is None
            else f"; {target} are right from {step_in_words(found.scenario, found.step)} on"
        )
    )
    own = found.strategy == assessment.scenario.decision.strategy
    lines = [f"{found.strategy}{', as it is' if own else ''}: {text}."]
    lines += _declared(found.worst.outcome, found.scenario) + waiting_in_words(found.scenario)
    if assessment.recommended_band is not None:
        robots = assessment.scenario.robots.count
        lines.append(band_sentence(assessment.recommended_band, robots, assessment.target))
    return lines


def _best_tracker(assessment: Assessment) -> list[str]:
    """Return the strategy that is right in most steps of a world that changes."""
    own = assessment.scenario.decision.strategy
    tried = {
        own: assessment.outcome,
        **{trial.outcome.contender: trial.outcome for trial in assessment.strategies},
    }
    name = max(tried, key=lambda each: tried[each].judged.estimate)
    same = " (as it is)" if name == own else ""
    found = tried[name]
    return [
        f"Of {len(tried)} strategies, {name}{same} is right in the most steps: {percent(found.judged)}; "
        f"{found.bits.mean():.3g} bits per robot-step.",
        *_tracking(found, assessment.scenario),
    ]


def _faults(assessment: Assessment) -> list[str]:
    chosen = assessment.scenario if assessment.recommended is None else assessment.recommended.scenario
    name = chosen.decision.strategy
    return [
        f"{name}, {trial.outcome.contender}: {_right(trial.outcome)}, {_gain(trial.difference)}."
        for trial in assessment.faults
    ]


def _changes(assessment: Assessment) -> list[str]:
    helps = [trial for trial in assessment.limits if trial.difference.low > 0]
    lines = [f"{trial.outcome.contender}: {points(trial.difference)}." for trial in helps]
    if not helps:
        lines = ["None of the tried changes is shown to make the swarm right more often."]
    better = _chosen(assessment.better)
    return lines + [_strategy_in_words(trial, assessment.target) for trial in better]


def _strategy_in_words(trial: Trial, target: float) -> str:
    step, other = wait_for(trial.outcome, target), trial.opposite
    return (
        f"strategy {trial.outcome.contender}: {points(trial.difference)}, "
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
    """Return a difference in words: none to speak of, one that is shown, or one that isn't."""
    if is_none(difference):
        return f"as without it (within {100 * MARGIN:g} points)"
    return points(difference) + ("" if is_clear(difference) else ", which may be chance")


def section_as_html(title: str, lines: Sequence[str]) -> str:
    """Return a section as a heading and a list."""
    listed = "".join(f"<li>{html.escape(line).replace(' %', '&nbsp;%')}</li>" for line in lines)
    return f"<h2>{html.escape(title)}</h2><ul>{listed}</ul>"


def table_as_html(title: str, cells: Sequence[Sequence[str | float | None]]) -> str:
    """Return a table in HTML that scrolls where it is too wide; the names of its columns are first.

    A number is a share, shown in percent and as a shade; None is a dash.
    """
    heads, *rows = cells
    head = "".join(f'<th scope="col">{html.escape(str(name))}</th>' for name in heads)
    body = "".join(
        f'<tr><th scope="row">{html.escape(str(name))}</th>{"".join(map(_cell, others))}</tr>'
        for name, *others in rows
    )
    return _framed(title, f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")


def _cell(cell: str | float | None) -> str:
    if isinstance(cell, float):
        return f'<td class="share" style="--share: {cell:.3f}">{100 * cell:.0f}</td>'
    return f"<td>{'-' if cell is None else html.escape(cell)}</td>"


def cells_of(trials: Sequence[Trial]) -> list[list[str]]:
    """Return trials as a table of texts, the names of its columns first."""
    turned = sorted({trial.opposite.tasks for trial in trials if trial.opposite})
    right = "right at the end" if trials[0].outcome.tracking is None else "right in the steps"
    rows = [["", right, "difference", *(f"right with {tasks} tasks" for tasks in turned), "bits", "runs"]]
    for trial in trials:
        other = trial.opposite
        rows.append(
            [
                trial.outcome.contender,
                percent(trial.outcome.judged),
                points(trial.difference),
                *(percent(other.accuracy) if other and other.tasks == tasks else "" for tasks in turned),
                f"{trial.outcome.bits.mean():.3g}",
                f"{trial.outcome.runs:,}",
            ]
        )
    return rows


def excluded_as_html(excluded: Mapping[str, str]) -> str:
    """Return why strategies aren't recommended, as a table in HTML."""
    rows = "".join(
        f'<tr><th scope="row">{html.escape(name)}</th><td class="text">{html.escape(why)}</td></tr>'
        for name, why in excluded.items()
    )
    return _framed("Not recommended", f"<table><tbody>{rows}</tbody></table>") if rows else ""


def _framed(title: str, table: str) -> str:
    label = html.escape(title, quote=True)
    return f'<h2>{label}</h2><div class="wide" tabindex="0" role="region" aria-label="{label}">{table}</div>'
