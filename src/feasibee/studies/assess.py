"""Assess a swarm before deployment: whether it would be right, how sure that is, and what would help."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from feasibee.errors import ScenarioError
from feasibee.scenario.feasibility import explain
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.sections import KINDS
from feasibee.studies.comparison import SURE, Outcome, design_points, difference, outcomes_of
from feasibee.studies.needs import asked_of, suitable
from feasibee.studies.recommend import (
    TOLERATES,
    Candidate,
    Constraints,
    Recommendation,
    numbered,
    opposite_of,
    recommend,
)
from feasibee.studies.report import Assessment, Trial
from feasibee.studies.size import Rule, Sizing, band_of, size
from feasibee.sweeps.sweep import Execution, Rounds

AS_IT_IS: Final = "as it is"
RESOLUTION: Final = 0.15
"""Of the numbers of robots and of tasks that are enough: a finer search would take most of the time."""
SHORT_REACH: Final = 3
"""Searches go up to so many times the number of robots or tasks."""
LEAST_RUNS: Final = 400
"""A search may use so many runs of a value: 100 % of 200 is not enough to exclude 95 %."""
LOST: Final = 0.2
"""Share of lost messages that is tried as a fault."""
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

    A swarm that always gave one answer would be right in all worlds of one truth. So the swarm, and the
    strategies that do better, are also simulated at the reciprocal ratio of robots to tasks.

    In a world that changes, swarms are judged by the share of steps at which they are right. Neither numbers
    of robots nor the opposite truth are searched then, and no strategy is recommended.

    Parameters
    ----------
    scenario : Scenario
        What to assess.
    runs : int
        Number of runs of each variant; searches use up to as many for each of their values, or 400.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    right : float
        Share of swarms that must be right; in a world that changes, share of steps.
    """
    scenario = scenario.replace({"run.stop_at_decision": False})
    with Rounds(execution, most=None) as rounds:
        return _Assessing(rounds, scenario, runs, seed, right).assessment()


@dataclass(frozen=True)
class _Assessing:
    """The rounds of one assessment."""

    rounds: Rounds
    scenario: Scenario
    runs: int
    seed: int
    right: float

    def assessment(self) -> Assessment:
        scenario = self.scenario
        others, changed = suitable(scenario)[0], changes_of(scenario)
        others.pop(scenario.decision.strategy, None)
        outcomes = self._outcomes({AS_IT_IS: scenario, **changed, **others})
        base = outcomes[AS_IT_IS]
        strategies = _trials(others, outcomes, base)
        gaining = [each.outcome.contender for each in strategies if each.difference.low > 0]
        opposite = self._outcomes(_turned({AS_IT_IS: scenario, **{name: others[name] for name in gaining}}))
        recommendation, recommended = self._recommended()
        rule = Rule(self.right, most=max(LEAST_RUNS, self.runs), resolution=RESOLUTION)
        chosen = None if recommended is None else recommended.scenario
        return Assessment(
            scenario=scenario,
            truth=explain(scenario),
            target=self.right,
            outcome=base,
            asked=asked_of(scenario, self.seed),
            sizing=self._sizing(rule),
            limits=_trials(changed, outcomes, base),
            strategies=[replace(each, opposite=opposite.get(each.outcome.contender)) for each in strategies],
            opposite=opposite.get(AS_IT_IS),
            recommendation=recommendation,
            recommended=recommended,
            recommended_band=(
                None if chosen is None else band_of(chosen, rule, self.seed, self.rounds, SHORT_REACH)
            ),
            faults=self._faults(chosen or scenario),
            seed=self.seed,
        )

    def _outcomes(self, kinds: Mapping[str, Scenario]) -> dict[str, Outcome]:
        self.rounds.phase = "comparing"
        designs = design_points(kinds, (), self.runs, self.seed)
        return {each.contender: each for each in outcomes_of(self.rounds, designs, self.runs, self.seed)}

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
        found = recommend(self.scenario, constraints, (), runs, self.seed, self.rounds)
        first = found.ranking[0] if found.ranking else None
        return found, next((each for each in found.ranking if each.strategy == own), first)

    def _faults(self, chosen: Scenario) -> list[Trial]:
        """Return what single faults do to a swarm, compared with the same swarm without them."""
        outcomes = self._outcomes({AS_IT_IS: chosen, **faults_of(chosen)})
        base = outcomes.pop(AS_IT_IS)
        return [Trial(each, difference(each, base)) for each in outcomes.values()]


def _turned(kinds: Mapping[str, Scenario]) -> dict[str, Scenario]:
    """Return the scenarios at the reciprocal ratio, where the truth is the opposite, as far as possible."""
    turned = {name: None if each.dynamic else opposite_of(each) for name, each in kinds.items()}
    return {name: each for name, each in turned.items() if each is not None}


def _trials(names: Mapping[str, Any], outcomes: Mapping[str, Outcome], base: Outcome) -> list[Trial]:
    trials = [Trial(outcomes[name], difference(outcomes[name], base)) for name in names]
    return sorted(trials, key=lambda trial: (-trial.difference.estimate, trial.outcome.bits.mean()))


def changes_of(scenario: Scenario) -> dict[str, Scenario]:
    """Return the scenario with each change that may show what limits the swarm."""
    sensing, radio, decision, robots = scenario.sensing, scenario.radio, scenario.decision, scenario.robots
    tried: dict[str, dict[str, Any]] = {
        "sight 1.5 times as far": {"sensing.range": MORE * sensing.range, "radio.range": radio.range},
        "radio 1.5 times as far": {"radio.range": MORE * radio.range},
        "explorations 3 times as long": {"decision.exploration": 3 * decision.exploration},
        "3 times as many steps": {"run.steps": 3 * scenario.run.steps},
    }
    if not (robots.classes or robots.points):
        more = round(MORE * robots.count)
        tried[f"{more} robots instead of {robots.count}"] = {"robots.count": more}
    if not sensing.count_self:
        tried["robots that count themselves"] = {"sensing.count_self": True}
    errors = ("miss", "false_robots", "false_tasks", "misname")
    if any(getattr(sensing, name) for name in errors):
        tried["a perfect sensor"] = {f"sensing.{name}": 0.0 for name in errors}
    if radio.loss:
        tried["no message lost"] = {"radio.loss": 0.0}
    if any(scenario.faulty):
        tried["no faulty robot"] = {f"faults.{kind}": 0.0 for kind in KINDS}
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
