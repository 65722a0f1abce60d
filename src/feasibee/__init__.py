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
    from feasibee.base.errors import FeasibeeError as FeasibeeError
    from feasibee.base.errors import ScenarioError as ScenarioError
    from feasibee.figures.arena import plot_arena as plot_arena
    from feasibee.figures.decisions import plot_decision_steps as plot_decision_steps
    from feasibee.figures.decisions import plot_decisions as plot_decisions
    from feasibee.figures.decisions import plot_opinions as plot_opinions
    from feasibee.results.dataset import save_results as save_results
    from feasibee.results.dataset import scenario_of as scenario_of
    from feasibee.results.statistics import confidence_sequence as confidence_sequence
    from feasibee.results.statistics import decision_counts as decision_counts
    from feasibee.results.statistics import decision_rates as decision_rates
    from feasibee.results.statistics import decision_times as decision_times
    from feasibee.results.statistics import wilson as wilson
    from feasibee.scenario.feasibility import explain as explain
    from feasibee.scenario.feasibility import truth as truth
    from feasibee.scenario.scenario import Scenario as Scenario
    from feasibee.simulation.ensemble import simulate as simulate
    from feasibee.simulation.swarm import Swarm as Swarm
    from feasibee.simulation.swarm import truth_at as truth_at
    from feasibee.simulation.table import open_results as open_results
    from feasibee.simulation.table import sweep as sweep
    from feasibee.strategies import STRATEGIES as STRATEGIES
    from feasibee.studies.assess import assess as assess
    from feasibee.studies.constraints import compare as compare
    from feasibee.studies.size import size as size
    from feasibee.theory.predict import predict as predict

_NAMES = {
    "base.errors": ("FeasibeeError", "ScenarioError"),
    "figures.arena": ("plot_arena",),
    "figures.decisions": ("plot_decision_steps", "plot_decisions", "plot_opinions"),
    "results.dataset": ("save_results", "scenario_of"),
    "results.statistics": (
        "confidence_sequence",
        "decision_counts",
        "decision_rates",
        "decision_times",
        "wilson",
    ),
    "scenario.feasibility": ("explain", "truth"),
    "scenario.scenario": ("Scenario",),
    "simulation.ensemble": ("simulate",),
    "simulation.swarm": ("Swarm", "truth_at"),
    "strategies": ("STRATEGIES",),
    "studies.assess": ("assess",),
    "studies.constraints": ("compare",),
    "studies.size": ("size",),
    "simulation.table": ("open_results", "sweep"),
    "theory.predict": ("predict",),
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}
__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Import a public name on first use, so that ``import feasibee`` loads no library."""
    if name in _HOMES:
        value = getattr(import_module(f"feasibee.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'feasibee' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
