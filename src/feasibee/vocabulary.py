"""The words and numbers that every part of feasibee agrees on."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

MODEL_VERSION: Final = 1
"""Raised whenever the same scenario and seed would give other results."""

# Opinions, and the decision of a swarm (model.md 4.1, 4.7).
INFEASIBLE: Final = 0
FEASIBLE: Final = 1
UNDECIDED: Final = -1
DECISIONS: Final = {FEASIBLE: "feasible", INFEASIBLE: "infeasible", UNDECIDED: "undecided"}

# Phases of the controller (model.md 4.2, 4.4).
EXPLORING: Final = 0
DISSEMINATING: Final = 1

# What a random number is for: the last word of its Philox counter. Append only; never renumber.
PLACE_ROBOT: Final = 0  # words 0, 1: x, y
PLACE_TASK: Final = 1  # words 0, 1: x, y
FIRST_OPINION: Final = 2  # word 0: its top bit
WALK: Final = 3  # word 0: heading; word 1: duration
PHASE: Final = 4  # word 0: duration
PURPOSES: Final = {
    "PLACE_ROBOT": PLACE_ROBOT,
    "PLACE_TASK": PLACE_TASK,
    "FIRST_OPINION": FIRST_OPINION,
    "WALK": WALK,
    "PHASE": PHASE,
}

SEED_LIMIT: Final = 2**64
RUN_LIMIT: Final = 2**32


def exact(value: float) -> Fraction:
    """Return the decimal number that a person wrote, exactly: ``0.7`` is 7/10.

    The float nearest to 0.7 is a little less, so that 7 of 10 robots would pass for "more than 70 %".

    Parameters
    ----------
    value : float
        A finite number.

    Returns
    -------
    Fraction
        The shortest decimal that reads back as ``value``.
    """
    return Fraction(repr(value))
