"""Which runs to simulate: how many, of which seed, from which number on."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING

from feasibee.errors import FeasibeeError, quoted
from feasibee.model.codes import RUN_LIMIT, SEED_LIMIT

if TYPE_CHECKING:
    pass


RUNS_APART = 1_000_000
"""The points of a study have runs of their own, so many apart: they share no random numbers."""


def check_numbers(runs: int, seed: int, first_run: int = 0, name: str = "first_run") -> tuple[int, int, int]:
    """Refuse numbers of runs that there aren't, and return the others as Python's own."""
    runs = whole("runs", runs, 1, RUN_LIMIT)
    seed = whole("seed", seed, 0, SEED_LIMIT - 1)
    return runs, seed, whole(name, first_run, 0, RUN_LIMIT - runs)


def first_run_of(point: int, runs: int) -> int:
    """Return the number of the first run of a point of a study."""
    if runs > RUNS_APART:
        raise FeasibeeError(f"runs = {runs}: must be at most {RUNS_APART} at each point; take fewer")
    return point * RUNS_APART


def whole(name: str, value: int, low: int, high: int) -> int:
    """Return a whole number of any library as an int, if it is between two bounds."""
    try:
        number = low - 1 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = low - 1
    if not low <= number <= high:
        raise FeasibeeError(
            f"{name} = {quoted(value)}: must be a whole number from {low} to {high}; choose one"
        )
    return number
