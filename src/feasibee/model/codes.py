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
NO_OPINION: Final = -1
DECISIONS: Final = {FEASIBLE: "feasible", INFEASIBLE: "infeasible", UNDECIDED: "undecided"}

# Phases of the controller (model.md 4.2, 4.4).
EXPLORING: Final = 0
DISSEMINATING: Final = 1

ATTEMPTS: Final = 256
"""How often a place is drawn before a thing is put where there is room for sure."""

LONGEST: Final = 2**30
"""Steps that are drawn for a phase at most: a strategy of one's own may ask for any number."""

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


# Okabe and Ito's colours, for colour-blind people too.
COLOURS: Final = {"feasible": "#0072B2", "infeasible": "#D55E00", "undecided": "#7F7F7F"}
TASK: Final = "#E69F00"
