"""Points as a journal stores them."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.sweeps.content import Damage
from feasibee.sweeps.schema import Entry


class StoredPoint(NamedTuple):
    """A point in the journal."""

    id: int
    hash: str
    seed: int
    truth: bool
    values: dict[str, Any]
    scenario: Scenario
    """With the text of the strategy's file from the journal, which isn't run without the user's consent."""
    until: dict[str, float] | None
    """Stopping rule that chose the number of runs, if any."""
    source: int | None
    """Number of the text of its strategy's file, if any."""


def stored_point(entry: Entry) -> StoredPoint:
    """Return a point from its row; compute its truth again, and raise `Damage` if it differs."""
    scenario = Scenario.from_tables(json.loads(entry.scenario), source=entry.text, trusted=False)
    if truth(scenario) != entry.truth:
        raise Damage("its truth")
    return StoredPoint(
        entry.id,
        entry.hash,
        int(entry.seed),
        bool(entry.truth),
        json.loads(entry.vary),
        scenario,
        json.loads(entry.until or "null"),
        entry.source,
    )
