"""Which fields of a scenario something supports: of any other field it takes the default only."""

from __future__ import annotations

from collections.abc import Iterator, Set
from typing import Any, NamedTuple

from feasibee.scenario.fields import SECTIONS
from feasibee.scenario.scenario import Scenario


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
