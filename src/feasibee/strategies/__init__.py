"""The strategies: one file each, one row each. A strategy's file imports nothing but ``math``."""

from __future__ import annotations

from types import ModuleType
from typing import Final

from feasibee.strategies import (
    accumulate,
    average,
    bayes,
    census,
    cross_inhibition,
    dc,
    dmmd,
    dmvd,
    estimate,
    fading,
    fading_votes,
    k_unanimity,
    majority,
    mixture,
    quiet_census,
    roster,
    roster_turns,
    sketch,
    tally,
    totals,
    turns,
    voter,
)
from feasibee.strategies import map as map_
from feasibee.strategies.contract import ARGUMENTS, CONSTANTS, Strategy


def strategy_of_module(name: str, module: ModuleType) -> Strategy:
    """Return the strategy that an imported module of this package defines."""
    functions = {each: getattr(module, each) for each in ARGUMENTS if hasattr(module, each)}
    constants = {field: getattr(module, each) for each, field in CONSTANTS.items() if hasattr(module, each)}
    return Strategy(name=name, functions=frozenset(functions), **functions, **constants)


STRATEGIES: Final[dict[str, Strategy]] = {
    name: strategy_of_module(name, module)
    for name, module in {
        "dmmd": dmmd,
        "dmvd": dmvd,
        "dc": dc,
        "voter": voter,
        "majority": majority,
        "k-unanimity": k_unanimity,
        "cross-inhibition": cross_inhibition,
        "bayes": bayes,
        "accumulate": accumulate,
        "average": average,
        "tally": tally,
        "estimate": estimate,
        "census": census,
        "sketch": sketch,
        "quiet-census": quiet_census,
        "map": map_,
        "turns": turns,
        "totals": totals,
        "mixture": mixture,
        "roster": roster,
        "roster-turns": roster_turns,
        "fading": fading,
        "fading-votes": fading_votes,
    }.items()
}
"""The built-in strategies, the paper's first."""
