"""The effective chain for model checkers, and the drift of opinions as a differential equation."""

from __future__ import annotations

import math

import numpy as np

from feasibee.scenario.scenario import Scenario
from feasibee.theory.predict import predict

FASTEST = 0.9
"""Largest probability to leave a state in one tick."""
DEGREE = 3
"""Degree of the polynomial that the drift is fitted with, besides its zeros at both consensus states."""


def to_prism(scenario: Scenario) -> str:
    """Return the effective chain as a model for PRISM or Storm.

    State 0 is the decision infeasible, the last but one the decision feasible. The last is the start, whose
    first tick draws the coins. Labels: ``feasible``, ``infeasible``, ``decided``.
    Reward: ``steps``.

    Parameters
    ----------
    scenario : Scenario
        A scenario within the theory's reach.
    """
    chain = predict(scenario).chain
    among, exits = chain.moves()
    last = len(among) + 1
    ticks = max(1, math.ceil((among.sum(1) + exits.sum(1)).max() / FASTEST))
    rates = np.concatenate([exits[:, 1:], among, exits[:, :1]], axis=1) / ticks
    rates[np.arange(last - 1), np.arange(1, last)] = 1 - rates.sum(1)
    first = np.array([chain.decided[1], *chain.start, chain.decided[0]])

    def row(state: int, chances: np.ndarray) -> str:
        moves = enumerate(chances.tolist())
        to = " + ".join(f"{chance!r}:(x'={k})" for k, chance in moves if chance > 0)
        return f"  [] x={state} -> {to};"

    return "\n".join(
        [
            f"// {scenario.robots.count} robots, {scenario.tasks.count} tasks, {scenario.decision.strategy}",
            f"dtmc\nconst int ticks_per_step = {ticks};",
            f"module swarm\n  x : [0..{last + 1}] init {last + 1};",
            row(last + 1, first / first.sum()),
            *(row(state, chances) for state, chances in enumerate(rates, 1)),
            f"  [] x=0|x={last} -> true;\nendmodule",
            f'label "feasible" = x={last};\nlabel "infeasible" = x=0;\nlabel "decided" = x=0|x={last};',
            f'rewards "steps"\n  x>0&x<{last} : 1/{ticks};\nendrewards\n',
        ]
    )


def to_ode(scenario: Scenario) -> str:
    """Return the drift of the share of feasible opinions as a differential equation.

    Parameters
    ----------
    scenario : Scenario
        A scenario within the theory's reach.
    """
    along = predict(scenario).along
    share = along.holders[:, 0] / scenario.robots.count
    drift = along.drift * np.gradient(share, along.places)
    ends = share * (1 - share)
    basis = ends[:, None] * share[:, None] ** np.arange(DEGREE + 1)
    factors = np.linalg.lstsq(basis, drift, rcond=None)[0]
    error = np.abs(basis @ factors - drift).max() / np.abs(drift).max()
    terms = " + ".join(f"({factor:.6g})*x^{power}" for power, factor in enumerate(factors))
    return (
        f"# feasibee scenario --to ode: {scenario.robots.count} robots, {scenario.tasks.count} tasks\n"
        f"# x: share of feasible opinions; t: steps; fit within {error:.1%} of the largest drift\n"
        f"dx/dt = x*(1-x)*({terms})\n"
    )
