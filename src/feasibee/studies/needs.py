"""What a strategy asks of its robots, in a scenario: by its file's declarations, and by its messages."""

from __future__ import annotations

from typing import Any, Final

from feasibee.scenario.scenario import Scenario
from feasibee.simulation.lowering import lower
from feasibee.simulation.swarm import Swarm
from feasibee.strategies.contract import Manifest, Me, Words

IDS: Final = "ids that are never mistaken"
NAMES: Final = "names of tasks"
COUNT: Final = "the number of robots"
LOOKS: Final = 20
"""Number of steps of a run, evenly spaced, at which messages are measured."""


def needs_of(scenario: Scenario) -> list[str]:
    """Return what a scenario's strategy needs, in words, with the scenario's values of its parameters."""
    manifest = scenario.manifest
    found = [IDS] if _needs(manifest.needs_ids, scenario) else []
    found += [NAMES] if _needs(manifest.needs_names, scenario) else []
    return found + ([COUNT] if manifest.needs_count or scenario.robots.know_count else [])


def _needs(declared: bool | str, scenario: Scenario) -> bool:
    if isinstance(declared, str):
        return float(scenario.decision.parameters.get(declared, 0.0)) > 0
    return declared


def declared_needs(manifest: Manifest) -> list[str]:
    """Return what a strategy needs with the default values of its parameters, in words."""
    of = {IDS: manifest.needs_ids, NAMES: manifest.needs_names, COUNT: manifest.needs_count}
    return [
        name
        for name, need in of.items()
        if (manifest.parameters[need] > 0 if isinstance(need, str) else need)
    ]


def longest_message(scenario: Scenario, seed: int = 0) -> int:
    """Return the length in bits of the longest message that a robot could send in a run.

    Messages that hold knowledge are measured in one run, at 20 steps, of all robots.
    """
    plain: int = lower(scenario, seed).params.radio.message_bits
    strategy: Any = scenario.strategy
    if not strategy.knowledge:
        return plain
    swarm = Swarm(scenario, seed)
    steps = scenario.run.steps
    longest = 0
    for look in range(1, LOOKS + 1):
        swarm.advance(steps * look // LOOKS - swarm.step)
        longest = max(longest, *(_length(strategy, row.tolist(), scenario) for row in swarm.knowledge))
    return plain + longest


def _length(strategy: Any, known: list[int], scenario: Scenario) -> int:
    """Return the length of the message of a robot with this knowledge, in bits."""
    me = Me(0, 0, 0, 0, [0.0] * strategy.memory, scenario.setting)
    words = Words(known)
    if strategy.encode is None:
        message = words
    else:
        message = Words([0] * strategy.row_lengths(scenario.setting)[1])
        strategy.encode(message, words, me)
    return int(strategy.bits(tuple(message), me))
