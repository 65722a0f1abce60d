"""The built-in strategies that a scenario supports, and why it does not support the others."""

from __future__ import annotations

from typing import Any

from feasibee.errors import FeasibeeError, ScenarioError
from feasibee.scenario.plugins import registered
from feasibee.scenario.scenario import Scenario
from feasibee.strategies import STRATEGIES


def suitable(scenario: Scenario) -> tuple[dict[str, Scenario], dict[str, ScenarioError]]:
    """Return the scenario with each built-in strategy that it supports, and the problems with the others.

    Parameters
    ----------
    scenario : Scenario
        Its own strategy keeps its parameters.

    Returns
    -------
    scenarios : dict of str to Scenario
        By the name of the strategy.
    problems : dict of str to ScenarioError
        Such as that of a strategy that needs the number of robots.
    """
    scenarios, problems = {}, {}
    for name in STRATEGIES:
        try:
            scenarios[name] = scenario.replace(strategy_change(scenario, name))
        except ScenarioError as error:
            problems[name] = error
    return scenarios, problems


def strategy_change(scenario: Scenario, name: str) -> dict[str, Any]:
    """Return the changes that give a scenario another strategy; its own one keeps its parameters."""
    own = name == scenario.decision.strategy
    return {} if own else {"decision.strategy": name, "decision.parameters": {}}


def all_strategies(scenario: Scenario) -> list[str]:
    """Return the names of the built-in strategies, of those of installed packages, and the scenario's own."""
    return list(dict.fromkeys([*STRATEGIES, *registered(), scenario.decision.strategy]))


def check_stays(scenario: Scenario, question: str) -> None:
    """Raise an error if the world of a scenario changes: then there is no single truth to be right about."""
    if scenario.dynamic:
        raise FeasibeeError(
            f"{question}: needs a world that stays, but the world of this scenario changes; leave out events "
            "and rates, or use feasibee compare or feasibee assess"
        )
