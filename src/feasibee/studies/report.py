"""What an assessment of a swarm found: plain tables, the verdict, words, and a page of HTML."""

from __future__ import annotations

import base64
import html
import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, NamedTuple

from matplotlib.figure import Figure

from feasibee.figures.comparison import draw_against_bits, draw_against_time
from feasibee.figures.sizing import draw_sizing
from feasibee.files import atomic_write
from feasibee.model.codes import MODEL_VERSION
from feasibee.results.statistics import CONFIDENCE, Interval, pareto, wilson
from feasibee.scenario.feasibility import Verdict as Truth
from feasibee.scenario.html import folded, framed
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import length_in_words, step_in_words, steps_in_words
from feasibee.studies.comparison import (
    Outcome,
    difference,
    origin,
    percent,
    points,
    tracking_figures,
    wait_for,
)
from feasibee.studies.needs import IDS, NAMES, Asked, needs_of, quiet_times_in_words
from feasibee.studies.race import MARGIN, is_clear, is_none
from feasibee.studies.recommend import Candidate, Recommendation
from feasibee.studies.size import Band, Sizing, band_sentence, panels_of, sentences

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
            "asked": self.asked._asdict(),
            **self.outcome.found.to_dict(),
            "opposite": _opposite_as_dict(self.opposite),
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
        parts += [folded(name, table_of(name, trials)) for name, trials in tables.items()]
        return framed("".join(parts) + folded("Scenario", self.scenario._repr_html_()))

    def _recommended_as_dict(self) -> dict[str, Any] | None:
        if self.recommended is None:
            return None
        band = None if self.recommended_band is None else self.recommended_band.to_dict()
        asked = self.recommended.asked._asdict()
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
        "Recommended": _recommended(assessment),
        "What to expect": _expected(assessment),
        "How many robots, for how many tasks": sized,
        "What is asked of the robots": _asked(assessment),
        "If something fails": _faults(assessment),
        "What would help": _changes(assessment),
    }
    return {title: lines for title, lines in found.items() if lines}


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


def _truth(assessment: Assessment) -> str:
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
    _, _, ok, wrong, steps = outcome.declared
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
    lines += _declared(found.worst.outcome, found.scenario)
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
    lines += [_strategy_in_words(trial, assessment.target) for trial in better]
    return [
        *lines,
        f"All differences in this report hold together with a probability of {100 * CONFIDENCE:g} %.",
    ]


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


def table_of(title: str, trials: Sequence[Trial]) -> str:
    """Return trials as a table in HTML that scrolls where it is too wide."""
    if not trials:
        return ""
    turned = {trial.opposite.tasks for trial in trials if trial.opposite}
    columns: dict[str, Callable[[Trial], str]] = {
        "right at the end" if trials[0].outcome.tracking is None else "right in the steps": lambda trial: (
            percent(trial.outcome.judged)
        ),
        "difference": lambda trial: points(trial.difference),
        **{
            f"right with {tasks} tasks": lambda trial: (
                percent(trial.opposite.accuracy) if trial.opposite else ""
            )
            for tasks in turned
        },
        "bits": lambda trial: f"{trial.outcome.bits.mean():.3g}",
        "runs": lambda trial: f"{trial.outcome.runs:,}",
    }
    head = "".join(f'<th scope="col">{name}</th>' for name in ("", *columns))
    rows = "".join(
        f'<tr><th scope="row">{html.escape(trial.outcome.contender)}</th>'
        f"{''.join(f'<td>{shown(trial)}</td>' for shown in columns.values())}</tr>"
        for trial in trials
    )
    return _framed(title, f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>")


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


OWN = "this swarm"


TRACKING = {
    "time": "Share of right swarms at each step, with each strategy; grey: the tasks are infeasible",
    "bits": "Share of steps at which swarms are right against bits on the air",
    "delay": "Delay of detection against bits on the air",
}
"""Titles of the figures of a world that changes."""


class Shown(NamedTuple):
    """A figure of the page."""

    title: str
    text: str
    """What it shows, for those who can't see it."""
    drawn: Figure


def write_report(assessment: Assessment, path: Path, command: str = "feasibee.studies.assess") -> None:
    """Write an assessment as one HTML file that includes its figures.

    Parameters
    ----------
    assessment : Assessment
        What to write.
    path : Path
        The file.
    command : str
        The command that made it, for the footer.
    """
    _, *others = sections(assessment).items()
    body = _verdict(assessment) + "".join(f"<p>{html.escape(line)}</p>" for line in _ended_early(assessment))
    body += "".join(section_as_html(*each) for each in others)
    body += "".join(map(_figure, _figures(assessment)))
    body += table_of("Strategies", assessment.strategies) + table_of("Changes", assessment.limits)
    body += table_of("Faults", assessment.faults) + excluded_as_html(assessment.recommendation.excluded)
    written = html.escape(assessment.scenario.to_toml())
    body += f"<details><summary>Scenario</summary><pre>{written}</pre></details>"
    text = PAGE.replace("{body}", body).replace("{footer}", _footer(assessment, command))
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _verdict(assessment: Assessment) -> str:
    level, right, tasks = assessment.verdict
    colour, shape = SIGNS[level]
    middle, low, high = (100 * value for value in right)
    scenario, target = assessment.scenario, 100 * assessment.target
    steps = steps_in_words(scenario, scenario.run.steps)
    world = f"{scenario.robots.count} robots, {tasks} tasks"
    what = (
        f"of the swarms are right after {steps} ({world})"
        if assessment.outcome.tracking is None
        else f"of {steps}, these swarms are right ({world} before any change)"
    )
    return (
        f'<section class="verdict {colour}"><p class="level"><span aria-hidden="true">{shape}</span> '
        f'{level.capitalize()}</p><p class="number">{middle:.1f} %</p>'
        f"<p>{what}. 95 % interval: {low:.1f} to {high:.1f} %. Asked for: {target:g} %.</p></section>"
    )


def _figures(assessment: Assessment) -> Iterator[Shown]:
    if assessment.sizing is not None:
        yield Shown(
            "Share of right swarms against the number of robots, and against the number of tasks",
            " ".join(sentences(assessment.sizing)),
            draw_sizing(panels_of(assessment.sizing), assessment.target),
        )
    recommended = assessment.recommended
    keep = [OWN] if recommended is None else [OWN, recommended.strategy]
    outcomes = {
        OWN: assessment.outcome,
        **{trial.outcome.contender: trial.outcome for trial in assessment.strategies},
    }
    if assessment.outcome.tracking is not None:
        for name, drawn in tracking_figures(outcomes).items():
            yield Shown(TRACKING[name], _best_in_words(assessment), drawn)
        return
    shares = {name: each.right_at[None, :] / each.runs for name, each in outcomes.items()}
    yield Shown(
        "Share of right swarms at each step, with each strategy",
        _best_in_words(assessment),
        draw_against_time(shares, keep=keep, seconds=assessment.scenario.units.seconds),
    )
    totals = {name: (float(each.bits.mean()), each.accuracy) for name, each in outcomes.items()}
    yield Shown(
        "Share of right swarms against bits on the air",
        _best_in_words(assessment),
        draw_against_bits(totals, keep=keep),
    )


def _best_in_words(assessment: Assessment) -> str:
    """Return the shares at the end of this swarm and of the best other strategies, in words."""
    best = [
        f"{trial.outcome.contender} {percent(trial.outcome.judged)}" for trial in assessment.strategies[:4]
    ]
    when = "At the end" if assessment.outcome.tracking is None else "Of the steps"
    return f"{when}: {'; '.join([f'{OWN} {percent(assessment.outcome.judged)}', *best])}."


def _figure(shown: Shown) -> str:
    buffer = io.BytesIO()
    shown.drawn.savefig(buffer, format="png", dpi=150)
    data = base64.b64encode(buffer.getvalue()).decode()
    alt = html.escape(f"{shown.title}. {shown.text}", quote=True)
    return (
        f'<figure><div class="wide"><img alt="{alt}" src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{html.escape(shown.title)}</figcaption></figure>"
    )


def _footer(assessment: Assessment, command: str) -> str:
    parts = (
        f"<code>{html.escape(command)}</code>",
        f"scenario {assessment.scenario.hash[:12]}",
        f"seed {assessment.seed}",
        f"{assessment.outcome.runs} runs of the swarm",
        f"feasibee {version('feasibee')}, model {MODEL_VERSION}",
        f"{datetime.now(UTC):%Y-%m-%d}",
    )
    return "; ".join(parts)


PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>feasibee: assessment</title><style>
:root { color-scheme: light dark; --line: color-mix(in srgb, currentColor 22%, transparent); }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 52rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .4rem; }
ul { padding-left: 1.2rem; } li { margin: .25rem 0; }
.verdict { border: 2px solid; border-left-width: .6rem; border-radius: .4rem; padding: .6rem 1.2rem; }
.verdict p { margin: .2rem 0; } .level { font-weight: 600; font-size: 1.2rem; }
.number { font-size: 2.6rem; line-height: 1.1; font-weight: 600; }
.green { border-color: #0b7a53; } .amber { border-color: #b06d00; } .red { border-color: #c2410c; }
.green .level { color: #0b7a53; } .amber .level { color: #8f5800; } .red .level { color: #c2410c; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; min-width: 32rem; background: white; border-radius: .3rem; }
figcaption { font-size: .9rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
td, th { text-align: left; padding: .25rem .7rem .25rem 0; white-space: nowrap; font-weight: normal; }
thead th { font-weight: 600; } td.text { white-space: normal; }
tr + tr, tbody tr { border-top: 1px solid var(--line); }
pre { overflow-x: auto; font-size: 13px; } summary { cursor: pointer; margin-top: 2rem; }
footer { border-top: 1px solid var(--line); margin-top: 2rem; padding-top: .6rem; font-size: .85rem; }
footer code { overflow-wrap: anywhere; }
@media (prefers-color-scheme: dark) {
  .green { border-color: #35c08a; } .amber { border-color: #e0a33a; } .red { border-color: #ff8a5c; }
  .green .level { color: #35c08a; } .amber .level { color: #e0a33a; } .red .level { color: #ff8a5c; }
  img { filter: invert(0.92) hue-rotate(180deg); }
}
@media print {
  body { max-width: none; margin: 0; font-size: 10.5pt; } img { filter: none; min-width: 0; }
  figure, .verdict, tr { break-inside: avoid; } h2 { break-after: avoid; } .wide { overflow: visible; }
  td, th { padding-right: .5rem; font-size: 8.5pt; }
}
</style></head><body><main><h1>Assessment of a swarm</h1>{body}</main><footer>{footer}</footer></body></html>
"""
