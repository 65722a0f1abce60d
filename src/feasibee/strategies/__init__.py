"""The strategies: one file each, one row each. A file imports ``math``, and functions of other strategies."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Final

from feasibee.strategies.contract import ARGUMENTS, CONSTANTS, Strategy
from feasibee.strategies.layout import both_ways


def module_of(name: str) -> ModuleType:
    """Return the module of this package that defines a built-in strategy."""
    return import_module(f"{__name__}.{name.replace('-', '_')}")


def _strategy_of(name: str) -> Strategy:
    """Return the strategy that a module of this package defines."""
    module = module_of(name)
    if hasattr(module, "layout"):  # other files may import pack and unpack
        vars(module).update(both_ways(module.layout))
    functions = {each: getattr(module, each) for each in ARGUMENTS if hasattr(module, each)}
    constants = {field: getattr(module, each) for each, field in CONSTANTS.items() if hasattr(module, each)}
    return Strategy(name=name, functions=frozenset(functions), **functions, **constants)


STRATEGIES: Final[dict[str, Strategy]] = {
    name: _strategy_of(name)
    for name in (
        "dmmd",
        "dmvd",
        "dc",
        "voter",
        "majority",
        "k-unanimity",
        "cross-inhibition",
        "bayes",
        "tally",
        "estimate",
        "census",
        "quiet-census",
        "map",
        "turns",
        "roster",
    )
}
"""The built-in strategies, the paper's first."""
GOSSIP: Final = _strategy_of("gossip")
"""No strategy for users: `feasibee.simulation.flooding` simulates it."""
