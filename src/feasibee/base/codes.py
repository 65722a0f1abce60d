"""Codes of opinions, decisions and phases, limits, and colours, shared by the whole package."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

MODEL_VERSION: Final = 2
"""Version of the model; raise it whenever the same scenario and seed give other results."""

# Opinions, and the decision of a swarm (model.md 4.1, 4.7).
INFEASIBLE: Final = 0
FEASIBLE: Final = 1
UNDECIDED: Final = -1
NO_OPINION: Final = -1
DECISIONS: Final = {FEASIBLE: "feasible", INFEASIBLE: "infeasible", UNDECIDED: "undecided"}
FLAGS: Final = (
    *("feasible", "neutral", "disseminating", "declared", "working", "byzantine", "stubborn"),
    *("there", "standing"),
)
"""Properties of robots, as bits of a number; ``there`` is false where no robot has the number."""
CERTAIN: Final = 2**20
"""What stands for probability 1 where probabilities are summed up, so that no order of robots matters."""

# Phases of the controller (model.md 4.2, 4.4).
DISSEMINATING: Final = 1

ATTEMPTS: Final = 256
"""Number of random positions that are tried before a place with room is computed instead."""

COS_EIGHTH: Final = 3037000499
"""Cosine of an eighth of a turn, in units of 1 / 2**32, rounded down (model.md 6.2.4)."""

LONGEST: Final = 2**30
"""Longest duration of a phase in steps; a user's strategy may return any mean."""

COUNT_LIMIT: Final = 2**53
"""What a strategy may count of robots, or of tasks, in units of its own."""
BITS_LIMIT: Final = 2**40
"""Bits of one message."""

SEED_LIMIT: Final = 2**64
"""Seeds are smaller than this."""
RUN_LIMIT: Final = 2**32
"""Numbers of runs are smaller than this."""


def exact(value: float) -> Fraction:
    """Return the shortest decimal that reads back as a number, which a user wrote: ``0.7`` is 7/10.

    The float nearest to 0.7 is slightly smaller, so with floats 7 of 10 robots would be "more than 70 %".
    """
    return Fraction(repr(value))


def is_whole(value: object, most: int, least: int = 0) -> bool:
    """Return whether a value is an int from ``least`` to ``most``, and not a bool."""
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


# Okabe and Ito's palette, which colour-blind people can tell apart.
COLOURS: Final = {"feasible": "#0072B2", "infeasible": "#D55E00", "undecided": "#7F7F7F"}
TASK: Final = "#E69F00"
ZONE: Final = "#009E73"
MOST_WALLS = 8
"""Walls between two robots beyond which more shorten the radio range no further (model.md 6.21)."""
