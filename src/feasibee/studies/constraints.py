"""Strategies under the constraints of a deployment: which are shown to meet them, and why others are not."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

from feasibee.base.errors import FeasibeeError, ScenarioError
from feasibee.results.measures import columns
from feasibee.results.statistics import OF_THE_RUNS, in_percent
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import step_in_words
from feasibee.simulation.schedule import run_work
from feasibee.simulation.sequential import EARLY, Finding, SequentialDesign
from feasibee.simulation.sweep import Execution, Rounds
from feasibee.studies.comparison import (
    Comparison,
    Outcome,
    check_distinct,
    check_stays,
    contenders_of,
    design_points,
    in_bits,
    latest,
    origin,
    outcomes_of,
    percent,
    rounds_of,
    wait_for,
)
from feasibee.studies.comparison import compare as compare_all
from feasibee.studies.needs import COUNT, IDS, NAMES, Asked, all_strategies, possible, strategy_change

if TYPE_CHECKING:
    import pandas as pd

BEST: Final = ("right most", "soonest", "cheapest")
"""What the first of a ranking by share, by step and by bits is called."""
TOLERATES: Final = "tolerates"
"""The parameter that says how many Byzantine robots a strategy bears."""
PHASE: Final = "testing strategies"


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


def numbered(number: int, name: str) -> str:
    """Return a number with a name, such as ``3 robots``."""
    return f"{number} {name}" if number == 1 else f"{number} {name}s"


@dataclass(frozen=True)
class Candidate:
    """A strategy under the constraints."""

    asked: Asked
    """What it asks of the robots, in the scenario with it."""
    worlds: Sequence[Outcome]
    """Tests in the scenario's world, then in that of the opposite truth, or in those asked for."""
    right: float
    """Share of swarms that must be right."""

    @property
    def scenario(self) -> Scenario:
        """The scenario with it."""
        return self.asked.scenario

    @property
    def strategy(self) -> str:
        """Its name."""
        return self.scenario.decision.strategy

    @property
    def tests(self) -> list[Finding]:
        """What the tests found, world by world."""
        return [each.test for each in self.worlds if each.test is not None]

    @property
    def worst(self) -> Outcome:
        """The world in which it is right least often."""
        return min(self.worlds, key=lambda each: each.judged.estimate)

    @property
    def is_probable(self) -> bool:
        """Whether it probably reaches the target in all worlds, although it isn't shown."""
        unshown = [each for each in self.tests if each.answer != "enough"]
        return bool(unshown) and all(each.is_close(self.right) for each in unshown)

    @property
    def more_runs(self) -> str:
        """About how many more runs its open tests need, in words."""
        more = [each.more_trials(self.right) for each in self.tests if each.answer == "open"]
        known = [number for number in more if number is not None]
        return f"about {max(known):,}" if len(known) == len(more) else "many"

    @property
    def bits(self) -> float:
        """Mean number of bits per robot-step in the scenario's world."""
        return float(self.worlds[0].bits.mean())

    @property
    def step(self) -> int | None:
        """First step from which enough swarms are right until the end, in all worlds; None without one."""
        return latest(wait_for(each, self.right) for each in self.worlds)

    @property
    def needs(self) -> str:
        """What it needs, in words, and the parameters that it was given."""
        defaults, values = self.scenario.manifest.parameters, self.scenario.decision.parameters
        given = [f"{name} = {value:g}" for name, value in values.items() if value != defaults[name]]
        needs = f"needs {', '.join(self.asked.needs)}" if self.asked.needs else "needs nothing more"
        return "; ".join([needs, *(["with " + ", ".join(given)] if given else [])])

    def reasons(self, constraints: Constraints) -> dict[str, str]:
        """Return which constraints it does not meet, by the option's name, each with the reason in words."""
        found = barred(self.asked, constraints)
        if constraints.bits is not None and self.bits > constraints.bits:
            found["--bits"] = f"{in_bits(self.bits)} bits per robot-step"
        tested = [(test, each.tasks) for each, test in zip(self.worlds, self.tests, strict=True)]
        # one world is enough: where a strategy fails, its tests in the others end
        if short := [each for each in tested if each[0].answer != "enough"]:
            test, tasks = min(short, key=lambda each: (each[0].answer == "open", each[0].interval))
            having = "" if tasks == self.worlds[0].tasks else f"with {tasks} tasks "
            close = ", too close to tell" if test.answer == "open" else ""
            found["--right"] = f"{having}right in {test.successes} of {test.trials}{close}"
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the candidate as plain tables, for programs."""
        return {
            "strategy": self.strategy,
            "parameters": dict(self.scenario.decision.parameters),
            "right": self.worlds[0].judged._asdict(),
            "opposite": [{"tasks": each.tasks, "right": each.judged._asdict()} for each in self.worlds[1:]],
            "runs": self.worlds[0].runs,
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


@dataclass(frozen=True)
class Constrained:
    """Which strategies meet some constraints, the best first."""

    scenario: Scenario
    """The swarm and its world, with the faults of the constraints."""
    constraints: Constraints
    """What strategies must do with, and bear."""
    ranking: Sequence[Candidate]
    """Those that meet all."""
    excluded: Mapping[str, str]
    """The others by name, each with the reasons."""
    tested: Sequence[Candidate] = field(default=())
    """All strategies that were simulated."""
    seed: int = 0
    stopped: str = ""
    """Why the tests ended early, if they did."""
    missing = ""
    """Which runs are missing: the answer says it."""

    @property
    def best(self) -> dict[str, list[str]]:
        """Return what each strategy is best at: ``"right most"``, ``"soonest"`` or ``"cheapest"``."""
        found: dict[str, list[str]] = {each.strategy: [] for each in self.ranking}
        if self.ranking:
            keys = (lambda each: -each.worst.judged.estimate, lambda each: each.step, lambda each: each.bits)
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
        right = percent(best.worst.judged)
        return [f"{best.strategy} probably is: {right}; {best.more_runs} more runs would settle it."]

    @property
    def relax(self) -> dict[str, Candidate]:
        """If none meets all constraints: the best strategy without a single one of them, by its option."""
        found: dict[str, Candidate] = {}
        for each in ranked([] if self.ranking else self.tested):
            reasons = list(each.reasons(self.constraints))
            if len(reasons) == 1:
                found.setdefault(reasons[0], each)
        return found

    @property
    def rows(self) -> list[dict[str, object]]:
        """A row for each strategy, those that meet all constraints first, each with its reasons in words."""
        needs = {each.strategy: each.needs for each in self.ranking}
        tested = {each.strategy: each for each in (*self.ranking, *ranked(self.tested))}
        reasons = needs | dict(self.excluded)
        return [_row(name, tested.get(name), name in needs, reasons[name]) for name in tested | reasons]

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as plain tables, for programs."""
        best = self.best
        return {
            "ranking": [{**each.to_dict(), "best": best[each.strategy]} for each in self.ranking],
            "excluded": [{"strategy": name, "reason": why} for name, why in self.excluded.items()],
            "relax": [{"constraint": name, **each.to_dict()} for name, each in self.relax.items()],
            "probably": self.probably,
            "stopped": self.stopped,
            "constraints": vars(self.constraints),
            "by": self.scenario.run.steps,
            **origin(self.seed, self.scenario),
        }


def _row(name: str, found: Candidate | None, meets: bool, reasons: str) -> dict[str, object]:
    """Return the columns of a strategy, with shares of its worst world; None for what wasn't simulated."""
    worst = None if found is None else found.worst
    return {
        "strategy": name,
        **columns("right", None if worst is None else worst.judged),
        "runs": worst and worst.runs,
        "tasks": worst and worst.tasks,
        "step": found and found.step,
        "bits_per_robot_and_step": found and found.bits,
        "message_bits": found and found.asked.message_bits,
        "meets_all": meets,
        "reasons": reasons,
    }


def answer(found: Constrained) -> list[str]:
    """Return which strategy to use, or else what comes closest, in words."""
    early = [f"The tests ended early ({found.stopped}); more time would complete them."] * bool(found.stopped)
    if not found.ranking:
        return [f"No strategy is shown to meet all constraints. {' '.join(_ways(found))}".rstrip(), *early]
    first = found.ranking[0]
    tasks = " and with ".join(str(each.tasks) for each in first.worlds)
    step = "" if first.step is None else f", from {step_in_words(found.scenario, first.step)} on"
    others = [
        f"{name} is the {what}"
        for what in BEST[1:]
        for name, best in found.best.items()
        if what in best and name != first.strategy
    ]
    right = in_percent(first.worst.judged, OF_THE_RUNS)
    return [
        f"Use {first.strategy}: right in {right}, with {tasks} tasks{step}.",
        *([f"Of those that meet all constraints, {' and '.join(others)}."] if others else []),
        *early,
    ]


def _ways(found: Constrained) -> Iterator[str]:
    """Yield what comes closest to meeting all constraints: more runs, or one constraint less."""
    yield from found.probably
    for name, each in found.relax.items():
        right = f"in {in_percent(each.worst.judged, OF_THE_RUNS)}"
        if name == "--right" and not found.probably:
            yield f"Of those that meet the others, {each.strategy} is best: right {right}."
        elif name != "--right":
            yield f"Without {name}, {each.strategy} does: right {right}."
    yield from uncounted(found)


def uncounted(found: Constrained) -> Iterator[str]:
    """Yield in words which strategies were not tried because they need the number of robots, if any."""
    if those := [name for name, why in found.excluded.items() if why == f"needs {COUNT}"]:
        names, verb = " and ".join(those), "needs" if len(those) == 1 else "need"
        yield f"{names} {verb} {COUNT}: try --set robots.know_count=true."


def ranked(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates in their order: by right swarms in whole percent, then by step, then by bits."""
    return sorted(
        candidates,
        key=lambda each: (
            -round(100 * each.worst.judged.estimate),
            math.inf if each.step is None else each.step,
            each.bits,
        ),
    )


def compare_under(
    scenario: Scenario,
    constraints: Constraints | None = None,
    strategies: Sequence[str] = (),
    runs: int = 1000,
    seed: int = 0,
    execution: Execution | Rounds | None = None,
    *,
    tasks: Sequence[int] = (),
    relax: bool = True,
    early: tuple[int, ...] = EARLY,
) -> Constrained:
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
        Names or files; by default those that ``feasibee show strategies`` lists.
    runs, seed : int
        Largest number of runs of each strategy in each world, and their seed.
    execution : Execution or Rounds, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    tasks : sequence of int
        Numbers of tasks with which strategies must be right; by default the scenario's and the opposite one.
    relax : bool
        Whether to run strategies that one constraint excludes, if none meets all.
    early : tuple of int
        Numbers of runs of looks before the first one after 100.

    Raises
    ------
    FeasibeeError
        If the constraints contradict each other or the scenario.
    """
    check_stays(scenario, "compare with constraints")
    check_distinct(names := list(strategies or all_strategies(scenario)))
    world = world_of(scenario, constraints := constraints or Constraints())  # raises before the work
    with rounds_of(execution, PHASE) as rounds:
        tests, own = max(2, len(tasks)) * len(names), rounds is not execution
        design = SequentialDesign(runs, tests=tests, early=early)
        if own:
            rounds.phases = {PHASE: tests * runs * run_work(world)}
        return _Trials(rounds, world, constraints, design, seed, tasks, own).compared(names, relax)


@dataclass(frozen=True)
class _Trials:
    """The tests of strategies in a world, all of them on the same runs."""

    rounds: Rounds
    world: Scenario
    constraints: Constraints
    design: SequentialDesign
    seed: int
    tasks: Sequence[int]
    tells: bool
    """Whether the answer so far is that of these tests, and not of a study around them."""

    def compared(self, names: Sequence[str], relax: bool) -> Constrained:
        """Test strategies; say why others are excluded, without runs if one that was tested meets all."""
        entered, problems = self._entered(names)
        reasons = {name: barred(asked, self.constraints) for name, asked in entered.items()}
        tested = self._tested({name: each for name, each in entered.items() if not reasons[name]})
        if relax and all(each.reasons(self.constraints) for each in tested):
            tested += self._tested({name: each for name, each in entered.items() if len(reasons[name]) == 1})
        if self.rounds.stopped:
            late = {"": f"not tested ({self.rounds.stopped})"}
            reasons = {name: why or late for name, why in reasons.items()}
        reasons |= {each.strategy: each.reasons(self.constraints) for each in tested}
        excluded = {name: "; ".join(why.values()) for name, why in reasons.items() if why}
        return Constrained(
            scenario=self.world,
            constraints=self.constraints,
            ranking=ranked([each for each in tested if not reasons[each.strategy]]),
            excluded={**excluded, **problems},
            tested=tested,
            seed=self.seed,
            stopped=self.rounds.stopped,
        )

    def _entered(self, names: Sequence[str]) -> tuple[dict[str, Asked], dict[str, str]]:
        """Return what each strategy asks that the world supports, and why it doesn't support the others."""
        found: dict[str, Asked] = {}
        problems: dict[str, str] = {}
        for name in names:
            try:
                scenario = self.world.replace(strategy_for(self.world, name, self.constraints.liars))
            except ScenarioError as error:
                if any(problem.path == "decision.strategy" for problem in error.problems):
                    raise  # there is no such strategy
                problems[name] = error.problems[0].rule.removeprefix(f"{name} ")
                continue
            found[scenario.decision.strategy] = Asked(scenario, self.seed)
        return found, problems

    def _tested(self, asked: Mapping[str, Asked]) -> list[Candidate]:
        """Test strategies in all their worlds at once; one that fails in a world ends in the others, too.

        Each test is a confidence sequence, valid wherever it ends, and all that may be made share the error
        rate. So it doesn't matter that the answer in one world ends the tests in others.
        """
        worlds = {
            (name, place): world
            for name, each in asked.items()
            for place, world in enumerate(worlds_of(each.scenario, self.tasks))
        }
        found: dict[str, dict[int, Outcome]] = {name: {} for name in asked}

        def see(left: Mapping[tuple[str, int], Scenario], runs: int) -> dict[tuple[str, int], Outcome]:
            self.rounds.place = f"{len({name for name, _ in left})} of {len(asked)}"
            seen = dict(zip(left, self._seen(left, runs), strict=True))
            for (name, place), each in seen.items():
                found[name][place] = each
            self._tell(found)
            return seen

        def is_settled(seen: Outcome) -> bool:
            """Whether a test needs no more runs, perhaps since its strategy fails in another world."""
            tests = [each.test for each in found[seen.contender].values() if each.test is not None]
            return self._is_settled(seen.test) or any(map(self._fails, tests))

        self.design.run(worlds, see, is_settled)
        right = self.constraints.right
        return [Candidate(asked[name], [*seen.values()], right) for name, seen in found.items() if seen]

    def _is_settled(self, test: Finding | None) -> bool:
        return test is not None and self.design.is_settled(self.constraints.right, test)

    def _fails(self, test: Finding) -> bool:
        """Whether a test needs no more runs, and neither reaches the target nor comes close."""
        close = test.is_close(self.constraints.right)
        return self._is_settled(test) and test.answer != "enough" and not close

    def _seen(self, left: Mapping[tuple[str, int], Scenario], runs: int) -> list[Outcome]:
        """Return the outcomes of some strategies, each in a world, with their tests."""
        designs = [
            design
            for (name, _), world in left.items()
            for design in design_points({name: world}, (), runs, self.seed)
        ]
        seen = outcomes_of(self.rounds, designs, runs, self.seed)
        tests = [self.design.tested(self.constraints.right, int(each.right.sum()), runs) for each in seen]
        return [replace(each, test=test) for each, test in zip(seen, tests, strict=True)]

    def _tell(self, found: Mapping[str, Mapping[int, Outcome]]) -> None:
        """Report the strategy that is right most often so far in the worst of its worlds."""
        if self.tells:
            share = operator.attrgetter("judged.estimate")
            best = max((min(seen.values(), key=share) for seen in found.values()), key=share)
            where = f"{percent(best.judged)} with {best.tasks} tasks"
            self.rounds.tell(f"right most often so far: {best.contender}, {where}, by {best.runs:,} runs")


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


def worlds_of(scenario: Scenario, tasks: Sequence[int] = ()) -> list[Scenario]:
    """Return the scenario with each number of tasks; without any, itself and its opposite."""
    if tasks:
        return [scenario.replace({"tasks.count": number}) for number in tasks]
    turned = opposite_of(scenario)
    return [scenario] if turned is None else [scenario, turned]


def opposite_of(scenario: Scenario) -> Scenario | None:
    """Return the scenario at the reciprocal ratio of robots to tasks, where the truth is the opposite.

    None if robots or tasks have classes, tasks have given places, the world changes, or it isn't valid.
    """
    robots, tasks = scenario.robots.count, scenario.tasks.count
    others = robots + 1 if tasks == robots else max(1, round(robots * robots / max(1, tasks)))
    if scenario.dynamic or scenario.robots.classes or scenario.tasks.classes or scenario.tasks.points:
        return None
    turned = possible(scenario, {"tasks.count": others})  # a census has room for so many tasks
    return turned if turned is not None and truth(turned) != truth(scenario) else None


def compare(
    scenario: Scenario,
    strategies: Sequence[str] = (),
    tasks: Sequence[int] = (),
    runs: int | None = None,
    seed: int = 0,
    **constraints: Any,
) -> pd.DataFrame:
    """Compare strategies on the same worlds: run r starts from the same places for all of them.

    Parameters
    ----------
    scenario : Scenario
        What all strategies have in common.
    strategies : sequence of str
        Names or files; by default all built-in strategies that the scenario supports.
    tasks : sequence of int
        Numbers of tasks; by default that of the scenario; with constraints, also the opposite one.
    runs, seed : int
        Number of runs of each strategy with each number of tasks, by default 200, and their seed. With
        constraints, the largest number of runs, by default 1,000.
    **constraints
        Fields of ``feasibee.studies.constraints.Constraints``, such as ``right=0.95`` or ``liars=1``.

    Returns
    -------
    pandas.DataFrame
        The rows of ``compare.csv``, which ``feasibee compare`` writes: for each strategy and number of tasks,
        ``accuracy`` is the share of runs that are right at the last step. With constraints, a row for each
        strategy says whether it ``meets_all``, and why.

    Examples
    --------
    >>> import feasibee
    >>> table = feasibee.compare(feasibee.Scenario(), ["dmmd", "census"], tasks=[10, 40], runs=20, seed=1)
    >>> table.groupby("contender").accuracy.mean().round(2).to_dict()
    {'census': 1.0, 'dmmd': 0.78}
    """
    import pandas as pd

    if constraints:
        wanted = Constraints(**constraints)
        return pd.DataFrame(compare_under(scenario, wanted, strategies, runs or 1000, seed, tasks=tasks).rows)
    contenders, number = contenders_of(scenario, strategies), 200 if runs is None else runs
    outcomes = compare_all(contenders, tasks, number, seed)
    return pd.DataFrame(Comparison(outcomes, number, seed).rows)
