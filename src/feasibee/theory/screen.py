"""Quick predictions for a search, which compares many scenarios: the chain of fewer states and pairs."""

from __future__ import annotations

from typing import Final

import numpy as np

from feasibee.errors import ScenarioError
from feasibee.results.measures import least_quorum
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.theory.chain import chain_of
from feasibee.theory.classes import Array
from feasibee.theory.geometry import ending
from feasibee.theory.quality import longest_exploration
from feasibee.theory.reach import check_fields, check_swarm, tested_error
from feasibee.theory.rule import swarm_of
from feasibee.theory.saddle import manifold

WALKED: Final = frozenset(("arena.side", "robots.speed", "sensing.range", "walk.mean_run"))
"""Fields whose values each need walks of their own: a search over them isn't quick."""
LONGEST: Final = 300.0
"""Largest mean exploration, in steps, whose walks are quick."""
PAIRS: Final = 1_000
"""Number of pairs sampled per geometry: an eighth of those of a prediction."""
FEW: Final[Array] = np.array([0.006, 0.05, *np.linspace(0.14, 0.86, 7), 0.95, 0.994])
"""Shares of feasible opinions at which drift and noise are computed: about half as many."""
ITERATIONS: Final = 30
"""Iterations for the value of the classes."""
LARGEST_ERROR: Final = 0.06
"""Largest tested error of a share with which scenarios are compared."""


class Screen:
    """Predicts the share of swarms that decide right, to compare many scenarios.

    Parameters
    ----------
    exploration : float
        Largest mean exploration of the scenarios, in steps: their walks are shared.
    error : float
        Largest tested error of a share.
    """

    def __init__(self, exploration: float, error: float = LARGEST_ERROR) -> None:
        self._error = error
        self._walked = longest_exploration(ending(exploration))

    def right(self, scenario: Scenario) -> float | None:
        """Return the share; None beyond reach, with faulty robots, or with too large a tested error."""
        try:
            check_fields(scenario)
            if tested_error(scenario) > self._error or any(scenario.faulty):
                return None
            swarm = swarm_of(scenario, PAIRS, self._walked)
            check_swarm(scenario, swarm)
        except ScenarioError:
            return None
        along, quorum = manifold(swarm, FEW, ITERATIONS), least_quorum(scenario, swarm.robots)
        chain, _ = chain_of(swarm, (quorum, quorum), along)
        feasible, infeasible = chain.decided_by(scenario.run.steps)
        return float(feasible if truth(scenario) else infeasible)
