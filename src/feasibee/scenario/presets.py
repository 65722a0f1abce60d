"""Presets: published controllers of the field, as values of scenarios (model.md 7)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

# Durations in steps: 10 s and 3 s at ten ticks a second.
_LONG: Final = {"exploration": 100.0, "gain": 100.0}
_WINDOW: Final = {"dissemination_floor": 30, "listen": {"last": 30}}

PRESETS: Final[Mapping[str, Mapping[str, Mapping[str, Any]]]] = {
    "valentini-2016": {"decision": {**_LONG, **_WINDOW, "inbox_size": 2}, "run": {"steps": 10_000}},
    "minimize-surprise": {"decision": {**_LONG, **_WINDOW, "inbox_size": 4}, "run": {"steps": 10_000}},
    "subcdm-2025": {
        "decision": {**_LONG, "listen": "dissemination", "inbox_size": 2, "quality_floor": 1},
        "radio": {"id_bits": 8},
        "run": {"steps": 10_000},
    },
}

ABOUT: Final[Mapping[str, str]] = {
    "valentini-2016": "Pold87/blockchain-swarm-robotics, on the collective perception of 2016",
    "minimize-surprise": "Minimize-Surprise/Collective-Perception",
    "subcdm-2025": "SooratiLab/subset_CDM, by the paper's group",
}
"""Whose controller each preset is."""


def with_preset(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scenario's tables with the values of its preset, if any, filled in where it sets none."""
    tables = dict(given)
    name = tables.get("preset")
    for section, values in PRESETS.get(name, {}).items() if isinstance(name, str) else ():
        table = tables.get(section, {})
        if hasattr(table, "model_dump"):
            table = table.model_dump(exclude_unset=True)
        if isinstance(table, Mapping):  # validation reports anything else
            tables[section] = {**values, **table}
    return tables
