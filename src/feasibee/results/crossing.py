"""Find where a rate reaches a target, by sequential tests of few values.

The values are in order, and the rate is assumed not to fall along them. Each value is tested with as many
trials as it takes, by a confidence sequence, which is valid at any number of them. The tests share the error
rate of the whole answer (Bonferroni), so that it doesn't matter which values are tested.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from feasibee.results.statistics import CONFIDENCE, Interval, confidence_sequence

GROWTH: Final = 1.5
"""Each look at a value comes after so many times the trials of the last look."""

Answer = Literal["enough", "too few", "open"]
"""Whether a rate is shown to reach the target, shown not to, or neither after the most trials."""


class Finding(NamedTuple):
    """A tested value."""

    place: int
    """Its place among the values, from 0."""
    successes: int
    trials: int
    interval: Interval
    """The rate, with an interval that holds for all tests of a search together."""
    answer: Answer


@dataclass(frozen=True)
class Rule:
    """How values are tested.

    Parameters
    ----------
    target : float
        The rate that is asked for, between 0 and 1.
    first, most : int
        Number of trials before the first look at a value, and the largest number.
    confidence : float
        Probability that the whole answer is right, at least.
    resolution : float
        A gap is not searched if it is at most this share of the distance from the first value.
    """

    target: float
    first: int = 100
    most: int = 2000
    confidence: float = CONFIDENCE
    resolution: float = 0.0


@dataclass(frozen=True)
class Crossing:
    """Where a rate reaches the target.

    Parameters
    ----------
    tested : tuple of Finding
        The tested values, in their order.
    enough : int or None
        First place from which on the rate is shown to reach the target; None if it isn't shown of any.
    possible : int
        First place of which the rate isn't shown to be below the target. The first place that reaches it lies
        between this one and ``enough``.
    """

    tested: tuple[Finding, ...]
    enough: int | None
    possible: int

    @property
    def refuted(self) -> Finding | None:
        """Tested place beyond ``enough`` whose rate is shown to be below the target: the rate falls again."""
        last = self.tested[-1]
        falls = self.enough is not None and last.place > self.enough and last.answer == "too few"
        return last if falls else None


def most_tests(places: int) -> int:
    """Return the largest number of values that `find_crossing` tests of so many."""
    return 3 * places.bit_length()


def finding_at(place: int, count: Callable[[int], int], rule: Rule, tests: int) -> Finding:
    """Test one value.

    Parameters
    ----------
    place : int
        Its place.
    count : callable
        Returns the number of successes in the first so many trials.
    rule : Rule
        How to test.
    tests : int
        Largest number of tests that share the error rate.
    """
    confidence = 1 - (1 - rule.confidence) / tests
    trials = min(rule.first, rule.most)
    while True:
        successes = count(trials)
        interval = confidence_sequence(successes, trials, confidence)
        answer = _answer(interval, rule.target)
        if answer != "open" or trials == rule.most:
            return Finding(place, successes, trials, interval, answer)
        trials = min(rule.most, math.ceil(GROWTH * trials))


def _answer(interval: Interval, target: float) -> Answer:
    if interval.low >= target:
        return "enough"
    return "too few" if interval.high < target else "open"


def find_crossing(
    places: int, test: Callable[[int], Finding], resolution: float = 0.0, look_last: bool = False
) -> Crossing:
    """Find the first of the places ``0 ... places - 1`` from which on the rate reaches the target.

    The first place is tested, then places at twice the distance each until one reaches the target. The gap
    between the last that doesn't and the first that does is halved until no place between can change the
    answer. A place that stays open parts the gap in two.

    Parameters
    ----------
    places : int
        Number of values, at least 1.
    test : callable
        Tests the value at a place; see `finding_at`.
    resolution : float
        Gaps of at most this share of their upper place are left.
    look_last : bool
        Whether to test the last place in any case, since the rate may fall again.
    """
    found: dict[int, Finding] = {}
    place: int | None = 0
    while place is not None:
        found[place] = test(place)
        below = max((at for at, each in found.items() if each.answer == "too few"), default=-1)
        enough = min((at for at, each in found.items() if each.answer == "enough"), default=None)
        if enough is None and places - 1 not in found:
            place = min(2 * place + 1, places - 1)
        else:
            low, high = _gap(found, below, enough, places)
            place = (low + high) // 2 if high - low > max(1, resolution * high) else None
    if look_last and places - 1 not in found:
        found[places - 1] = test(places - 1)
    return Crossing(tuple(found[at] for at in sorted(found)), enough, below + 1)


def _gap(found: Collection[int], below: int, enough: int | None, places: int) -> tuple[int, int]:
    """Return the larger gap without tests: above the last below, or below the first that is enough."""
    upper = places if enough is None else enough
    opened = [place for place in found if below < place < upper]
    gaps = [(below, min(opened, default=upper))]
    if enough is not None:
        gaps.append((max(opened, default=below), upper))
    return max(gaps, key=lambda gap: gap[1] - gap[0])
