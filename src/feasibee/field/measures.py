"""How a field tracked a truth that changes, as ``feasibee run`` says it of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from feasibee.model.record import Record
from feasibee.results.measures import tracked as measures_of
from feasibee.scenario.scenario import Scenario


def tracked(scenario: Scenario, steps: Sequence[tuple[int, int]]) -> dict[str, Any]:
    """Return the measures of a field; none if its world doesn't change.

    Parameters
    ----------
    scenario : Scenario
        What the field ran.
    steps : sequence of pairs of int
        The truth and the opinion held, at each step.
    """
    if not scenario.dynamic:
        return {}
    record = Record.empty(0, 1, 0, len(steps))
    record.truth[0], record.held[0] = np.array(steps).T
    return measures_of(record, scenario)
