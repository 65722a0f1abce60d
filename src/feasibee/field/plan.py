"""What a field does: the scenario, the clocks of its robots, and the faults on purpose."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from feasibee.base.codes import LONGEST
from feasibee.base.errors import FeasibeeError

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario

ROBOTS_LIMIT: Final = 65_535
"""Numbers of robots are smaller than this."""
KILL, PAUSE, RESUME, PARTITION = "kill", "pause", "resume", "partition"
PROCESS: Final = (KILL, PAUSE, RESUME)
"""Faults of processes, which the field causes; the world causes the others."""
RANGES_SHOWN: Final = 3
"""Number of ranges of numbers that a text lists."""
_LENGTH: Final = re.compile(r"(\d+(?:\.\d+)?)(ms|s|)", re.ASCII)


class Fault(NamedTuple):
    """One fault."""

    step: int
    """The step at whose beginning it happens."""
    kind: str
    robots_hit: int = 0
    """Number of robots it concerns: those with the highest numbers that no other fault concerns."""
    robots: tuple[int, ...] = ()
    """Numbers of these robots."""
    lasts: float = 0.0
    """For how many steps, if it is a pause or a partition; 0: until the end."""


def parse_length(option: str, text: str, hz: float) -> float:
    """Return a length of time in steps: ``200ms``, ``5s``, or a number of steps.

    Raise a FeasibeeError if the text is no length of time.
    """
    found = _LENGTH.fullmatch(text.strip())
    if found is None:
        raise FeasibeeError(f"{option} {text}: must be a time, such as 200ms, 5s or 20 (steps)")
    number = float(found[1])
    steps = {"": number, "s": number * hz, "ms": number * hz / 1000.0}[found[2]]
    if steps > LONGEST:
        raise FeasibeeError(f"{option} {text}: is more than {LONGEST:,} steps; use less")
    return steps


def parse_fault(kind: str, text: str, hz: float) -> Fault:
    """Return the fault of an option: COUNT@STEP, COUNT@STEP:TIME for a pause, TIME@STEP for a partition.

    Raise a FeasibeeError if the text isn't of this form.
    """
    option = f"--{kind}"
    what, at, when = text.partition("@")
    when, colon, lasting = when.partition(":")
    if not (at and _is_number(when) and (kind == PAUSE or not colon)):
        example = {KILL: "3@50", PAUSE: "1@80 or 1@80:5s", PARTITION: "5s@100"}[kind]
        raise FeasibeeError(f"{option} {text}: must end with a step, such as {option} {example}")
    if kind == PARTITION:
        return Fault(int(when), kind, lasts=parse_length(option, what, hz))
    if not (_is_number(what) and int(what) > 0):
        raise FeasibeeError(f"{option} {text}: must begin with a number of robots, such as {option} 1@50")
    lasts = max(1, round(parse_length(option, lasting, hz))) if colon else 0
    return Fault(int(when), kind, int(what), lasts=lasts)


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 10


def schedule(faults: list[Fault], robots: int, steps: int) -> list[Fault]:
    """Return the faults in their order, with the numbers of their robots; the last robots fail first.

    Raise a FeasibeeError if no robot would be left, or a fault lies beyond the last step.
    """
    left = list(range(robots))
    planned: list[Fault] = []
    for fault in sorted(faults, key=lambda each: each.step):
        step, kind, count, _, lasts = fault
        if not 0 < step <= steps:
            raise FeasibeeError(f"--{kind} at step {step}: must be from 1 to {steps}, the last step")
        if count >= len(left):
            raise FeasibeeError(
                f"--{kind} {count}@{step}: leaves no robot of {len(left)}; use at most {len(left) - 1}"
            )
        first = len(left) - count
        chosen, left = tuple(left[first:]), left[:first]
        planned.append(fault._replace(robots=chosen))
        if kind == PAUSE and 0 < lasts <= steps - step:
            planned.append(Fault(step + int(lasts), RESUME, count, chosen))
    return sorted(planned, key=lambda each: each.step)


def fault_in_words(fault: Mapping[str, Any]) -> str:
    """Return what a fault does, as a clause."""
    single = len(fault["robots"]) == 1
    which = f"robot{'s' * (not single)} {numbers_in_words(fault['robots'])}"
    return {
        KILL: f"{which} {'is' if single else 'are'} killed",
        PAUSE: f"{which} {'is' if single else 'are'} stopped",
        RESUME: f"{which} {'goes' if single else 'go'} on",
        PARTITION: f"the radio is cut in two for {fault['lasts']:g} steps",
    }[fault["kind"]]


def numbers_in_words(numbers: Sequence[int]) -> str:
    """Return ascending numbers of robots as ranges, such as ``3, 17 to 19``; at most the first few ranges."""
    ranges: list[list[int]] = []
    for number in numbers:
        if ranges and number == ranges[-1][-1] + 1:
            ranges[-1].append(number)
        else:
            ranges.append([number])
    shown = [str(each[0]) if len(each) == 1 else f"{each[0]} to {each[-1]}" for each in ranges[:RANGES_SHOWN]]
    left = sum(map(len, ranges[RANGES_SHOWN:]))
    return ", ".join(shown) + (f" and {left} more" if left else "")


class FieldPlan(NamedTuple):
    """What a field does: the scenario, the clock of its robots, and the faults."""

    scenario: Scenario
    seed: int
    run: int
    lockstep: bool
    hz: float
    """Steps per second of a robot's clock; in lockstep only the unit of times in faults."""
    drift: float
    """Largest error of a robot's clock, as a share."""
    jitter: float
    """Largest deviation of a step's duration, as a share."""
    delay: float
    """Delay of messages in addition to the scenario's, in steps."""
    faults: tuple[Fault, ...]
    patience: float
    """Seconds of silence after which a robot is lost."""
    wait: float
    """Seconds that the robots have to join."""

    @property
    def message_delay(self) -> float:
        """Delay of messages, in steps (model.md 6.21.2)."""
        return self.scenario.radio.delay + self.delay


def plan_from(plain: Mapping[str, Any]) -> FieldPlan:
    """Return a plan from its plain form, as `plain_plan` makes it."""
    from feasibee.scenario.scenario import Scenario  # heavy: only in the world's process

    scenario, flooding = Scenario.from_toml(plain["scenario"]), plain["flooding"]
    if flooding is not None:
        scenario = scenario.with_flooding(flooding)
    faults = tuple(Fault(**{**each, "robots": tuple(each["robots"])}) for each in plain["faults"])
    return FieldPlan(
        **{name: plain[name] for name in FieldPlan._fields} | {"scenario": scenario, "faults": faults}
    )


def plain_plan(plan: FieldPlan) -> dict[str, Any]:
    """Return a plan as plain values."""
    faults = [fault._asdict() for fault in plan.faults]
    scenario = {"scenario": plan.scenario.to_toml(), "flooding": plan.scenario.flooding}
    return {**plan._asdict(), **scenario, "faults": faults}
