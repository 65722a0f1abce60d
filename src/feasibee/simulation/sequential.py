"""The sequential design of all studies: points get more runs at each look, until they have an answer.

A rate is tested by a confidence sequence, which is valid at any number of runs. The tests of an answer share
its error rate (Bonferroni), so that it doesn't matter which of them are made, or when one of them ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, TypeVar

from feasibee.results.statistics import CONFIDENCE, Interval, confidence_sequence
from feasibee.simulation.sweep import Enough

FIRST: Final = 100
"""Number of runs before the first look at a point."""
GROWTH: Final = 1.5
"""Each look at a point comes after so many times the runs of the last look."""
EARLY: Final = (20, 45)
"""Numbers of runs of two looks before the first one, at which a rate far below a target has its answer."""
HOPELESS: Final = 2
"""After a quarter of its trials, a test ends open if it seems to need so many times those that are left."""
MOST_TRIALS: Final = 100_000
"""More trials than these are not suggested for an open test."""

Answer = Literal["enough", "too few", "open"]
"""Whether a rate is shown to reach the target, shown not to, or neither after the most trials."""
Name = TypeVar("Name")
Point = TypeVar("Point")
Seen = TypeVar("Seen")
IN_WORDS: Final = {"enough": "often enough", "too few": "too rarely", "open": "too close to tell"}


class Finding(NamedTuple):
    """A tested value."""

    place: int
    """Its place among the values, from 0."""
    successes: int
    trials: int
    interval: Interval
    """The rate, with an interval that holds for all tests of an answer together."""
    answer: Answer

    def is_close(self, target: float) -> bool:
        """Whether the rate isn't shown to reach a target, but is as large."""
        return self.answer == "open" and self.interval.estimate >= target

    def more_trials(self, target: float) -> int | None:
        """Return about how many more trials an open test needs if the rate stays; None if too many.

        An interval shrinks with the root of their number. It must end where the target is.
        """
        rate, low, high = self.interval
        away = abs(rate - target)
        half = rate - low if rate >= target else high - rate
        if away * math.sqrt(MOST_TRIALS / self.trials) <= half:
            return None
        more = self.trials * (half / away) ** 2 - self.trials
        return 100 * max(1, math.ceil(more / 100))


def looks(first: int, most: int, growth: float = GROWTH) -> list[int]:
    """Return the numbers of runs after which points are looked at, from the first to the most."""
    numbers = [min(first, most)]
    while numbers[-1] < most:
        numbers.append(min(most, math.ceil(growth * numbers[-1])))
    return numbers


@dataclass(frozen=True)
class SequentialDesign:
    """At which numbers of runs points are looked at, and how sure each answer must be."""

    most: int
    """Largest number of runs of a point."""
    first: int = FIRST
    """Number of runs before the first look."""
    growth: float = GROWTH
    """Factor between the runs of one look and those of the next."""
    tests: int = 1
    """Number of tests that share the error rate; of intervals that aren't sequences, times that of looks."""
    confidence: float = CONFIDENCE
    """Probability that all of them are right, at least."""
    early: tuple[int, ...] = ()
    """Numbers of runs of looks before the first one."""

    @property
    def looks(self) -> list[int]:
        """Numbers of runs after which points are looked at, from the first to the most."""
        later = looks(self.first, self.most, self.growth)
        return [*(runs for runs in self.early if runs < later[0]), *later]

    @property
    def level(self) -> float:
        """Confidence of each test."""
        return 1 - (1 - self.confidence) / self.tests

    def run(
        self,
        points: Mapping[Name, Point],
        see: Callable[[Mapping[Name, Point], int], Mapping[Name, Seen]],
        is_settled: Callable[[Seen], bool] = lambda seen: False,
    ) -> dict[Name, Seen]:
        """Look at points until each needs no more runs, or has the most.

        Parameters
        ----------
        points : mapping
            Points by name.
        see : callable
            Returns what is seen of some points after so many runs of each.
        is_settled : callable
            Whether a point needs no more runs, by what is seen of it.

        Returns
        -------
        dict
            What was seen last of each point. If the study ends early, points without a look are missing.
        """
        found: dict[Name, Seen] = {}
        left = dict(points)
        with suppress(Enough):
            for runs in self.looks:
                found |= see(left, runs) if left else {}
                left = {name: point for name, point in left.items() if not is_settled(found[name])}
        return found

    def tested(self, target: float, successes: int, trials: int, place: int = 0) -> Finding:
        """Return whether a rate reaches a target, by a confidence sequence."""
        interval = confidence_sequence(successes, trials, self.level)
        answer: Answer = "too few" if interval.high < target else "open"
        return Finding(place, successes, trials, interval, "enough" if interval.low >= target else answer)

    def is_settled(self, target: float, finding: Finding) -> bool:
        """Whether a test has an answer, or its rate is so close to the target that it would hardly get one.

        The trials that are left then go where they decide. A confidence sequence is valid wherever it ends.
        """
        if finding.answer != "open" or finding.trials < max(self.first, self.most / 4):
            return finding.answer != "open"
        more = finding.more_trials(target)
        return more is None or more > HOPELESS * (self.most - finding.trials)
