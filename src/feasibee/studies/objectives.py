"""What a search improves: a measure of each run, and a bound on false alarms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.model.record import Record
from feasibee.results.measures import MEASURES, PER, Measure, false_alarms_of, steps_of
from feasibee.results.statistics import (
    Interval,
    mean_difference,
    mean_of,
    mean_share,
    paired_difference,
    wilson,
)
from feasibee.scenario.scenario import Scenario
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Rounds

Values = NDArray[np.float64]
RIGHT_AT_END: Final = "right_at_end"
TUNED: Final = tuple(each.name for each in MEASURES.values() if each.values is not None)
"""Names of the measures that a search may improve."""


@dataclass(frozen=True)
class Objective:
    """What a search improves.

    Parameters
    ----------
    measure : str
        One of `TUNED`.
    false_alarms : float, optional
        Parameters with more false alarms per 1,000 steps aren't chosen.
    """

    measure: str = RIGHT_AT_END
    false_alarms: float | None = None

    @property
    def of(self) -> Measure:
        """The measure."""
        return MEASURES[self.measure]

    @property
    def sign(self) -> int:
        """1 if more is better, otherwise -1."""
        return -1 if self.of.less else 1

    def score(self, runs: Scored) -> float:
        """Return the mean of the measure, negative if less is better; -inf where it must not be chosen."""
        known = _known(runs.values)
        if not known.size or (self.false_alarms is not None and runs.false_alarms > self.false_alarms):
            return -math.inf
        return self.sign * float(known.mean())

    def interval(self, values: Values) -> Interval:
        """Return the mean over runs with its interval."""
        if self.of.holds is not None:
            return wilson(int(values.sum()), values.size)
        return mean_of(_known(values)) if self.of.less else mean_share(values)

    def gain(self, one: Values, other: Values) -> Interval:
        """Return by how much the first runs are better than the second: the same runs otherwise."""
        if self.of.holds is not None:
            return paired_difference(one, other)
        return mean_of(_known(other - one)) if self.of.less else mean_difference(one, other)


class Scored(NamedTuple):
    """Runs of one design point, as an objective sees them."""

    values: Values
    """The measure of each run."""
    false_alarms: float
    """False alarms per 1,000 steps; 0 in a world that doesn't change."""


def objective_for(
    scenario: Scenario, measure: str | None = None, false_alarms: float | None = None
) -> Objective:
    """Return the objective for a scenario; by default, its swarms are to be right as often as possible.

    Raises
    ------
    FeasibeeError
        If the measure, or a bound on false alarms, needs a world that changes.
    """
    chosen = measure or ("right_share" if scenario.dynamic else RIGHT_AT_END)
    if chosen not in TUNED:
        raise FeasibeeError(f"measure = {chosen}: is no measure; choose from {', '.join(TUNED)}")
    if not scenario.dynamic and (chosen != RIGHT_AT_END or false_alarms is not None):
        what = "false alarms" if chosen == RIGHT_AT_END else chosen
        raise FeasibeeError(f"{what}: needs a world that changes; add [[events]] or rates, or leave it out")
    return Objective(chosen, false_alarms)


def scored(
    rounds: Rounds, designs: Sequence[DesignPoint], runs: int, seed: int, objective: Objective
) -> list[Scored]:
    """Run one round; return the measure of each run of each point."""
    records, values = rounds.run(Study(designs, runs, seed)), objective.of.values
    assert values is not None  # as of all that `objective_for` returns
    return [
        Scored(values(record, design.scenario), _alarms(record, design.scenario))
        for design, record in zip(designs, records, strict=True)
    ]


def _alarms(record: Record, scenario: Scenario) -> float:
    if not scenario.dynamic:
        return 0.0
    alarms, steps = false_alarms_of(record.truth, record.held), steps_of(record.truth)
    return PER * float(alarms.sum()) / max(1, int(steps.sum()))


def _known(values: Values) -> Values:
    return values[np.isfinite(values)]
