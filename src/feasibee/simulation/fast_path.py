"""Which scenarios the fast path simulates: the paper's world, with these fields free."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import unsupported

FAST_PATH_FIELDS: Final = frozenset(
    {
        "arena.side",
        "robots.count",
        "robots.speed",
        "robots.diameter",
        "robots.know_count",
        "tasks.count",
        "walk.mean_run",
        "sensing.range",
        "sensing.count_self",
        "radio.range",
        "decision.strategy",
        "decision.parameters",
        "decision.exploration",
        "decision.gain",
        "decision.dissemination_floor",
        "decision.quality_floor",
        "decision.listen",
        "decision.inbox",
        "decision.own_vote",
        "decision.threshold",
        "run.steps",
        "run.stop_at_decision",
        "units.metres",
        "units.seconds",
    }
)
"""The fields that the fast path implements; it takes only the default of any other field."""

FAST_PATH_LIMITS: Final[Mapping[str, Callable[[Scenario], bool]]] = {
    "arena.side": lambda scenario: scenario.arena.size[0] == scenario.arena.size[1],
    "decision.strategy": lambda scenario: not scenario.manifest.knowledge,
    "decision.listen": lambda scenario: scenario.decision.listen in ("always", "dissemination"),
}
"""Conditions on the values of some of these fields."""


def takes_fast_path(scenario: Scenario) -> bool:
    """Return whether the fast path simulates a scenario; if not, the general engine does.

    A new field of a scenario needs the general engine until it is listed above.
    """
    if scenario.dynamic or any(unsupported(scenario, FAST_PATH_FIELDS)):
        return False
    return all(holds(scenario) for holds in FAST_PATH_LIMITS.values())
