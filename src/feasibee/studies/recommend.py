"""Recommend a strategy: test all of them under the constraints of a deployment."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Final

from feasibee.errors import FeasibeeError, ScenarioError
from feasibee.results.statistics import Interval
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import step_in_words
from feasibee.studies.comparison import (
    CONTENDER,
    Outcome,
    check_distinct,
    check_stays,
    origin,
    outcomes_of,
    percent,
    rounds_of,
    studies_of,
    wait_for,
)
from feasibee.studies.needs import IDS, NAMES, Asked, all_strategies, strategy_change
from feasibee.studies.size import Finding, Rule, finding_at
from feasibee.sweeps.plan import DesignPoint
from feasibee.sweeps.schedule import run_work
from feasibee.sweeps.sweep import Enough, Execution, Rounds

BEST: Final = ("right most", "soonest", "cheapest")
"""What the first of a ranking by share, by step and by bits is called."""


@dataclass(frozen=True)
class Constraints:
    """What a strategy must do with, and bear."""

    right: float = 0.95
    """Share of swarms that must be right at the last step, with these tasks and at the opposite truth."""
    bits: float | None = None
    """Most bits per robot-step, on average."""
    message_bits: int | None = None
    """Most bits in a message."""
    ids: bool = True
    names: bool = True
    """Whether ids of robots are never misread, and whether all robots have the same name for a task."""
    liars: int = 0
    stopped: int = 0
    """Number of Byzantine robots, and of robots that stop."""

    @property
    def faults(self) -> str:
        """The faulty robots, in words; empty without any."""
        kinds = {"Byzantine robot": self.liars, "stopped robot": self.stopped}
        return " and ".join(numbered(number, name) for name, number in kinds.items() if number)


def numbered(number: int, name: str) -> str:
    """Return a number with a name, such as ``3 robots``."""
    return f"{number} {name}" if number == 1 else f"{number} {name}s"


@dataclass(frozen=True)
class Measured:
    """A world in which a strategy was tested."""

    test: Finding
    """Its test, with an interval that holds for all tests together."""
    outcome: Outcome
    """Outcome of the same runs."""

    target: float
    """Share of swarms that must be right."""

    @property
    def right(self) -> Interval:
        """Share of swarms that are right at the last step."""
        return self.test.interval

    @property
    def is_close(self) -> bool:
        """Whether the share isn't shown to reach the target, but is as large."""
        return self.test.answer == "open" and self.right.estimate >= self.target


@dataclass(frozen=True)
class Candidate:
    """A strategy under the constraints."""

    strategy: str
    """Its name."""
    scenario: Scenario
    """The scenario with it."""
    worlds: Sequence[Measured]
    """The scenario's world, then that of the opposite truth, if it was tested."""
    asked: Asked
    """What it asks of the robots."""
    right: float
    """Share of swarms that must be right."""

    @property
    def worst(self) -> Measured:
        """The world in which it is right least often."""
        return min(self.worlds, key=lambda each: each.right.estimate)

    @property
    def is_probable(self) -> bool:
        """Whether it probably reaches the target in all worlds, although it isn't shown."""
        close = [each.is_close for each in self.worlds]
        return any(close) and all(each.is_close or each.test.answer == "enough" for each in self.worlds)

    @property
    def bits(self) -> float:
        """Mean number of bits per robot-step in the scenario's world."""
        return float(self.worlds[0].outcome.bits.mean())

    @property
    def step(self) -> int | None:
        """First step from which enough swarms are right until the end, in both worlds; None without one."""
        steps = [wait_for(each.outcome, self.right) for each in self.worlds]
        return None if None in steps else max(step for step in steps if step is not None)

    def reasons(self, constraints: Constraints) -> dict[str, str]:
        """Return which constraints it does not meet, by the option's name, each with the reason in words."""
        found = barred(self.asked, constraints)
        if constraints.bits is not None and self.bits > constraints.bits:
            found["--bits"] = f"{self.bits:.3g} bits per robot-step"
        short = [each for each in self.worlds if each.test.answer != "enough"]
        if short:
            found["--right"] = "; ".join(_short(each, self.worlds[0], constraints) for each in short)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the candidate as plain tables, for programs."""
        return {
            "strategy": self.strategy,
            "parameters": dict(self.scenario.decision.parameters),
            "right": self.worlds[0].right._asdict(),
            "opposite": [
                {"tasks": each.outcome.tasks, "right": each.right._asdict()} for each in self.worlds[1:]
            ],
            "runs": self.worlds[0].test.trials,
            "step": self.step,
            "bits": self.bits,
            "message_bits": self.asked.message_bits,
            "needs": list(self.asked.needs),
        }


def barred(asked: Asked, constraints: Constraints) -> dict[str, str]:
    """Return which constraints a strategy can't meet, however often it is right, as `Candidate.reasons`."""
    found = {}
    if not constraints.ids and IDS in asked.needs:
        found["--no-ids"] = f"needs {IDS}"
    if not constraints.names and NAMES in asked.needs:
        found["--no-names"] = f"needs {NAMES}"
    if constraints.message_bits is not None and asked.message_bits > constraints.message_bits:
        found["--message-bits"] = f"messages of up to {asked.message_bits} bits"
    return found


def _short(world: Measured, first: Measured, constraints: Constraints) -> str:
    given = ["" if world is first else f"{world.outcome.tasks} tasks", constraints.faults]
    having = " and ".join(each for each in given if each)
    close = ", too close to tell" if world.test.answer == "open" else ""
    right = f"right in {world.test.successes} of {world.test.trials}{close}"
    return f"with {having} {right}" if having else right


@dataclass(frozen=True)
class Relaxation:
    """A constraint without which a strategy would be recommended."""

    constraint: str
    """Name of its option."""
    candidate: Candidate
    """The best strategy without it."""

    @property
    def in_words(self) -> str:
        """What to do, such as ``Without --no-ids and --no-names``; a change of a field is one with it."""
        parts = self.constraint.split(" and ")
        changed = [part for part in parts if "=" in part]
        left = [part for part in parts if "=" not in part]
        ways = {"with": changed, "without": left}
        text = " and ".join(f"{way} {' and '.join(those)}" for way, those in ways.items() if those)
        return text[0].upper() + text[1:]

    def to_dict(self) -> dict[str, Any]:
        """Return the relaxation as plain tables, for programs."""
        return {"constraint": self.constraint, **self.candidate.to_dict()}


@dataclass(frozen=True)
class Recommendation:
    """Which strategies meet some constraints, the best first."""

    scenario: Scenario
    """The swarm and its world, with the faults of the constraints."""
    constraints: Constraints
    """What strategies must do with, and bear."""
    ranking: Sequence[Candidate]
    """Those that meet all."""
    excluded: Mapping[str, str]
    """The others by name, each with the reasons."""
    relax: Sequence[Relaxation] = field(default=())
    """If none meets all: which constraint to relax, and what that gains."""
    seed: int = 0
    tested: Sequence[Candidate] = field(default=())
    """All strategies that were simulated."""
    stopped: str = ""
    """Why the tests ended early, if they did."""

    @property
    def best(self) -> dict[str, list[str]]:
        """Return what each strategy is best at: ``"right most"``, ``"soonest"`` or ``"cheapest"``."""
        found: dict[str, list[str]] = {each.strategy: [] for each in self.ranking}
        if self.ranking:
            keys = (lambda each: -each.worst.right.estimate, lambda each: each.step, lambda each: each.bits)
            for name, key in zip(BEST, keys, strict=True):
                found[min(self.ranking, key=key).strategy].append(name)
        return found

    @property
    def probably(self) -> list[str]:
        """Return in words which strategy probably meets all constraints, if none is shown to."""
        close = [each for each in self.tested if each.is_probable and not self.ranking]
        close = [each for each in close if list(each.reasons(self.constraints)) == ["--right"]]
        if not close:
            return []
        best = ranked(close)[0]
        more = [each.test.more_trials(best.right) for each in best.worlds if each.is_close]
        known = [number for number in more if number is not None]
        settled = f"about {max(known):,} more runs" if len(known) == len(more) else "many more runs"
        return [f"{best.strategy} probably is: {percent(best.worst.right)}; {settled} would settle it."]

    def to_dict(self) -> dict[str, Any]:
        """Return the recommendation as plain tables, for programs."""
        best = self.best
        return {
            "ranking": [{**each.to_dict(), "best": best[each.strategy]} for each in self.ranking],
            "excluded": [{"strategy": name, "reason": why} for name, why in self.excluded.items()],
            "relax": [each.to_dict() for each in self.relax],
            "probably": self.probably,
            "stopped": self.stopped,
            "constraints": vars(self.constraints),
            "by": self.scenario.run.steps,
            **origin(self.seed, self.scenario),
        }


def ranked(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates in their order: by right swarms in whole percent, then by step, then by bits."""
    return sorted(
        candidates,
        key=lambda each: (
            -round(100 * each.worst.right.estimate),
            math.inf if each.step is None else each.step,
            each.bits,
        ),
    )


def described(candidate: Candidate) -> str:
    """Return what a candidate does, in words."""
    found = candidate.step
    step = "" if found is None else f", from {step_in_words(candidate.scenario, found)} on"
    defaults, values = candidate.scenario.manifest.parameters, candidate.scenario.decision.parameters
    changed = [f"{name} = {value:g}" for name, value in values.items() if value != defaults[name]]
    needs = f"needs {', '.join(candidate.asked.needs) or 'nothing more'}"
    return (
        f"right in {percent(candidate.worst.right)}{step}; {candidate.bits:.3g} bits per robot-step, "
        f"{candidate.asked.message_bits} in the longest message; {needs}"
        + (f"; with {', '.join(changed)}" if changed else "")
    )


A_WORKER: Final = 4
"""Number of strategies whose first runs a worker has at a time."""
WITHOUT: Final = "testing without constraints"
TOLERATES: Final = "tolerates"
"""The parameter that says how many Byzantine robots a strategy bears."""


def recommend(
    scenario: Scenario,
    constraints: Constraints | None = None,
    strategies: Sequence[str] = (),
    runs: int = 1000,
    seed: int = 0,
    execution: Execution | Rounds | None = None,
    *,
    relax: bool = True,
) -> Recommendation:
    """Find the strategies that meet some constraints in a scenario's world, and rank them.

    A strategy meets ``right`` if it is shown to be right often enough at the last step, in this world and in
    one of the opposite truth, since one that always gave the same answer would be right in all worlds of one
    truth. All intervals hold together with a probability of 95 %. Strategies that a constraint excludes are
    run only if none meets all.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its world.
    constraints : Constraints, optional
        What strategies must do with, and bear.
    strategies : sequence of str
        Names or files; by default those that ``feasibee strategies`` lists.
    runs, seed : int
        Largest number of runs of each strategy in each world, where a test begins with 100; and their seed.
    execution : Execution or Rounds, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    relax : bool
        Whether to test which constraint to relax if no strategy meets all.

    Raises
    ------
    FeasibeeError
        If the constraints contradict each other or the scenario.
    """
    check_stays(scenario, "recommend")
    check_distinct(names := list(strategies or all_strategies(scenario)))
    world = world_of(scenario, constraints := constraints or Constraints())  # raises before the work
    with rounds_of(execution, "testing strategies") as rounds:
        rule, looser = Rule(constraints.right, most=runs), _looser(scenario, constraints)
        trials = Trials(rounds, rule, seed, 2 * len(names), rounds is not execution)
        trials.announce(world, len(looser))
        entered = trials.field_of(world, names, constraints)
        candidates = trials.tested(entered.groups[0])
        none = relax and all(each.reasons(constraints) for each in candidates)
        candidates += trials.tested(entered.groups[1]) if none else []
        found = _relaxations(trials, scenario, constraints, names, candidates) if none else ()
    return _recommendation(world, constraints, candidates, entered, found, seed, rounds.stopped)


def _recommendation(
    world: Scenario,
    constraints: Constraints,
    candidates: Sequence[Candidate],
    entered: Field,
    relax: Sequence[Relaxation],
    seed: int,
    stopped: str,
) -> Recommendation:
    """Rank the candidates without reasons, and say why the others and those without runs are excluded."""
    untested = {"stopped": f"not tested ({stopped})"} if stopped else {}
    reasons = {name: why or untested for name, why in entered.barred.items()}
    reasons |= {each.strategy: each.reasons(constraints) for each in candidates}
    excluded = {name: "; ".join(why.values()) for name, why in reasons.items() if why}
    return Recommendation(
        scenario=world,
        constraints=constraints,
        ranking=ranked([each for each in candidates if not reasons[each.strategy]]),
        excluded={**excluded, **entered.problems},
        relax=relax,
        seed=seed,
        tested=candidates,
        stopped=stopped,
    )


def world_of(scenario: Scenario, constraints: Constraints) -> Scenario:
    """Return the scenario with the faulty robots of the constraints, and with ids that may be mistaken.

    Robots draw such ids at random, in as many bits as the number of robots takes.
    """
    robots = scenario.robots.count
    _check(constraints, robots, scenario.setting.id_bits)
    changes: dict[str, Any] = {"run.stop_at_decision": False}
    if constraints.liars:
        changes["faults.byzantine"] = {"count": constraints.liars}
    if constraints.stopped:
        changes["faults.stopped"] = {"count": constraints.stopped}
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
class Field:
    """Strategies in a world, before any run."""

    groups: dict[int, list[tuple[Scenario, Asked]]] = field(default_factory=lambda: {0: [], 1: []})
    """Scenarios with a strategy each, by the number of constraints that it can't meet."""
    barred: dict[str, dict[str, str]] = field(default_factory=dict)
    """Those constraints of each strategy, as `Candidate.reasons`."""
    problems: dict[str, str] = field(default_factory=dict)
    """Why the world supports the others not."""


@dataclass(frozen=True)
class Trials:
    """Tests strategies in a world and at its opposite truth, all of them on the same runs."""

    rounds: Rounds
    rule: Rule
    seed: int
    tests: int
    tells: bool
    """Whether the answer so far is that of these tests, and not of a study around them."""

    def announce(self, world: Scenario, looser: int) -> None:
        """Set the most robot-steps of the tests in a world, and in ``looser`` worlds without constraints."""
        if self.tells:
            most = self.tests * self.rule.most * run_work(world)
            self.rounds.phases = {"testing strategies": most, WITHOUT: looser * most}

    def tell(self, candidate: Candidate) -> None:
        """Add a tested strategy to the answer so far."""
        if self.tells:
            reached = all(each.test.answer == "enough" for each in candidate.worlds)
            told = f"{candidate.strategy} {'is' if reached else 'is not shown to be'} right often enough"
            self.rounds.so_far = f"{told}: {percent(candidate.worst.right)}"

    def field_of(self, world: Scenario, names: Sequence[str], constraints: Constraints) -> Field:
        """Return which strategies a world supports, and which constraints each can't meet."""
        entered = Field()
        for name in names:
            try:
                scenario = world.replace(strategy_for(world, name, constraints.liars))
            except ScenarioError as error:
                if any(problem.path == "decision.strategy" for problem in error.problems):
                    raise  # there is no such strategy
                entered.problems[name] = error.problems[0].rule.removeprefix(f"{name} ")
                continue
            asked = Asked(scenario, self.seed)
            why = entered.barred[scenario.decision.strategy] = barred(asked, constraints)
            entered.groups.setdefault(len(why), []).append((scenario, asked))
        return entered

    def tested(self, group: Sequence[tuple[Scenario, Asked]]) -> list[Candidate]:
        """Return what some strategies do in their world: several a worker at a time, so that none idles."""
        found, number = [], A_WORKER * self.rounds.execution.pool.workers
        for place in range(0, len(group), number):
            some = group[place : place + number]
            self.rounds.place = f"{place + len(some)} of {len(group)}"
            designs = [_design(scenario) for scenario, _ in some]
            with suppress(Enough):
                for study in studies_of(designs, min(self.rule.first, self.rule.most), self.seed):
                    self.rounds.complete(study)
            for each in some:
                with suppress(Enough):  # of the others, all runs may be there
                    found.append(self._candidate(*each))
                    self.tell(found[-1])
        return found

    def _candidate(self, scenario: Scenario, asked: Asked) -> Candidate:
        worlds = [self._measured(scenario)]
        turned = opposite_of(scenario)
        if turned is not None and (worlds[0].test.answer == "enough" or worlds[0].is_close):
            worlds.append(self._measured(turned))
        return Candidate(
            strategy=scenario.decision.strategy,
            scenario=scenario,
            worlds=worlds,
            asked=asked,
            right=self.rule.target,
        )

    def _measured(self, scenario: Scenario) -> Measured:
        last: list[Outcome] = []

        def count(runs: int) -> int:
            last[:] = outcomes_of(self.rounds, [_design(scenario)], runs, self.seed)
            return int(last[0].right.sum())

        test = finding_at(0, count, self.rule, self.tests)
        return Measured(test, last[0], self.rule.target)


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
    """Return for each constraint what would be recommended without it, or without it and a second one."""
    trials.rounds.phase = WITHOUT
    alone: dict[str, list[Candidate]] = {}
    for each in candidates:
        reasons = list(each.reasons(constraints))
        if len(reasons) == 1:
            alone.setdefault(reasons[0], []).append(each)
    found = {name: ranked(those)[0] for name, those in alone.items()}
    for name, looser, changes in _looser(scenario, constraints):
        world = world_of(scenario.replace(changes), looser)
        entered = trials.field_of(world, names, looser)
        others = trials.tested(entered.groups[0])
        if all(each.reasons(looser) for each in others):
            others += trials.tested(
                [each for each in entered.groups[1] if found.keys().isdisjoint(barred(each[1], looser))]
            )
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
