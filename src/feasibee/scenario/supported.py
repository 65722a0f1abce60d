"""Which fields of a scenario each backend supports: of any other field it takes the default only.

The engine's general path and the reference take every field; so does a field of processes, but for
batteries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Set
from typing import Final

from feasibee.base.errors import Problem
from feasibee.scenario.fields import SECTIONS, Bitmap
from feasibee.scenario.paths import inline_toml
from feasibee.scenario.scenario import Scenario

COMMON: Final = frozenset(
    {
        "arena.side",
        *("robots.count", "robots.speed", "robots.diameter", "tasks.count", "walk.mean_run"),
        *("sensing.range", "sensing.count_self", "radio.range"),
        *("decision.strategy", "decision.parameters", "decision.exploration", "decision.gain"),
        *("decision.dissemination_floor", "decision.quality_floor", "decision.listen", "decision.inbox"),
        *("decision.own_vote", "decision.ties", "decision.start", "decision.threshold"),
        *("run.steps", "run.stop_at_decision"),
    }
)
"""Fields that every backend supports."""
FAST_PATH: Final = COMMON | {"robots.know_count", "units.metres", "units.seconds"}
"""Fields that the fast path of the engine implements; the general path simulates any other scenario."""
TOGETHER: Final = 128
"""Robots of the largest swarm that the engine plays with sets of robots in sight."""
THEORY: Final = (COMMON - {"decision.dissemination_floor"}) | {
    *("faults.byzantine", "faults.byzantine_says", "faults.stubborn"),
    *("sensing.miss", "radio.loss", "robots.know_count", "units.metres", "units.seconds"),
}
"""Fields that the theory takes into account."""
FAST_PATH_LIMITS: Final[Mapping[str, Callable[[Scenario], bool]]] = {
    "arena.side": lambda scenario: scenario.arena.size[0] == scenario.arena.size[1],
    "decision.strategy": lambda scenario: not scenario.manifest.knowledge,
    "decision.listen": lambda scenario: scenario.decision.listen in ("always", "dissemination"),
    "run.steps": lambda scenario: (
        scenario.robots.count > TOGETHER or scenario.robots.count * scenario.run.steps < 2**31
    ),
}
"""Conditions on the values of some fields of the fast path; counts of few robots have 32 bits."""


def takes_fast_path(scenario: Scenario) -> bool:
    """Return whether the fast path simulates a scenario; if not, the general path does."""
    if scenario.dynamic or any(unsupported(scenario, FAST_PATH)):
        return False
    return all(holds(scenario) for holds in FAST_PATH_LIMITS.values())


def unsupported(
    scenario: Scenario, supported: Set[str], rule: str = "", otherwise: str = ""
) -> Iterator[Problem]:
    """Yield a problem for each field of a scenario that isn't supported and isn't at its default.

    So a new field is unsupported until somebody lists it.
    ``supported`` has the dotted paths of fields. ``rule`` is that of the problems, and ``otherwise`` what
    their remedies offer in addition to the default.
    """
    for name, section in SECTIONS.items():
        values = getattr(scenario, name)
        for key, field in section.model_fields.items():
            path, default = f"{name}.{key}", field.get_default(call_default_factory=True)
            if path not in supported and getattr(values, key) != default:
                off = default in (None, (), {})
                remedy = f"leave out {path}" if off else f"set {path} = {inline_toml(default)}"
                given = "a map" if isinstance(getattr(values, key), Bitmap) else values.model_dump()[key]
                yield Problem(path, given, rule, f"{remedy}{otherwise}")
    changed = (each.model_dump(exclude_defaults=True) for each in scenario.events)
    if {f"events.{name}" for each in changed for name in each} - supported:
        yield Problem("events", f"{len(scenario.events)} events", rule, f"leave out [[events]]{otherwise}")
