"""Which fields of a scenario each backend supports: of any other field it takes the default only.

The general engine, the reference and a field of processes take every field.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Set
from typing import Any, Final, NamedTuple

from feasibee.scenario.fields import SECTIONS
from feasibee.scenario.scenario import Scenario

COMMON: Final = frozenset(
    {
        "arena.side",
        *("robots.count", "robots.speed", "robots.diameter", "tasks.count", "walk.mean_run"),
        *("sensing.range", "sensing.count_self", "radio.range"),
        *("decision.strategy", "decision.parameters", "decision.exploration", "decision.gain"),
        *("decision.dissemination_floor", "decision.quality_floor", "decision.listen", "decision.inbox"),
        *("decision.own_vote", "decision.threshold"),
        *("run.steps", "run.stop_at_decision"),
    }
)
"""Fields that every backend supports."""
FAST_PATH: Final = COMMON | {"robots.know_count", "units.metres", "units.seconds"}
"""Fields that the fast path of the engine implements; the general engine simulates any other scenario."""
IN_C: Final = COMMON | {"decision.inbox_size", "decision.switching", "decision.declare"}
"""Fields that a world around the controller in C has."""
PAGE: Final = IN_C | {"radio.id_bits", "robots.know_count", "units.metres", "units.seconds"}
"""Fields that a page simulates."""
ARGOS: Final = IN_C | {"arena.boundary", "robots.avoid_collisions", "sensing.miss", "radio.loss"}
"""Fields that an experiment of ARGoS expresses."""
FAST_PATH_LIMITS: Final[Mapping[str, Callable[[Scenario], bool]]] = {
    "arena.side": lambda scenario: scenario.arena.size[0] == scenario.arena.size[1],
    "decision.strategy": lambda scenario: not scenario.manifest.knowledge,
    "decision.listen": lambda scenario: scenario.decision.listen in ("always", "dissemination"),
}
"""Conditions on the values of some fields of the fast path."""


def takes_fast_path(scenario: Scenario) -> bool:
    """Return whether the fast path simulates a scenario; if not, the general engine does."""
    if scenario.dynamic or any(unsupported(scenario, FAST_PATH)):
        return False
    return all(holds(scenario) for holds in FAST_PATH_LIMITS.values())


class Unsupported(NamedTuple):
    """A field that isn't supported, with a value other than its default."""

    path: str
    value: Any
    default: Any


def unsupported(scenario: Scenario, supported: Set[str]) -> Iterator[Unsupported]:
    """Yield the fields of a scenario that aren't among the supported ones and aren't at their default.

    So a new field is unsupported until somebody lists it.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    supported : set of str
        Dotted paths of fields.
    """
    for name, section in SECTIONS.items():
        values = getattr(scenario, name)
        for key, field in section.model_fields.items():
            path, default = f"{name}.{key}", field.get_default(call_default_factory=True)
            if path not in supported and getattr(values, key) != default:
                yield Unsupported(path, getattr(values, key), default)
