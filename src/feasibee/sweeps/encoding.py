"""How a journal's rows encode the outcome of runs."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.model.outcomes import CURVES, OUTCOMES
from feasibee.model.record import Record

LEVEL, WINDOW_BITS, MEMORY_LEVEL = 1, 12, 5
"""Of zlib: 18 us per run of 1,000 steps, and 9 to read it. The usual 6, 15 and 8 take twice as long."""


class EncodedRuns(NamedTuple):
    """Consecutive runs of one point, as the rows of a journal's tables."""

    runs: list[tuple[int, ...]]
    """Number of each run, then its `OUTCOMES`."""
    curves: list[tuple[Any, ...]]
    """Number of each run, then its compressed `CURVES`; empty if no curves are kept."""


def encode(record: Record) -> EncodedRuns:
    """Encode runs, and their curves if the record has any."""
    return EncodedRuns(list(rows_of_runs(record)), list(rows_of_curves(record)))


def rows_of_runs(record: Record) -> Iterator[tuple[int, ...]]:
    """Yield each run's number and its outcomes, in the order of `OUTCOMES`."""
    numbers = range(record.first_run, record.first_run + record.runs)
    return zip(numbers, *(getattr(record, each.name).tolist() for each in OUTCOMES), strict=True)


def rows_of_curves(record: Record) -> Iterator[tuple[Any, ...]]:
    """Yield each run's number and its compressed curves, in the order of `CURVES`; nothing without curves."""
    curves = [getattr(record, each.name) for each in CURVES]
    if curves[0].shape[1]:
        for row in range(record.runs):
            yield record.first_run + row, *(_compressed(counts[row]) for counts in curves)


def _compressed(counts: NDArray[np.int32]) -> bytes:
    packer = zlib.compressobj(LEVEL, zlib.DEFLATED, WINDOW_BITS, MEMORY_LEVEL)
    return packer.compress(np.ascontiguousarray(counts, "<i4").tobytes()) + packer.flush()


def curve_of(blob: bytes) -> NDArray[np.int32]:
    """Return a count of robots at each step: int32, shape (steps + 1,)."""
    return np.frombuffer(zlib.decompress(blob), "<i4").astype(np.int32)


def fill(record: Record, columns: NDArray[np.int64], curves: Iterable[tuple[Any, ...]]) -> None:
    """Fill in a record from the rows of a journal; rows of other runs are ignored.

    Parameters
    ----------
    record : Record
        Empty, of the runs and the curve length that are wanted.
    columns : int64 array, shape (rows, columns of `PLACES`)
        Number of each run, then its `OUTCOMES`.
    curves : iterable of tuple
        Number of each run, then its compressed `CURVES`.
    """
    first = record.first_run
    wanted = columns[(first <= columns[:, 0]) & (columns[:, 0] < first + record.runs)]
    rows = wanted[:, 0] - first
    for place, outcome in enumerate(OUTCOMES, start=1):
        getattr(record, outcome.name)[rows] = wanted[:, place]
    for run, *blobs in curves:
        if 0 <= run - first < record.runs:
            for curve, blob in zip(CURVES, blobs, strict=True):
                getattr(record, curve.name)[run - first] = curve_of(blob)
