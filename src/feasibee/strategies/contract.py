"""What a strategy is: a few plain functions, the same file in the engine, in the reference and on a robot.

A strategy's file must define ``quality``, ``dissemination`` and ``decide``. It may define ``say`` and
``value``, and the constants ``PARAMETERS``, ``MEMORY``, ``VALUE_BITS``, ``FORGETS`` and ``STARTS_NEUTRAL``:
see `Strategy`. The functions use numbers and ``math`` only, since the engine compiles them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any, Final, NamedTuple

ARGUMENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "quality": ("robots_seen", "tasks_seen"),
    "dissemination": ("quality", "gain"),
    "decide": ("mind", "inbox"),
    "say": ("mind",),
    "value": ("mind",),
}
"""The functions of a strategy's file, and the arguments of each."""
REQUIRED: Final = ("quality", "dissemination", "decide")
CONSTANTS: Final[Mapping[str, str]] = {
    "PARAMETERS": "parameters",
    "MEMORY": "memory",
    "VALUE_BITS": "value_bits",
    "FORGETS": "forgets",
    "STARTS_NEUTRAL": "starts_neutral",
}
"""The constants of a strategy's file, and the fields of `Manifest` that hold them."""


class Mind(NamedTuple):
    """What a robot knows of itself."""

    opinion: int
    """1 feasible, 0 infeasible, -1 none."""
    quality: float
    """Of the opinion that it holds, by its last exploration; 1/2 without an opinion (model.md 4.3)."""
    feasible_quality: float
    """Of *feasible*: rho_1."""
    own_vote: int
    """What its own opinion weighs in a majority: 1 or 0."""
    memory: Any
    """As many floats as ``MEMORY`` says, 0.0 at the start, the strategy's to read and write."""
    parameters: Any
    """The values of ``PARAMETERS``, floats in their order."""


class Inbox(NamedTuple):
    """What a robot heard since its last decision."""

    feasible_votes: int
    """Messages that say *feasible*; the robot's own opinion isn't among them."""
    infeasible_votes: int
    """Messages that say *infeasible*."""
    heard_opinion: int
    """What one of them says, drawn at random; -1 if there is none."""
    heard_value: float
    """The value in that message, 0 to 1; 0.0 if there is none."""
    mean_value: float
    """Of all messages; 0.0 if there is none."""
    chance: float
    """A random number, 0 <= chance < 1, for what the strategy leaves to chance."""


def say(mind: Mind) -> int:
    """Return the opinion to tell: the robot's own."""
    return mind.opinion


def value(mind: Mind) -> float:
    """Return the number to tell, if messages have one: the quality of *feasible*."""
    return mind.feasible_quality


@dataclass(frozen=True, eq=False, kw_only=True)
class Manifest:
    """What the file of a strategy declares: all that can be known without running it.

    Parameters
    ----------
    name : str
        What a scenario calls the strategy.
    parameters : mapping of str to float
        ``PARAMETERS``, with their defaults; a scenario changes them in ``[decision.parameters]``.
    memory : int
        ``MEMORY``: how many floats a robot keeps.
    value_bits : int
        ``VALUE_BITS``: at how many bits the value is sent; 0: messages have none.
    forgets : bool
        ``FORGETS``: whether each exploration counts afresh.
    starts_neutral : bool
        ``STARTS_NEUTRAL``: whether robots start without an opinion.
    knowledge : type, optional
        ``Knowledge``: what robots pass on in addition to opinions (built-in strategies only).
    source : str
        The text of a user's file; it is part of a scenario's hash. Built-in strategies have none here.
    trusted : bool
        Whether the text may be run. Text that came with results may not, unless the user says so.
    """

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    memory: int = 0
    value_bits: int = 0
    forgets: bool = True
    starts_neutral: bool = False
    knowledge: Any = None
    source: str = ""
    trusted: bool = True

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Manifest) and (self.name, self.source) == (other.name, other.source)

    def __hash__(self) -> int:
        return hash((self.name, self.source))


@dataclass(frozen=True, eq=False, kw_only=True)
class Strategy(Manifest):
    """How opinions are rated, told and chosen: a manifest with its functions.

    Parameters
    ----------
    quality : callable
        ``quality(robots_seen, tasks_seen)``: the quality of *feasible*, 0 to 1.
    dissemination : callable
        ``dissemination(quality, gain)``: for how long to broadcast an opinion of this quality, on average,
        in steps.
    decide : callable
        ``decide(mind, inbox)``: the next opinion, 1 or 0, or -1 for none.
    say : callable, optional
        ``say(mind)``: what to tell for the whole dissemination, 1 or 0, or -1 to be silent.
    value : callable, optional
        ``value(mind)``: a number from 0 to 1 to tell with it, near 1 if it speaks for *feasible*.
    """

    quality: Callable[[int, int], float]
    dissemination: Callable[[float, float], float]
    decide: Callable[[Mind, Inbox], int]
    say: Callable[[Mind], int] = say
    value: Callable[[Mind], float] = value


def strategy_of_module(name: str, module: ModuleType) -> Strategy:
    """Return the strategy that an imported module of this package defines."""
    functions = {each: getattr(module, each) for each in ARGUMENTS if hasattr(module, each)}
    constants = {field: getattr(module, each) for each, field in CONSTANTS.items() if hasattr(module, each)}
    return Strategy(name=name, knowledge=getattr(module, "Knowledge", None), **functions, **constants)


def sent(value: float, bits: int) -> int:
    """Return a value from 0 to 1 as the whole number of ``bits`` bits that a message holds."""
    return int(min(max(value, 0.0), 1.0) * (2**bits - 1) + 0.5)
