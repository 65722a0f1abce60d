"""Runs: which runs of a scenario to simulate. They are validated once, where they enter the package."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Self

from feasibee.base.codes import RUN_LIMIT, SEED_LIMIT
from feasibee.base.errors import FeasibeeError, quoted

RUNS_APART = 1_000_000
"""Distance between the first runs of two consecutive points of a study: no two points share a run."""


@dataclass(frozen=True, slots=True)
class Runs:
    """Consecutive runs of one seed, as validated built-in ints.

    Parameters
    ----------
    count : int
        Number of runs, from 1 to 2**32.
    seed : int
        Seed of all random numbers, from 0 to 2**64 - 1.
    first : int
        Number of the first run. The number of the last run is at most 2**32 - 1.

    Raises
    ------
    FeasibeeError
        If a value is not an integer in its range; it names ``runs``, ``seed`` or ``first_run``.

    Examples
    --------
    >>> from feasibee.scenario.runs import Runs
    >>> Runs(100, seed=1, first=200)
    Runs(count=100, seed=1, first=200)
    """

    count: int
    seed: int = 0
    first: int = 0

    def __post_init__(self) -> None:
        count = check_integer("runs", self.count, 1, RUN_LIMIT)
        seed = check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        first = check_integer("first_run", self.first, 0, RUN_LIMIT - count)
        for name, value in (("count", count), ("seed", seed), ("first", first)):
            object.__setattr__(self, name, value)

    @classmethod
    def single(cls, seed: int, run: int) -> Self:
        """Return the one run of a seed with the number ``run``, the name that errors use."""
        return cls(1, seed, check_integer("run", run, 0, RUN_LIMIT - 1))

    @classmethod
    def of_point(cls, point: int, count: int, seed: int) -> Self:
        """Return the runs of a study's point, counted from 0; no other point has the same runs."""
        runs = cls(count, seed, point * RUNS_APART)
        if runs.count > RUNS_APART:
            rule = f"must be at most {RUNS_APART} per point of a study"
            raise FeasibeeError(f"runs = {runs.count}: {rule}; use 1 to {RUNS_APART}")
        return runs


def check_integer(name: str, value: int, low: int, high: int) -> int:
    """Return an integer of any library, but no bool, as a built-in int; its name is for the error."""
    try:
        number = low - 1 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = low - 1
    if not low <= number <= high:
        rule = f"must be a whole number from {low} to {high}"
        raise FeasibeeError(f"{name} = {quoted(value)}: {rule}; such as {max(low, min(high, 1))}")
    return number
