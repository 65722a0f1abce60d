"""What a simulation leaves behind, before it gets labels: plain arrays, one row a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from feasibee.vocabulary import UNDECIDED


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
    """

    first_run: int
    decision: NDArray[np.int8]
    decision_step: NDArray[np.int32]
    feasible_count: NDArray[np.int32]

    @classmethod
    def empty(cls, first_run: int, runs: int, curve_length: int) -> Record:
        """Make room for the outcome of some runs."""
        return cls(
            first_run,
            np.full(runs, UNDECIDED, np.int8),
            np.full(runs, -1, np.int32),
            np.full((runs, curve_length), -1, np.int32),
        )

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.decision.size

    def part(self, start: int, stop: int) -> Record:
        """Return a view of some rows."""
        rows = slice(start, stop)
        return Record(
            self.first_run + start, self.decision[rows], self.decision_step[rows], self.feasible_count[rows]
        )
