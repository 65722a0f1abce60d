"""What a simulation leaves behind, before it gets labels: plain arrays, one row a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import UNDECIDED

BITS_SENT, COMMIT_STEP, COMMITTED_FEASIBLE, COMMITTED_INFEASIBLE = range(4)
"""Columns of `Record.account`."""


@dataclass(frozen=True)
class Record:
    """The outcome of consecutive runs of one scenario.

    Parameters
    ----------
    first_run : int
        Number of the run in row 0.
    decision : int8 array, shape (runs,)
        1 feasible, 0 infeasible, -1 undecided.
    decision_step : int32 array, shape (runs,)
        The first step at which the swarm had decided; -1 if undecided.
    feasible_count : int32 array, shape (runs, steps + 1)
        Robots with opinion 1 at each step from 0 on, -1 after the end of a run that stopped at its decision;
        shape (runs, 0) if nobody asked for it.
    infeasible_count : int32 array
        Robots with opinion 0, likewise; some strategies know robots without an opinion.
    account : int64 array, shape (runs, 4)
        Behind the properties below.
    """

    first_run: int
    decision: NDArray[np.int8]
    decision_step: NDArray[np.int32]
    feasible_count: NDArray[np.int32]
    infeasible_count: NDArray[np.int32]
    account: NDArray[np.int64]

    @classmethod
    def empty(cls, first_run: int, runs: int, curve_length: int) -> Record:
        """Make room for the outcome of some runs."""
        return cls(
            first_run,
            np.full(runs, UNDECIDED, np.int8),
            np.full(runs, -1, np.int32),
            np.full((runs, curve_length), -1, np.int32),
            np.full((runs, curve_length), -1, np.int32),
            np.tile(np.array([0, -1, 0, 0], np.int64), (runs, 1)),
        )

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.decision.size

    @property
    def bits_sent(self) -> NDArray[np.int64]:
        """Length of all messages of a run: int64, shape (runs,)."""
        return self.account[:, BITS_SENT]

    @property
    def commit_step(self) -> NDArray[np.int64]:
        """First step at which more than the threshold's share of the robots had committed; -1: never."""
        return self.account[:, COMMIT_STEP]

    @property
    def committed_feasible(self) -> NDArray[np.int64]:
        """Robots committed to *feasible* at the end of each run."""
        return self.account[:, COMMITTED_FEASIBLE]

    @property
    def committed_infeasible(self) -> NDArray[np.int64]:
        """Robots committed to *infeasible* at the end of each run."""
        return self.account[:, COMMITTED_INFEASIBLE]

    def part(self, start: int, stop: int) -> Record:
        """Return a view of some rows."""
        rows = slice(start, stop)
        return Record(
            self.first_run + start,
            self.decision[rows],
            self.decision_step[rows],
            self.feasible_count[rows],
            self.infeasible_count[rows],
            self.account[rows],
        )
