"""How a journal's rows encode the outcome of runs."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.model.outcomes import CURVES, OUTCOMES, TRACES, Outcome
from feasibee.model.record import Record

LEVEL, WINDOW_BITS, MEMORY_LEVEL = 1, 12, 5
"""Of zlib: 18 us per run of 1,000 steps, and 9 to read it. The usual 6, 15 and 8 take twice as long."""


class EncodedRuns(NamedTuple):
    """Consecutive runs of one point, as the rows of a journal's tables."""

    runs: list[tuple[int, ...]]
    """Number of each run, then its `OUTCOMES`."""
    curves: list[tuple[Any, ...]]
    """Number of each run, then its compressed `CURVES`; empty if no curves are kept."""
    traces: list[tuple[Any, ...]]
    """Number of each run, then its compressed `TRACES`; empty in a world that doesn't change."""


def encode(record: Record) -> EncodedRuns:
    """Encode runs, and their curves and traces if the record has any."""
    by_step = (list(_rows_by_step(record, outcomes)) for outcomes in (CURVES, TRACES))
    return EncodedRuns(list(rows_of_runs(record)), *by_step)


def rows_of_runs(record: Record) -> Iterator[tuple[int, ...]]:
    """Yield each run's number and its outcomes, in the order of `OUTCOMES`."""
    numbers = range(record.first_run, record.first_run + record.runs)
    return zip(numbers, *(getattr(record, each.name).tolist() for each in OUTCOMES), strict=True)


def _rows_by_step(record: Record, outcomes: Sequence[Outcome]) -> Iterator[tuple[Any, ...]]:
    """Yield each run's number and its compressed outcomes by step; nothing if the record has none."""
    arrays = [getattr(record, each.name) for each in outcomes]
    if arrays[0].shape[1]:
        for row in range(record.runs):
            yield record.first_run + row, *(_compressed(each[row]) for each in arrays)


def _compressed(values: NDArray[Any]) -> bytes:
    packer = zlib.compressobj(LEVEL, zlib.DEFLATED, WINDOW_BITS, MEMORY_LEVEL)
    little = values.dtype.newbyteorder("<")
    return packer.compress(np.ascontiguousarray(values, little).tobytes()) + packer.flush()


def curve_of(blob: bytes, dtype: str = "int32") -> NDArray[Any]:
    """Return an outcome at each step: shape (steps + 1,)."""
    return np.frombuffer(zlib.decompress(blob), np.dtype(dtype).newbyteorder("<")).astype(dtype)


def fill(
    record: Record,
    columns: NDArray[np.int64],
    curves: Iterable[tuple[Any, ...]] = (),
    traces: Iterable[tuple[Any, ...]] = (),
) -> None:
    """Fill in a record from the rows of a journal; rows of other runs are ignored.

    Parameters
    ----------
    record : Record
        Empty, of the runs and the curve length that are wanted.
    columns : int64 array, shape (rows, columns of `PLACES`)
        Number of each run, then its `OUTCOMES`.
    curves : iterable of tuple
        Number of each run, then its compressed `CURVES`.
    traces : iterable of tuple
        Number of each run, then its compressed `TRACES`.
    """
    first = record.first_run
    wanted = columns[(first <= columns[:, 0]) & (columns[:, 0] < first + record.runs)]
    rows = wanted[:, 0] - first
    for place, outcome in enumerate(OUTCOMES, start=1):
        getattr(record, outcome.name)[rows] = wanted[:, place]
    for outcomes, by_step in ((CURVES, curves), (TRACES, traces)):
        for run, *blobs in by_step:
            if 0 <= run - first < record.runs:
                for outcome, blob in zip(outcomes, blobs, strict=True):
                    getattr(record, outcome.name)[run - first] = curve_of(blob, outcome.dtype)
