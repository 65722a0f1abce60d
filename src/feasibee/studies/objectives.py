"""What a search improves: a measure of each run, and a bound on false alarms."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.model.record import Record
from feasibee.results.judging import ended_right
from feasibee.results.replicates import mean_difference, mean_of, mean_share
from feasibee.results.statistics import Interval, paired_difference, wilson
from feasibee.results.tracking import PER, changes_of, false_alarms_of, right_shares, steps_of
from feasibee.scenario.scenario import Scenario
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Rounds

Values = NDArray[np.float64]

RIGHT_AT_END, RIGHT_SHARE, DELAY = "right_at_end", "right_share", "detection_delay"


class Measure(NamedTuple):
    """A number of each run."""

    values: Callable[[Record, Scenario], Values]
    """Returns it: shape (runs,); NaN for a run without it."""
    interval: Callable[[Values], Interval]
    """Returns the mean over runs with its interval."""
    gain: Callable[[Values, Values], Interval]
    """Returns by how much the first runs are better than the second: the same runs with other parameters."""
    sign: int
    """1 if more is better, otherwise -1."""
    label: str
    """What it is, with its unit, for an axis."""


@dataclass(frozen=True)
class Objective:
    """What a search improves.

    Parameters
    ----------
    measure : str
        A key of `MEASURES`.
    false_alarms : float, optional
        Parameters with more false alarms per 1,000 steps aren't chosen.
    """

    measure: str = RIGHT_AT_END
    false_alarms: float | None = None

    @property
    def of(self) -> Measure:
        """The measure."""
        return MEASURES[self.measure]

    def score(self, runs: Scored) -> float:
        """Return the mean of the measure, negative if less is better; -inf where it must not be chosen."""
        known = runs.values[np.isfinite(runs.values)]
        if not known.size or (self.false_alarms is not None and runs.false_alarms > self.false_alarms):
            return -math.inf
        return self.of.sign * float(known.mean())


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
    chosen = measure or (RIGHT_SHARE if scenario.dynamic else RIGHT_AT_END)
    if chosen not in MEASURES:
        raise FeasibeeError(f"measure = {chosen}: is no measure; choose from {', '.join(MEASURES)}")
    if not scenario.dynamic and (chosen != RIGHT_AT_END or false_alarms is not None):
        what = "false alarms" if chosen == RIGHT_AT_END else chosen
        raise FeasibeeError(f"{what}: needs a world that changes; add [[events]] or rates, or leave it out")
    return Objective(chosen, false_alarms)


def scored(
    rounds: Rounds, designs: Sequence[DesignPoint], runs: int, seed: int, objective: Objective
) -> list[Scored]:
    """Run one round; return the measure of each run of each point."""
    records = rounds.run(Study(designs, runs, seed))
    return [
        Scored(objective.of.values(record, design.scenario), _alarms(record, design.scenario))
        for design, record in zip(designs, records, strict=True)
    ]


def _alarms(record: Record, scenario: Scenario) -> float:
    if not scenario.dynamic:
        return 0.0
    alarms, steps = false_alarms_of(record.truth, record.held), steps_of(record.truth)
    return PER * float(alarms.sum()) / max(1, int(steps.sum()))


def _mean_delays(record: Record, scenario: Scenario) -> Values:
    """Return the mean delay of each run over its changes; a missed one counts as long as it was watched.

    This is the restricted mean of a censored time; a run without changes that count has NaN.

    References
    ----------
    Royston, Parmar, "Restricted mean survival time: an alternative to the hazard ratio", 2013.
    """
    changes = changes_of(record.truth, record.held)
    waited = np.where(changes.delay >= 0, changes.delay, changes.watched + 1)
    number = np.bincount(changes.run, minlength=record.runs)
    total = np.bincount(changes.run, waited, minlength=record.runs)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _known(values: Values) -> Values:
    return values[np.isfinite(values)]


MEASURES: Final[Mapping[str, Measure]] = {
    RIGHT_AT_END: Measure(
        lambda record, scenario: ended_right(record, scenario).astype(np.float64),
        lambda values: wilson(int(values.sum()), values.size),
        paired_difference,
        1,
        "right swarms (%)",
    ),
    RIGHT_SHARE: Measure(
        lambda record, scenario: right_shares(record),
        mean_share,
        mean_difference,
        1,
        "steps at which swarms are right (%)",
    ),
    DELAY: Measure(
        _mean_delays,
        lambda values: mean_of(_known(values)),
        lambda one, other: mean_of(_known(other - one)),
        -1,
        "mean delay of detection (steps)",
    ),
}
"""What a search may improve, by name."""
