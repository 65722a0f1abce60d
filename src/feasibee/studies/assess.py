"""Assess a swarm before deployment: whether it would be right, how sure that is, and what would help."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

from feasibee.errors import ScenarioError
from feasibee.scenario.feasibility import explain
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.sections import KINDS
from feasibee.studies.comparison import SURE, Outcome, difference, percent
from feasibee.studies.needs import Asked, all_strategies, suitable
from feasibee.studies.race import AS_IT_IS, FIRST, Race
from feasibee.studies.recommend import (
    TOLERATES,
    Candidate,
    Constraints,
    Recommendation,
    numbered,
    opposite_of,
    recommend,
)
from feasibee.studies.report import Assessment, Trial, judge
from feasibee.studies.size import Rule, Sizing, band_of, looks, most_tests, size
from feasibee.sweeps.schedule import run_work
from feasibee.sweeps.sweep import Enough, Execution, Rounds

OPPOSITE: Final = "opposite"
RESOLUTION: Final = 0.15
"""Of the numbers of robots and of tasks that are enough: a finer search would take most of the time."""
SHORT_REACH: Final = 3
"""Searches go up to so many times the number of robots or tasks."""
FEW: Final = 10
"""Runs of the first verdict."""
LEAST_RUNS: Final = 400
"""A search may use so many runs of a value: 100 % of 200 is not enough to exclude 95 %."""
LOST: Final = 0.2
"""Share of lost messages that is tried as a fault."""
MOST_FAULTS: Final = 4
MORE: Final = 1.5
"""Ranges and robots are tried at so many times their number."""


def assess(
    scenario: Scenario,
    runs: int = 400,
    seed: int = 0,
    execution: Execution | None = None,
    right: float = SURE,
) -> Assessment:
    """Simulate a swarm, changes to it, other strategies and single faults, all on the same worlds.

    All differences hold together with a probability of 95 %. Their runs are paired.

    A swarm that always gave one answer would be right in all worlds of one truth. So the swarm, and the
    strategies that do better, are also simulated at the reciprocal ratio of robots to tasks.

    In a world that changes, swarms are judged by the share of steps at which they are right. Neither numbers
    of robots nor the opposite truth are searched then, and no strategy is recommended.

    Parameters
    ----------
    scenario : Scenario
        What to assess.
    runs : int
        Number of runs of the swarm; largest number of each change and fault, which end when their difference
        is clear, or surely small. Searches and other strategies have up to as many, or 400.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    right : float
        Share of swarms that must be right; in a world that changes, share of steps.
    """
    scenario = scenario.replace({"run.stop_at_decision": False})
    with Rounds(execution, most=None) as rounds:
        study = _Assessing(rounds, scenario, runs, seed, right)
        rounds.phases = study.most_work()
        return study.assessment()


@dataclass(frozen=True)
class _Assessing:
    """The rounds of one assessment."""

    rounds: Rounds
    scenario: Scenario
    runs: int
    seed: int
    right: float
    missing: list[str] = field(default_factory=list)
    """Phases that ended early."""

    def assessment(self) -> Assessment:
        scenario = self.scenario
        outcomes = self._verdict_runs()
        base, opposite = outcomes[AS_IT_IS], outcomes.get(OPPOSITE)
        changed = self._turned(self._raced("comparing changes", scenario, self.changed))
        with self._part("testing strategies"):
            recommendation, recommended = self._recommended()
        strategies = self._strategies(base, recommendation.tested)
        rule = Rule(self.right, most=max(LEAST_RUNS, self.runs), resolution=RESOLUTION)
        chosen = scenario if recommended is None else recommended.scenario
        faults = self._raced("comparing faults", chosen, faults_of(chosen))
        sizing = band = None
        with self._part("searching sizes"):
            sizing = self._sizing(rule)
            if recommended is not None:
                band = band_of(chosen, rule, self.seed, self.rounds, SHORT_REACH)
        return Assessment(
            scenario=scenario,
            truth=explain(scenario),
            target=self.right,
            outcome=base,
            asked=Asked(scenario, self.seed),
            limits=_best_first(changed),
            strategies=_best_first(strategies),
            opposite=opposite,
            recommendation=recommendation,
            recommended=recommended,
            faults=faults,
            sizing=sizing,
            recommended_band=band,
            seed=self.seed,
            confidence=self.race.confidence,
            stopped=self.rounds.stopped,
            missing=tuple(self.missing),
        )

    @contextmanager
    def _part(self, phase: str) -> Iterator[None]:
        """Compute a part of the answer; note its phase if it ends before it is complete."""
        self.rounds.phase, before = phase, self.rounds.stops
        with suppress(Enough):
            yield
        if self.rounds.stops > before and phase not in self.missing:
            self.missing.append(phase)

    def most_work(self) -> dict[str, int]:
        """Return the largest number of robot-steps of each phase."""
        most, own = max(LEAST_RUNS, self.runs), run_work(self.scenario)
        strategies = 2 * len(self.others) * most * own
        searches = most_tests(SHORT_REACH * max(self.scenario.most)) * most * own
        return {
            "running the swarm": 2 * self.runs * own,
            "comparing changes": 2 * self.runs * sum(map(run_work, self.changed.values())),
            "testing strategies": strategies,
            "comparing strategies": strategies,
            "comparing faults": MOST_FAULTS * self.runs * own,
            "searching sizes": (SHORT_REACH + 4) * searches,  # robots, and tasks of two swarms on two sides
        }

    @cached_property
    def changed(self) -> dict[str, Scenario]:
        """The scenario with each change that may show what limits the swarm."""
        return changes_of(self.scenario)

    @cached_property
    def others(self) -> dict[str, Scenario]:
        """The scenario with each other built-in strategy."""
        found = suitable(self.scenario)[0]
        found.pop(self.scenario.decision.strategy, None)
        return found

    @cached_property
    def race(self) -> Race:
        """How changes are raced: their differences hold together, also those at the opposite truth."""
        differences = len(self.changed) + 2 * len(all_strategies(self.scenario)) + MOST_FAULTS
        several = len(looks(FIRST, max(LEAST_RUNS, self.runs)))
        return Race(self.rounds, self.runs, self.seed, differences * several)

    def _verdict_runs(self) -> dict[str, Outcome]:
        """Return the outcome of the scenario, and that at the opposite truth, if any."""
        opposite = None if self.scenario.dynamic else opposite_of(self.scenario)
        worlds = {AS_IT_IS: self.scenario} | ({} if opposite is None else {OPPOSITE: opposite})
        outcomes: dict[str, Outcome] = {}
        with self._part("running the swarm"):
            for runs in (min(FEW, self.runs), *looks(FIRST, self.runs)):
                outcomes = self.race.outcomes(worlds, runs)
                judged = judge([*outcomes.values()], self.right)
                right = f"{percent(judged.right)} right of {runs} swarms"
                self.rounds.tell(f"{judged.level} so far: {right}")
        return outcomes

    def _raced(self, phase: str, scenario: Scenario, changed: Mapping[str, Scenario]) -> list[Trial]:
        with self._part(phase):
            found = self.race.against(scenario, changed)
        return [Trial(*each) for each in found.values()]

    def _turned(self, changed: Sequence[Trial]) -> list[Trial]:
        """Return priced changes; those that may be enough have all runs, also at the opposite truth."""
        prices = {name: price for price, name in enumerate(self.changed)}
        found = {each.outcome.contender: each for each in changed}
        near = [name for name, each in found.items() if _may_be_enough(each, self.right)]
        turned = {name: opposite_of(self.changed[name]) for name in near if not self.scenario.dynamic}
        worlds = {name: world for name, world in turned.items() if world is not None}
        here: dict[str, Outcome] = {}
        there: dict[str, Outcome] = {}
        with self._part("comparing changes"):
            here = self.race.outcomes({name: self.changed[name] for name in near}, self.runs) if near else {}
            there = self.race.outcomes(worlds, self.runs) if worlds else {}
        return [
            replace(each, outcome=here.get(name, each.outcome), opposite=there.get(name), price=prices[name])
            for name, each in found.items()
        ]

    def _strategies(self, base: Outcome, tested: Sequence[Candidate]) -> list[Trial]:
        """Return the other strategies; of those that gain, also what they do at the opposite truth.

        In a world that stays, their runs are those that were to show whether they reach the target.
        """
        if self.scenario.dynamic:
            return self._raced("comparing strategies", self.scenario, self.others)
        candidates = {each.strategy: each for each in tested}
        candidates.pop(self.scenario.decision.strategy, None)
        here = {name: each.worlds[0].outcome for name, each in candidates.items()}
        there = {name: each.worlds[1].outcome for name, each in candidates.items() if each.worlds[1:]}
        trials = [Trial(each, difference(each, base, self.race.confidence)) for each in here.values()]
        names = {each.outcome.contender for each in trials if each.difference.low > 0} - there.keys()
        gaining = {name: opposite_of(candidates[name].scenario) for name in sorted(names)}
        own, known = opposite_of(self.scenario), {name: each for name, each in gaining.items() if each}
        if own is not None:
            with self._part("comparing strategies"):
                there |= {name: each for name, (each, _) in self.race.against(own, known).items()}
        return [replace(each, opposite=there.get(each.outcome.contender)) for each in trials]

    def _sizing(self, rule: Rule) -> Sizing | None:
        """Return how many robots are enough; None if their number can't vary, or the world changes."""
        robots = self.scenario.robots
        if self.scenario.dynamic or robots.classes or robots.points:
            return None
        return size(self.scenario, rule=rule, seed=self.seed, execution=self.rounds, reach=SHORT_REACH)

    def _recommended(self) -> tuple[Recommendation, Candidate | None]:
        """Return which strategies reach the target, and of these the scenario's, or else the first."""
        own, constraints = self.scenario.decision.strategy, Constraints(self.right)
        if self.scenario.dynamic:
            return Recommendation(self.scenario, constraints, [], {}, (), self.seed), None
        runs = max(LEAST_RUNS, self.runs)
        found = recommend(self.scenario, constraints, (), runs, self.seed, self.rounds, relax=False)
        first = found.ranking[0] if found.ranking else None
        return found, next((each for each in found.ranking if each.strategy == own), first)


def _may_be_enough(trial: Trial, target: float) -> bool:
    return trial.difference.low > 0 and trial.outcome.judged.estimate >= target


def _best_first(trials: Sequence[Trial]) -> list[Trial]:
    return sorted(trials, key=lambda trial: (-trial.difference.estimate, trial.outcome.bits.mean()))


def changes_of(scenario: Scenario) -> dict[str, Scenario]:
    """Return the scenario with each change that may show what limits the swarm, the cheapest first."""
    sensing, radio, decision, robots = scenario.sensing, scenario.radio, scenario.decision, scenario.robots
    tried: dict[str, dict[str, Any]] = {
        "explorations 3 times as long": {"decision.exploration": 3 * decision.exploration},
        "3 times as many steps": {"run.steps": 3 * scenario.run.steps},
    }
    if not sensing.count_self:
        tried["robots that count themselves"] = {"sensing.count_self": True}
    if not (robots.classes or robots.points):
        more = round(MORE * robots.count)
        tried[f"{more} robots instead of {robots.count}"] = {"robots.count": more}
    tried["radio 1.5 times as far"] = {"radio.range": MORE * radio.range}
    tried["sight 1.5 times as far"] = {"sensing.range": MORE * sensing.range, "radio.range": radio.range}
    errors = ("miss", "false_robots", "false_tasks", "misname", "position_error")
    if any(getattr(sensing, name) for name in errors):
        tried["a perfect sensor"] = {f"sensing.{name}": 0.0 for name in errors}
    if radio.loss:
        tried["no message lost"] = {"radio.loss": 0.0}
    if radio.delay:
        tried["no message late"] = {"radio.delay": 0}
    if any(scenario.faulty):
        tried["no faulty robot"] = {f"faults.{kind}": 0.0 for kind in KINDS}
    if scenario.place.exists:
        tried["robots that start everywhere"] = {"robots.zone": None}
        tried["radio through walls"] = {"radio.walls": 1.0}
    return _valid(scenario, tried)


def faults_of(scenario: Scenario) -> dict[str, Scenario]:
    """Return the scenario with each single fault that may happen in addition to its own."""
    stopped, byzantine, _ = scenario.faulty
    lying = {"faults.byzantine": {"count": byzantine + 1}}
    liars = numbered(byzantine + 1, "Byzantine robot")
    tried: dict[str, dict[str, Any]] = {
        f"with {liars}": lying,
        f"with {numbered(stopped + 1, 'broken robot')}": {"faults.stopped": {"count": stopped + 1}},
        "with a fifth of the messages lost": {"radio.loss": 1 - (1 - LOST) * (1 - scenario.radio.loss)},
    }
    parameters = scenario.decision.parameters
    if parameters.get(TOLERATES, byzantine + 1) <= byzantine:
        bearing = {"decision.parameters": {**parameters, TOLERATES: byzantine + 1}}
        tried[f"with {liars} and {TOLERATES} = {byzantine + 1}"] = {**lying, **bearing}
    return _valid(scenario, tried)


def _valid(scenario: Scenario, tried: Mapping[str, Mapping[str, Any]]) -> dict[str, Scenario]:
    """Return the scenario with each of the changes that it supports."""
    changed = {}
    for name, values in tried.items():
        try:
            changed[name] = scenario.replace(values)
        except ScenarioError:  # such as a range that would reach round the torus
            continue
    return changed
