"""Faults: how many robots a share or a count stands for, and conflicts between faults (model.md 6.6)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, Final

from feasibee.errors import Problem
from feasibee.model.codes import exact

KINDS: Final = ("stopped", "byzantine", "stubborn")
"""The faults of which a robot has one at most, in the order in which faulty robots are drawn."""


def whole_robots(faulty: float | Mapping[str, int], robots: int) -> int:
    """Return a count, or a share of the swarm as a number of robots, with halves rounded up (model.md 6.6).

    Examples
    --------
    >>> from feasibee.scenario.faults import whole_robots
    >>> whole_robots(0.1, 5), whole_robots({"count": 1}, 5)
    (1, 1)
    """
    if isinstance(faulty, Mapping):
        return faulty["count"]
    return math.floor(exact(faulty) * robots + Fraction(1, 2))


def fault_conflicts(faults: Mapping[str, Any], robots: int) -> Iterator[Problem]:
    """Yield a problem if more robots are faulty than there are, or no honest robot works."""
    if not any(faults[kind] for kind in KINDS):
        return  # the usual case: exact fractions take half the time of all rules
    numbers = {kind: whole_robots(faults[kind], robots) for kind in KINDS}
    if _fit(numbers, robots):
        return
    total = sum(numbers.values())
    listed = ", ".join(f"{number} {kind}" for kind, number in numbers.items())
    rule = (
        f"must be at most {robots}, since a robot has one fault at most; there are {listed}"
        if total > robots
        else f"must leave an honest robot that works; of {robots} robots there are {listed}"
    )
    yield Problem("faults", f"{total} robots", rule, _remedy(numbers, robots))


def _fit(numbers: Mapping[str, int], robots: int) -> bool:
    return sum(numbers.values()) <= robots and numbers["stopped"] + numbers["byzantine"] < robots


def _remedy(numbers: Mapping[str, int], robots: int) -> str:
    """Return the largest count of the most frequent fault, or of another, that fits the other faults."""
    room = robots - sum(numbers.values())
    for kind in sorted(numbers, key=numbers.__getitem__, reverse=True):
        for count in (numbers[kind] + room, numbers[kind] + room - 1):
            if 0 <= count <= numbers[kind] and _fit({**numbers, kind: count}, robots):
                return f"use faults.{kind} = {{count = {count}}}"
    return "lower two of them, such as to {count = 1}"
