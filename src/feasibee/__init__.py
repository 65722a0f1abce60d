"""Simulate robot swarms that decide together whether a set of tasks is feasible.

>>> import feasibee
>>> swarms = feasibee.simulate(feasibee.Scenario(tasks={"count": 2}), runs=100, seed=1)
>>> feasibee.decision_counts(swarms.decision)
{'feasible': 91, 'infeasible': 9, 'undecided': 0}
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from feasibee.errors import FeasibeeError, ScenarioError
    from feasibee.figures.arena import plot_arena
    from feasibee.figures.decisions import plot_decision_steps, plot_decisions, plot_opinions
    from feasibee.results.dataset import open_results, save_results, scenario_of
    from feasibee.results.statistics import decision_counts, decision_rates, decision_times, wilson
    from feasibee.scenario.feasibility import truth
    from feasibee.scenario.scenario import Scenario
    from feasibee.simulation.ensemble import simulate
    from feasibee.simulation.swarm import Swarm, truth_at

_HOMES = {
    "FeasibeeError": "errors",
    "Scenario": "scenario.scenario",
    "ScenarioError": "errors",
    "Swarm": "simulation.swarm",
    "decision_counts": "results.statistics",
    "decision_rates": "results.statistics",
    "decision_times": "results.statistics",
    "open_results": "results.dataset",
    "plot_arena": "figures.arena",
    "plot_decision_steps": "figures.decisions",
    "plot_decisions": "figures.decisions",
    "plot_opinions": "figures.decisions",
    "save_results": "results.dataset",
    "scenario_of": "results.dataset",
    "simulate": "simulation.ensemble",
    "truth": "scenario.feasibility",
    "truth_at": "simulation.swarm",
    "wilson": "results.statistics",
}

__all__ = [
    "FeasibeeError",
    "Scenario",
    "ScenarioError",
    "Swarm",
    "decision_counts",
    "decision_rates",
    "decision_times",
    "open_results",
    "plot_arena",
    "plot_decision_steps",
    "plot_decisions",
    "plot_opinions",
    "save_results",
    "scenario_of",
    "simulate",
    "truth",
    "truth_at",
    "wilson",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use, so that ``import feasibee`` loads no library."""
    if name in _HOMES:
        value = getattr(import_module(f"feasibee.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'feasibee' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
