"""Assess a swarm before deployment: whether it would be right, how sure that is, and what would help."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

from feasibee.results.statistics import Interval, in_percent, wilson
from feasibee.scenario.feasibility import explain
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.sections import KINDS
from feasibee.simulation.sequential import EARLY, FIRST, Finding, SequentialDesign, looks
from feasibee.simulation.sweep import Enough, Execution, Rounds
from feasibee.studies.comparison import SURE, Outcome, design_points, difference, outcomes_of
from feasibee.studies.constraints import TOLERATES, Constraints, compare_under, numbered, opposite_of
from feasibee.studies.needs import all_strategies, possible, suitable
from feasibee.studies.report import NOT_READY, READY, Assessment, Trial, is_none, level_of
from feasibee.studies.size import Rule, Sizing, band_of, size

AS_IT_IS, OPPOSITE = "as it is", "opposite"
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
    *,
    details: bool = True,
) -> Assessment:
    """Simulate a swarm, other strategies, single faults, and changes to it, all on the same worlds.

    All differences hold together with a probability of 95 %. The swarm, and strategies that do better, are
    also simulated at the reciprocal ratio, since a swarm may always give one answer.

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
    details : bool
        Whether to compute all. Otherwise, strategies are tried only if the swarm isn't ready, changes and
        numbers of robots only if no strategy is shown to be enough, and only up to one that is.

    Returns
    -------
    Assessment
        With ``level`` and ``to_dict``; in notebooks, a page.

    Examples
    --------
    >>> import feasibee
    >>> found = feasibee.assess(feasibee.Scenario(decision={"strategy": "census"}), runs=100, details=False)
    >>> found.level, found.to_dict()["right_from_step"]
    ('ready', 92)
    """
    scenario = scenario.replace({"run.stop_at_decision": False})
    with Rounds(execution, most=None) as rounds:
        return _Assessing(rounds, scenario, runs, seed, right, details).assessment()


def is_clear(shown: Interval) -> bool:
    """Whether a difference is shown to have its sign."""
    return shown.low > 0 or shown.high < 0


@dataclass(frozen=True)
class Race:
    """How changed swarms are raced against the swarm without the change, all of them on the same worlds.

    A change has as many runs as its difference takes: until it is clear, or surely small. All differences of
    a report share one error rate (Bonferroni over changes and looks), so that none of them is shown by luck.
    """

    rounds: Rounds
    runs: int
    """Largest number of runs of a change."""
    seed: int
    tests: int
    """Largest number of differences in the report, times that of looks at one: they hold together."""

    @property
    def design(self) -> SequentialDesign:
        """The numbers of runs after which differences are looked at."""
        return SequentialDesign(self.runs, tests=self.tests)

    @property
    def confidence(self) -> float:
        """Confidence of each difference at each look."""
        return self.design.level

    def outcomes(self, kinds: Mapping[str, Scenario], runs: int) -> dict[str, Outcome]:
        """Return the outcomes of some scenarios, by name, with so many runs each; as `outcomes_of`."""
        designs = design_points(kinds, (), runs, self.seed)
        found = outcomes_of(self.rounds, designs, runs, self.seed)
        return {each.contender: each for each in found}

    def against(
        self,
        scenario: Scenario,
        changed: Mapping[str, Scenario],
        is_hopeless: Callable[[Outcome], bool] | None = None,
    ) -> dict[str, tuple[Outcome, Interval]]:
        """Return the outcome of each changed scenario, and its difference from the unchanged one.

        If the study ends early, they are those of the last look, if any. Changes that are hopeless end at
        once, perhaps at looks that are too early for a difference.
        """

        def see(left: Mapping[str, Scenario], runs: int) -> dict[str, tuple[Outcome, Interval]]:
            outcomes = self.outcomes({AS_IT_IS: scenario, **left}, runs)
            base = outcomes.pop(AS_IT_IS)
            return {name: (each, difference(each, base, self.confidence)) for name, each in outcomes.items()}

        def is_settled(seen: tuple[Outcome, Interval]) -> bool:
            outcome, gain = seen
            if is_hopeless is not None and is_hopeless(outcome):
                return True
            return outcome.runs >= self.design.first and (is_clear(gain) or is_none(gain))

        design = self.design if is_hopeless is None else replace(self.design, early=EARLY)
        return design.run(changed, see, is_settled)


@dataclass(frozen=True)
class _Assessing:
    """The rounds of one assessment."""

    rounds: Rounds
    scenario: Scenario
    runs: int
    seed: int
    right: float
    details: bool = True
    missing: list[str] = field(default_factory=list)
    """Phases that ended early."""

    def assessment(self) -> Assessment:
        """Compute the answer first, then the details."""
        found = self._answer()
        advised = found.advice[1]
        if self.details or advised is not None or found.level != NOT_READY:  # nobody deploys the others
            faults = faults_of(world := (advised or found.own).scenario)
            found = replace(found, faults=self._raced("comparing faults", world, faults))
        found = self._detailed(found) if self.details else found
        return replace(found, stopped=self.rounds.stopped, missing=tuple(self.missing))

    def _answer(self) -> Assessment:
        """Return what the advice rests on, from the cheapest to the most expensive change."""
        outcomes = self._verdict_runs()
        base, opposite = outcomes[AS_IT_IS], outcomes.get(OPPOSITE)
        found = Assessment(self.scenario, explain(self.scenario), self.right, base, opposite, self.seed)
        if found.level == READY:
            return found
        found = self._with_strategies(found)
        if found.recommended or any(each.helps(self.right) for each in found.strategies):
            return found
        return self._with_changes(found)

    def _with_changes(self, found: Assessment) -> Assessment:
        """Return an assessment with changes and numbers of robots: without details, up to one that is enough.

        The cheapest change comes first, and numbers of robots are searched where their change comes.
        """
        robots_may_help = found.opposite is None or found.opposite.judged.low >= self.right
        if self.details:
            found = replace(found, limits=self._changes(self.changed))
            return replace(found, sizing=self._sizing()) if robots_may_help else found
        robots, hopeless = self.scenario.robots.count, self._hopeless(found)
        more = [name for name, each in self.changed.items() if each.robots.count > robots]
        for name in self.changed:
            if robots_may_help and name == next(iter(more or self.changed)):
                found = replace(found, sizing=self._sizing())
            if name not in hopeless and not found.enough:
                found = replace(found, limits=_best_first([*found.limits, *self._changes([name])]))
            if found.enough:
                break
        return found

    def _detailed(self, found: Assessment) -> Assessment:
        found = self._with_strategies(found) if found.level == READY else found
        band = None
        strategies = found.strategies or self._others(found)
        limits = found.limits or self._changes(self.changed)
        sizing = found.sizing or self._sizing()
        with self._part("searching sizes"):
            if found.recommended is not None and found.opposite is not None:
                world = found.recommended.scenario
                band = band_of(world, self.rule, self.seed, self.rounds, SHORT_REACH)
        return replace(found, strategies=strategies, limits=limits, sizing=sizing, recommended_band=band)

    @contextmanager
    def _part(self, phase: str) -> Iterator[None]:
        """Compute a part of the answer; note its phase if it ends before it is complete."""
        self.rounds.phase, before = phase, self.rounds.stops
        with suppress(Enough):
            yield
        if self.rounds.stops > before and phase not in self.missing:
            self.missing.append(phase)

    @cached_property
    def changed(self) -> dict[str, Scenario]:
        """The scenario with each change that may show what limits the swarm."""
        return changes_of(self.scenario)

    @property
    def rule(self) -> Rule:
        """How values are tested."""
        most = max(LEAST_RUNS, self.runs)
        return Rule(self.right, most=most, resolution=RESOLUTION, band=self.details)

    @cached_property
    def race(self) -> Race:
        """How changes are raced: their differences hold together with those of strategies."""
        differences = len(self.changed) + len(all_strategies(self.scenario)) + MOST_FAULTS
        several = len(looks(FIRST, max(LEAST_RUNS, self.runs)))
        return Race(self.rounds, self.runs, self.seed, differences * several)

    def _verdict_runs(self) -> dict[str, Outcome]:
        """Return the outcome of the scenario, and that at the opposite truth, if any.

        Without details, the latter ends once no further runs could let the swarm be ready. So the verdict is
        that of all runs. The share of fewer runs has a confidence sequence, since what came ended them.
        """
        opposite = opposite_of(self.scenario)
        worlds = {AS_IT_IS: self.scenario} | ({} if opposite is None else {OPPOSITE: opposite})
        outcomes: dict[str, Outcome] = {}
        with self._part("running the swarm"):
            for runs in (min(FEW, self.runs), *looks(FIRST, self.runs)):
                outcomes |= self.race.outcomes(worlds, runs)
                if OPPOSITE in worlds and not self.details and (test := self._failed(outcomes[OPPOSITE])):
                    outcomes[OPPOSITE] = replace(outcomes[OPPOSITE], test=test)
                    del worlds[OPPOSITE]
                shares = [each.judged for each in outcomes.values()]
                told = " and ".join(map(in_percent, shares))
                self.rounds.tell(f"{level_of(shares, self.right)} so far: right in {told} of {runs} runs")
        return outcomes

    def _failed(self, outcome: Outcome) -> Finding | None:
        """Return the test of a swarm that no further runs could let be ready; None if some could."""
        right, runs = int(outcome.right.sum()), outcome.runs
        best = wilson(self.runs - runs + right, self.runs)  # if it were right in all runs that are left
        test = SequentialDesign(self.runs).tested(self.right, right, runs)
        fails = test.answer == "too few" and best.high < self.right
        return test if fails and FIRST <= runs < self.runs else None

    def _raced(
        self,
        phase: str,
        scenario: Scenario,
        changed: Mapping[str, Scenario],
        is_hopeless: Callable[[Outcome], bool] | None = None,
    ) -> list[Trial]:
        """Return changed swarms and their differences from the unchanged one."""
        with self._part(phase):
            found = self.race.against(scenario, changed, is_hopeless)
        return [Trial(changed[name], each, difference=gain) for name, (each, gain) in found.items()]

    def _with_strategies(self, found: Assessment) -> Assessment:
        """Return an assessment with the strategies that reach the target; the scenario's own comes first."""
        own, constraints = self.scenario.decision.strategy, Constraints(self.right)
        if self.scenario.dynamic:
            others = {name: each for name, each in suitable(self.scenario)[0].items() if name != own}
            raced = self._raced("comparing strategies", self.scenario, others)
            return replace(found, strategies=_best_first(raced))
        with self._part("testing strategies"):
            runs = max(LEAST_RUNS, self.runs)
            early = () if self.details else EARLY  # the details have differences, of 100 runs or more
            tested = compare_under(
                self.scenario, constraints, (), runs, self.seed, self.rounds, relax=False, early=early
            )
        first = next(
            (each for each in tested.ranking if each.strategy == own), next(iter(tested.ranking), None)
        )
        return replace(found, recommendation=tested, recommended=first)

    def _others(self, found: Assessment) -> list[Trial]:
        """Return the other tested strategies, with their differences from the scenario's own."""
        tested, own = found.recommendation.tested if found.recommendation else (), found.scenario
        others = [Trial.of(each).untested() for each in tested if each.strategy != own.decision.strategy]
        gains = [difference(each.outcome, found.outcome, self.race.confidence) for each in others]
        return _best_first([replace(each, difference=gain) for each, gain in zip(others, gains, strict=True)])

    def _changes(self, names: Iterable[str]) -> list[Trial]:
        """Return priced changes; those that may be enough have all runs, also at the opposite truth."""
        tried, prices = {name: self.changed[name] for name in names}, [*self.changed]
        is_hopeless = None if self.details else self._is_hopeless
        found = self._raced("comparing changes", self.scenario, tried, is_hopeless)
        near = {each.name: each.scenario for each in found if _may_be_enough(each, self.right)}
        worlds = {name: world for name, each in near.items() if (world := opposite_of(each)) is not None}
        here: dict[str, Outcome] = {}
        there: dict[str, Outcome] = {}
        with self._part("comparing changes"):
            here = self.race.outcomes(near, self.runs) if near else {}
            there = self.race.outcomes(worlds, self.runs) if worlds else {}
        return _best_first(
            [
                replace(
                    each,
                    outcome=here.get(each.name, each.outcome),
                    opposite=there.get(each.name),
                    price=prices.index(each.name),
                )
                for each in found
            ]
        )

    def _hopeless(self, found: Assessment) -> set[str]:
        """Return the changes that few runs at the opposite truth exclude, if the swarm is worse there."""
        if found.own.worst is not found.opposite:
            return set()
        worlds = {name: world for name, each in self.changed.items() if (world := opposite_of(each))}
        design = SequentialDesign(min(FIRST, self.runs), early=EARLY)
        with self._part("comparing changes"):
            seen = design.run(worlds, self.race.outcomes, self._is_hopeless)
        return {name for name, each in seen.items() if self._is_hopeless(each)}

    def _is_hopeless(self, outcome: Outcome) -> bool:
        """Whether a swarm would not be enough even if it were right in all runs that it can still have."""
        wrong = outcome.runs - int(outcome.right.sum())
        return outcome.tracking is None and wilson(self.runs - wrong, self.runs).low < self.right

    def _sizing(self) -> Sizing | None:
        """Return how many robots are enough; None if their number can't vary, or the world changes."""
        robots, found = self.scenario.robots, None
        with self._part("searching sizes"):
            if not (self.scenario.dynamic or robots.classes or robots.points):
                found = size(
                    self.scenario, rule=self.rule, seed=self.seed, execution=self.rounds, reach=SHORT_REACH
                )
        return found


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
    return {name: each for name, values in tried.items() if (each := possible(scenario, values)) is not None}
