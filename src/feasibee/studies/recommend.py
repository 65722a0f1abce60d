"""Recommend a strategy: test all of them under the constraints of a deployment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Final

from feasibee.errors import FeasibeeError, ScenarioError
from feasibee.results.crossing import Rule, finding_at
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import CONTENDER, Outcome, check_distinct, outcomes_of
from feasibee.studies.needs import longest_message, needs_of
from feasibee.studies.recommendation import (
    Candidate,
    Constraints,
    Measured,
    Recommendation,
    Relaxation,
    ranked,
)
from feasibee.studies.suitable import all_strategies, check_stays, strategy_change
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds

TOLERATES: Final = "tolerates"
"""The parameter that says how many Byzantine robots a strategy bears."""


def recommend(
    scenario: Scenario,
    constraints: Constraints | None = None,
    strategies: Sequence[str] = (),
    runs: int = 1000,
    seed: int = 0,
    execution: Execution | None = None,
) -> Recommendation:
    """Find the strategies that meet some constraints in a scenario's world, and rank them.

    A strategy meets ``right`` if it is shown to be right often enough at the last step, in this world and in
    one of the opposite truth, since one that always gave the same answer would be right in all worlds of one
    truth. All runs have the faulty robots of the constraints. If ids may be mistaken, robots draw them at
    random, in as many bits as the number of robots takes. All intervals of the ranked and the excluded
    strategies hold together with a probability of 95 %. Relaxed constraints are tested in addition.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its world.
    constraints : Constraints, optional
        What strategies must do with, and bear.
    strategies : sequence of str
        Names or files; by default those that ``feasibee strategies`` lists.
    runs : int
        Largest number of runs of each strategy in each world; a test begins with 100.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Raises
    ------
    FeasibeeError
        If the constraints contradict each other or the scenario.
    """
    check_stays(scenario, "recommend")
    constraints = constraints or Constraints()
    names = list(strategies or all_strategies(scenario))
    check_distinct(names)
    world = world_of(scenario, constraints)  # raises before the work
    with Rounds(execution, 3 * len(names) * Rule.first) as rounds:
        return recommend_within(rounds, scenario, world, constraints, names, runs, seed)


def recommend_within(
    rounds: Rounds,
    scenario: Scenario,
    world: Scenario,
    constraints: Constraints,
    names: Sequence[str],
    runs: int,
    seed: int,
) -> Recommendation:
    """Recommend as a part of another study; ``world`` is the scenario with what strategies must bear."""
    trials = Trials(rounds, Rule(constraints.right, most=runs), seed, 2 * len(names))
    candidates, problems = trials.candidates(world, names, constraints)
    reasons = {each.strategy: each.reasons(constraints) for each in candidates}
    ranking = ranked([each for each in candidates if not reasons[each.strategy]])
    relax = () if ranking else _relaxations(trials, scenario, constraints, names, candidates)
    excluded = {name: "; ".join(why.values()) for name, why in reasons.items() if why}
    return Recommendation(world, constraints, ranking, {**excluded, **problems}, relax, seed)


def world_of(scenario: Scenario, constraints: Constraints) -> Scenario:
    """Return the scenario with the faulty robots of the constraints, and with ids that may be mistaken."""
    robots = scenario.robots.count
    _check(constraints, robots, scenario.setting.id_bits)
    changes: dict[str, Any] = {"run.stop_at_decision": False}
    if constraints.liars:
        changes["faults.byzantine"] = constraints.liars / robots
    if constraints.stopped:
        changes["faults.stopped"] = constraints.stopped / robots
    if not constraints.ids and scenario.radio.id_bits is None:
        changes["radio.id_bits"] = scenario.setting.id_bits
    return scenario.replace(changes)


def _check(constraints: Constraints, robots: int, id_bits: int) -> None:
    faulty = constraints.liars + constraints.stopped
    if faulty >= robots:
        raise FeasibeeError(
            f"--liars {constraints.liars} --stopped {constraints.stopped}: must be fewer together than the "
            f"{robots} robots; such as --liars {min(1, robots - 1)}"
        )
    least = id_bits + 1
    if constraints.message_bits is not None and constraints.message_bits < least and constraints.ids:
        raise FeasibeeError(
            f"--message-bits {constraints.message_bits}: an id and an opinion alone take {least} bits; "
            f"use {least} or more"
        )


@dataclass(frozen=True)
class Trials:
    """Tests strategies in a world and at its opposite truth, all of them on the same runs."""

    rounds: Rounds
    rule: Rule
    seed: int
    tests: int

    def candidates(
        self, world: Scenario, names: Sequence[str], constraints: Constraints
    ) -> tuple[list[Candidate], dict[str, str]]:
        """Return what each strategy does in a world, and why the world supports the others not."""
        scenarios, problems = [], {}
        for name in names:
            try:
                scenarios.append(world.replace(strategy_for(world, name, constraints.liars)))
            except ScenarioError as error:
                if any(problem.path == "decision.strategy" for problem in error.problems):
                    raise  # there is no such strategy
                problems[name] = error.problems[0].rule.removeprefix(f"{name} ")
        designs = list(map(_design, scenarios))  # their first runs side by side, on all workers
        self.rounds.complete(Study(designs, min(self.rule.first, self.rule.most), self.seed, curves=True))
        return [self._candidate(scenario) for scenario in scenarios], problems

    def _candidate(self, scenario: Scenario) -> Candidate:
        worlds = [self._measured(scenario)]
        turned = opposite_of(scenario)
        if turned is not None and worlds[0].test.answer == "enough":
            worlds.append(self._measured(turned))
        return Candidate(
            strategy=scenario.decision.strategy,
            scenario=scenario,
            worlds=worlds,
            message_bits=longest_message(scenario, self.seed),
            needs=needs_of(scenario),
            right=self.rule.target,
        )

    def _measured(self, scenario: Scenario) -> Measured:
        last: list[Outcome] = []

        def count(runs: int) -> int:
            last[:] = outcomes_of(self.rounds, [_design(scenario)], runs, self.seed)
            return int(last[0].right.sum())

        test = finding_at(0, count, self.rule, self.tests)
        return Measured(scenario.tasks.count, test, last[0])


def _design(scenario: Scenario) -> DesignPoint:
    return DesignPoint({CONTENDER: scenario.decision.strategy}, scenario)


def strategy_for(world: Scenario, name: str, liars: int) -> dict[str, Any]:
    """Return the changes that give a world a strategy, which bears the Byzantine robots if it can."""
    changes = strategy_change(world, name)
    if not liars or not changes:
        return changes  # the scenario's own strategy keeps its parameters
    manifest = world.replace(changes).manifest
    return (
        {**changes, "decision.parameters": {TOLERATES: liars}}
        if TOLERATES in manifest.parameters
        else changes
    )


def opposite_of(scenario: Scenario) -> Scenario | None:
    """Return the scenario at the reciprocal ratio of robots to tasks, where the truth is the opposite.

    None if robots or tasks have classes, tasks have given places, or it isn't valid.
    """
    robots, tasks = scenario.robots.count, scenario.tasks.count
    others = robots + 1 if tasks == robots else max(1, round(robots * robots / max(1, tasks)))
    if scenario.robots.classes or scenario.tasks.classes or scenario.tasks.points:
        return None
    with suppress(ScenarioError):  # such as more tasks than a census has room for
        turned = scenario.replace({"tasks.count": others})
        return turned if truth(turned) != truth(scenario) else None
    return None


def _relaxations(
    trials: Trials,
    scenario: Scenario,
    constraints: Constraints,
    names: Sequence[str],
    candidates: Sequence[Candidate],
) -> list[Relaxation]:
    """Return for each constraint what would be recommended without it."""
    alone: dict[str, list[Candidate]] = {}
    for each in candidates:
        reasons = list(each.reasons(constraints))
        if len(reasons) == 1:
            alone.setdefault(reasons[0], []).append(each)
    found = {name: ranked(those)[0] for name, those in alone.items()}
    for name, looser, changes in _looser(scenario, constraints):
        world = world_of(scenario.replace(changes), looser)
        others, _ = trials.candidates(world, names, looser)
        for each in ranked(others):
            left = list(each.reasons(looser))
            if not left:
                found.setdefault(name, each)
            elif len(left) == 1 and "--right" not in left:
                found.setdefault(f"{name} and {left[0]}", each)
    return _without_supersets(found)


def _without_supersets(found: Mapping[str, Candidate]) -> list[Relaxation]:
    """Leave out pairs of constraints of which one alone is enough; of two orders of a pair, keep one."""
    kept: dict[frozenset[str], Relaxation] = {}
    for name, each in sorted(found.items(), key=lambda item: item[0].count(" and ")):
        parts = frozenset(name.split(" and "))
        if not any(those <= parts for those in kept):
            kept[parts] = Relaxation(name, each)
    return sorted(kept.values(), key=lambda each: -each.candidate.worst.right.estimate)


def _looser(scenario: Scenario, constraints: Constraints) -> list[tuple[str, Constraints, Mapping[str, Any]]]:
    """Return the constraints that change the world, each left out: its name, the others, and what changes."""
    ways: list[tuple[str, Constraints, Mapping[str, Any]]] = []
    if constraints.liars:
        ways.append(("--liars", replace(constraints, liars=0), {}))
    if constraints.stopped:
        ways.append(("--stopped", replace(constraints, stopped=0), {}))
    if not constraints.ids:
        ways.append(("--no-ids", replace(constraints, ids=True), {}))
    if not scenario.robots.know_count:
        ways.append(("robots.know_count = true", constraints, {"robots.know_count": True}))
    return ways
