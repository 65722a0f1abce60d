"""How a journal's rows encode the outcome of runs."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.model.outcomes import CURVES, OUTCOMES
from feasibee.model.record import Record


def rows_of_runs(record: Record) -> Iterator[tuple[int, ...]]:
    """Yield each run's number and its outcomes, in the order of `OUTCOMES`."""
    numbers = range(record.first_run, record.first_run + record.runs)
    return zip(numbers, *(getattr(record, each.name).tolist() for each in OUTCOMES), strict=True)


def rows_of_curves(record: Record) -> Iterator[tuple[Any, ...]]:
    """Yield each run's number and its curves as bytes, in the order of `CURVES`."""
    for row in range(record.runs):
        curves = (getattr(record, each.name)[row] for each in CURVES)
        packed = (zlib.compress(np.ascontiguousarray(curve, "<i4").tobytes()) for curve in curves)
        yield record.first_run + row, *packed


def curve_of(blob: bytes) -> NDArray[np.int32]:
    """Return a count of robots at each step: int32, shape (steps + 1,)."""
    return np.frombuffer(zlib.decompress(blob), "<i4").astype(np.int32)
