"""The outcomes of consecutive runs as plain arrays, one row per run: what engine and reference fill in."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.base.outcomes import ACCOUNT, CURVES, OUTCOMES, TRACES

COLUMNS = {each.name: number for number, each in enumerate(ACCOUNT)}


@dataclass(frozen=True)
class Record:
    """The outcomes of consecutive runs of one scenario and seed.

    Each column of ``account`` is also an attribute: ``record.bits_sent`` is a view of int64, shape (runs,).

    Parameters
    ----------
    first_run : int
        Number of the run in row 0.
    decision : int8 array, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided.
    decision_step : int32 array, shape (runs,)
        The first step at which the swarm had decided; -1 if undecided.
    feasible_count : int32 array, shape (runs, steps + 1)
        Counted robots with opinion 1 at each step from 0 on; -1 after the end of a run. Without curves, the
        shape is (runs, 0).
    infeasible_count : int32 array, shape (runs, steps + 1)
        Counted robots with opinion 0, likewise; with some strategies, robots may have no opinion.
    account : int64 array, shape (runs, columns)
        The other outcomes per run: a column for each of `feasibee.base.outcomes.ACCOUNT`.
    truth : int8 array, shape (runs, steps + 1)
        Whether the tasks are feasible at each step from 0 on; -1 after the end of a run. In a world that
        doesn't change, this and the following arrays have the shape (runs, 0).
    held : int8 array, shape (runs, steps + 1)
        The opinion of more than the threshold's share of the counted robots at each step; -1 if none.
    robots_present, tasks_present : int32 array, shape (runs, steps + 1)
        Number of robots and of tasks at each step; -1 after the end of a run.
    """

    first_run: int
    decision: NDArray[np.int8]
    decision_step: NDArray[np.int32]
    feasible_count: NDArray[np.int32]
    infeasible_count: NDArray[np.int32]
    account: NDArray[np.int64]
    truth: NDArray[np.int8]
    held: NDArray[np.int8]
    robots_present: NDArray[np.int32]
    tasks_present: NDArray[np.int32]

    @classmethod
    def empty(cls, first_run: int, runs: int, curve_length: int, trace_length: int = 0) -> Record:
        """Return a record of runs that are still to be simulated: every outcome has its fill value.

        ``curve_length`` is the number of steps of the counts of opinions, 0 without them; ``trace_length``
        is that of the truth and what belongs to it, 0 in a world that doesn't change.
        """
        arrays: dict[str, NDArray[Any]] = {
            each.name: np.full(runs, each.fill, each.dtype) for each in OUTCOMES if each not in ACCOUNT
        }
        arrays |= {each.name: np.full((runs, curve_length), each.fill, each.dtype) for each in CURVES}
        arrays |= {each.name: np.full((runs, trace_length), each.fill, each.dtype) for each in TRACES}
        account = np.tile(np.array([each.fill for each in ACCOUNT], np.int64), (runs, 1))
        return cls(first_run, account=account, **arrays)

    def __getattr__(self, name: str) -> NDArray[np.int64]:
        if name not in COLUMNS:
            raise AttributeError(f"a record has no outcome {name!r}")
        return self.account[:, COLUMNS[name]]

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.decision.size

    def part(self, start: int, stop: int) -> Record:
        """Return a view of the rows from ``start`` to before ``stop``."""
        return Record(
            self.first_run + start, **{name: array[start:stop] for name, array in self._arrays().items()}
        )

    def at(self, rows: NDArray[np.intp]) -> Record:
        """Return a copy of some rows; the first is taken to be the first run."""
        return Record(self.first_run, **{name: array[rows] for name, array in self._arrays().items()})

    def without_curves(self) -> Record:
        """Return the same runs without curves."""
        none = {each.name: getattr(self, each.name)[:, :0] for each in CURVES}
        return Record(self.first_run, **{**self._arrays(), **none})

    def followed_by(self, *others: Record) -> Record:
        """Return this record with the runs of others, whose curves are as long, after its own."""
        rows = [each._arrays() for each in (self, *others)]
        arrays = {name: np.concatenate([each[name] for each in rows]) for name in rows[0]}
        return Record(self.first_run, **arrays) if others else self

    def lengthened(self, length: int) -> Record:
        """Return a copy with longer curves, and traces if it has any; the new steps have the fill value."""
        longer = Record.empty(self.first_run, self.runs, length, length if self.truth.shape[1] else 0)
        for name, array in self._arrays().items():
            getattr(longer, name)[tuple(map(slice, array.shape))] = array
        return longer

    def _arrays(self) -> dict[str, NDArray[Any]]:
        return {each.name: getattr(self, each.name) for each in fields(self) if each.name != "first_run"}
