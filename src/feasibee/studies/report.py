"""What an assessment of a swarm found: the answer, a table, and details, in words and as plain tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any, Final

from feasibee.base.codes import MODEL_VERSION
from feasibee.results.calibration import SHARES, Calibration
from feasibee.results.statistics import Interval, in_percent, plain, wilson
from feasibee.scenario.feasibility import Verdict as Truth
from feasibee.scenario.feasibility import who_counts
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.shown import render
from feasibee.scenario.units import step_in_words, steps_in_words, when_in_words
from feasibee.simulation.flooding import flooding_in_words
from feasibee.studies.comparison import (
    Outcome,
    calibration_of,
    in_bits,
    latest,
    origin,
    wait_for,
    wait_interval,
)
from feasibee.studies.constraints import Candidate, Constrained, ranked, uncounted
from feasibee.studies.needs import Asked, noisy_names_in_words, untested_in_words
from feasibee.studies.size import Band, Sizing, band_sentence, sentences

READY, UNCERTAIN, NOT_READY = "ready", "uncertain", "not ready"
SIGNS: Final = {READY: ("green", "●"), UNCERTAIN: ("amber", "▲"), NOT_READY: ("red", "■")}
"""The colour and the shape of each verdict."""
MARGIN: Final = 0.05
"""A difference that is shown to be at most this share, either way, is called none."""
NO_DIFFERENCE: Final = Interval(0.0, 0.0, 0.0)


def level_of(shares: Sequence[Interval], target: float) -> str:
    """Return whether a swarm can be deployed, from its shares of right runs in some worlds."""
    worst = min(shares)
    level = READY if worst.low >= target else UNCERTAIN
    return NOT_READY if worst.high < target else level


@dataclass(frozen=True)
class Trial:
    """A simulated swarm: as it is, changed, with another strategy, or with a fault."""

    scenario: Scenario
    outcome: Outcome
    """Outcome of its runs; its contender is the name of the change."""
    opposite: Outcome | None = None
    """Outcome at the reciprocal ratio, where the truth is the opposite."""
    difference: Interval = NO_DIFFERENCE
    """Share of swarms that are right at the end, less that share without the change; in a world that changes,
    share of steps."""
    price: int = 0
    """Place among the changes in the order of what they cost, 0 for the cheapest."""

    @classmethod
    def of(cls, found: Candidate) -> Trial:
        """Return a tested strategy as a trial."""
        return cls(found.scenario, found.worlds[0], found.worlds[1] if len(found.worlds) > 1 else None)

    def untested(self) -> Trial:
        """Return it judged by its runs alone, not by the tests that chose their number."""
        there = self.opposite and replace(self.opposite, test=None)
        return replace(self, outcome=replace(self.outcome, test=None), opposite=there)

    @property
    def name(self) -> str:
        """Name of the change, or of the strategy."""
        return self.outcome.contender

    @property
    def worlds(self) -> list[Outcome]:
        """Outcomes in its world and, if any, at the opposite truth."""
        return [each for each in (self.outcome, self.opposite) if each is not None]

    @property
    def worst(self) -> Outcome:
        """The world in which it is right least often."""
        return min(self.worlds, key=lambda world: world.judged.estimate)

    def helps(self, target: float) -> bool:
        """Whether it is shown to be better, and to be right often enough in all worlds in which it ran."""
        return self.difference.low > 0 and all(each.judged.low >= target for each in self.worlds)

    def wait(self, target: float) -> int | None:
        """Return the first step from which enough runs are right until the end, in all its worlds."""
        return latest(wait_for(outcome, target) for outcome in self.worlds)

    def to_dict(self, target: float) -> dict[str, Any]:
        """Return the trial as plain tables, for programs."""
        return {
            "name": self.name,
            "runs": self.outcome.runs,
            "right": self.outcome.accuracy._asdict(),
            "difference": self.difference._asdict(),
            "right_from_step": wait_for(self.outcome, target),
            "bits_per_robot_and_step": float(self.outcome.bits.mean()),
            **self.outcome.found.to_dict(),
            "opposite": _opposite_as_dict(self.opposite),
        }


@dataclass(frozen=True)
class Assessment:
    """Expected behaviour of a swarm, and what would improve it.

    Without details, it has what the answer rests on. ``limits``, ``sizing`` and others may then be empty.
    """

    scenario: Scenario
    """The assessed scenario."""
    truth: Truth
    """Ground truth, with its proof."""
    target: float
    """Share of swarms that must be right."""
    outcome: Outcome
    """Outcome of the unchanged scenario."""
    opposite: Outcome | None
    """Outcome at the reciprocal ratio, where the truth is the opposite; None if robots or tasks have classes
    or tasks have given places."""
    seed: int
    """Seed of the runs."""
    recommendation: Constrained | None = None
    """Strategies that reach the target in both worlds."""
    recommended: Candidate | None = None
    """The scenario's own strategy if it is among these, or the first of them; None without any."""
    strategies: Sequence[Trial] = ()
    """The other strategies, the best first."""
    limits: Sequence[Trial] = ()
    """Changes that show what limits the swarm, the most helpful first."""
    faults: Sequence[Trial] = ()
    """Single faults of the advised swarm."""
    sizing: Sizing | None = None
    """How many robots are enough for the tasks, and the blind band; None if robots have classes or given
    places."""
    recommended_band: Band | None = None
    """Blind band of the recommended strategy."""
    stopped: str = ""
    """Why the assessment ended early, if it did."""
    missing: Sequence[str] = ()
    """Phases that then were not complete."""

    @cached_property
    def own(self) -> Trial:
        """The swarm as it is."""
        return Trial(self.scenario, self.outcome, self.opposite)

    @property
    def level(self) -> str:
        """Whether the swarm can be deployed: ``"ready"``, ``"uncertain"`` or ``"not ready"``."""
        return level_of([each.judged for each in self.own.worlds], self.target)

    @property
    def shares(self) -> dict[str, Interval]:
        """Shares of the swarms that are right, wrong and split at the last step.

        More than the threshold's share of the robots holds the true opinion, the other one, or neither.
        """
        right, held, runs = int(self.outcome.right.sum()), int(self.outcome.agreed.sum()), self.outcome.runs
        counts = {"right": right, "wrong": held - right, "split": runs - held}
        return {name: wilson(count, runs) for name, count in counts.items()}

    @property
    def calibration(self) -> Calibration | None:
        """How good the probabilities are that swarms give to *feasible*; None without the opposite truth."""
        return calibration_of(self.own.worlds)

    @cached_property
    def advice(self) -> tuple[str, Trial | None]:
        """What to do, and the swarm that comes of it, if it is another one.

        It is the cheapest change that is shown to reach the target in both worlds, or else the nearest one.
        Cheap to expensive: no change, another strategy, then the other changes in the order of their prices.
        """
        own, found = self.scenario.decision.strategy, self.recommended
        if self.level == READY:
            return f"Use the swarm as it is, with {own}.", None
        if found is not None and found.strategy == own:
            return f"Use the swarm as it is, with {own}. Further runs show that it is enough.", None
        if found is not None:
            return _instead(own, Trial.of(found)), Trial.of(found)
        changing = self.strategies if self.outcome.tracking is not None else ()
        if enough := [each for each in changing if each.helps(self.target)]:
            best = min(enough, key=lambda trial: float(trial.outcome.bits.mean()))
            return _instead(own, best), best
        return self.enough[0][1:] if self.enough else _nearest(self)

    @cached_property
    def enough(self) -> list[tuple[int, str, Trial | None]]:
        """Price of more robots and of each change that is enough, what to do, and the changed swarm."""
        return sorted(_changes(self), key=lambda each: each[0])

    @property
    def table(self) -> tuple[list[str], list[list[str]]]:
        """What to expect of the swarm as it is, and of the advised one: step, risk and price."""
        columns = {f"{self.scenario.decision.strategy}, as it is": _cells(self, self.own)}
        if (advised := self.advice[1]) is not None:
            columns[advised.name] = _cells(self, advised)
        names = dict.fromkeys(name for cells in columns.values() for name in cells)
        return ["", *columns], [
            [name, *(cells.get(name, "") for cells in columns.values())] for name in names
        ]

    @property
    def warnings(self) -> list[str]:
        """Warnings that the swarm, or the advised one, is beyond what was tested."""
        swarms = [each.scenario for each in (self.own, self.advice[1]) if each is not None]
        told = (line for each in swarms for line in (*untested_in_words(each), *noisy_names_in_words(each)))
        return list(dict.fromkeys(told))

    def to_dict(self) -> dict[str, Any]:
        """Return the assessment as plain tables, for programs."""
        worst = self.own.worst
        colour, shape = SIGNS[self.level]
        sign = {"level": self.level, "colour": colour, "shape": shape}
        trials = {"faults": self.faults, "limits": self.limits, "strategies": self.strategies}
        return {
            "verdict": {**sign, "right": worst.judged._asdict(), "tasks": worst.tasks, "target": self.target},
            "action": self.advice[0],
            "scenario": self.scenario.to_dict(),
            "runs": self.outcome.runs,
            "stopped": self.stopped,
            "missing": list(self.missing),
            "steps": self.scenario.run.steps,
            "truth": self.truth.to_dict(),
            **{name: share._asdict() for name, share in self.shares.items()},
            "first_decision_right": self.outcome.first._asdict(),
            "right_from_step": wait_for(self.outcome, self.target),
            "bits_per_robot_and_step": float(self.outcome.bits.mean()),
            "asked": Asked(self.scenario, self.seed).to_dict(),
            **self.outcome.found.to_dict(),
            "opposite": _opposite_as_dict(self.opposite),
            "calibration": plain(self.calibration),
            "brier_of": self.outcome.said_by,
            "size": None if self.sizing is None else self.sizing.to_dict(),
            "recommended": self._recommended_as_dict(),
            "excluded": dict(self.recommendation.excluded) if self.recommendation else {},
            "faults_of": self.faults[0].scenario.decision.strategy if self.faults else None,
            **{name: [each.to_dict(self.target) for each in those] for name, those in trials.items()},
            **origin(self.seed, self.scenario),
        }

    def _repr_html_(self) -> str:
        """Return the assessment as HTML, for notebooks."""
        return render(
            "cell.html", a=self, words=sections(self), percent=in_percent, points=in_points, in_bits=in_bits
        )

    def _recommended_as_dict(self) -> dict[str, Any] | None:
        if self.recommended is None:
            return None
        band = None if self.recommended_band is None else self.recommended_band.to_dict()
        asked = self.recommended.asked.to_dict()
        return {**self.recommended.to_dict(), "asked": asked, "blind_band": band}


def _opposite_as_dict(outcome: Outcome | None) -> dict[str, Any] | None:
    if outcome is None:
        return None
    return {"tasks": outcome.tasks, "runs": outcome.runs, "right": outcome.judged._asdict()}


def is_none(shown: Interval) -> bool:
    """Whether a difference is shown to be small enough to be called none."""
    return shown.low >= -MARGIN and shown.high <= MARGIN


def in_points(shown: Interval) -> str:
    """Return a difference of shares with its interval, in whole percentage points, with a decimal near 0."""
    middle, low, high = (f"{100 * each:+.{int(abs(each) < 0.01)}f}" for each in shown)
    return f"{middle} points ({low} to {high})"


def _nearest(a: Assessment) -> tuple[str, Trial | None]:
    """Return the advice if nothing is shown to be enough."""
    own = a.scenario.decision.strategy
    close = [each for each in a.recommendation.tested if each.is_probable] if a.recommendation else []
    if close:
        found = ranked(close)[0]
        ending = f". That is probably enough; {found.more_runs} more runs would settle it."
        if found.strategy == own:
            return f"Use the swarm as it is, with {own}{ending}", None
        return _instead(own, Trial.of(found), ending), Trial.of(found)
    best = next((each for each in a.strategies if each.difference.low > 0), None)
    if a.outcome.tracking is not None and best is not None:
        return _instead(own, best, ". No strategy or change tried is shown to be enough."), best
    lines = ["None of the strategies and changes that were tried is shown to be enough."]
    lines += ["Allow more time: not all of them were tried."] * bool(a.missing)
    lines += uncounted(a.recommendation) if a.recommendation else ()
    return " ".join(lines), None


def _instead(own: str, trial: Trial, ending: str = ".") -> str:
    return f"Use the strategy {trial.scenario.decision.strategy} instead of {own}: {_right(trial)}{ending}"


def _right(trial: Trial) -> str:
    worst = trial.worst
    return f"right in {in_percent(worst.judged)} of the {'runs' if worst.tracking is None else 'steps'}"


def _changes(a: Assessment) -> Iterator[tuple[int, str, Trial | None]]:
    """Yield the price of more robots and of each change that is enough, what to do, and the changed swarm."""
    robots, steps, tasks = a.scenario.robots.count, a.scenario.run.steps, a.scenario.tasks.count
    one_sided = a.opposite is not None and a.opposite.judged.low < a.target
    least = None if a.sizing is None or one_sided else a.sizing.edge.enough
    if least is not None and least > robots:
        price = next((each.price for each in a.limits if each.outcome.robots > robots), 0)
        more = f"{least - robots:g} more. That was tested with {tasks} tasks."
        yield price, f"Use {least:g} robots, {more}", None
    for trial in (each for each in a.limits if each.helps(a.target)):
        last = latest(wait_interval(outcome, a.target)[1] for outcome in trial.worlds)
        what = f"Change this: {trial.name}"
        if trial.scenario.run.steps > steps and last is not None and last > steps:
            longer = steps_in_words(a.scenario, last - steps)
            what = f"Let the swarm run until {step_in_words(a.scenario, last)}, {longer} longer"
        yield trial.price, f"{what}: {_right(trial)}.", trial


def _cells(a: Assessment, trial: Trial) -> dict[str, str]:
    """Return a column of the table of an assessment."""
    found, scenario, asked = trial.outcome.found, a.scenario, Asked(trial.scenario, a.seed)
    step, tracking, last = trial.wait(a.target), found.tracking, trial is (a.advice[1] or a.own)
    cells = {}
    for outcome in trial.worlds:
        where = f" with {outcome.tasks} tasks" if a.opposite else ""
        cells[f"right{where}" if tracking is None else "right, of the steps"] = in_percent(outcome.judged)
        if outcome.found.acting and not outcome.feasible:
            cells[f"acts in vain{where}"] = in_percent(outcome.found.acting.started_in_vain)
    if tracking is None:
        cells[f"{100 * a.target:g} % right from"] = "never" if step is None else step_in_words(scenario, step)
    else:
        delay = tracking.detection_delay.median
        within = "never" if delay is None else f"within {steps_in_words(scenario, delay)}"
        cells["half of the changes followed"] = within
        cells["changes missed"] = "" if tracking.missed is None else in_percent(tracking.missed)
        cells["false alarms per 1,000 steps"] = f"{tracking.false_alarms.estimate:.2g}"
    if found.declared is not None:
        cells["declared rightly"] = in_percent(found.declared.ok)
        cells["a robot declared wrongly"] = in_percent(found.declared.wrong)
        cells["95 % have declared"] = when_in_words(scenario, found.declared.step_90.p95)
    if found.acting is not None:
        cells["robots at all tasks they can do"] = in_percent(found.acting.done)
        cells["half of the runs are there"] = when_in_words(scenario, found.acting.all_taken_step.median)
    for fault in a.faults:
        none = is_none(fault.difference)
        shown = "as without it" if none else in_percent(fault.outcome.judged)
        cells[fault.name] = shown if last else ""
    return cells | {
        "bits per robot-step": in_bits(trial.outcome.bits.mean()),
        "longest message, bits": f"{asked.message_bits:,}",
        "memory of a robot, bytes": f"{math.ceil(asked.memory_bits / 8):,}",
        "robots need": ",\n".join(asked.needs) or "nothing",
    }


def sections(assessment: Assessment) -> dict[str, list[str]]:
    """Return an assessment in words: the lines of each section, by its title; see ``assessment.txt``."""
    a, scenario = assessment, assessment.scenario
    words = {
        "steps": steps_in_words(scenario, scenario.run.steps),
        "who": who_counts(scenario),
        "waits": wait_interval(a.outcome, a.target),
        "flooding": flooding_in_words(scenario),
        "sizes": [] if a.sizing is None else sentences(a.sizing),
        "version": version("feasibee"),
        "model_version": MODEL_VERSION,
        "SHARES": SHARES,
        "SIGNS": SIGNS,
        **{each.__name__: each for each in (in_bits, in_percent, in_points, band_sentence, step_in_words)},
    }
    found: dict[str, list[str]] = {}
    for line in render("assessment.txt", a=a, **words).splitlines():
        if line.startswith("# "):
            lines = found[line[2:]] = []
        elif line.startswith("- "):
            lines.append(line[2:].strip())
        elif more := line.strip():
            lines[-1] += f" {more}"
    return {title: lines for title, lines in found.items() if lines}
