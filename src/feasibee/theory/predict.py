"""Predict how a swarm decides, and why, without simulating it."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from feasibee.results.measures import least_quorum
from feasibee.results.statistics import Interval, Quartiles, decision_rates, decision_times, wilson
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.theory.chain import Chain, chain_of, opinions_over_time
from feasibee.theory.classes import Array, Moves
from feasibee.theory.reach import check_fields, check_swarm, tested_error, time_error, warnings_for
from feasibee.theory.rule import swarm_of
from feasibee.theory.saddle import Manifold, Tipping, tipping

QUARTERS = {"q25": 0.25, "median": 0.5, "q75": 0.75}
CLEAR = 0.02  # share of the robots: rounding errors are smaller


@dataclass(frozen=True)
class Prediction:
    """What the theory says of a scenario; shares are those of all swarms."""

    scenario: Scenario
    """The scenario."""
    by_step: Array
    """Share of swarms that have decided feasible and infeasible by each step, shape (steps + 1, 2)."""
    tipping: Tipping | None
    """Where opinions tip, how fast, and by which noise; None if they only drift."""
    error: float
    """Largest error of a share that was measured for such scenarios, against the engine."""
    warnings: tuple[str, ...]
    """Why the error may be larger than elsewhere."""
    chain: Chain
    """The effective chain; if there are stubborn robots, with half of them for each opinion."""
    along: Manifold
    """States of the swarm from one consensus to the other."""
    swarm: Moves
    """The numbers of one robot."""

    @cached_property
    def opinions(self) -> Array:
        """Share of robots for feasible by step, over swarms: mean, 5 and 95 % quantile; (steps + 1, 3)."""
        return opinions_over_time(self.swarm, self.along, len(self.by_step) - 1)

    @property
    def feasible(self) -> float:
        """Share of swarms that decide feasible within the steps of a run."""
        return float(self.by_step[-1, 0])

    @property
    def infeasible(self) -> float:
        """Share of swarms that decide infeasible within the steps of a run."""
        return float(self.by_step[-1, 1])

    @property
    def undecided(self) -> float:
        """Share of swarms that don't decide."""
        return max(0.0, 1 - self.feasible - self.infeasible)

    @property
    def right(self) -> float:
        """Share of swarms that decide what is true."""
        return self.feasible if truth(self.scenario) else self.infeasible

    @cached_property
    def steps(self) -> dict[str, int | None]:
        """First steps by which a quarter, half and three quarters of the swarms decide; None if never."""
        decided = self.by_step.sum(1)
        found = {name: int(np.searchsorted(decided, share)) for name, share in QUARTERS.items()}
        return {name: step if step < len(decided) else None for name, step in found.items()}

    def to_dict(self) -> dict[str, Any]:
        """Return the prediction as JSON has it."""
        tips = self.tipping
        return {
            "feasible": self.feasible,
            "infeasible": self.infeasible,
            "undecided": self.undecided,
            "right": self.right,
            "median_step": self.steps["median"],
            "decision_step": self.steps,
            "error": self.error,
            "tipping_point": tips and tips.point,
            "growth_per_step": tips and tips.growth,
            "e_fold_steps": tips and tips.e_fold,
            "noise": tips and {"coins": tips.coins, "later": tips.later, "coins_share": tips.coins_share},
            "warnings": list(self.warnings),
        }


def predict(scenario: Scenario) -> Prediction:
    """Predict the decisions of a scenario's swarms by theory, without simulating them.

    Parameters
    ----------
    scenario : Scenario
        A scenario within the theory's reach.

    Returns
    -------
    Prediction
        Shares and times of decisions, the tipping point of opinions, and the tested error.

    Raises
    ------
    ScenarioError
        If the scenario is beyond the theory's reach, with the fields, their values and what to use.

    Examples
    --------
    >>> import feasibee
    >>> round(feasibee.predict(feasibee.Scenario(tasks={"count": 10})).right, 2)
    0.75
    """
    check_fields(scenario)
    swarm = swarm_of(scenario)
    check_swarm(scenario, swarm)
    tips = tipping(swarm)
    stubborn = scenario.faulty[2]
    quorum, by_step = least_quorum(scenario, scenario.counted(0)), np.zeros((scenario.run.steps + 1, 2))
    for first in sorted(range(stubborn + 1), key=lambda held: held == stubborn // 2):  # an even split last
        here = swarm_of(scenario, feasible_ones=first) if stubborn else swarm
        chain, along = chain_of(here, (quorum - first, quorum - stubborn + first))
        by_step = by_step + math.comb(stubborn, first) / 2**stubborn * chain.over_time(scenario.run.steps)
    notes = tuple(warnings_for(scenario, tips))
    return Prediction(scenario, by_step, tips, tested_error(scenario), notes, chain, along, swarm)


def even_tasks(scenario: Scenario) -> int | None:
    """Return the largest number of tasks at which most decided swarms decide feasible, by the formula.

    None if it isn't between a quarter and four times the number of robots. That the theory covers the
    scenario isn't checked.
    """

    def excess(tasks: int) -> float:
        tips = tipping(swarm := swarm_of(scenario.replace({"tasks.count": tasks})))
        return math.nan if tips is None else tips.point - swarm.begins

    low, high = scenario.robots.count // 4, 4 * scenario.robots.count
    if not (excess(low) < -CLEAR and excess(high) > CLEAR):
        return None
    return low + bisect_left(range(low, high), True, key=lambda tasks: excess(tasks) > 0) - 1


class Agreement(NamedTuple):
    """What the engine found, and whether it agrees with a prediction."""

    runs: int
    """Number of runs."""
    rates: dict[str, Interval]
    """Shares of runs that decided feasible, infeasible and not, each with its 95 % interval."""
    steps: Quartiles
    """Quartiles of the step of the decision."""
    shares_agree: bool
    """Whether both predicted shares lie within the tested error of the engine's 95 % intervals."""
    times_agree: bool
    """Whether the predicted median lies within the tested error of a median in the engine's 95 % interval."""

    @property
    def agree(self) -> bool:
        """Whether shares and times agree."""
        return self.shares_agree and self.times_agree


def compare(prediction: Prediction, results: Any) -> Agreement:
    """Compare a prediction with runs of the engine, whose results have ``decision`` and ``decision_step``."""
    decision, step = np.asarray(results.decision), np.asarray(results.decision_step)
    rates = decision_rates(decision)
    shares = all(
        rates[name].low - prediction.error <= share <= rates[name].high + prediction.error
        for name, share in (("feasible", prediction.feasible), ("infeasible", prediction.infeasible))
    )
    return Agreement(decision.size, rates, decision_times(step), shares, _median_agrees(prediction, step))


def _median_agrees(prediction: Prediction, step: Any) -> bool:
    """Return whether half of the runs may have decided within the tested error of the predicted median."""
    error = time_error(prediction.scenario)
    steps, median = prediction.scenario.run.steps, prediction.steps["median"]

    def decided(by: float) -> Interval:
        return wilson(int(((step >= 0) & (step <= by)).sum()), step.size)

    if median is None:  # half may decide just after the last step
        return decided((1 - error) * steps).low <= 0.5
    late = (1 + error) * median
    return decided((1 - error) * median).low <= 0.5 and (late >= steps or decided(late).high >= 0.5)
