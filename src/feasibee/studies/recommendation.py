"""Recommendations of strategies: constraints, what each strategy does under them, and both in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any, Final

from feasibee.model.codes import MODEL_VERSION
from feasibee.results.crossing import Finding
from feasibee.results.statistics import Interval
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import step_in_words
from feasibee.studies.comparison import Outcome
from feasibee.studies.needs import IDS, NAMES
from feasibee.studies.shares import percent, wait_for

BEST: Final = ("right most", "soonest", "cheapest")
"""What the first of a ranking by share, by step and by bits is called."""


@dataclass(frozen=True)
class Constraints:
    """What a strategy must do with, and bear.

    Parameters
    ----------
    right : float
        Share of swarms that must be right at the last step, with these tasks and at the opposite truth.
    bits : float, optional
        Most bits per robot-step, on average.
    message_bits : int, optional
        Most bits in a message.
    ids, names : bool
        Whether ids of robots are never mistaken, and whether all robots have the same name for a task.
    liars, stopped : int
        Number of Byzantine robots, and of robots that stop.
    """

    right: float = 0.95
    bits: float | None = None
    message_bits: int | None = None
    ids: bool = True
    names: bool = True
    liars: int = 0
    stopped: int = 0

    @property
    def faults(self) -> str:
        """The faulty robots, in words; empty without any."""
        kinds = (_robots(self.liars, "Byzantine"), _robots(self.stopped, "stopped"))
        return " and ".join(each for each in kinds if each)


def _robots(number: int, kind: str) -> str:
    return "" if number == 0 else f"1 {kind} robot" if number == 1 else f"{number} {kind} robots"


@dataclass(frozen=True)
class Measured:
    """A world in which a strategy was tested.

    Parameters
    ----------
    tasks : int
        Number of tasks.
    test : Finding
        Its test, with an interval that holds for all tests together.
    outcome : Outcome
        Outcome of the same runs.
    """

    tasks: int
    test: Finding
    outcome: Outcome

    @property
    def right(self) -> Interval:
        """Share of swarms that are right at the last step."""
        return self.test.interval


@dataclass(frozen=True)
class Candidate:
    """A strategy under the constraints.

    Parameters
    ----------
    strategy : str
        Its name.
    scenario : Scenario
        The scenario with it.
    worlds : sequence of Measured
        The scenario's world, then that of the opposite truth, if it was tested.
    message_bits : int
        Length of the longest message.
    needs : sequence of str
        What it needs, in words.
    right : float
        Share of swarms that must be right.
    """

    strategy: str
    scenario: Scenario
    worlds: Sequence[Measured]
    message_bits: int
    needs: Sequence[str]
    right: float

    @property
    def worst(self) -> Measured:
        """The world in which it is right least often."""
        return min(self.worlds, key=lambda each: each.right.estimate)

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
        found = {}
        if not constraints.ids and IDS in self.needs:
            found["--no-ids"] = f"needs {IDS}"
        if not constraints.names and NAMES in self.needs:
            found["--no-names"] = f"needs {NAMES}"
        if constraints.message_bits is not None and self.message_bits > constraints.message_bits:
            found["--message-bits"] = f"messages of up to {self.message_bits} bits"
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
            "opposite": [{"tasks": each.tasks, "right": each.right._asdict()} for each in self.worlds[1:]],
            "runs": self.worlds[0].test.trials,
            "step": self.step,
            "bits": self.bits,
            "message_bits": self.message_bits,
            "needs": list(self.needs),
        }


def _short(world: Measured, first: Measured, constraints: Constraints) -> str:
    given = ["" if world is first else f"{world.tasks} tasks", constraints.faults]
    having = " and ".join(each for each in given if each)
    close = ", too close to tell" if world.test.answer == "open" else ""
    right = f"right in {world.test.successes} of {world.test.trials}{close}"
    return f"with {having} {right}" if having else right


@dataclass(frozen=True)
class Relaxation:
    """A constraint without which a strategy would be recommended.

    Parameters
    ----------
    constraint : str
        Name of its option.
    candidate : Candidate
        The best strategy without it.
    """

    constraint: str
    candidate: Candidate

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
    """Which strategies meet some constraints, the best first.

    Parameters
    ----------
    scenario : Scenario
        The swarm and its world, with the faults of the constraints.
    constraints : Constraints
        What strategies must do with, and bear.
    ranking : sequence of Candidate
        Those that meet all.
    excluded : mapping of str to str
        The others by name, each with the reasons.
    relax : sequence of Relaxation
        If none meets all: which constraint to relax, and what that gains.
    """

    scenario: Scenario
    constraints: Constraints
    ranking: Sequence[Candidate]
    excluded: Mapping[str, str]
    relax: Sequence[Relaxation] = field(default=())
    seed: int = 0

    @property
    def best(self) -> dict[str, list[str]]:
        """Return what each strategy is best at: ``"right most"``, ``"soonest"`` or ``"cheapest"``."""
        found: dict[str, list[str]] = {each.strategy: [] for each in self.ranking}
        if self.ranking:
            keys = (lambda each: -each.worst.right.estimate, lambda each: each.step, lambda each: each.bits)
            for name, key in zip(BEST, keys, strict=True):
                found[min(self.ranking, key=key).strategy].append(name)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the recommendation as plain tables, for programs."""
        best = self.best
        return {
            "ranking": [{**each.to_dict(), "best": best[each.strategy]} for each in self.ranking],
            "excluded": [{"strategy": name, "reason": why} for name, why in self.excluded.items()],
            "relax": [each.to_dict() for each in self.relax],
            "constraints": vars(self.constraints),
            "by": self.scenario.run.steps,
            "seed": self.seed,
            "scenario_hash": self.scenario.hash,
            "version": version("feasibee"),
            "model_version": MODEL_VERSION,
        }


def ranked(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates in their order: by right swarms in whole percent, then by step, then by bits."""
    return sorted(
        candidates,
        key=lambda each: (-round(100 * each.worst.right.estimate), _or_last(each.step), each.bits),
    )


def _or_last(step: int | None) -> float:
    return float("inf") if step is None else step


def described(candidate: Candidate) -> str:
    """Return what a candidate does, in words."""
    found = candidate.step
    step = "" if found is None else f", from {step_in_words(candidate.scenario, found)} on"
    defaults, values = candidate.scenario.manifest.parameters, candidate.scenario.decision.parameters
    changed = [f"{name} = {value:g}" for name, value in values.items() if value != defaults[name]]
    needs = f"needs {', '.join(candidate.needs)}" if candidate.needs else "needs nothing more"
    return (
        f"right in {percent(candidate.worst.right)}{step}; {candidate.bits:.3g} bits per robot-step, "
        f"{candidate.message_bits} in the longest message; {needs}"
        + (f"; with {', '.join(changed)}" if changed else "")
    )
