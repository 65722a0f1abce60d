"""How a journal's rows encode the outcome of runs."""

from __future__ import annotations

import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from feasibee.model.record import Record


def rows_of_runs(record: Record) -> Iterator[tuple[int, ...]]:
    """Yield each run's number and then `COLUMNS`."""
    columns = (
        range(record.first_run, record.first_run + record.runs),
        record.decision.tolist(),
        record.decision_step.tolist(),
        record.bits_sent.tolist(),
        record.commit_step.tolist(),
        record.committed_feasible.tolist(),
        record.committed_infeasible.tolist(),
    )
    return zip(*columns, strict=True)


def rows_of_curves(record: Record) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield each run's number, feasible count and infeasible count."""
    for row in range(record.runs):
        feasible, infeasible = (
            zlib.compress(np.ascontiguousarray(counts[row], "<i4").tobytes())
            for counts in (record.feasible_count, record.infeasible_count)
        )
        yield record.first_run + row, feasible, infeasible


def curve_of(blob: bytes) -> NDArray[np.int32]:
    """Return a count of robots at each step: int32, shape (steps + 1,)."""
    return np.frombuffer(zlib.decompress(blob), "<i4").astype(np.int32)
