"""Fill a store with records, and read the runs of its points as tables: sweeps do neither."""

from __future__ import annotations

import numpy as np

from feasibee.base.outcomes import OUTCOMES
from feasibee.simulation.store import Store

PLACES = {name: place for place, name in enumerate(("run", *(each.name for each in OUTCOMES)))}
"""Numbers of the columns of a table of runs, by name."""


def filled(folder, points, records, seed, until=None):
    """Return a folder with a record of each point."""
    store = Store(folder, write=True)
    for key, record in zip(store.add(points, seed, until), records, strict=True):
        store.put(key, record)
    return folder


def rows_in(store, row):
    """Return the runs of a point: int64, shape (runs, columns of `PLACES`)."""
    results = store.results(row.key)
    return np.stack([getattr(results, name) for name in PLACES], axis=1).astype(np.int64)


def counts(folder):
    """Return how many runs each point has."""
    store = Store(folder)
    return [store.count(row.key) for row in store.points]
