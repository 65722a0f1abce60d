"""Whether runs of the engine agree with a prediction, by a test that is fixed before they are run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from feasibee.results.statistics import Interval, Quartiles, decision_rates, decision_times, wilson
from feasibee.theory.predict import Prediction
from feasibee.theory.reach import time_error


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
    """Compare a prediction with runs of the engine.

    Parameters
    ----------
    prediction : Prediction
        What the theory says.
    results : Record or xarray.Dataset
        Runs of the same scenario, with ``decision`` and ``decision_step``.
    """
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
