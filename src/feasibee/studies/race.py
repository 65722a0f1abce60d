"""Race changed swarms against the swarm without the change, all of them on the same worlds.

A change has as many runs as its difference takes: until it is clear, or surely small. All differences of a
report share one error rate (Bonferroni over changes and looks), so that none of them is shown by luck.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from feasibee.results.statistics import CONFIDENCE, Interval
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import Outcome, design_points, difference, outcomes_of
from feasibee.studies.size import looks
from feasibee.sweeps.sweep import Enough, Rounds

AS_IT_IS: Final = "as it is"
FIRST: Final = 100
"""Number of runs before the first look at a difference."""
MARGIN: Final = 0.05
"""A difference that is shown to be at most this share, either way, is called none."""


def is_none(shown: Interval) -> bool:
    """Whether a difference is shown to be small enough to be called none."""
    return shown.low >= -MARGIN and shown.high <= MARGIN


def is_clear(shown: Interval) -> bool:
    """Whether a difference is shown to have its sign."""
    return shown.low > 0 or shown.high < 0


@dataclass(frozen=True)
class Race:
    """How changes are raced."""

    rounds: Rounds
    runs: int
    """Largest number of runs of a change."""
    seed: int
    tests: int
    """Largest number of differences in the report, times that of looks at one: they hold together."""

    @property
    def confidence(self) -> float:
        """Confidence of each difference at each look."""
        return 1 - (1 - CONFIDENCE) / self.tests

    def outcomes(self, kinds: Mapping[str, Scenario], runs: int) -> dict[str, Outcome]:
        """Return the outcomes of some scenarios, by name, with so many runs each; as `outcomes_of`."""
        designs = design_points(kinds, (), runs, self.seed)
        found = outcomes_of(self.rounds, designs, runs, self.seed)
        return {each.contender: each for each in found}

    def against(
        self, scenario: Scenario, changed: Mapping[str, Scenario]
    ) -> dict[str, tuple[Outcome, Interval]]:
        """Return the outcome of each changed scenario, and its difference from the unchanged one.

        If the study ends early, they are those of the last look, if any.
        """
        found: dict[str, tuple[Outcome, Interval]] = {}
        left = dict(changed)
        with suppress(Enough):
            for runs in looks(FIRST, self.runs):
                outcomes = self.outcomes({AS_IT_IS: scenario, **left}, runs) if left else {}
                for name in tuple(left):
                    shown = difference(outcomes[name], outcomes[AS_IT_IS], self.confidence)
                    found[name] = outcomes[name], shown
                    if is_clear(shown) or is_none(shown):
                        del left[name]
        return found
